"""`snhc minimize`: the smallest stream on which a decoder still fails in the same way.

Rules: CNF-17, CNF-19.
"""

from __future__ import annotations

import shlex
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .common import Common, InputPath, Output, common_options, progress

if TYPE_CHECKING:
    from snhc.conformance.adapters import Adapter
    from snhc.conformance.minimize import Minimized, Subject

DUMP_LINES = 60


@click.command()
@click.argument("adapter")
@click.argument("vector", metavar="VECTOR|FILE")
@click.option(
    "--aux", type=InputPath(), metavar="FRAMES",
    help="The frames that FILE, a table, is used on.",
)  # fmt: skip
@click.option(
    "--suite", type=InputPath(folder=True), metavar="DIR",
    help="Folder of the suite that VECTOR is of; the one of this installation if not given.",
)  # fmt: skip
@click.option("--timeout", type=click.FloatRange(min=0.01), help="Seconds per run of the decoder.")
@click.option(
    "--runs", type=click.IntRange(min=1), default=1000, show_default=True, help="How often the decoder may be run."
)
@click.option(
    "--seconds", type=click.FloatRange(min=0), default=300.0, show_default=True,
    help="How long it may take; 0 for any time. The result depends on the machine where this ends it.",
)  # fmt: skip
@click.option("--check", is_flag=True, help="Do not shrink: say whether and how the decoder fails.")
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(
    adapter: str,
    vector: str,
    aux: Path | None,
    suite: Path | None,
    timeout: float | None,
    runs: int,
    seconds: float,
    check: bool,
    object_number: int,
    common: Common,
) -> None:
    """Shrink an input while a decoder still fails on it in the same way.

    ADAPTER: as for `snhc run`. VECTOR: an id of the suite; FILE: any stream or document, on which the decoder is held
    against the reference decoder. Planes, groups, FAPs, nodes, coefficients, headers are left out and numbers lowered.
    The smallest input goes to -o, by default NAME.min.EXT here; what it is and how to see it fail again is printed. An
    interrupt (Ctrl-C) leaves the smallest so far.

    Exit codes: 0 shrunk, 2 usage, 3 a file cannot be read or the decoder does not fail on it, 5 an adapter file is
    wrong. With --check: 0 it does not fail, 1 it fails.
    """
    from snhc.conformance import adapters as kinds
    from snhc.conformance.compare import BAD
    from snhc.conformance.minimize import Budget, Target, minimize
    from snhc.conformance.scratch import scratch

    decoder = kinds.find(adapter)
    if common.dct_tables is not None:
        raise click.UsageError("--dct-tables: decoders are held against the shipped tables")
    extra = ""
    if timeout is not None:
        decoder = decoder.timed(timeout)
        extra += f" --timeout {timeout:g}"
    if common.readings.chosen:
        decoder = decoder.following(common.readings.chosen)
        extra += "".join(f" --reading {id}={key}" for id, key in common.readings.chosen.items())
    subject = _subject(vector, aux, suite, object_number, common)
    try:
        with scratch() as folder:
            if check:
                verdict, _, _ = Target(decoder, subject, folder).ask(subject.data, subject.aux)
                with Output(common.output, common.keep_partial) as out:
                    out.write(f"{verdict.status}: {verdict.reason}\n" if verdict.reason else f"{verdict.status}\n")
                if verdict.status in BAD:
                    raise click.exceptions.Exit(1)
                return
            with progress(common, "minimize", runs) as bar:
                found = minimize(
                    decoder,
                    subject,
                    folder,
                    Budget(runs, seconds or None),
                    None if bar is None else lambda n, _: bar(n),
                )
            _tell(found, subject, decoder, shlex.quote(adapter) + extra, vector, folder, common)
            if found.interrupt is not None:
                raise found.interrupt
    finally:
        decoder.close()


