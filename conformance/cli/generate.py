"""`snhc generate`: make the suite from its recipes, check it, export it, or say what changed since an older one.

Rules: CNF-3, CNF-4, CNF-19.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, format_of

if TYPE_CHECKING:
    from collections.abc import Iterable


@click.command()
@click.option("--check", is_flag=True, help="Compare instead of writing; exit 1 on a mismatch.")
@click.option(
    "--export", metavar="DIR", help="Write the suite as a folder that needs no Python; NAME.tar.gz: as an archive."
)
@click.option(
    "--changes", type=click.Path(path_type=Path), metavar="OLD",
    help="What changed since OLD, an older suite's folder or manifest; exit 1 where ids or version break the rules.",
)  # fmt: skip
@click.option("--format", type=click.Choice(["text", "json"]), help="Of --changes. Default: by -o, else text.")
@click.option(
    "--suite", type=click.Path(file_okay=False, path_type=Path), metavar="DIR",
    help="Folder of the suite; the one of this installation if not given.",
)  # fmt: skip
@common_options(reads=False)
def command(
    check: bool, export: str | None, changes: Path | None, format: str | None, suite: Path | None, common: Common
) -> None:
    """Make the suite's vectors, check or export them, or list changes.

    Alone it makes the folder hold exactly what the recipes make. The options write nothing there.

    --check names every file that differs, is missing or is left over on standard output.

    --export takes the suite as it is, held against its manifest. A folder is left whole or not at all.
    """
    from snhc.vectors.generate import RecipeFault
    from snhc.vectors.manifest import SUITE

    if sum((check, export is not None, changes is not None)) > 1:
        raise click.UsageError("--check, --export and --changes exclude each other")
    if format is not None and changes is None:
        raise click.UsageError("--format goes with --changes")
    folder = suite if suite is not None else SUITE
    failed = False
    lines: Iterable[str]
    try:
        if changes is not None:
            lines, failed = _changes(changes, folder, format_of(format, common.output, _SUFFIXES, "text"))
        elif export is not None:
            lines = _export(export, folder)
        elif check:
            lines, failed = _check(folder)
        else:
            lines = _make(folder)
    except RecipeFault as error:
        failed, lines = True, ()
        click.echo(f"recipe: {error}", err=True)
    with Output(common.output, common.keep_partial) as out:
        out.write("".join(lines))
    if failed:
        raise click.exceptions.Exit(1)


_SUFFIXES = {".json": "json", ".txt": "text"}


def _make(folder: Path) -> list[str]:
    from snhc.vectors.generate import generate
    from snhc.vectors.manifest import MANIFEST_NAME

    files = generate(folder)
    vectors = json.loads(files[MANIFEST_NAME])["vectors"]
    return [f"{len(vectors)} vectors, {len(files)} files with {MANIFEST_NAME} in {folder}\n"]


def _check(folder: Path) -> tuple[list[str], bool]:
    from snhc.vectors.generate import check

    found = check(folder)
    lines = [f"{mismatch.what}: {mismatch.file}\n" for mismatch in found]
    return lines or ["the suite is what the recipes make\n"], bool(found)


def _export(target: str, folder: Path) -> list[str]:
    from snhc.vectors.export import ARCHIVE, archive, export_files, write_export
    from snhc.vectors.manifest import load

    if not target.endswith(ARCHIVE):
        files = write_export(Path(target), folder)
    else:
        files = export_files(folder)
        with Output(target) as out:
            out.write(archive(files, f"snhc-suite-{load(folder).suite}"))
    return [f"{len(files)} files in {target}\n"]


def _changes(old: Path, folder: Path, format: str) -> tuple[Iterable[str], bool]:
    from snhc.vectors.changes import changes_between, load_old
    from snhc.vectors.manifest import load

    found = changes_between(load_old(old), load(folder))
    return [found.text()] if format == "json" else found.lines(), found.failed
