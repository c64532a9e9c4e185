"""`snhc check`: the findings of a stream, a text, a face definition or a table.

Rules: CNF-2, CNF-19, CNF-23.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .common import Common, InputPath, Output, common_options, open_binary

if TYPE_CHECKING:
    from snhc.analyzer.policy import Policy
    from snhc.analyzer.profiles import LevelReport
    from snhc.reference_impl.bitstream.findings import Finding
    from snhc.reference_impl.tables import ProfileLevel

# In ascending order, as in `findings.SEVERITIES`; a test compares them.
SEVERITIES = ("info", "warning", "error")


SIGNALLED = "signalled"


def parse_profile(value: str | None) -> ProfileLevel | str | None:
    """`simple-face@L1` as the profile and level, `signalled` as it is. Rules: SYS-8. Raises click.BadParameter."""
    if value is None or value == SIGNALLED:
        return value
    from snhc.analyzer.profiles import name_of, profile_of
    from snhc.reference_impl.tables import profile_level_codes

    found = profile_of(value)
    if found is None:
        names = ", ".join(name_of(entry) for entry in profile_level_codes())
        raise click.BadParameter(f"{value!r} is none of {names}, {SIGNALLED}")
    return found


@click.command()
@click.argument("file")
@click.option(
    "--fail-on", type=click.Choice(SEVERITIES), default="error", show_default=True,
    help="Exit with 1 where a finding is at least this severe.",
)  # fmt: skip
@click.option("--format", "format_", type=click.Choice(("text", "json")), default="text", show_default=True)
@click.option(
    "--tolerance", type=click.FloatRange(min=0), metavar="LENGTH",
    help="How far feature points may be from their places, in model units. Default: 2 % of ES0.",
)  # fmt: skip
@click.option(
    "--profile", "profile", metavar="NAME@LEVEL", callback=lambda ctx, param, value: parse_profile(value),
    help="Hold a stream against a profile and level, e.g. simple-face@L1; `signalled`: those that it signals.",
)  # fmt: skip
@click.option(
    "--policy", "policies", type=InputPath(), multiple=True,
    metavar="FILE", help="Rules of your own for streams (TOML). Repeatable.",
)  # fmt: skip
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(
    file: str,
    fail_on: str,
    format_: str,
    tolerance: float | None,
    profile: ProfileLevel | str | None,
    policies: tuple[Path, ...],
    object_number: int,
    common: Common,
) -> None:
    """Print the findings of an input.

    FILE: a stream, .fap text, a face definition (JSON or .fdp), a FAT model or a FIT (JSON, or the text of their
    nodes); - for standard input. What it is, its content tells. With --format json a finding is one JSON line.
    --profile measures all objects of a stream: bit rates, frame rates, faces; limits are known for Simple Face
    Animation, all else is not_checked. --policy holds a stream against rules of your own.

    Exit codes: 0 no finding at --fail-on or above, 1 there is one, 2 usage, 3 input or I/O, 4 it does not decode.
    """
    from snhc.analyzer.check import CheckOptions, check_input

    worst = -1

    with Output(common.output, common.keep_partial) as out:

        def report(finding: Finding) -> None:
            nonlocal worst
            worst = max(worst, SEVERITIES.index(finding.severity))
            text = json.dumps(finding.as_json(), ensure_ascii=False) if format_ == "json" else str(finding)
            out.write(text + "\n")

        with open_binary(file) as stream:
            options = CheckOptions(
                tolerance, common.options(object_number), common.limits, common.strict,
                policies=_loaded(policies), levels=profile is not None,
                profile=None if isinstance(profile, str) else profile,
                folder=None if file == "-" else Path(file).parent,
            )  # fmt: skip
            checked = check_input(stream, report, options)  # type: ignore[arg-type]
        if (profile is not None or policies) and checked.kind != "stream":
            option = "--policy" if policies else "--profile"
            raise click.UsageError(f"{option} is for streams; {file} is of kind {checked.kind}")
        if checked.levels is not None:
            _print_levels(out, checked.levels, format_)
    if worst >= SEVERITIES.index(fail_on):
        raise click.exceptions.Exit(1)


def _loaded(files: tuple[Path, ...]) -> tuple[Policy, ...]:
    if not files:
        return ()
    from snhc.analyzer.policy import load_policy

    return tuple(load_policy(file) for file in files)


def _print_levels(out: Output, levels: LevelReport, format_: str) -> None:
    from snhc.analyzer.profiles import report_lines

    if format_ == "json":
        out.write(json.dumps(levels.as_json(), ensure_ascii=False) + "\n")
        return
    for line in report_lines(levels):
        out.write(line)
