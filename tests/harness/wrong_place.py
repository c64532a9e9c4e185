"""Rejects what is to be rejected, at another place."""

import json

from _shared import answer, finish

lines, said, code = answer()
if said:
    end = json.loads(said)["bits"][1]
    said = json.dumps({"bit": end}) + "\n"
finish(lines, said, code)
