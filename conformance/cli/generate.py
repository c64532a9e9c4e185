"""`snhc generate`: make the suite from its recipes, or check that it is what they make.

Rules: CNF-4, CNF-19.
"""

from __future__ import annotations

import json
from pathlib import Path

import click

from .common import Common, Output, common_options


@click.command()
@click.option("--check", is_flag=True, help="Compare instead of writing; exit 1 on a mismatch.")
@click.option(
    "--suite", type=click.Path(file_okay=False, path_type=Path), metavar="DIR",
    help="Folder of the suite; the one of this installation if not given.",
)  # fmt: skip
@common_options(reads=False)
def command(check: bool, suite: Path | None, common: Common) -> None:
    """Make the suite's vectors, or check them.

    Without --check the folder is made to hold exactly what the recipes make. With it nothing is written: every file
    that differs, is missing or is left over is named on standard output.
    """
    from snhc.vectors.generate import RecipeFault, generate
    from snhc.vectors.generate import check as mismatches
    from snhc.vectors.manifest import MANIFEST_NAME, SUITE

    folder = suite if suite is not None else SUITE
    lines: list[str] = []
    failed = False
    try:
        if check:
            found = mismatches(folder)
            failed = bool(found)
            lines = [f"{mismatch.what}: {mismatch.file}" for mismatch in found]
            lines = lines or ["the suite is what the recipes make"]
        else:
            files = generate(folder)
            vectors = json.loads(files[MANIFEST_NAME])["vectors"]
            lines = [f"{len(vectors)} vectors, {len(files)} files with {MANIFEST_NAME} in {folder}"]
    except RecipeFault as error:
        failed = True
        click.echo(f"recipe: {error}", err=True)
    with Output(common.output, common.keep_partial) as out:
        out.write("".join(f"{line}\n" for line in lines))
    if failed:
        raise click.exceptions.Exit(1)
