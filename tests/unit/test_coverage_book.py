"""The coverage book: value classes, branches, the probe, reasons for holes, and the book as a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import pytest
from click.testing import CliRunner

from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat, RangeViolation, ReservedValue
from snhc.reference_impl.syntax.element import ELEMENTS, Element
from snhc.vectors.coverage import book as books
from snhc.vectors.coverage import branches
from snhc.vectors.coverage.book import Book, Row, bind, load_book, lost
from snhc.vectors.coverage.cells import KINDS, Cell
from snhc.vectors.coverage.holes import Holes, Reason, load_holes, matches
from snhc.vectors.coverage.observe import Observation, observe
from snhc.vectors.coverage.probe import probe
from snhc.vectors.coverage.values import all_classes, classes_of
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import DOCUMENTS, SUITE, Rejected, load

# The branches of compiled code cannot be watched, and its machines see no interpreted coder.
pytestmark = pytest.mark.pure


def element(**declared: object) -> Element:
    """An element that no syntax has."""
    el = Element("test", "CNF-8", **declared)  # type: ignore[arg-type]
    ELEMENTS.remove(el)
    return el


# -- value classes ---------------------------------------------------------------------------------------------------


def test_small_fields_have_a_class_per_value() -> None:
    el = element(lo=1, hi=5, fault=ReservedValue, meaning={4: "four"})
    assert all_classes(el, 3, False) == ["refused 0", "1", "2", "3", "4 (four)", "5", "refused 6", "refused 7"]


def test_large_fields_have_their_ends_and_what_lies_outside() -> None:
    el = element(lo=2, hi=1000, fault=RangeViolation)
    wanted = ["min 2", "max 1000", "between", "refused 0", "refused 1", "refused 1001", "refused 1023"]
    assert all_classes(el, 10, False) == wanted
    assert classes_of(el, 10, False, 1001) == ["refused 1001"]
    assert classes_of(el, 10, False, 1002) == []


@pytest.mark.parametrize(
    ("n", "signed", "declared"),
    [
        *((n, False, {}) for n in (1, 2, 4, 5, 8)),
        *((n, False, {"lo": 1, "hi": 9, "forbidden": (3,)}) for n in (4, 5, 8)),
        (1, False, {"lo": 1, "hi": 1}),
        (5, True, {}),
        (13, True, {}),
    ],
)
def test_every_value_is_in_a_known_class(n: int, signed: bool, declared: dict[str, object]) -> None:
    el = element(**declared)
    known = set(all_classes(el, n, signed))
    first = -(1 << (n - 1)) if signed else 0
    met = set()
    for value in range(first, first + (1 << n)):
        found = classes_of(el, n, signed, value)
        assert set(found) <= known, value
        # Only values outside the domain may be in none, and only in large fields.
        assert found or not el.allows(value)
        met |= set(found)
    assert met == known


# -- branches --------------------------------------------------------------------------------------------------------

MODULE = '''
"""Rules: CNF-1."""
from snhc.reference_impl.bitstream.errors import RangeViolation


def both(a, b):
    """Rules: FBA-26..28."""
    if (
        a
        and b
    ):
        return 1
    for x in range(a):
        if x > 2:
            break
    else:
        a = 5
    while a > 3:
        a -= 1
    try:
        a / b
    except ZeroDivisionError:
        raise RangeViolation("MSH-5", "b") from None
    if a:
        a = 2
    if a:
        a = 3
'''


def test_branches_of_a_module_are_found_and_watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "watched.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(branches, "PACKAGE", "package")
    source = branches.read_source("watched", ["RangeViolation"])
    assert source.errors == {("RangeViolation", "MSH-5")}
    names = [branch.key.removeprefix("branch/watched/both/") for branch in source.branches]
    assert names == [
        "if a and b/yes", "if a and b/no", "for x in range(a)/body", "for x in range(a)/end", "if x > 2/yes",
        "if x > 2/no", "while a > 3/body", "while a > 3/end", "except ZeroDivisionError/caught", "if a/yes", "if a/no",
        "if a #2/yes", "if a #2/no",
    ]  # fmt: skip
    assert {branch.rules for branch in source.branches} == {("FBA-26", "FBA-27", "FBA-28")}

    from package.watched import both  # type: ignore[import-not-found]

    def fails() -> None:
        with pytest.raises(RangeViolation):
            both(1, 0)

    hits = branches.Watch([source]).run([("one", lambda: both(1, 1)), ("none", lambda: None), ("two", fails)])
    hits = {key.removeprefix("branch/watched/both/"): ids for key, ids in hits.items()}
    assert hits == {
        "if a and b/yes": {"one"}, "if a and b/no": {"two"}, "for x in range(a)/body": {"two"},
        "if x > 2/no": {"two"}, "for x in range(a)/end": {"two"}, "while a > 3/body": {"two"},
        "while a > 3/end": {"two"}, "except ZeroDivisionError/caught": {"two"},
    }  # fmt: skip


# -- the probe -------------------------------------------------------------------------------------------------------


def test_the_probe_reads_as_the_reader_does() -> None:
    checked = 0
    for entry in load().entries:
        if entry.media in DOCUMENTS or not isinstance(entry.expect, Rejected):
            continue
        data = (SUITE / entry.file).read_bytes()
        decoded = decode_input(entry.media, data, None, entry.options.for_decoder())
        seen = probe(data, entry.options.for_decoder())
        assert decoded.error is not None
        # The reader looks for objects too; every other fault is the syntax's.
        if decoded.error.what != "objects in the stream":
            assert str(seen.error) == str(decoded.error), entry.id
            checked += 1
    assert checked > 100


def test_cells_that_are_known_of_a_vector() -> None:
    entries = [entry for entry in load().entries if entry.id == "fap.arith.error.guard-zero.second"]
    observed = observe(entries, SUITE, ())
    assert set(observed.hits) <= set(observed.cells)
    wanted = {
        "error/MarkerBit/FBA-25", "rule/FBA-25/broken", "segment/FBA-28/fap_segment/inter/guard 0",
        "segment/FBA-28/fap_segment/inter/several guards", "plane/FBA boundary/behind the object start code/plane",
        "element/FBA-5/is_intra/0", "element/FBA-5/fba_object_mask/1 (FAP data)", "group/FBA-10/fap_mask_type/7/1",
    }  # fmt: skip
    assert wanted <= set(observed.hits)
    # The faulty segment gives no levels.
    assert "level/FAP 48 head_pitch/inter/coded" not in observed.hits
    assert "level/FAP 48 head_pitch/intra/coded" in observed.hits


# -- holes and book --------------------------------------------------------------------------------------------------


def small_book(holes: Holes | None = None) -> tuple[Book, list[str]]:
    """Three cells, two of them covered."""
    cells = {key: Cell(key, ("FBA-1",)) for key in ("element/a", "word/t/1", "word/t/2")}
    hits = {"element/a": frozenset({"v.a", "v.b", "v.d"}), "word/t/1": frozenset({"v.c"})}
    holes = holes or Holes((Reason("word/*/2", "never sent"),), ())
    return bind(Observation(cells, hits), holes, "1.0.0", ["v.a", "v.b", "v.c", "v.d"])


def test_patterns_know_one_wildcard() -> None:
    assert matches("word/*/1", "word/t/1") and matches("*", "") and matches("a[0]?*", "a[0]?x")
    assert not matches("word/*", "element/word/1") and not matches("a[0]", "a0")


def test_reasons_must_be_needed() -> None:
    assert small_book()[1] == []
    assert small_book(Holes((), ()))[1] == ["hole without a reason: word/t/2"]
    why = Reason("word/t/2", "never sent")
    assert small_book(Holes((why, Reason("none/*", "x")), ()))[1] == ["reason for no cell: none/*"]
    assert small_book(Holes((Reason("word/*", "x"),), ()))[1] == ["reason for a covered cell: word/*: word/t/1"]


def test_a_book_comes_back_from_its_file(tmp_path: Path) -> None:
    book, _ = small_book()
    path = tmp_path / "book.json"
    path.write_text(book.text(), encoding="utf-8")
    again = load_book(path)
    assert (again.suite, again.vectors, again.rows) == (book.suite, book.vectors, dict(book.rows))
    assert again.text() == book.text()
    assert '"0-1 3"' in book.text()
    assert book.share().percent == "66.6"
    assert book.reasons() == {"never sent": 1}


def test_a_damaged_book_is_one_error(tmp_path: Path) -> None:
    path = tmp_path / "book.json"
    for text in ("", "[]", "[" * 100_000, small_book()[0].text().replace("snhc-coverage", "other")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputFormat):
            load_book(path)


def test_a_cell_that_is_gone_is_not_lost() -> None:
    old, _ = small_book()
    rows = {key: replace(row, vectors=()) for key, row in old.rows.items() if key != "element/a"}
    assert lost(old, replace(old, rows=rows)) == ["word/t/1"]


def test_a_module_that_no_vector_enters_any_more_is_lost() -> None:
    old, _ = small_book()
    row = Row(Cell("branch/face.state/f/if a/yes", ()), ("v.a",), "")
    old = replace(old, rows={**old.rows, row.cell.key: row})
    new = replace(small_book()[0], unentered=("face.state", "face.encode"))
    assert lost(old, new) == ["branch/face.state/*"]


def test_check_names_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, _ = small_book()
    path = tmp_path / "book.json"
    path.write_text(good.text(), encoding="utf-8")
    monkeypatch.setattr(books, "make_book", lambda suite: (good, []))
    assert books.check(path) == []
    row = good.rows["word/t/1"]
    worse = replace(good, rows={**good.rows, "word/t/1": Row(row.cell, (), "")})
    monkeypatch.setattr(books, "make_book", lambda suite: (worse, ["hole without a reason: word/t/1"]))
    said = books.check(path)
    assert said[:2] == ["lost: word/t/1", "hole without a reason: word/t/1"]
    assert said[2].startswith("stale: 0 cells are new, 0 are gone, 1 have other")


def test_the_shipped_book_names_real_vectors_and_modules() -> None:
    book = load_book()
    assert {row.cell.kind for row in book.rows.values()} == set(KINDS)
    assert set(book.vectors) == {entry.id for entry in load().entries}
    assert all(row.covered or row.why for row in book.rows.values())
    assert {
        one.pattern for one in load_holes().outside if not any(matches(one.pattern, m) for m in branches.modules())
    } == set()


# -- the verb --------------------------------------------------------------------------------------------------------


def run(*words: str) -> tuple[int, str, str]:
    """Exit code, standard output, standard error."""
    result = CliRunner().invoke(snhc, ["coverage", *words], prog_name="snhc")
    return result.exit_code, result.stdout, result.stderr


def test_the_verb_shows_shares_and_cells() -> None:
    code, out, _ = run()
    assert code == 0 and "Words of the code tables" in out and "holes, by reason" in out
    code, out, _ = run("--rule", "fba-26")
    assert code == 0 and all(line.startswith(("+ ", "- ")) and "FBA-26" in line for line in out.splitlines())
    code, out, _ = run("--holes", "--rule", "MSH")
    assert code == 0 and all(line.startswith("- ") for line in out.splitlines())
    code, out, _ = run("--format", "html")
    assert code == 0 and out.startswith("<!doctype html>") and "<!--" not in out
    code, out, _ = run("--cell", "word/mvd/0", "--format", "json")
    assert code == 0 and '"cell": "word/mvd/0"' in out


@pytest.mark.parametrize(
    "words", [("--check", "--update"), ("--check", "--holes"), ("--suite", "."), ("--cell", "no such cell")]
)
def test_the_verb_refuses_what_makes_no_sense(words: tuple[str, ...]) -> None:
    assert run(*words)[0] == 2


def test_the_verb_reads_another_book(tmp_path: Path) -> None:
    path = tmp_path / "book.json"
    path.write_text(dedent(small_book()[0].text()), encoding="utf-8")
    assert "suite 1.0.0: 4 vectors" in run("--book", str(path))[1]
    path.write_text("{}", encoding="utf-8")
    code, _, err = run("--book", str(path))
    assert code == 3 and "coverage book" in err


def test_a_compiled_form_is_measured_by_a_pure_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("snhc.conformance.cli.version.form", lambda: "compiled")
    # The child finds no suite: its exit code is handed on.
    code, out, _ = run("--check", "--suite", str(tmp_path))
    assert code == 3 and not out
