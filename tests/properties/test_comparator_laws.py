"""The comparators: no single change of a right output passes.

Rules: CNF-1, CNF-2, CNF-16.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.conformance.adapters import Outcome
from snhc.conformance.compare import judge
from snhc.vectors.manifest import SUITE, Accepted, Entry, load

ENTRIES = {entry.id: entry for entry in load(check_schema=False).entries}
Step = int | str
# Of the header only these are compared.
_HEADER = ("format", "version", "kind")


def _kinds() -> dict[str, Entry]:
    """Vectors of every kind of output, with and without tolerance, that are short and hold frames."""
    chosen: dict[str, Entry] = {}
    for entry in ENTRIES.values():
        if entry.kind != "valid" or not isinstance(entry.expect, Accepted):
            continue
        text = (SUITE / entry.expect.file).read_text()
        if 3 <= text.count("\n") <= 40 or entry.expect.kind == "fapu":
            chosen.setdefault(f"{entry.expect.kind}, {'exact' if entry.tolerance is None else 'near'}", entry)
    extra = [ENTRIES[id] for id in ("fba.body.alternating", "fap.highlevel.retained", "fap.arith.example.1")]
    return chosen | {entry.id: entry for entry in extra}


KINDS = _kinds()


def test_all_kinds_of_output_are_among_them() -> None:
    assert {name.partition(",")[0] for name in KINDS if "," in name} == {"fba", "mesh", "faces", "vertices", "fapu"}


def _status(entry: Entry, text: str) -> str:
    return judge(entry, Outcome(0, text.encode("utf-8", "surrogatepass")), SUITE, "ndjson").status


def _text(lines: list[Any]) -> str:
    return "".join(json.dumps(line) + "\n" for line in lines)


def _paths(value: Any, path: tuple[Step, ...] = ()) -> Iterator[tuple[Step, ...]]:
    yield path
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _paths(item, (*path, key))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _paths(item, (*path, i))


def _changed(old: Any, entry: Entry, near_enough: bool) -> st.SearchStrategy[Any]:
    """Values that are another one."""
    others: list[st.SearchStrategy[Any]] = [st.sampled_from([None, "", "x", [], {}, [None], True, False, 10**30, -7])]
    if isinstance(old, bool):
        others.append(st.sampled_from([not old, int(old), str(old)]))
    elif isinstance(old, int):
        near = 1 if entry.tolerance is None else 2
        others += [st.integers(near, 1 << 40).map(lambda d: old + d), st.integers(near, 1 << 40).map(lambda d: old - d)]
        others.append(st.sampled_from([float(old), str(old)]))
    elif isinstance(old, float):
        away = 1e-3 + 1e-3 * abs(old) + 3 * (entry.tolerance.bound if entry.tolerance is not None else 0.0)
        others.append(st.floats(away, 1e9).map(lambda d: old + d))
        others.append(st.floats(away, 1e9).map(lambda d: old - d))
        others.append(st.sampled_from([str(old), float("nan"), float("inf"), 1 << 2000]))
    elif isinstance(old, str):
        others.append(st.text(max_size=70))
        others.append(st.integers(0, max(0, len(old) - 1)).map(lambda i: old[:i] + "!" + old[i + 1 :]))
    return st.one_of(others).filter(lambda new: not _equal(old, new, near_enough))


def _equal(old: Any, new: Any, near_enough: bool) -> bool:
    """`near_enough`: numbers are floats, and may differ a little."""
    if near_enough and type(old) in (int, float) and type(new) in (int, float) and abs(new) < 1 << 1000:
        return bool(abs(old - new) <= 1e-3)
    return json.dumps(old, sort_keys=True) == json.dumps(new, sort_keys=True)


@pytest.mark.parametrize("name", KINDS)
@settings(max_examples=150)
@given(data=st.data())
def test_no_changed_value_passes(name: str, data: st.DataObject) -> None:
    entry = KINDS[name]
    assert isinstance(entry.expect, Accepted)
    lines = [json.loads(line) for line in (SUITE / entry.expect.file).read_text().splitlines()]
    number = data.draw(st.integers(0, len(lines) - 1), "line")
    paths = [path for path in _paths(lines[number]) if path and (number or path[0] in _HEADER)]
    path = data.draw(st.sampled_from(paths), "path")
    *steps, last = path
    place: Any = lines[number]
    for step in steps:
        place = place[step]
    near_enough = entry.expect.kind in ("vertices", "fapu") and path[0] in ("meshes", "units", "faps")
    new = data.draw(_changed(place[last], entry, near_enough), "new")
    before = copy.deepcopy(lines)
    place[last] = new
    assert _status(entry, _text(before)) == "pass"
    status = _status(entry, _text(lines))
    assert status in ("fail", "error"), (path, new)


@pytest.mark.parametrize("name", KINDS)
@settings(max_examples=60)
@given(data=st.data())
def test_no_key_entry_or_line_that_is_missing_or_too_much_passes(name: str, data: st.DataObject) -> None:
    entry = KINDS[name]
    assert isinstance(entry.expect, Accepted)
    lines: list[Any] = [json.loads(line) for line in (SUITE / entry.expect.file).read_text().splitlines()]
    what = data.draw(
        st.sampled_from(["line lost", "line twice", "lines swapped", "key lost", "entry lost", "entry twice"])
    )
    number = data.draw(st.integers(0, len(lines) - 1), "line")
    if what == "line lost":
        del lines[number]
    elif what == "line twice":
        lines.insert(number, lines[number])
    elif what == "lines swapped":
        other = data.draw(st.integers(0, len(lines) - 1).filter(lambda n: lines[n] != lines[number]), "other")
        lines[number], lines[other] = lines[other], lines[number]
    elif what == "key lost":
        optional = {"gender", "coding_type", "fap_quant", "baps", "entropy_profile"}
        del lines[number][data.draw(st.sampled_from(sorted(set(lines[number]) - optional)), "key")]
    else:
        lists = [path for path in _paths(lines[number]) if path and isinstance(_at(lines[number], path), list)]
        lists = [path for path in lists if _at(lines[number], path)]
        if not lists:
            return
        found = _at(lines[number], data.draw(st.sampled_from(lists), "list"))
        at = data.draw(st.integers(0, len(found) - 1), "entry")
        if what == "entry lost":
            del found[at]
        else:
            found.insert(at, found[at])
    assert _status(entry, _text(lines)) in ("fail", "error")


def _at(value: Any, path: tuple[Step, ...]) -> Any:
    for step in path:
        value = value[step]
    return value


@pytest.mark.parametrize("name", ["fap.arith.example.1", "mesh, exact"])
@settings(max_examples=150)
@given(data=st.data())
def test_no_change_of_one_byte_passes_but_one_that_changes_nothing(name: str, data: st.DataObject) -> None:
    entry = KINDS[name]
    assert isinstance(entry.expect, Accepted)
    text = (SUITE / entry.expect.file).read_bytes()
    at = data.draw(st.integers(0, len(text) - 1))
    byte = data.draw(st.integers(0, 255).filter(lambda byte: byte != text[at]))
    changed = text[:at] + bytes([byte]) + text[at + 1 :]
    status = judge(entry, Outcome(0, changed), SUITE, "ndjson").status
    if status == "pass":
        # Then it says the same, blanks apart, or lacks a key that need not be there.
        for a, b in zip(text.splitlines(), changed.splitlines(), strict=True):
            ours, theirs = json.loads(a), json.loads(b)
            assert all(theirs[key] == value for key, value in ours.items() if key in theirs)
            assert set(ours) - set(theirs) <= {"gender", "coding_type", "fap_quant", "baps"}
    else:
        assert status in ("fail", "error")