def _subject(vector: str, aux: Path | None, suite: Path | None, object_number: int, common: Common) -> Subject:
    from snhc.conformance.minimize import subject_of_file, subject_of_vector
    from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
    from snhc.vectors.manifest import SUITE, DecodeOptions, load

    if Path(vector).is_file():
        limits = {
            name: getattr(common.limits, name)
            for name in DEFAULT_LIMITS.names()
            if getattr(common.limits, name) != getattr(DEFAULT_LIMITS, name)
        }
        options = DecodeOptions(common.draft, common.strict, object_number, limits)
        return subject_of_file(Path(vector), aux, options)
    folder = suite if suite is not None else SUITE
    for entry in load(folder).entries:
        if entry.id == vector:
            return subject_of_vector(entry, folder)
    raise click.BadParameter(f"{vector!r} is neither a file nor a vector of the suite", param_hint="VECTOR|FILE")


def _tell(
    found: Minimized, subject: Subject, decoder: Adapter, adapter: str, vector: str, folder: Path, common: Common
) -> None:
    from snhc.conformance.where import examine
    from snhc.reference_impl.bitstream.errors import one_line

    to_stdout = common.output == "-"
    place = Path(common.output or f"{Path(vector).stem if Path(vector).is_file() else vector}.min{_suffix(found)}")
    with Output("-" if to_stdout else str(place), common.keep_partial) as out:
        out.write(found.data)
    words = [str(place)]
    if found.aux is not None and not to_stdout:
        second = place.with_name(f"{place.stem}.frames.ndjson")
        with Output(str(second)) as out:
            out.write(found.aux)
        words += ["--aux", str(second)]
    entry = found.entry
    words += [
        word for flag, word in ((entry.options.draft, "--compat draft"), (entry.options.strict, "--strict")) if flag
    ]
    words += [f"--object {entry.options.object_number}"] if entry.options.object_number else []
    words += [f"--limit {name}={value}" for name, value in entry.options.limits.items()]
    evidence = examine(entry, folder, decoder, found.outcome, found.verdict)
    before = len(subject.data) + len(subject.aux or b"")
    after = len(found.data) + len(found.aux or b"")
    ended = "the budget is spent" if found.interrupt is None else "interrupted"
    lines = [
        f"{vector}: {before} bytes -> {after} bytes, {found.runs} runs of {decoder.name}"
        + ("" if found.complete else f"; {ended}, it may shrink further"),
        f"fails as before: {found.signature}",
        f"  {found.verdict.reason}",
    ]
    if evidence.location is not None:
        lines.append(f"  where: {evidence.location}")
    if not to_stdout:
        quoted = " ".join([shlex.quote(words[0]), *words[1:]])
        lines.append(f"  again: snhc minimize {adapter} {quoted} --check")
        lines.append(f"  input: {place}")
    for line in lines:
        click.echo(one_line(line), err=to_stdout)
    for line in _excerpt(found):
        click.echo(line, err=to_stdout)


def _suffix(found: Minimized) -> str:
    return Path(found.entry.file).suffix


def _excerpt(found: Minimized) -> list[str]:
    """The dump of a stream, or a document, as far as it can be looked over."""
    from snhc.analyzer.dump import dump_tree
    from snhc.analyzer.parts import Parts
    from snhc.reference_impl.bitstream.errors import InputFormat
    from snhc.reference_impl.bitstream.source import BytesSource
    from snhc.reference_impl.systems.stream import trace_stream
    from snhc.vectors.manifest import DOCUMENTS

    if found.entry.media in DOCUMENTS:
        from snhc.reference_impl.bitstream.errors import one_line

        text = found.data.decode("utf-8", "replace")
        return ["", *(one_line(line)[:2000] for line in text.splitlines()[:DUMP_LINES])]
    source = BytesSource(found.data)
    try:
        parts = Parts(trace_stream(source, found.entry.options.for_decoder()))
    except InputFormat as error:
        return ["", str(error)]
    lines = [line.rstrip("\n") for line in islice(dump_tree(parts, source), DUMP_LINES + 1)]
    if len(lines) > DUMP_LINES:
        lines[DUMP_LINES:] = ["... (snhc dump shows all)"]
    return ["", *lines]
