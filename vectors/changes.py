"""What changed between two suites, and the step that the version of the suite must take for it.

Rules: CNF-3. The form of the list is `changes.schema.json`.

    major   an input or an expectation of an id changed, or an id was removed
    minor   vectors were added
    patch   only words changed: titles, documentation, rules, features, tiers, notes
    none    nothing changed

That holds before 1.0.0 too. The version may take a larger step than it must. Ids are permanent: one that is gone needs
a tombstone, and one with a tombstone never comes back. What breaks this is an error; a version said of a vector or a
tombstone that does not lie between the two suites is a warning.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from .manifest import Entry, Manifest, load

FORMAT: Final = "snhc-changes"
VERSION: Final = 1
SCHEMA_FILE: Final = Path(__file__).parent / "changes.schema.json"
STEPS: Final = ("none", "patch", "minor", "major")
ADDED: Final = "added"
REMOVED: Final = "removed"
CHANGED: Final = "changed"

# What a decoder gets, and what is wanted of it: a change of these is another test.
_INPUT: Final = ("input", "options")
_EXPECTATION: Final = ("kind", "tools", "profile", "expect", "tolerance", "readings", "check")
_WORDS: Final = (
    "title", "description", "tier", "rules", "features", "value_classes", "provenance", "notes", "since", "files",
)  # fmt: skip

_SAID: Final = ("tombstone-version", "since")

Version = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Change:
    """One vector that is not as it was. Rules: CNF-3.

    `what`: added, removed, changed. `input`, `expectation`, `words`: the fields of the manifest that differ, by what
    they mean; `files` stands for files of the same content under other names. `step`: what it asks of the version.
    """

    id: str
    what: str
    step: str
    input: tuple[str, ...] = ()
    expectation: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    reason: str = ""

    def as_json(self) -> dict[str, Any]:
        """The entry of the list."""
        out: dict[str, Any] = {"id": self.id, "what": self.what, "step": self.step}
        if self.what == CHANGED:
            out |= {"input": list(self.input), "expectation": list(self.expectation), "words": list(self.words)}
        if self.what == REMOVED:
            out["reason"] = self.reason
        return out


@dataclass(frozen=True, slots=True)
class Fault:
    """What a suite must not do to its ids or its version. Rules: CNF-3. `id`: of the vector, "" for the suite."""

    kind: str
    id: str
    message: str

    @property
    def severity(self) -> str:
        """`error`, or `warning` for what is only said wrongly."""
        return "warning" if self.kind in _SAID else "error"

    def as_json(self) -> dict[str, Any]:
        """The entry of the list."""
        return {"fault": self.kind, "severity": self.severity, "id": self.id or None, "message": self.message}


@dataclass(frozen=True, slots=True)
class ChangeList:
    """Two suites side by side. Rules: CNF-3. `old`, `new`: their versions; `step`: what `new` must have taken."""

    old: str
    new: str
    step: str
    changes: tuple[Change, ...]
    faults: tuple[Fault, ...]

    @property
    def failed(self) -> bool:
        """Whether there is an error."""
        return any(fault.severity == "error" for fault in self.faults)

    @property
    def required(self) -> str:
        """The least version that the step allows."""
        return _text(_stepped(_version(self.old), self.step))

    def as_json(self) -> dict[str, Any]:
        """The document."""
        counts = {what: sum(change.what == what for change in self.changes) for what in (ADDED, REMOVED, CHANGED)}
        return {
            "format": FORMAT, "version": VERSION, "old": self.old, "new": self.new, "step": self.step,
            "required": self.required, "counts": counts, "changes": [change.as_json() for change in self.changes],
            "faults": [fault.as_json() for fault in self.faults],
        }  # fmt: skip

    def text(self) -> str:
        """The file's content."""
        return json.dumps(self.as_json(), ensure_ascii=False, indent=1) + "\n"

    def lines(self) -> Iterator[str]:
        """For people, line by line."""
        said = "no changes" if self.step == "none" else f"step {self.step}"
        yield f"suite {self.old} -> {self.new}: {said}\n"
        for what in (REMOVED, CHANGED, ADDED):
            chosen = [change for change in self.changes if change.what == what]
            if not chosen:
                continue
            yield f"\n{what} ({len(chosen)}):\n"
            for change in chosen:
                yield f"  {change.id}{_why(change)}\n"
        if self.faults:
            yield f"\nfaults ({len(self.faults)}):\n"
            for fault in self.faults:
                yield f"  {fault.severity}: {fault.kind}: {f'{fault.id}: ' if fault.id else ''}{fault.message}\n"


