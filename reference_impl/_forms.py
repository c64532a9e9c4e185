"""The two forms of the codec: the same source, interpreted (pure) or compiled.

Where the package was built with a compiler, the hot modules stand beside their source as extension modules, and
Python takes those first. SNHC_PURE=1 makes it take the sources.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType


class _PureFinder:
    """Finds the modules of the codec by their source, whatever has been compiled beside it."""

    @classmethod
    def find_spec(
        cls, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The spec of a module's source; None for modules elsewhere."""
        if not name.startswith(f"{__package__}."):
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None or spec.origin is None or spec.origin.endswith(".py"):
            return spec
        source = Path(spec.origin).parent / (name.rpartition(".")[2] + ".py")
        if not source.exists():
            raise ImportError(f"SNHC_PURE is set, and {name} is there compiled only: {source} is missing", name=name)
        return spec_from_file_location(name, source, loader=SourceFileLoader(name, str(source)))


def _choose() -> None:
    if os.environ.get("SNHC_PURE", "") not in ("", "0"):
        sys.meta_path.insert(0, _PureFinder)


# Before any other module of the codec is loaded.
_choose()
