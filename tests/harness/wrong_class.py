"""Rejects what is to be rejected, for another reason."""

import json

from _shared import answer, finish

lines, said, code = answer()
if said:
    said = json.dumps({**json.loads(said), "class": "TrailingData"}) + "\n"
finish(lines, said, code)
