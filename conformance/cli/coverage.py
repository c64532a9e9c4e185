"""`snhc coverage`: which cells of syntax and decoder the suite reaches; the book of it, printed, checked or made anew.

Rules: CNF-8, CNF-19.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from .common import Common, Output, common_options, format_of

if TYPE_CHECKING:
    from snhc.vectors.coverage.book import Book

_FORMATS: Final = {".json": "json", ".txt": "terminal", ".html": "html", ".md": "markdown"}
_FILE: Final = click.Path(dir_okay=False, path_type=Path)
_FOLDER: Final = click.Path(file_okay=False, path_type=Path)


@click.command()
@click.option(
    "--check", is_flag=True, help="Run the suite; exit 1 where a cell is lost or the book is not what it gives."
)
@click.option("--update", is_flag=True, help="Run the suite and write the book of this installation anew.")
@click.option("--rule", multiple=True, metavar="ID", help="Only cells of a rule (FBA-26) or an area (FBA). Repeatable.")
@click.option("--cell", default="", metavar="TEXT", help="Only cells with this text in their name.")
@click.option("--holes", is_flag=True, help="Only cells that no vector reaches.")
@click.option(
    "--format", "given", type=click.Choice(["terminal", "json", "html", "markdown"]),
    help="Form of the output; from the file name of -o if not given, else terminal. markdown: with --mutants.",
)  # fmt: skip
@click.option("--mutants", is_flag=True, help="The kill matrix: which mistakes of a decoder which vectors show.")
@click.option("--mutant", multiple=True, metavar="GLOB", help="Only mutants with such ids. Repeatable, with --mutants.")
@click.option("--matrix", type=_FILE, metavar="FILE", help="The matrix; the one of this installation if not given.")
@click.option("-j", "--jobs", type=click.IntRange(min=1), default=2, show_default=True, help="Processes of --mutants.")
@click.option("--book", type=_FILE, metavar="FILE", help="The book; the one of this installation if not given.")
@click.option(
    "--suite", type=_FOLDER, metavar="DIR", help="The suite to run; the one of this installation if not given."
)
@common_options(reads=False)
def command(
    check: bool,
    update: bool,
    rule: tuple[str, ...],
    cell: str,
    holes: bool,
    given: str | None,
    mutants: bool,
    mutant: tuple[str, ...],
    matrix: Path | None,
    jobs: int,
    book: Path | None,
    suite: Path | None,
    common: Common,
) -> None:
    """Show what the suite covers, and its holes.

    Without filters: the shares of all kinds of cells and all areas of rules. With them: the cells and their vectors.
    The book is part of the installation; --check and --update run the suite and need the extra snhc[test].

    With --mutants: the kill matrix instead of the book. --check runs every mutant and exits with 1 where one survives
    without a reason or a vector no longer shows it; --update writes the matrix anew, with --mutant only those lines.
    """
    if check and update:
        raise click.UsageError("--check and --update do not go together")
    if (check or update) and (rule or cell or holes or given):
        raise click.UsageError("--check and --update are of the whole book: no filters, no format")
    if mutants:
        if book is not None or suite is not None:
            raise click.UsageError("--book and --suite are of the book, not of --mutants")
        _mutants(check, update, given, mutant, matrix, jobs, common)
        return
    if mutant or matrix is not None:
        raise click.UsageError("--mutant and --matrix go with --mutants")
    if check or update:
        good, lines = _measured("--check" if check else "--update", book, suite)
        with Output(common.output, common.keep_partial) as out:
            out.write("".join(f"{line}\n" for line in lines))
        if not good:
            raise click.exceptions.Exit(1)
        return
    if suite is not None:
        raise click.UsageError("--suite goes with --check or --update")
    from snhc.vectors.coverage import book as books

    style = format_of(given, common.output, _FORMATS, "terminal")
    if style == "markdown":
        raise click.UsageError(f"{style} is a form of --mutants")
    filtered = bool(rule or cell or holes)
    shown = books.load_book(book or books.BOOK_FILE)
    if filtered:
        shown = shown.select([name.upper() for name in rule], cell, holes)
        if not shown.rows:
            raise click.UsageError("no cell fits")
    with Output(common.output, common.keep_partial) as out:
        for text in _texts(shown, style, filtered):
            out.write(text)


def _mutants(
    check: bool,
    update: bool,
    given: str | None,
    only: tuple[str, ...],
    matrix: Path | None,
    jobs: int,
    common: Common,
) -> None:
    from . import coverage_mutants as of_mutants

    if check or update:
        run = of_mutants.check if check else of_mutants.update
        good, lines = run(common, matrix, only, jobs)
        with Output(common.output, common.keep_partial) as out:
            out.write("".join(f"{line}\n" for line in lines))
        if not good:
            raise click.exceptions.Exit(1)
        return
    style = format_of(given, common.output, _FORMATS, "terminal")
    with Output(common.output, common.keep_partial) as out:
        for text in of_mutants.texts(matrix, style, only):
            out.write(text)


def _texts(book: Book, style: str, filtered: bool) -> Iterator[str]:
    if style == "json":
        yield book.text()
    elif style == "html":
        from snhc.vectors.coverage.page import page

        yield page(book)
    else:
        from snhc.vectors.coverage.text import cell_lines, summary_lines

        for line in cell_lines(book) if filtered else summary_lines(book):
            yield line + "\n"


def _measured(option: str, book: Path | None, suite: Path | None) -> tuple[bool, list[str]]:
    """Whether all is well, and the lines to print. Branches of compiled code cannot be watched."""
    from .version import form

    _needs_library(option)
    if form() == "compiled":
        return _in_pure_form(option, book, suite)
    return _check(book, suite) if option == "--check" else _update(book, suite)


def _in_pure_form(option: str, book: Path | None, suite: Path | None) -> tuple[bool, list[str]]:
    import os
    import subprocess
    import sys

    words = [sys.executable, "-m", "snhc.conformance.cli", "coverage", option]
    for name, value in (("--book", book), ("--suite", suite)):
        words += [name, str(value)] if value is not None else []
    ended = subprocess.run(words, stdout=subprocess.PIPE, text=True, env={**os.environ, "SNHC_PURE": "1"}, check=False)
    if ended.returncode not in (0, 1):
        raise click.exceptions.Exit(ended.returncode)
    return ended.returncode == 0, ended.stdout.splitlines()


def _check(book: Path | None, suite: Path | None) -> tuple[bool, list[str]]:
    from snhc.vectors.coverage import book as books
    from snhc.vectors.manifest import SUITE

    faults = books.check(book or books.BOOK_FILE, suite or SUITE)
    return not faults, faults or ["the book is what the suite reaches"]


def _update(book: Path | None, suite: Path | None) -> tuple[bool, list[str]]:
    from snhc.reference_impl.bitstream.errors import InputFormat
    from snhc.vectors.coverage import book as books
    from snhc.vectors.manifest import SUITE

    path = book or books.BOOK_FILE
    new, faults = books.make_book(suite or SUITE)
    if path.exists():
        try:
            faults = [f"lost: {key}" for key in books.lost(books.load_book(path), new)] + faults
        except InputFormat as error:
            faults = [f"the old book is not compared: {error}", *faults]
    with Output(str(path)) as out:
        out.write(new.text())
    share = new.share()
    return not faults, [*faults, f"{share.covered} of {share.total} cells are covered: {path}"]


def _needs_library(option: str) -> None:
    from importlib.util import find_spec

    if find_spec("coverage") is None:
        from .extras import MissingExtra

        raise MissingExtra(f"snhc coverage {option} needs the extra snhc[test] (coverage is not installed)")
