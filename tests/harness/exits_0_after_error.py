"""Says what is wrong, and exits with 0."""

from _shared import answer, finish

lines, said, _ = answer()
finish(lines, said, 0)
