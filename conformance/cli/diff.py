"""`snhc diff`: what differs between two streams or decodes.

Rules: CNF-17, CNF-19.
"""

from __future__ import annotations

import click

from .common import Common, Output, common_options, format_of, open_input


@click.command()
@click.argument("a")
@click.argument("b")
@click.option(
    "--level", type=click.Choice(("syntax", "values")),
    help="Compare only elements, or only decoded values. Default: both, where both inputs are streams.",
)  # fmt: skip
@click.option(
    "--align", type=click.Choice(("time", "number")), default="time", show_default=True, help="How planes pair."
)
@click.option(
    "--tolerance", type=click.FloatRange(min=0), default=0.0, metavar="D",
    help="Values that differ by D or less are equal. Default: 0.",
)  # fmt: skip
@click.option(
    "--max", "shown", type=click.IntRange(min=0), default=20, show_default=True, metavar="N",
    help="Differences to list.",
)  # fmt: skip
@click.option(
    "--format", "format_", type=click.Choice(("terminal", "json", "html")),
    help="Default: by the extension of -o, else terminal.",
)  # fmt: skip
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Whose values.")
@common_options()
def command(
    a: str,
    b: str,
    level: str | None,
    align: str,
    tolerance: float,
    shown: int,
    format_: str | None,
    object_number: int,
    common: Common,
) -> None:
    """Show what differs between two streams or decodes.

    A and B: streams, .fap text or decoded NDJSON, in any mixture. Streams are compared element by element (first
    divergence with its bits in both) and by the values that they decode to: largest difference, rms, PSNR per FAP.

    Exit codes: 0 equal, 1 different, 2 usage, 3 input or I/O, 4 one does not decode.
    """
    if a == b == "-":
        raise click.UsageError("only one of the two can be standard input")
    chosen = format_of(format_, common.output, {".json": "json", ".html": "html", ".txt": "terminal"}, "terminal")
    from snhc.analyzer.diff.compare import compare
    from snhc.analyzer.diff.report import json_text, terminal_lines

    with open_input(a) as left, open_input(b) as right, Output(common.output, common.keep_partial) as out:
        comparison = compare(
            left, right, common.options(object_number), names=(a, b), level=level, align=align, tolerance=tolerance,
            shown=shown, curves=chosen == "html",
        )  # fmt: skip
        if chosen == "json":
            out.write(json_text(comparison))
        elif chosen == "html":
            from snhc.analyzer.diff.html import html_text

            out.write(html_text(comparison))
        else:
            for line in terminal_lines(comparison):
                out.write(line)
        error = comparison.error
        if error is not None:
            # The report says itself where a stream ends, so it is whole.
            out.keep()
            raise error
    if not comparison.equal:
        raise click.exceptions.Exit(1)
