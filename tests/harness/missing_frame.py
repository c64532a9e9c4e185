"""The last frame is not there."""

from _shared import answer, finish

lines, said, code = answer()
finish(lines[:-1] if len(lines) > 1 else lines, said, code)
