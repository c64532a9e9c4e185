"""Reports of a run: for the terminal, and as JSON, JUnit XML, SARIF, Markdown and HTML.

Rules: CNF-15, CNF-17, CNF-18. Each renderer takes a `Report` and gives text; saved ones are read by
`json` and joined by `merge`. What decoders said is hostile: every renderer escapes it.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from snhc.conformance.results import Report


def render(report: Report, format: str, *, colour: bool = False, width: int = 100) -> str:
    """A report as text.

    Rules: CNF-18. `format`: `terminal`, or the name of a module here. `colour`, `width`: of a terminal.
    """
    if format == "terminal":
        from .terminal import terminal_text

        return terminal_text(report, colour=colour, width=width)
    text: Callable[[Report], str] = import_module(f"{__name__}.{format}").text
    # Half of a surrogate pair, which JSON of a decoder can hold, is nothing that a file can.
    return text(report).encode("utf-8", "replace").decode()
