"""The columns of a dump, and what is done where a terminal is too narrow for them.

Rules: CNF-17.

Files and pipes always get `WIDE`, and lines of any length. On a terminal no line is longer than the terminal: below 110
columns the byte offset goes, and bytes stand four to a line; below 70 columns there are no bytes at all.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Final

from .hexdump import PER_LINE, WIDTH

_ALL_FROM: Final = 110
_BYTES_FROM: Final = 70
_LEAST: Final = 40
_MARK: Final = "..."


@dataclass(frozen=True, slots=True)
class Layout:
    """Widths in characters; 0: there is no such column.

    Rules: CNF-17. `span`: at the least, long numbers take more. `per_line`: bytes in a line. `name`: what stands before
    the rule. `most`: the longest line, 0 for any.
    """

    span: int = 20
    offset: int = 7
    data: int = WIDTH
    per_line: int = PER_LINE
    name: int = 56
    indent: str = "  "
    most: int = 0

    def bits(self, span: int, indent: int, count: int) -> int:
        """How many bits stand in a line behind a span of that width: `count`, or whole bytes. Rules: CNF-17."""
        room = self.most - span - 1 - (self.data + 1 if self.data else 0) - indent
        return count if not self.most or room >= count else max(room // 8 * 8, 8)

    def fitted(self, text: str, room: int) -> str:
        """What of a text has room, cut between words: half a number would be another one. Rules: CNF-17."""
        if not self.most or len(text) <= room:
            return text
        head = text[: max(room - len(_MARK), 0)]
        blank = head.rfind(" ", len(text) - len(text.lstrip()))
        return (head[: blank + 1] if blank >= 0 else head) + _MARK

    def folded(self, text: str, room: int) -> list[str]:
        """All of a text, in lines that have room, each as deep as the first. Rules: CNF-17."""
        if not self.most or len(text) <= room:
            return [text]
        deep = text[: len(text) - len(text.lstrip())]
        return textwrap.wrap(text, max(room, len(deep) + 8), initial_indent="", subsequent_indent=deep + self.indent)


WIDE: Final = Layout()


def layout_for(columns: int | None) -> Layout:
    """The layout for a terminal of so many columns; None: for files and pipes. Rules: CNF-17."""
    if columns is None:
        return WIDE
    most = max(columns, _LEAST)
    if most >= _ALL_FROM:
        return Layout(most=most)
    per_line = 4 if most >= _BYTES_FROM else 0
    data = 3 * per_line + 1 if per_line else 0
    return Layout(span=15, offset=0, data=data, per_line=per_line, indent=" ", most=most)
