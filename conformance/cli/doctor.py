"""`snhc doctor`: what is wrong with an adapter.

Rules: CNF-13, CNF-19.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from .common import Common, InputPath, Output, colour_allowed, common_options, format_of

if TYPE_CHECKING:
    from snhc.conformance.diagnosis import Diagnosis

_FORMATS: Final = {".json": "json", ".txt": "terminal"}
_STYLES: Final = {"ok": "green", "wrong": "red", "decoder": "red", "note": "yellow", "not_run": "bright_black"}
_WORDS: Final = {"ok": "ok", "wrong": "WRONG", "decoder": "DIFFERS", "note": "note", "not_run": "not run"}
_VERDICTS: Final = {
    0: "the adapter is in order: snhc run {} is next",
    1: "the adapter is in order, the decoder is not right: snhc run {} shows more",
    5: "the adapter has to be corrected",
}


@click.command()
@click.argument("adapter")
@click.option(
    "--suite", type=InputPath(folder=True), metavar="DIR",
    help="Folder of the suite; the one of this installation if not given.",
)  # fmt: skip
@click.option("--format", "given", type=click.Choice(["terminal", "json"]), help="Of the report.")
@common_options(reads=False)
def command(adapter: str, suite: Path | None, given: str | None, common: Common) -> None:
    """Walk an adapter through every step and say what is wrong.

    ADAPTER: a TOML file, or decoder:NAME for an installed Python decoder.

    Exit codes: 0 all is well, 1 the adapter works and the decoder is wrong, 2 usage, 5 the adapter is at fault.
    """
    from snhc.conformance.doctor import examine
    from snhc.vectors.manifest import SUITE, load

    style = format_of(given, common.output, _FORMATS, "terminal")
    folder = suite if suite is not None else SUITE
    diagnosis = examine(adapter, load(folder, check_schema=suite is not None), folder)
    with Output(common.output, common.keep_partial) as out:
        if style == "json":
            out.write(json.dumps(diagnosis.as_json(), ensure_ascii=False, indent=1) + "\n")
        else:
            out.write(_text(diagnosis, colour=colour_allowed(out.is_terminal)))
    if diagnosis.exit_code:
        raise click.exceptions.Exit(diagnosis.exit_code)


def _text(diagnosis: Diagnosis, colour: bool) -> str:
    from snhc.conformance.diagnosis import GUIDE
    from snhc.reference_impl.bitstream.errors import one_line

    lines: list[str] = []
    for step in diagnosis.steps:
        state = f"{_WORDS[step.state]:8}"
        shown = click.style(state, fg=_STYLES[step.state]) if colour else state
        lines.append(f"{shown}{step.name:9}{one_line(step.what)}")
        if step.fix:
            lines.append(f"{'':17}fix: {one_line(step.fix)}")
        if step.section:
            lines.append(f'{"":17}see: {GUIDE}, "{step.section}"')
    lines.append(_VERDICTS[diagnosis.exit_code].format(diagnosis.adapter))
    return "\n".join(lines) + "\n"
