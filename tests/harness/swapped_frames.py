"""Right values in the wrong frame: the first two change places."""

import json

from _shared import answer, finish

lines, said, code = answer()
if len(lines) > 2:
    first, second = json.loads(lines[1]), json.loads(lines[2])
    first["faps"], second["faps"] = second["faps"], first["faps"]
    lines[1:3] = [json.dumps(first) + "\n", json.dumps(second) + "\n"]
finish(lines, said, code)
