"""What verbs say when an optional part of the installation is missing.

Rules: CNF-19.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import click

# What the extra `view` brings; anything else that cannot be imported is a bug.
_VIEW: Final = frozenset({"numpy", "scipy", "skimage", "PIL", "trimesh", "pyvista", "matplotlib", "vtk"})


class MissingExtra(click.ClickException):
    """An extra is needed and not installed. Rules: CNF-19."""

    exit_code = 2


@contextmanager
def needs_view(verb: str) -> Iterator[None]:
    """Imports inside may need `snhc[view]`; without it one line says so. Rules: CNF-19."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in _VIEW:
            raise
        raise MissingExtra(f"{verb} needs the extra snhc[view] ({error.name} is not installed)") from None
