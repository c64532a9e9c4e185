"""The coverage book as one HTML file that needs nothing else: it works from `file://`, light and dark.

Rules: CNF-8.
"""

from __future__ import annotations

import json
import re
from html import escape
from pathlib import Path
from typing import Final

from snhc.analyzer.pages import base_css

from .book import Book, Share
from .cells import KINDS

TEMPLATE: Final = Path(__file__).parent / "page.html"


def page(book: Book) -> str:
    """The whole page. Rules: CNF-8."""
    whole = book.share()
    parts = {
        "BASE": base_css(),
        "SUITE": escape(book.suite),
        "VECTORS": str(len(book.vectors)),
        "COVERED": str(whole.covered),
        "TOTAL": str(whole.total),
        "PERCENT": whole.percent,
        "KINDS": _shares({kind: share for kind, share in book.by_kind().items() if share.total}, "kind", KINDS),
        "AREAS": _shares(book.by_area(), "rule", {}),
        "REASONS": _reasons(book),
        "UNENTERED": _unentered(book),
        "OPTIONS": "".join(f'<option value="{kind}">{escape(name)}</option>' for kind, name in KINDS.items()),
        # `</script>` in a cell's name must not end the script.
        "BOOK": json.dumps(book.as_json(), ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"),
    }
    # In one go: what is put in may look like a place itself.
    return re.sub(r"<!--([A-Z]+)-->", lambda place: parts[place[1]], TEMPLATE.read_text(encoding="utf-8"))


def _shares(shares: dict[str, Share], filter: str, names: dict[str, str]) -> str:
    rows = [
        f'<tr><th scope="row"><a href="#find" data-{filter}="{key}">{escape(names.get(key, key))}</a></th>'
        f'<td class="number">{share.covered} of {share.total}</td>'
        f'<td class="number">{share.percent} %</td><td><span class="bar" aria-hidden="true">'
        f'<span style="width:{share.percent}%"></span></span></td></tr>'
        for key, share in shares.items()
    ]
    return f"<table><tbody>{''.join(rows)}</tbody></table>"


def _reasons(book: Book) -> str:
    reasons = book.reasons()
    if not reasons:
        return "<p>There are none.</p>"
    rows = [
        f'<tr><td class="number">{count}</td><td>{escape(why or "no reason given")}</td></tr>'
        for why, count in reasons.items()
    ]
    head = '<thead><tr><th scope="col" class="number">Holes</th><th scope="col">Reason</th></tr></thead>'
    return f"<table>{head}<tbody>{''.join(rows)}</tbody></table>"


def _unentered(book: Book) -> str:
    if not book.unentered:
        return ""
    names = ", ".join(f"<code>{escape(module)}</code>" for module in book.unentered)
    return (
        f"<details><summary>{len(book.unentered)} modules of the codec have no cells: no vector enters them "
        f"(encoders, outputs)</summary><p>{names}</p></details>"
    )
