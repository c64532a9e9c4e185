"""`snhc run`: decoders against the suite.

Rules: CNF-9, CNF-15, CNF-18, CNF-19, CNF-20.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

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
    parse_readings,
    progress,
)

if TYPE_CHECKING:
    from snhc.conformance.adapters import Adapter
    from snhc.conformance.runner import Progress
    from snhc.conformance.running.shards import Shard


def _shard(ctx: click.Context, param: click.Parameter, value: str | None) -> Shard | None:
    from snhc.conformance.running.shards import parse_shard
    from snhc.reference_impl.bitstream.errors import InputFormat

    if value is None:
        return None
    try:
        return parse_shard(value)
    except InputFormat as error:
        raise click.BadParameter(f"{value!r} is not of the form i/n with i from 1 to n") from error


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
@click.option(
    "--reading", metavar="ID=KEY", multiple=True, callback=lambda ctx, param, value: parse_readings(value),
    help="Have the decoders follow another reading of an ambiguity (see `snhc rules AMB`). Repeatable.",
)  # fmt: skip
@click.option("--timeout", type=click.FloatRange(min=0.01), help="Seconds per vector, for all adapters.")
@click.option(
    "--suite", type=InputPath(folder=True), metavar="DIR",
    help="Folder of the suite; the one of this installation if not given.",
)  # fmt: skip
@click.option(
    "--filter", "expression", metavar="EXPR", default="",
    help="Vectors to run: terms that must all hold, e.g. 'fap.arith.* rule=FBA-25 !tier=stress'.",
)  # fmt: skip
@click.option(
    "--shard", metavar="I/N", callback=_shard,
    help="Only the I-th of N parts of the selection; `snhc report` joins the reports.",
)  # fmt: skip
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), default=os.cpu_count() or 1, help="Decoders at the same time."
)
@click.option("--cluster", metavar="ADDRESS", help="Run on the workers of this Dask scheduler (extra: cluster).")
@click.option(
    "--resume", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
    help="The journal of an interrupted run: go on with it. Is made if it is not there.",
)  # fmt: skip
@click.option(
    "--ledger", type=InputPath(), metavar="FILE",
    help="Known failures (TOML).",
)  # fmt: skip
@click.option(
    "--draft-ledger", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
    help="Write a ledger of the failures that none excuses; links are left to fill in.",
)  # fmt: skip
@click.option(
    "--traces", type=InputPath(folder=True), metavar="DIR",
    help="The decoder's own traces, VECTOR.json in the form of `snhc dump --format json`.",
)  # fmt: skip
@click.option("--format", "given", type=click.Choice(REPORT_FORMATS), help="Of the report.")
@common_options(reads=False)
def command(
    adapter: tuple[str, ...],
    adapter_command: tuple[str, ...],
    adapter_format: str,
    timeout: float | None,
    suite: Path | None,
    expression: str,
    shard: Shard | None,
    jobs: int,
    cluster: str | None,
    resume: Path | None,
    ledger: Path | None,
    draft_ledger: Path | None,
    traces: Path | None,
    given: str | None,
    common: Common,
) -> None:
    """Run decoders against the suite.

    ADAPTER: a TOML file that says how a decoder is asked, decoder:NAME for an installed Python decoder (entry point of
    the group snhc.decoders), or snhc for the built-in reference decoder.

    Without an adapter the built-in reference decoder is validated. Fields of --filter: id (the default), tier, kind,
    rule, feature, class, tool; globs, | between alternatives, ! before a term that must not hold.

    With -o FILE results are kept in FILE.journal until the report is written; after an interrupt --resume goes on
    with it.

    Exit codes: 0 every decoder passes, 1 one fails (an empty run fails), 2 usage, 3 a file cannot be read, 5 an adapter
    file is wrong, or nothing but the adapters is at fault.
    """
    from snhc.conformance import adapters as kinds
    from snhc.conformance import ledger as ledgers
    from snhc.conformance.filters import selector
    from snhc.conformance.reports import render
    from snhc.conformance.runner import run
    from snhc.reference_impl.bitstream.errors import InputFormat
    from snhc.vectors.manifest import SUITE, load

    style = format_of(given, common.output, REPORT_SUFFIXES, "terminal")
    try:
        select = selector(expression)
    except InputFormat as error:
        raise click.BadParameter(error.message, param_hint="--filter") from error
    decoders: list[Adapter] = [kinds.find(word) for word in adapter]
    decoders += [kinds.from_command(text, format=adapter_format) for text in adapter_command]
    words = [f"--timeout {timeout:g}"] if timeout is not None else []
    if timeout is not None:
        decoders = [one.timed(timeout) for one in decoders]
    decoders = decoders or [kinds.BuiltIn()]
    if common.readings.chosen:
        decoders = [one.following(common.readings.chosen) for one in decoders]
        words += [f"--reading {id}={key}" for id, key in common.readings.chosen.items()]
    folder = suite if suite is not None else SUITE
    known = ledgers.load(ledger) if ledger is not None else None
    journal = resume if resume is not None else _journal(common.output)
    with progress(common, "run", 0) as bar:
        shown = _Shown(bar)
        try:
            report = run(
                load(folder), decoders, suite=folder, select=select, filter=expression, jobs=jobs,
                shard=shard, cluster=cluster, journal=journal, resume=resume is not None, ledger=known, traces=traces,
                words=" ".join(words), progress=shown,
            )  # fmt: skip
        except KeyboardInterrupt:
            if journal is not None:
                click.echo(f"snhc: interrupted after {shown.words}; go on with --resume {journal}", err=True)
            raise
    with Output(common.output, common.keep_partial) as out:
        out.write(render(report, style, colour=colour_allowed(out.is_terminal)))
    sys.stdout.flush()
    if common.output not in (None, "-") and not common.quiet and not common.json_errors:
        # The report says it too, but nobody looks into a file to learn whether there is anything to look for.
        from snhc.conformance.reports.terminal import verdict_text

        click.echo(verdict_text(report, colour=colour_allowed(sys.stderr.isatty())), err=True, nl=False)
    if draft_ledger is not None:
        with Output(str(draft_ledger)) as out:
            out.write(ledgers.draft(report.results, date.today()))
    if journal is not None:
        journal.unlink(missing_ok=True)
    if report.exit_code:
        raise click.exceptions.Exit(report.exit_code)


def _journal(output: str | None) -> Path | None:
    if output is None or output == "-":
        return None
    path = Path(output)
    # A device keeps no journal beside it.
    return path.with_name(path.name + ".journal") if path.is_file() or not path.exists() else None


class _Shown:
    """How far the run is: on a bar, and in words for an interrupt."""

    def __init__(self, bar: Callable[..., None] | None) -> None:
        self._bar = bar
        self.words = "nothing"

    def __call__(self, progress: Progress) -> None:
        self.words = f"{progress.done} of {progress.total}"
        if self._bar is not None:
            self._bar(progress.done, progress.total)