def _why(change: Change) -> str:
    if change.what == REMOVED:
        return f": {change.reason}" if change.reason else ""
    parts = [
        f"{name}: {', '.join(fields)}"
        for name, fields in (("input", change.input), ("expectation", change.expectation), ("words", change.words))
        if fields
    ]
    return f" [{change.step}] {'; '.join(parts)}" if parts else ""


def changes_between(old: Manifest, new: Manifest) -> ChangeList:
    """The change list of two suites. Rules: CNF-3."""
    before, after = ({entry.id: entry for entry in manifest.entries} for manifest in (old, new))
    reasons = {tombstone.id: tombstone.reason for tombstone in new.tombstones}
    found = [Change(id, ADDED, "minor") for id in after.keys() - before.keys()]
    found += [Change(id, REMOVED, "major", reason=reasons.get(id, "")) for id in before.keys() - after.keys()]
    found += [one for id in before.keys() & after.keys() if (one := _changed(before[id], after[id])) is not None]
    step = max((change.step for change in found), key=STEPS.index, default="none")
    if step == "none" and old.tombstones != new.tombstones:
        step = "patch"
    faults = [*_id_faults(old, new), *_version_faults(old, new, step)]
    return ChangeList(old.suite, new.suite, step, tuple(sorted(found, key=lambda one: one.id)), tuple(faults))


def _changed(before: Entry, after: Entry) -> Change | None:
    a, b = before.as_json(), after.as_json()
    # Names of files are no part of a test, their contents are.
    files = _without_names(a) != a and sorted(before.files()) != sorted(after.files())
    a, b = _without_names(a), _without_names(b)
    differ = {key for key in a.keys() | b.keys() if a.get(key) != b.get(key)} | ({"files"} if files else set())
    if not differ:
        return None
    input, expectation, words = (
        tuple(key for key in group if key in differ) for group in (_INPUT, _EXPECTATION, _WORDS)
    )
    return Change(before.id, CHANGED, "major" if input or expectation else "patch", input, expectation, words)


def _without_names(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_names(item) for key, item in value.items() if not (key == "file" and "sha256" in value)}
    return value


def _id_faults(old: Manifest, new: Manifest) -> Iterator[Fault]:
    before, after = ({entry.id for entry in manifest.entries} for manifest in (old, new))
    buried, dead = ({tombstone.id: tombstone for tombstone in manifest.tombstones} for manifest in (old, new))
    for id in sorted(before - after - dead.keys()):
        yield Fault("no-tombstone", id, "gone without a tombstone")
    for id in sorted(after & (buried.keys() | dead.keys())):
        yield Fault("id-reused", id, f"removed in {(buried | dead)[id].removed}; an id never comes back")
    for id, tombstone in sorted(buried.items()):
        if id not in dead:
            yield Fault("tombstone-lost", id, "its tombstone is gone")
        elif dead[id].removed != tombstone.removed:
            yield Fault("tombstone-lost", id, f"removed in {tombstone.removed}, now said to be {dead[id].removed}")
    for id in sorted(dead.keys() - buried.keys()):
        if not _between(old.suite, dead[id].removed, new.suite):
            yield Fault("tombstone-version", id, f"removed in {dead[id].removed}, {_range(old, new)}")
    if old.suite == new.suite:
        # Work on the way to a version that nobody has named yet: the version itself is at fault.
        return
    for entry in new.entries:
        if entry.id not in before and not _between(old.suite, entry.since, new.suite):
            yield Fault("since", entry.id, f"since {entry.since}, {_range(old, new)}")


def _between(old: str, this: str, new: str) -> bool:
    return _version(old) < _version(this) <= _version(new)


def _range(old: Manifest, new: Manifest) -> str:
    return f"allowed: later than {old.suite}, {new.suite} at the latest"


def _version_faults(old: Manifest, new: Manifest, step: str) -> Iterator[Fault]:
    before, after = _version(old.suite), _version(new.suite)
    least = _stepped(before, step)
    if after < before:
        yield Fault("version", "", f"{new.suite} is older than {old.suite}")
    elif after < least:
        yield Fault("version", "", f"{new.suite} after {old.suite}: a {step} step is needed, {_text(least)} or later")


def _version(text: str) -> Version:
    major, minor, patch = (int(part) for part in text.split("."))
    return major, minor, patch


def _stepped(version: Version, step: str) -> Version:
    major, minor, patch = version
    return {
        "none": version, "patch": (major, minor, patch + 1), "minor": (major, minor + 1, 0), "major": (major + 1, 0, 0),
    }[step]  # fmt: skip


def _text(version: Iterable[int]) -> str:
    return ".".join(str(part) for part in version)


def load_old(path: Path) -> Manifest:
    """The manifest of an older suite: its folder, or the manifest itself. Rules: CNF-3. Raises InputFormat."""
    return load(path) if path.is_dir() else load(path.parent, name=path.name)
