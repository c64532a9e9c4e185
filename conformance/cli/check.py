"""`snhc check`: the findings of a stream, a text, a face definition or a table.

Rules: CNF-2, CNF-19, CNF-23.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, open_binary

if TYPE_CHECKING:
    from snhc.reference_impl.bitstream.findings import Finding

# In ascending order, as in `findings.SEVERITIES`; a test compares them.
SEVERITIES = ("info", "warning", "error")


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
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(file: str, fail_on: str, format_: str, tolerance: float | None, object_number: int, common: Common) -> None:
    """Print the findings of an input.

    FILE: a stream, .fap text, a face definition (JSON or .fdp), a FAT model or a FIT as JSON; - for standard input.
    What it is, its content tells. With --format json a finding is one JSON line.
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
            options = CheckOptions(tolerance, common.options(object_number), common.limits, common.strict)
            check_input(stream, report, options)  # type: ignore[arg-type]
    if worst >= SEVERITIES.index(fail_on):
        raise click.exceptions.Exit(1)
