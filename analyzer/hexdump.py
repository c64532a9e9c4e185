"""Bytes and bits beside the tree.

Rules: CNF-21.

Short spans are shown bit by bit inside their bytes, the bits of others as dots: `...10110 1.......`. Longer ones as
bytes, eight to a line; a byte that is shared with a neighbour has a `'` on that side: `'5b 3c 99'`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from snhc.reference_impl.bitstream.source import Source

# The longest span that is shown bit by bit; it lies in at most three bytes.
BITWISE: Final = 16
PER_LINE: Final = 8
WIDTH: Final = 26
_LINES_AT_ONCE: Final = 4096


def hex_lines(
    source: Source, start: int, end: int, most: int | None = None, per_line: int = PER_LINE
) -> Iterator[tuple[int, str, str]]:
    """The bits [start, end) as lines (byte offset, digits, characters).

    Rules: CNF-21. `most`: at most so many lines, the last one then ends in `...`; None: all. No line for no bits.
    `per_line`: bytes in a line; bit by bit is only what is no longer than such a line.
    """
    if end <= start:
        return
    first, last = start >> 3, (end + 7) >> 3
    if end - start <= BITWISE and 9 * (last - first) - 1 <= 3 * per_line + 2:
        yield first, _bitwise(source, start, end), ""
        return
    count = -(-(last - first) // per_line)
    shown = count if most is None or count <= most else most
    for line in range(0, shown, _LINES_AT_ONCE):
        begin = first + line * per_line
        data = source.read_at(begin, min(_LINES_AT_ONCE * per_line, last - begin))
        for at in range(0, min(len(data), (shown - line) * per_line), per_line):
            piece = data[at : at + per_line]
            offset = begin + at
            text = piece.hex(" ")
            if offset == first and start & 7:
                text = "'" + text
            if offset + len(piece) == last and end & 7:
                text += "'"
            if count > shown and line + at // per_line == shown - 1:
                text = text[: 3 * (per_line - 1) + (text[0] == "'")] + "..."
            yield offset, text, _characters(piece)


def _bitwise(source: Source, start: int, end: int) -> str:
    first, last = start >> 3, (end + 7) >> 3
    bits = format(int.from_bytes(source.read_at(first, last - first), "big"), f"0{8 * (last - first)}b")
    inside = bits[start - 8 * first : end - 8 * first]
    text = "." * (start - 8 * first) + inside + "." * (8 * last - end)
    return " ".join(text[at : at + 8] for at in range(0, len(text), 8))


def _characters(data: bytes) -> str:
    return "".join(chr(byte) if 32 <= byte < 127 else "." for byte in data)
