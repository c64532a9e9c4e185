"""Decodes everything right, and then exits with 1."""

from _shared import answer, finish

lines, said, _ = answer()
finish(lines, said, 1)
