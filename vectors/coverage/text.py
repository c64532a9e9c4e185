"""The coverage book in the terminal.

Rules: CNF-8.
"""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import wrap
from typing import Final

from .book import Book, Row, Share
from .cells import KINDS

_SHOWN: Final = 6


def summary_lines(book: Book) -> Iterator[str]:
    """The shares by kind and by area of rules, and the reasons for the holes."""
    yield f"coverage of suite {book.suite}: {len(book.vectors)} vectors"
    yield ""
    yield from _table({KINDS[kind]: share for kind, share in book.by_kind().items() if share.total}, "kind of cell")
    yield ""
    yield from _table(book.by_area(), "rules")
    yield ""
    yield from _table({"all": book.share()}, "")
    reasons = book.reasons()
    if reasons:
        yield ""
        yield "holes, by reason"
        for why, count in reasons.items():
            yield f"{count:>6}  {why or 'NO REASON GIVEN'}"
    if book.unentered:
        yield ""
        yield f"no vector enters {len(book.unentered)} modules of the codec (encoders, outputs; no cells of the book):"
        yield from wrap(", ".join(book.unentered), 116, initial_indent="  ", subsequent_indent="  ")


def _table(shares: dict[str, Share], title: str) -> Iterator[str]:
    if title:
        yield f"{title:<34} {'covered':>8} {'of':>6}      %"
    for name, share in shares.items():
        yield f"{name:<34} {share.covered:>8} {share.total:>6}  {share.percent:>5}"


def cell_lines(book: Book) -> Iterator[str]:
    """Every cell with its vectors, or the reason why it is a hole; syntax first, branches of the decoder last."""
    order = list(KINDS)
    for row in sorted(book.rows.values(), key=lambda row: order.index(row.cell.kind)):
        yield cell_line(row)


def cell_line(row: Row) -> str:
    """One cell: `+` covered, `-` a hole."""
    rules = f" ({', '.join(row.cell.rules)})" if row.cell.rules else ""
    if not row.covered:
        return f"- {row.cell.key}{rules}: {row.why or 'NO REASON GIVEN'}"
    shown = ", ".join(row.vectors[:_SHOWN])
    more = f" and {len(row.vectors) - _SHOWN} more" if len(row.vectors) > _SHOWN else ""
    return f"+ {row.cell.key}{rules}: {shown}{more}"
