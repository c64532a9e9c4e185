"""`snhc run`: decoders against the suite.

Rules: CNF-9, CNF-15, CNF-18, CNF-19.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from .common import Common, Output, common_options, format_of

_FORMATS = {".json": "json", ".txt": "terminal"}


@click.command()
@click.argument("adapter", nargs=-1, metavar="[ADAPTER]...")
@click.option(
    "--adapter-command", metavar="COMMAND", multiple=True,
    help="A decoder as a command line; {input} stands for the vector's path, without it the vector is standard input.",
)  # fmt: skip
@click.option(
    "--adapter-format", type=click.Choice(["ndjson", "fap", "csv"]), default="ndjson", show_default=True,
    help="What --adapter-command prints.",
)  # fmt: skip
@click.option("--timeout", type=click.FloatRange(min=0.01), help="Seconds per vector, for all adapters.")
@click.option(
    "--suite", type=click.Path(exists=True, file_okay=False, path_type=Path), metavar="DIR",
    help="Folder of the suite; the one of this installation if not given.",
)  # fmt: skip
@click.option(
    "--filter", "expression", metavar="EXPR", default="",
    help="Vectors to run: terms that must all hold, e.g. 'fap.arith.* rule=FBA-25 !tier=stress'.",
)  # fmt: skip
@click.option("--format", "given", type=click.Choice(["terminal", "json"]), help="Of the report.")
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), default=os.cpu_count() or 1, help="Decoders at the same time."
)
@common_options(reads=False)
def command(
    adapter: tuple[str, ...],
    adapter_command: tuple[str, ...],
    adapter_format: str,
    timeout: float | None,
    suite: Path | None,
    expression: str,
    given: str | None,
    jobs: int,
    common: Common,
) -> None:
    """Run decoders against the suite.

    ADAPTER: a TOML file that says how a decoder is asked, decoder:NAME for an installed Python decoder (entry point of
    the group snhc.decoders), or snhc for the built-in reference decoder.

    Without an adapter the built-in reference decoder is validated. Fields of --filter: id (the default), tier, kind,
    rule, feature, class, tool; globs, | between alternatives, ! before a term that must not hold.

    Exit codes: 0 every decoder passes, 1 one fails (an empty run fails), 2 usage, 3 a file cannot be read, 5 an adapter
    file is wrong, or nothing but the adapters is at fault.
    """
    from snhc.conformance import adapters as kinds
    from snhc.conformance import report as reports
    from snhc.conformance.filters import selector
    from snhc.conformance.runner import run
    from snhc.reference_impl.bitstream.errors import InputFormat
    from snhc.vectors.manifest import SUITE, load

    style = format_of(given, common.output, _FORMATS, "terminal")
    try:
        select = selector(expression)
    except InputFormat as error:
        raise click.BadParameter(error.message, param_hint="--filter") from error
    foreign: list[kinds.Adapter] = [kinds.find(word) for word in adapter]
    foreign += [kinds.from_command(text, format=adapter_format) for text in adapter_command]
    if timeout is not None:
        foreign = [one.timed(timeout) for one in foreign]
    decoders = foreign or [kinds.BuiltIn()]
    folder = suite if suite is not None else SUITE
    report = run(load(folder), decoders, suite=folder, select=select, filter=expression, jobs=jobs)
    with Output(common.output, common.keep_partial) as out:
        if style == "json":
            out.write(reports.json_text(report))
        else:
            colour = out.is_terminal and "NO_COLOR" not in os.environ
            out.write(reports.terminal_text(report, colour=colour))
    sys.stdout.flush()
    if report.exit_code:
        raise click.exceptions.Exit(report.exit_code)
