"""The catalogue: every vector on one page, in full, and every link to one leads there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from snhc.vectors.catalogue import anchor, group_of, groups, overview, page
from snhc.vectors.manifest import Accepted, Rejected, load

MANIFEST = load()


def test_groups_partition_the_suite() -> None:
    found = groups(MANIFEST)
    assert sorted(entry.id for entries in found.values() for entry in entries) == [e.id for e in MANIFEST.entries]
    assert list(found)[:3] == ["fap.arith", "fap.dct", "fap"]
    assert group_of("fap.arithmetic.x") == "fap" and group_of("own.rate.8-hz") == "own"


def test_the_overview_adds_up() -> None:
    rows = [line.split("|")[3:-1] for line in overview(MANIFEST).splitlines() if line.startswith("| ")][1:]
    numbers = [[int(cell) if cell.strip() else 0 for cell in row] for row in rows]
    assert all(sum(row[:-1]) == row[-1] for row in numbers)
    assert [sum(column) for column in zip(*numbers[:-1], strict=True)] == numbers[-1]
    assert numbers[-1][-1] == len(MANIFEST.entries)


def test_a_section_says_what_the_manifest_says() -> None:
    for group, entries in groups(MANIFEST).items():
        text = page(group, entries, lambda rule: f"<{rule}>")
        sections = dict(re.findall(r"^### `([^`]+)`\n(.*?)(?=^\(vector-|\Z)", text, re.MULTILINE | re.DOTALL))
        assert set(sections) == {entry.id for entry in entries}
        for entry in entries:
            said = sections[entry.id]
            assert all(f"`{name}`" in said for name in entry.files()), entry.id
            assert (
                all(f"<{rule}>" in said for rule in entry.rules) and f"* tier, kind: {entry.tier}, {entry.kind}" in said
            )
            if isinstance(entry.expect, Rejected):
                assert f"{entry.expect.error_class} ({entry.expect.rule}) at {entry.expect.place}" in said
            else:
                assert isinstance(entry.expect, Accepted)
            for amb, readings in entry.readings.items():
                assert all(f"* <{amb}> = {key}: " in said for key in readings)
            assert ("* check: " in said) == (entry.check is not None)


def test_links_to_vectors_lead_to_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs"))
    from register_pages import write_pages

    write_pages(tmp_path)
    pages = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md")}
    links = {link for text in pages.values() for link in re.findall(r"\]\((vectors-[\w-]+\.md)#([\w.-]+)\)", text)}
    assert len(links) > 100
    assert all(f"\n({target})=\n" in pages[name] for name, target in links)
    everything = "\n".join(pages.values())
    assert all(everything.count(f"\n({anchor(entry.id)})=\n") == 1 for entry in MANIFEST.entries)
