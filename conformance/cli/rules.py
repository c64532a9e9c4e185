"""`snhc rules`: the register in the terminal.

Rules: CNF-8, CNF-23, CNF-24.
"""

from __future__ import annotations

import click

from .common import Common, Output, common_options, near


@click.command()
@click.argument("id", required=False)
@common_options(reads=False)
def command(id: str | None, common: Common) -> None:
    """Print the rules, ambiguities and findings.

    Without ID: all rules, one per line. ID: a rule (FBA-26), an area (FBA), an ambiguity (AMB-FBA-6), all of them
    (AMB), a kind of finding (no-end-code) or all of them (findings).
    """
    with Output(common.output, common.keep_partial) as out:
        for line in _lines(id):
            out.write(line + "\n")


def _lines(id: str | None) -> list[str]:
    from snhc.reference_impl import rules
    from snhc.reference_impl.bitstream.errors import InputFormat

    if id is None:
        return list(rules.listing())
    name = id.lower() if id.lower() == "findings" else id.upper()
    if name in rules.AREAS:
        return [line for line in rules.listing() if line.startswith(f"{name}-")]
    if name == "AMB":
        return [f"{entry.id:<10} {entry.question} [{entry.followed}]" for entry in rules.ambiguities().values()]
    if name == "findings":
        return [f"{kind.id:<26} {kind.severity:<8} {kind.description}" for kind in rules.findings().values()]
    try:
        return [rules.describe(name if name.split("-")[0] in (*rules.AREAS, "AMB") else id.lower())]
    except InputFormat as error:
        known = (*rules.rules(), *rules.ambiguities(), *rules.findings())
        if name in known or id.lower() in known:
            # The id is known, so the register itself is broken.
            raise
        hint = near(name, known) or near(id.lower(), known)
        raise click.BadParameter(f"no rule, ambiguity or finding {id!r}{hint}", param_hint="ID") from error
