"""`snhc coverage --mutants`: the kill matrix, printed, checked or made anew.

Rules: CNF-8, CNF-18, CNF-19.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from itertools import count
from pathlib import Path

import click

from snhc.vectors.mutants import matrix as matrices
from snhc.vectors.mutants.matrix import Matrix, lost_kills
from snhc.vectors.mutants.mutant import Mutant, MutantFault, all_mutants

from .common import Common, Output, progress


def texts(path: Path | None, style: str, only: Sequence[str]) -> Iterator[str]:
    """A saved matrix in one of the formats; with `only` the mutants that these globs name.

    Rules: CNF-8. Raises InputFormat for a file that is no matrix.
    """
    from snhc.vectors.mutants.page import page
    from snhc.vectors.mutants.text import markdown_lines, mutant_lines, summary_lines

    shown = matrices.load_matrix(path or matrices.MATRIX)
    if only:
        lines = tuple(line for line in shown.lines if _fits(line.id, only))
        if not lines:
            raise click.UsageError("no mutant fits")
        shown = Matrix(shown.suite, shown.vectors, shown.complete, lines)
    if style == "json":
        yield shown.text()
    elif style == "html":
        yield from page(shown)
    else:
        lines_of = markdown_lines if style == "markdown" else mutant_lines if only else summary_lines
        for line in lines_of(shown):
            yield line + "\n"


def check(common: Common, path: Path | None, only: Sequence[str], jobs: int) -> tuple[bool, list[str]]:
    """Run all mutants, or some, against the suite of this installation.

    Rules: CNF-8. Faults: a mutant that does not fit the decoder, a survivor without a reason, a kill of the saved
    matrix that is lost, a mutant that the saved matrix does not have.
    """
    saved = matrices.load_matrix(path or matrices.MATRIX)
    found = _run(common, only, jobs)
    if isinstance(found, str):
        return False, [found]
    faults = _unexplained(found)
    faults += [f"lost: {vector} no longer shows {mutant}" for mutant, vector in lost_kills(saved, found)]
    known = {line.id for line in saved.lines}
    faults += [f"not in the matrix: {line.id}" for line in found.lines if line.id not in known]
    good = f"{len(found.lines)} mutants: no kill is lost, no survivor is without a reason"
    return not faults, faults or [good]


def update(common: Common, path: Path | None, only: Sequence[str], jobs: int) -> tuple[bool, list[str]]:
    """Run all mutants and write the matrix anew; or some, whose lines replace those of the saved one.

    Rules: CNF-8. Faults: survivors without a reason; it is written all the same.
    """
    found = _run(common, only, jobs)
    if isinstance(found, str):
        return False, [found]
    target = path or matrices.MATRIX
    if only:
        found = matrices.merged(matrices.load_matrix(target), found, list(all_mutants()))
    with Output(str(target)) as out:
        out.write(found.text())
    faults = _unexplained(found)
    shown = sum(bool(line.kills) for line in found.lines)
    return not faults, [*faults, f"{shown} of {len(found.lines)} mutants are shown by a vector: {target}"]


def _fits(id: str, only: Sequence[str]) -> bool:
    return any(fnmatchcase(id, glob) for glob in only)


def _run(common: Common, only: Sequence[str], jobs: int) -> Matrix | str:
    from snhc.conformance.kill_matrix import Found, kill_matrix

    mutants: list[Mutant] = [mutant for id, mutant in all_mutants().items() if not only or _fits(id, only)]
    if not mutants:
        raise click.UsageError("no mutant fits")
    try:
        with progress(common, "mutants", len(mutants)) as advance:
            done = count(1)

            def tell(found: Found) -> None:
                if advance is not None:
                    advance(next(done), len(mutants))

            return kill_matrix(mutants, jobs=jobs, progress=tell)
    except MutantFault as fault:
        return str(fault)


def _unexplained(found: Matrix) -> list[str]:
    return [
        f"survives without a reason: {line.id}" if not line.kills else f"shown, although it has a reason: {line.id}"
        for line in found.unexplained
    ]
