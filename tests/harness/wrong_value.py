"""One value of the last line is one off."""

import json

from _shared import answer, finish

lines, said, code = answer()
if len(lines) > 1:
    frame = json.loads(lines[-1])
    coded = next((i for i, value in enumerate(frame["faps"]) if value is not None), None)
    if coded is not None:
        frame["faps"][coded] += 1
    lines[-1] = json.dumps(frame) + "\n"
finish(lines, said, code)
