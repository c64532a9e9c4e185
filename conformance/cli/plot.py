"""`snhc plot`: FAP curves, bit rate over time and bits per plane as a picture.

Rules: CNF-19, SYS-11.
"""

from __future__ import annotations

import sys

import click

from .common import Common, Output, common_options, format_of, open_input
from .extras import needs_view


@click.command()
@click.argument("file")
@click.option(
    "--format", "format_", type=click.Choice(("png", "svg")), help="Default: by the extension of -o, else png."
)
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(file: str, format_: str | None, object_number: int, common: Common) -> None:
    """Plot the FAP curves and bit rates of a stream.

    FILE is a visual stream, - for standard input. One curve per FAP, groups above each other; below them the bit rate
    over windows of one second, and the bits of every plane.
    """
    from snhc.analyzer.plot import plot
    from snhc.analyzer.stats import stream_stats

    chosen = format_of(format_, common.output, {".png": "png", ".svg": "svg"}, "png")
    if chosen == "png" and common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError("png is not for terminals; give -o FILE")
    with open_input(file) as source, Output(common.output, common.keep_partial) as out:
        stats = stream_stats(source, common.options(object_number), common.report, keep_frames=True)
        with needs_view("plot"):
            out.write(plot(stats, chosen))
