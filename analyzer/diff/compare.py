"""Comparing two inputs at every level that they share.

Rules: CNF-17, CNF-2.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options

from .align import TIME
from .instants import Instants, form_of
from .report import Comparison
from .syntax import SyntaxDiff, diff_syntax
from .values import SHOWN, ValueDiff, diff_values

SYNTAX: Final = "syntax"
VALUES: Final = "values"


def compare(
    a: Source,
    b: Source,
    options: Options = DEFAULT_OPTIONS,
    *,
    names: tuple[str, str] = ("A", "B"),
    level: str | None = None,
    align: str = TIME,
    tolerance: float = 0.0,
    shown: int = SHOWN,
    curves: bool = False,
) -> Comparison:
    """Compare two inputs: `level` syntax, values, None: both where both are streams.

    Rules: CNF-2, CNF-17. A fault of a stream ends its side and stands in the result; faults of text are raised. Raises
    InputFormat where syntax is asked of what has none.
    """
    streams = [form_of(source) == "stream" for source in (a, b)]
    if level == SYNTAX and not all(streams):
        name = names[streams.index(False)]
        raise InputFormat("CNF-2", "input", value=name, allowed="a stream: text has no syntax elements")
    syntax: SyntaxDiff | None = None
    values: ValueDiff | None = None
    error: SnhcError | None = None
    if level != VALUES and all(streams):
        syntax = diff_syntax(a, b, options, align=align, shown=shown)
        error = syntax.error_a or syntax.error_b
    if level != SYNTAX:
        values = diff_values(
            Instants(a, options), Instants(b, options), align=align, tolerance=tolerance, shown=shown, curves=curves
        )
        error = error or values.error_a or values.error_b
    return Comparison(*names, align, tolerance, syntax, values, error)
