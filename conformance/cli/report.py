"""`snhc report`: saved results, joined and rendered.

Rules: CNF-18, CNF-19, CNF-20.
"""

from __future__ import annotations

from pathlib import Path

import click

from .common import (
    REPORT_FORMATS,
    REPORT_SUFFIXES,
    Common,
    InputPath,
    Output,
    colour_allowed,
    common_options,
    format_of,
)


@click.command()
@click.argument(
    "results",
    nargs=-1,
    required=True,
    type=InputPath(),
    metavar="RESULTS...",
)
@click.option("--format", "given", type=click.Choice(REPORT_FORMATS), help="By the extension of -o, else terminal.")
@click.option(
    "--verdict", is_flag=True, help="End as `snhc run` would: 1 where a decoder fails, or a shard is missing."
)
@common_options(reads=False)
def command(results: tuple[Path, ...], given: str | None, verdict: bool, common: Common) -> None:
    """Render saved results, and join those of several runs.

    RESULTS: JSON reports of `snhc run`. Shards of one run join to its report; several decoders stand side by side.
    The same vector and decoder in two reports with different results is an error.

    Exit codes: 0 rendered, 2 usage, 3 a file is no report or does not fit the others; with --verdict also 1 and 5.
    """
    style = format_of(given, common.output, REPORT_SUFFIXES, "terminal")
    from snhc.conformance.reports import render
    from snhc.conformance.reports.json import load
    from snhc.conformance.reports.merge import merge
    from snhc.conformance.results import FAILURE

    report = merge([load(path) for path in results], [str(path) for path in results])
    with Output(common.output, common.keep_partial) as out:
        out.write(render(report, style, colour=colour_allowed(out.is_terminal)))
    if verdict:
        missing = any(shards.missing for shards in report.shards.values())
        code = report.exit_code or (FAILURE if missing else 0)
        if code:
            raise click.exceptions.Exit(code)
