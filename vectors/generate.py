"""Making the suite from its recipes, and checking that it is what the recipes make.

Rules: CNF-3, CNF-4. Nothing here reads a clock, the environment, or the order of a hash. One vector: `making`.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from snhc.reference_impl.rules import rules

from .making import RecipeFault, make
from .manifest import MANIFEST_NAME, SUITE, Entry, Manifest, Tombstone, validate
from .recipe import Recipe, all_recipes

__all__ = [
    "Mismatch",
    "RecipeFault",
    "build_suite",
    "check",
    "compare",
    "generate",
    "make",
    "tombstones",
    "write_suite",
]

SUITE_VERSION: Final = "0.1.0"
# Stands in a folder while a suite is written to it, and remains where that was cut short.
UNFINISHED: Final = ".snhc-unfinished"
_LEFT_OVER: Final = "left over"
TOMBSTONES: Final = Path(__file__).parent / "tombstones.toml"


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A file of a suite that is not what the recipes make. Rules: CNF-4. `what`: `differs`, `missing`, `left over`."""

    file: str
    what: str


def tombstones(path: Path = TOMBSTONES) -> tuple[Tombstone, ...]:
    """The ids that are used up. Rules: CNF-3."""
    import tomllib

    entries = tomllib.loads(path.read_text(encoding="utf-8"))
    return tuple(Tombstone(id, entry["removed"], entry["reason"]) for id, entry in sorted(entries.items()))


def build_suite(
    recipes: Iterable[Recipe] | None = None,
    progress: Callable[[str], None] | None = None,
    *,
    version: str = SUITE_VERSION,
    dead: tuple[Tombstone, ...] | None = None,
) -> dict[str, bytes]:
    """All files of a suite by name, the manifest included. Rules: CNF-3, CNF-4.

    `recipes`: None for those of this package. `version`: of the suite. `dead`: its tombstones, None for this suite's.

    Raises RecipeFault for a recipe that the decoder contradicts, that names an unknown rule, or a dead id.
    """
    known = rules()
    dead = tombstones() if dead is None else dead
    files: dict[str, bytes] = {}
    entries: list[Entry] = []
    for recipe in all_recipes().values() if recipes is None else recipes:
        if progress is not None:
            progress(recipe.id)
        if recipe.id in {tombstone.id for tombstone in dead}:
            raise RecipeFault(f"{recipe.id}: this id was used before")
        made = make(recipe)
        unknown = [rule for rule in made.entry.rules if rule not in known]
        if unknown:
            raise RecipeFault(f"{recipe.id}: no such rule: {', '.join(unknown)}")
        entries.append(made.entry)
        files.update(made.files)
    manifest = Manifest(version, tuple(sorted(entries, key=lambda entry: entry.id)), dead)
    validate(manifest.as_json())
    files[MANIFEST_NAME] = manifest.text().encode()
    return dict(sorted(files.items()))


def generate(target: Path = SUITE) -> dict[str, bytes]:
    """Write the suite to a folder, which then holds nothing else. Rules: CNF-4. Raises as `write_suite`."""
    files = build_suite()
    write_suite(files, target)
    return files


def write_suite(files: dict[str, bytes], target: Path) -> None:
    """Make a folder hold the files of a suite and nothing else. Rules: CNF-4.

    Refuses (RecipeFault) a folder that is neither empty nor a suite. A kill at any moment leaves every file whole, and
    a manifest that is the old or the new one; writing again completes the folder.
    """
    mark = target / UNFINISHED
    if target.exists() and any(target.iterdir()) and not ((target / MANIFEST_NAME).is_file() or mark.is_file()):
        raise RecipeFault(f"{target} is neither empty nor a suite")
    mismatches = compare(files, target)
    if not mismatches:
        return
    target.mkdir(parents=True, exist_ok=True)
    mark.write_bytes(b"")
    # The manifest speaks of the files, so it comes behind all that it names and before what it no longer names goes.
    for mismatch in sorted(mismatches, key=lambda one: (one.what == _LEFT_OVER, one.file == MANIFEST_NAME)):
        path = target / mismatch.file
        if mismatch.what != _LEFT_OVER:
            _put(path, files[mismatch.file])
        elif path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path != mark:
            # What a kill left of a file may have become that file again.
            path.unlink(missing_ok=True)
    mark.unlink()


def _put(path: Path, content: bytes) -> None:
    """The whole content or none of it. A link stays a link: what it points to is replaced."""
    place = path.resolve()
    place.parent.mkdir(parents=True, exist_ok=True)
    fresh = place.with_name(f".{place.name[:200]}.part")
    fresh.write_bytes(content)
    fresh.replace(place)


def check(folder: Path = SUITE) -> list[Mismatch]:
    """Where a folder is not byte for byte what the recipes make. Rules: CNF-4."""
    return compare(build_suite(), folder)


def compare(files: dict[str, bytes], folder: Path) -> list[Mismatch]:
    """The files of a folder against what they should be, sorted by name. Rules: CNF-4."""
    out: list[Mismatch] = []
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file() or path.is_symlink()}
    for name, content in files.items():
        if name not in there:
            out.append(Mismatch(name, "missing"))
        elif (folder / name).read_bytes() != content:
            out.append(Mismatch(name, "differs"))
    out += [Mismatch(name, _LEFT_OVER) for name in there - set(files)]
    return sorted(out, key=lambda mismatch: mismatch.file)
