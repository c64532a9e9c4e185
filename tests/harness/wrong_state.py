"""Retained is called transmitted."""

import json

from _shared import answer, finish

lines, said, code = answer()
for i in range(1, len(lines)):
    frame = json.loads(lines[i])
    frame["state"] = frame["state"].replace("U", "R")
    lines[i] = json.dumps(frame) + "\n"
finish(lines, said, code)
