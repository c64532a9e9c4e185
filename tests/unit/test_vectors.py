"""The suite: its recipes, its manifest, and that it is what the recipes make.

Rules: CNF-3, CNF-4, CNF-5, CNF-6.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from hashlib import sha256
from pathlib import Path
from statistics import median

import pytest

from snhc.reference_impl.bitstream.errors import InputFormat, MarkerBit, RangeViolation
from snhc.reference_impl.rules import ambiguities, rules
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.vectors import recipe as recipes
from snhc.vectors.builders import all_lists, intra, stream
from snhc.vectors.generate import RecipeFault, build_suite, compare, generate, make
from snhc.vectors.manifest import (
    DOCUMENTS,
    MANIFEST_NAME,
    SUITE,
    TOOLS,
    DecodeOptions,
    Entry,
    Rejected,
    load,
    validate,
)
from snhc.vectors.recipe import Accept, Ambiguous, Build, Recipe, Reject, all_recipes
from snhc.vectors.seeded import Seeded


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return build_suite()


def test_committed_suite_is_what_the_recipes_make(files: dict[str, bytes]) -> None:
    assert compare(files, SUITE) == []


@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONHASHSEED": "0", "LC_ALL": "C", "TZ": "UTC"},
        # No assertion has an effect.
        {"PYTHONHASHSEED": "4242", "LC_ALL": "C.UTF-8", "TZ": "Pacific/Chatham", "PYTHONOPTIMIZE": "1"},
        {"PYTHONHASHSEED": "random", "LC_ALL": "POSIX", "TZ": "America/St_Johns", "PYTHONUTF8": "0"},
    ],
    ids=["plain", "optimised", "ascii"],
)
def test_other_hash_seeds_locales_and_time_zones_give_the_same_bytes(environment: dict[str, str]) -> None:
    """CNF-4. `tox -e nightly` does the same with every Python that is found."""
    code = "import sys; from snhc.conformance.cli import main; sys.argv[1:] = ['generate', '--check']; main()"
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LC_", "LANG"))}
    done = subprocess.run(
        [sys.executable, "-c", code], env=own | environment, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "the suite is what the recipes make\n"), done.stderr


def _folder(tmp_path: Path, files: dict[str, bytes]) -> Path:
    for name, content in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return tmp_path


def test_check_names_what_differs_is_missing_or_left_over(tmp_path: Path) -> None:
    wanted = {"fap/a.fba": b"a", "fap/b.fba": b"b", MANIFEST_NAME: b"{}"}
    folder = _folder(tmp_path, {"fap/a.fba": b"A", MANIFEST_NAME: b"{}", "old/c.fba": b"c"})
    found = [(mismatch.file, mismatch.what) for mismatch in compare(wanted, folder)]
    assert found == [("fap/a.fba", "differs"), ("fap/b.fba", "missing"), ("old/c.fba", "left over")]


def test_generate_replaces_a_suite_and_removes_what_is_left_over(
    tmp_path: Path, files: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {name: files[name] for name in (MANIFEST_NAME, "fap/fap.arith.example.1.fba")}
    monkeypatch.setattr("snhc.vectors.generate.build_suite", lambda: few)
    folder = _folder(tmp_path, {MANIFEST_NAME: b"old", "fap/gone.fba": b"old"})
    generate(folder)
    assert compare(few, folder) == []


def test_generate_refuses_a_folder_that_is_no_suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.vectors.generate.build_suite", dict)
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(RecipeFault, match="neither empty nor a suite"):
        generate(tmp_path)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_manifest_fits_its_schema_and_ids_are_unique() -> None:
    manifest = load()
    ids = [entry.id for entry in manifest.entries]
    assert ids == sorted(set(ids))
    assert len(ids) >= 60
    assert not set(ids) & {tombstone.id for tombstone in manifest.tombstones}


def test_manifest_reads_back_to_the_same_text(files: dict[str, bytes]) -> None:
    assert load().text().encode() == files[MANIFEST_NAME]


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"id": "No Dots"}, "id"),
        ({"kind": "invalid"}, "expect"),
        ({"rules": []}, "rules"),
        ({"tier": "hard"}, "tier"),
        ({"surplus": 1}, "vectors"),
    ],
)
def test_schema_refuses(change: dict[str, object], path: str, files: dict[str, bytes]) -> None:
    document = json.loads(files[MANIFEST_NAME])
    document["vectors"] = [next(entry for entry in document["vectors"] if entry["kind"] == "valid") | change]
    with pytest.raises(InputFormat) as error:
        validate(document)
    assert path in error.value.path


def test_missing_manifest_is_an_input_fault(tmp_path: Path) -> None:
    with pytest.raises(InputFormat):
        load(tmp_path)


def test_checksums_are_those_of_the_files(files: dict[str, bytes]) -> None:
    named = {MANIFEST_NAME}
    for entry in load().entries:
        for name, checksum in entry.files().items():
            assert sha256(files[name]).hexdigest() == checksum, name
            named.add(name)
    assert named == set(files)


def test_half_of_the_vectors_are_small() -> None:
    sizes = [sum((SUITE / name).stat().st_size for name in entry.files()) for entry in load().entries]
    assert median(sizes) < 2048


def test_every_recipe_is_documented_and_names_rules_of_the_register() -> None:
    known = rules()
    for recipe in all_recipes().values():
        assert len(recipe.description) > 20, recipe.id
        assert "{case}" not in recipe.id + recipe.title + recipe.description, recipe.id
        assert recipe.rules and set(recipe.rules) <= set(known), recipe.id


def test_every_face_ambiguity_has_a_vector_with_all_its_readings() -> None:
    found = {amb: set(readings) for entry in load().entries for amb, readings in entry.readings.items()}
    wanted = {id: set(amb.readings) for id, amb in ambiguities().items() if id.startswith("AMB-FBA-") and amb.built}
    missing = {id: readings for id, readings in wanted.items() if found.get(id) != readings}
    # Those that came with other tools have their vectors with those tools.
    assert set(missing) <= set(wanted) - {f"AMB-FBA-{n}" for n in range(1, 10)}


def test_no_pass_or_fail_vector_uses_the_default_range_of_fap_47() -> None:
    from snhc.reference_impl.systems.stream import read_stream

    for entry in load().entries:
        if entry.kind != "valid" or "fba" not in entry.tools:
            continue
        ever = False
        for item in read_stream((SUITE / entry.file).read_bytes(), entry.options.for_decoder()):
            for plane in item.fba.planes if item.fba is not None else []:
                if plane.is_intra and plane.faps is not None and plane.faps.coding_type == 0:
                    data = plane.faps
                    selected = data.mask_type[5] == 3 or (data.mask_type[5] in (1, 2) and data.group_mask[5] & 1)
                    ever = ever or all(data.new)
                    assert not selected or ever, entry.id


def test_every_kind_and_the_first_tiers_are_there() -> None:
    kinds = Counter(entry.kind for entry in load().entries)
    tiers = {entry.tier for entry in load().entries}
    assert min(kinds[kind] for kind in ("valid", "invalid", "ambiguous")) >= 9
    assert tiers >= {"syntax", "semantic", "stress", "error"}


def test_rejections_have_class_rule_and_a_span_inside_the_file() -> None:
    for entry in load().entries:
        if isinstance(entry.expect, Rejected):
            if entry.media in DOCUMENTS:
                assert entry.expect.bits is None and entry.expect.place, entry.id
            else:
                assert entry.expect.bits is not None
                start, end = entry.expect.bits
                assert 0 <= start <= end <= 8 * len((SUITE / entry.file).read_bytes()), entry.id
            assert entry.expect.rule in entry.rules, entry.id


# -- a recipe that is wrong does not generate -------------------------------------------------------------------------


def _recipe(build: Build) -> Recipe:
    return Recipe(
        "test.one", "Title", "Docstring", "syntax", ("FBA-1",), (), (), ("fba",), None, DecodeOptions(), "", "0.1.0",
        None, "test.one", lambda: build,
    )  # fmt: skip


_MARKER = ("marker_bit", "wire", 0, "plane[0].fap.group[3]")


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Accept(stream(intra({3: 5})), values={(0, 3): 21}), "declared 21"),
        (lambda: Accept(stream(intra({3: 5})), lines=2), "declared 2"),
        (lambda: Accept(stream(intra({3: 5})), times={0: "1/30"}), "declared 1/30"),
        (lambda: Accept(stream(intra({3: 5})), states={(0, 3): "R"}), "declared R"),
        (lambda: Accept(stream(intra({3: 5})), same_as=b"\0"), "declared 00"),
        (lambda: Accept(stream(intra({3: 5})), findings=("zero-padding",)), "findings"),
        (lambda: Accept(stream(intra({3: 5})), text={0: "Q"}), "without"),
        (lambda: Accept(b"\0\0\1\xba\xff"), "refuses"),
        (lambda: Reject(stream(intra({3: 5})), MarkerBit, "FBA-10", bits=(1, 2)), "takes it"),
        (lambda: Reject(stream(intra({3: 5})), RangeViolation, "FBA-10", (Mutation(*_MARKER),)), "declared Range"),
        (lambda: Reject(stream(intra({3: 5})), MarkerBit, "FBA-16", (Mutation(*_MARKER),)), "FBA-16"),
        (lambda: Reject(stream(intra({3: 5})), MarkerBit, "FBA-10", (Mutation(*_MARKER),), (9, 10)), r"\(9, 10\)"),
        (lambda: Reject(stream(intra({3: 5})), MarkerBit, "FBA-10", (Mutation("fap_qunt", "wire"),)), "never written"),
        (lambda: Reject(stream(intra({3: 5})), MarkerBit, "FBA-10"), "no bits"),
        (lambda: Ambiguous(stream(intra({3: 5})), "AMB-FBA-6"), "give the same"),
    ],
)  # fmt: skip
def test_a_recipe_that_the_decoder_contradicts_fails(build: object, said: str) -> None:
    assert callable(build)
    with pytest.raises(RecipeFault, match=said):
        make(_recipe(build()))


def test_a_stream_that_is_not_written_back_alike_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.vectors.making.read_stream", lambda data, options: stream(intra({3: 6})))
    with pytest.raises(RecipeFault, match="written back"):
        make(_recipe(Accept(stream(intra({3: 5})))))


def test_a_right_recipe_makes_its_files() -> None:
    made = make(_recipe(Reject(stream(intra({3: 5})), MarkerBit, "FBA-10", (Mutation(*_MARKER),))))
    assert made.entry.expect == Rejected("MarkerBit", "FBA-10", (65, 66))
    assert set(made.files) == {"test/test.one.fba"}
    assert Entry.from_json(made.entry.as_json()) == made.entry


def test_unknown_rules_and_dead_ids_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from snhc.vectors.manifest import Tombstone

    good = _recipe(Accept(stream(intra({3: 5}))))
    with pytest.raises(RecipeFault, match="no such rule: FBA-999"):
        build_suite([replace(good, rules=("FBA-999",))])
    monkeypatch.setattr("snhc.vectors.generate.tombstones", lambda: (Tombstone("test.one", "0.0.1", "wrong"),))
    with pytest.raises(RecipeFault, match="used before"):
        build_suite([good])


@pytest.mark.parametrize(
    "form",
    [
        {"id": "nodots"}, {"tier": "hard"}, {"rules": []}, {"id": "fap.arith.example.1"},
    ],
)  # fmt: skip
def test_the_decorator_refuses(form: dict[str, object]) -> None:
    all_recipes()
    before = dict(recipes.RECIPES)
    arguments = {"id": "test.two", "title": "T", "tier": "syntax", "rules": ["FBA-1"], **form}

    def function() -> Build:
        """A docstring."""
        return Accept(b"")

    with pytest.raises(TypeError):
        recipes.vector(**arguments)(function)  # type: ignore[arg-type]
    assert before == recipes.RECIPES


# -- builders and numbers ----------------------------------------------------------------------------------------------


def test_splitmix64_gives_the_published_numbers() -> None:
    numbers = Seeded(1234567)
    assert [numbers.next() for _ in range(3)] == [6457827717110365317, 3203168211198807973, 9817491932198370423]


def test_between_reaches_both_ends_and_nothing_else() -> None:
    numbers = Seeded(7)
    assert {numbers.between(-2, 3) for _ in range(200)} == set(range(-2, 4))


def test_builders_make_the_masks_and_limits_that_were_asked_for() -> None:
    plane = intra({3: 1, 18: 2, 48: 3}, types={2: 2, 5: 3}, ranges=all_lists(4), expression=(1, 2, 3, 4, 0, 1))
    data = plane.faps
    assert data is not None
    assert data.mask_type == [1, 2, 0, 0, 3, 0, 1, 0, 0, 0]
    assert (data.group_mask[0], data.group_mask[1], data.group_mask[6]) == (0b01, 0b1000000000000001, 0b100)
    assert data.levels == [1, 2, 0, 0, 0, 0, 3]
    assert data.new == [1, 1, 1, 1] and data.limits[0][39] == 4 and data.limits[0][4] == 0


def test_the_tools_are_those_that_an_adapter_can_claim() -> None:
    assert {tool for entry in load(SUITE).entries for tool in entry.tools} == set(TOOLS)
