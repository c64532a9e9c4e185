"""The last frame comes twice."""

from _shared import answer, finish

lines, said, code = answer()
finish(lines + lines[-1:] if len(lines) > 1 else lines, said, code)
