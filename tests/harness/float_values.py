"""Values as floats, all of them right."""

import json

from _shared import answer, finish

lines, said, code = answer()
for i in range(1, len(lines)):
    frame = json.loads(lines[i])
    frame["faps"] = [None if value is None else float(value) for value in frame["faps"]]
    lines[i] = json.dumps(frame) + "\n"
finish(lines, said, code)
