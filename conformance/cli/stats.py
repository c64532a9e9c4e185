"""`snhc stats`: what a stream costs and holds.

Rules: CNF-19, CNF-25, SYS-11, SYS-12.
"""

from __future__ import annotations

import click

from .common import Common, Output, common_options, format_of, open_input


@click.command()
@click.argument("file")
@click.option(
    "--format", "format_", type=click.Choice(("text", "json")), help="Default: by the extension of -o, else text."
)
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(file: str, format_: str | None, object_number: int, common: Common) -> None:
    """Sum up a stream: planes, rates, bits, masks, ranges.

    FILE is a visual stream, - for standard input. Bit rates as the levels of profiles are defined: mean, and peak over
    every window of one second.
    """
    import json

    from snhc.analyzer.stats import stream_stats, summary

    chosen = format_of(format_, common.output, {".json": "json", ".txt": "text"}, "text")
    with open_input(file) as source, Output(common.output, common.keep_partial) as out:
        stats = stream_stats(source, common.options(object_number), common.report)
        out.write(summary(stats) if chosen == "text" else json.dumps(stats.as_json(), indent=1) + "\n")
