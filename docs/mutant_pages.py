"""The tables of the kill matrix, made from the matrix of the installed package."""

from __future__ import annotations

from pathlib import Path

from snhc.vectors.mutants.matrix import load_matrix
from snhc.vectors.mutants.text import markdown_lines


def write_kill_matrix(folder: Path) -> None:
    """Write the part that kill-matrix.md includes; it is no page of its own."""
    folder.mkdir(exist_ok=True)
    (folder / "kill-matrix.inc").write_text("\n".join(markdown_lines(load_matrix())) + "\n", encoding="utf-8")
