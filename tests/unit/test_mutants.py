"""The kill matrix: mutants go in and come out, what kills them kills them, and the matrix says the truth."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest
from click.testing import CliRunner

from snhc.conformance.cli import snhc
from snhc.conformance.kill_matrix import TIMEOUTS, Bench, Kill, _Worker, kill_matrix, relevant_first, run_mutants
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.face import reconstruct
from snhc.reference_impl.face.parameters import fap_set
from snhc.reference_impl.mesh import predicates
from snhc.reference_impl.tables import fap_table
from snhc.vectors.decoding import decode
from snhc.vectors.manifest import SUITE, load
from snhc.vectors.mutants import mutant as catalogue
from snhc.vectors.mutants.matrix import HOW, Line, Matrix, load_matrix, lost_kills, merged
from snhc.vectors.mutants.mutant import Change, Edit, Mutant, MutantFault, Value, all_mutants
from snhc.vectors.mutants.page import page
from snhc.vectors.mutants.patching import applied
from snhc.vectors.mutants.text import markdown_lines, mutant_lines, summary_lines

pytestmark = pytest.mark.pure


def made(*changes: Change, findings: bool = False, id: str = "a.mutant", survives: str = "") -> Mutant:
    return Mutant(id, "a mistake", ("FBA-32",), changes, "values", findings, survives)


STEP = "base_steps[number] * self.scale if self.scale else 1"
EXAMPLE = "fap.value.fap-quant.2"


def decoded(id: str = EXAMPLE) -> str:
    entry = next(entry for entry in load(SUITE, check_schema=False).entries if entry.id == id)
    return decode((SUITE / entry.file).read_bytes(), entry.options.for_decoder()).text


# -- in and out --------------------------------------------------------------------------------------------------------


def test_a_change_of_source_reaches_everybody_and_is_undone() -> None:
    before = decoded()
    imported = reconstruct.parameter_values
    change = Edit("face.reconstruct:parameter_values", "values[number] = level * step", "values[number] = 7777")
    with applied(made(change)):
        assert '"faps":[null,null,7777,' in decoded()
        assert reconstruct.parameter_values is imported
    assert decoded() == before


def test_several_changes_of_one_function_go_together() -> None:
    target = "mesh.predicates:orientation"
    with applied(made(Edit(target, "(xs[b] - ax)", "(xs[b] - 1)"), Edit(target, "(ys[c] - ay)", "(ys[c] - 2)"))):
        assert predicates.orientation([0, 5, 0], [0, 0, 9], 0, 1, 2) == (5 - 1) * (9 - 2)
    assert predicates.orientation([0, 5, 0], [0, 0, 9], 0, 1, 2) == 45


def test_a_table_is_changed_with_all_that_was_made_of_it() -> None:
    steps = fap_set().base_steps[3]
    with applied(made(Value("tables:fap_table()[2].QP", 4, 9))):
        assert fap_table()[2].QP == 9
        assert fap_set().base_steps[3] == 9
    assert fap_set().base_steps[3] == steps == fap_table()[2].QP == 4


def test_a_property_and_a_cached_function_can_be_changed() -> None:
    changes = [
        Edit("face.dct_transform:DctReading.dc_divisor", "return 4 if", "return 5 if"),
        Edit("face.dct_transform:ac_step", "return scale[fap_quant]", "return 2 * scale[fap_quant]"),
    ]
    before = decoded("fap.dct.example.1")
    with applied(made(*changes)):
        assert decoded("fap.dct.example.1") != before
    assert decoded("fap.dct.example.1") == before


def test_it_comes_out_when_the_block_fails() -> None:
    before = decoded()
    with (
        pytest.raises(ZeroDivisionError),
        applied(made(Edit("face.state:ParameterState.set_steps", STEP, "7"), Value("face.state:LIMIT_UNIT", 60, 61))),
    ):
        raise ZeroDivisionError
    assert decoded() == before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (Edit("face.state:ParameterState.set_steps", "no such text", ""), "0 times, not once"),
        (Edit("face.state:ParameterState.set_steps", "number", "n"), "times, not once"),
        (Edit("face.state:ParameterState.set_steps", STEP, "1 +"), "is no Python"),
        (Edit("face.state:ParameterState.no_such", "a", "b"), "there is no"),
        (Edit("face.state:ParameterState", "a", "b"), "is no function"),
        (Value("tables:fap_table()[2].QP", 5, 9), "is 4, not 5"),
        (Value("face.state:LIMIT_UNIT", True, 9), "is 60, not True"),
        (Value("face.state:NO_SUCH", 5, 9), "there is no"),
        (Value("face.state:LIMIT_UNIT..", 5, 9), "is no path"),
    ],
)
def test_a_mutant_that_does_not_fit_is_an_error_and_changes_nothing(change: Change, message: str) -> None:
    before = decoded()
    good = Edit("face.reconstruct:parameter_values", "values[number] = level * step", "values[number] = 7777")
    with pytest.raises(MutantFault, match=f"a.mutant: .*{message}"), applied(made(good, change)):
        pass
    assert decoded() == before


def test_compiled_code_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconstruct, "__file__", "reconstruct.cpython-311-x86_64-linux-gnu.so")
    change = Edit("face.reconstruct:parameter_values", "values[number] = level * step", "pass")
    with (
        pytest.raises(MutantFault, match="compiled; mutants need the pure form: set SNHC_PURE=1"),
        applied(made(change)),
    ):
        pass


# -- the catalogue -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("Not.an.Id", "t", ["FBA-1"], Value("a:b", 1, 2)), "not the form"),
        (("fba.value.clipped", "t", ["FBA-1"], Value("a:b", 1, 2)), "is used"),
        (("a.new-one", "t", ["FBA-1"]), "changes nothing"),
        (("a.new-one", "t", [], Value("a:b", 1, 2)), "breaks no rule"),
    ],
)
def test_the_form_of_a_mutant(arguments: tuple[object, ...], message: str) -> None:
    all_mutants()
    with pytest.raises(MutantFault, match=message):
        catalogue.mutant(*arguments)  # type: ignore[arg-type]


def test_every_mutant_fits_the_decoder_and_leaves_it_as_it_was() -> None:
    mutants = all_mutants()
    assert len(mutants) >= 500
    before = decoded()
    for mutant in mutants.values():
        with applied(mutant):
            pass
    assert decoded() == before


def test_mutants_name_rules_that_there_are() -> None:
    from snhc.reference_impl.rules import rules

    known = set(rules())
    assert not {rule for mutant in all_mutants().values() for rule in mutant.rules} - known


# -- the engine --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench(
        only=lambda entry: entry.id.startswith(("fap.value.", "fap.ambiguous", "fba.error.marker", "fap.dct.ex"))
    )


def only(bench: Bench, mutant: Mutant, stop: bool = False) -> list[Kill]:
    return bench.run(mutant, relevant_first(mutant, bench.entries.values(), bench.seconds), stop)


def test_vectors_of_the_rules_come_first() -> None:
    entries = load(SUITE, check_schema=False).entries
    order = relevant_first(made(), entries, {"fap.value.prediction": 5.0})
    tagged = {entry.id for entry in entries if "FBA-32" in entry.rules}
    assert set(order[: len(tagged)]) == tagged
    assert order[len(tagged) - 1] == "fap.value.prediction"
    assert sorted(order) == sorted(entry.id for entry in entries)


def test_what_kills(bench: Bench) -> None:
    wrong = made(Edit("face.reconstruct:parameter_values", "values[number] += level", "values[number] -= level"))
    kills = only(bench, wrong)
    assert ("fap.value.prediction", "fail") in [(kill.vector, kill.how) for kill in kills]
    assert len(only(bench, wrong, stop=True)) == 1
    falls = made(
        Edit("face.reconstruct:parameter_values", "values[number] += level * step", "values[number] += 1 // 0")
    )
    assert {kill.how for kill in only(bench, falls)} == {"crash"}
    reading = made(Edit("face.reconstruct:parameter_values", "if clip:", "if True:"))
    assert ("fap.ambiguous.clipping", "reading") in [(kill.vector, kill.how) for kill in only(bench, reading)]
    conceals = made(Edit("face.syntax:group_masks", "io.marker(parameters.group_marker)", "io.u(IS_INTRA, 1, 1)"))
    assert {kill.how for kill in only(bench, conceals)} == {"concealed"}
    same = made(
        Edit("face.reconstruct:parameter_values", "values[number] += level * step", "values[number] += step * level")
    )
    assert only(bench, same) == []


def test_a_decoder_that_does_not_end_is_stopped(bench: Bench) -> None:
    hangs = made(
        Edit("face.reconstruct:parameter_values", "if clip:", "while state.values:\n        pass\n    if clip:")
    )
    kills = only(bench, hangs)
    assert [kill.how for kill in kills] == ["timeout"] * TIMEOUTS


def test_findings_are_held_against_what_recipes_declare() -> None:
    bench = Bench(only=lambda entry: entry.id.startswith("fba.framing."))
    silent = made(
        Edit("systems.visual:_trailing", 'io.finding("trailing-data"', '"" and io.finding("trailing-data"'),
        findings=True,
    )
    kills = only(bench, silent)
    assert [kill.vector for kill in kills] == ["fba.framing.trailing-data", "fba.framing.draft-plane-code-unasked"] or [
        kill.vector for kill in kills
    ] == ["fba.framing.draft-plane-code-unasked", "fba.framing.trailing-data"]


def test_a_decoder_that_fails_its_own_suite_is_no_ground_to_stand_on() -> None:
    broken = made(Edit("face.reconstruct:parameter_values", "values[number] = level * step", "values[number] = 1"))
    with applied(broken), pytest.raises(MutantFault, match=r"without any mutant the decoder fails fap\.value"):
        Bench(only=lambda entry: entry.id.startswith("fap.value."))


def test_a_process_that_dies_or_eats_memory_is_replaced() -> None:
    dies = made(
        Edit("face.reconstruct:parameter_values", "if clip:", "import os; os._exit(3)\n    if clip:"), id="it.dies"
    )
    eats = made(
        Edit("face.reconstruct:parameter_values", "if clip:", "held = bytearray(8 << 30)\n    if clip:"), id="it.eats"
    )
    good = made(
        Edit("face.reconstruct:parameter_values", "values[number] = level", "values[number] = 1 + level"), id="it.lives"
    )
    found = run_mutants([dies, eats, good], stop=True, jobs=1, first=lambda mutant: [EXAMPLE])
    assert [(one.mutant, one.kills[0].vector, one.kills[0].how) for one in found] == [
        ("it.dies", EXAMPLE, "timeout"), ("it.eats", EXAMPLE, "crash"), ("it.lives", EXAMPLE, "fail"),
    ]  # fmt: skip


def test_the_kills_of_a_process_that_dies_are_found_by_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mutant that falls over on one vector alone: all others are asked, also those before it."""
    wrong = "values[number] = 1 + level if number != 49 else __import__('os')._exit(3)"
    dies = made(Edit("face.reconstruct:parameter_values", "values[number] = level * step", wrong), id="it.dies")
    order = ["fap.arith.example.1", "fap.arith.example.2", "fap.arith.example.3"]
    monkeypatch.setattr("snhc.conformance.kill_matrix.relevant_first", lambda mutant, entries, seconds: order)
    (found,) = run_mutants([dies], jobs=1)
    assert {kill.vector: kill.how for kill in found.kills} == {order[0]: "fail", order[1]: "timeout", order[2]: "fail"}


def test_a_process_that_ends_before_its_first_vector_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    good = made(Edit("face.reconstruct:parameter_values", "values[number] = level", "values[number] = 1 + level"))
    worker = _Worker(SUITE)
    try:
        worker._process.kill()
        worker._process.join()
        # The next one is not needed for the message.
        monkeypatch.setattr(_Worker, "_start", lambda self: None)
        with pytest.raises(MutantFault, match="ended before its first vector"):
            worker.run(good, [EXAMPLE], True)
    finally:
        worker.close()


def test_a_misfit_ends_the_run() -> None:
    with pytest.raises(MutantFault, match="0 times"):
        run_mutants([made(Edit("face.reconstruct:parameter_values", "gone", ""))], jobs=1)


# -- the matrix of this installation -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def matrix() -> Matrix:
    return load_matrix()


def test_the_matrix_knows_every_mutant_and_explains_every_survivor(matrix: Matrix) -> None:
    mutants = all_mutants()
    assert [line.id for line in matrix.lines] == list(mutants)
    assert matrix.complete
    assert matrix.unexplained == ()
    for line in matrix.lines:
        assert line == Line.of(mutants[line.id], line.first, line.kills), f"{line.id}: snhc coverage --mutants --update"
        assert (line.first in line.killers) == bool(line.kills)


def test_every_recorded_first_killer_still_kills(matrix: Matrix) -> None:
    there = {entry.id for entry in load(SUITE, check_schema=False).entries}
    lines = {line.id: line for line in matrix.lines if line.kills}
    mutants = [mutant for mutant in all_mutants().values() if mutant.id in lines]
    found = run_mutants(mutants, stop=True, jobs=1, first=lambda mutant: [lines[mutant.id].first])
    gone = [one.mutant for one in found if not one.kills]
    assert not gone
    moved = [
        f"{one.mutant}: {lines[one.mutant].first}"
        for one in found
        if lines[one.mutant].first in there and one.kills[0].vector != lines[one.mutant].first
    ]
    assert not moved


def small() -> Matrix:
    def line(id: str, **kills: tuple[str, ...]) -> Line:
        first = next(iter(kills.values()))[0] if kills else ""
        return Line(id, id, ("FBA-1",), ("x",), "values", False, "" if kills else "a reason", first, kills)

    lines = (
        line("m.1", fail=("v.a", "v.b")),
        line("m.2", fail=("v.b",), crash=("v.c",)),
        line("m.3", reading=("v.c",)),
        line("m.4"),
    )
    return Matrix("1.0.0", ("v.a", "v.b", "v.c", "v.d"), True, lines)


def test_what_a_matrix_tells() -> None:
    m = small()
    assert m.columns() == {"v.a": ("m.1",), "v.b": ("m.1", "m.2"), "v.c": ("m.2", "m.3"), "v.d": ()}
    assert m.alone() == {"v.c": ("m.3",)}
    assert m.redundant() == ("v.a", "v.b", "v.d")
    assert m.enough() == ("v.b", "v.c")
    assert [line.id for line in m.survivors] == ["m.4"]
    assert [line.killed for line in m.lines] == [True, True, False, False]
    assert m.unexplained == ()


def test_a_survivor_without_reason_and_a_reason_without_survivor_are_faults() -> None:
    m = small()
    silent = Line("m.5", "m.5", ("FBA-1",), ("x",), "values", False, "", "", {})
    wrong = Line("m.6", "m.6", ("FBA-1",), ("x",), "values", False, "cannot be", "v.a", {"fail": ("v.a",)})
    assert [one.id for one in Matrix("1", m.vectors, True, (*m.lines, silent, wrong)).unexplained] == ["m.5", "m.6"]


def test_lost_kills_are_those_of_vectors_and_mutants_that_are_left() -> None:
    m = small()
    _, two, *rest = m.lines
    now = Matrix("1", ("v.b", "v.c", "v.d"), True, (Line.of(made(id="m.1"), "", {}), *rest))
    assert lost_kills(m, now) == [("m.1", "v.b")]
    assert two.id == "m.2"  # gone, like v.a


def test_some_lines_can_be_made_anew() -> None:
    m = small()
    new = Matrix("2", ("v.b", "v.c"), True, (Line.of(made(id="m.4"), "v.c", {"fail": ["v.c"]}),))
    both = merged(m, new, ["m.4", "m.1", "m.3"])
    assert [line.id for line in both.lines] == ["m.4", "m.1", "m.3"]
    assert [line.killers for line in both.lines] == [("v.c",), ("v.b",), ("v.c",)]
    assert [line.first for line in both.lines] == ["v.c", "v.b", "v.c"]
    assert both.suite == "2" and both.complete


def test_a_matrix_is_read_as_it_was_written(tmp_path: Path, matrix: Matrix) -> None:
    for m in (small(), matrix):
        path = tmp_path / "matrix.json"
        path.write_text(m.text(), encoding="utf-8")
        again = load_matrix(path)
        assert again == m
        assert again.text() == m.text()
    for text in ("", "[]", '{"format": "other"}', '{"format": "snhc-kill-matrix", "version": 2}', "[" * 100_000):
        path.write_text(text)
        with pytest.raises(InputFormat, match="CNF-8"):
            load_matrix(path)


def test_two_runs_give_the_same_bytes() -> None:
    mutants = list(islice(all_mutants().values(), 3))
    assert kill_matrix(mutants, stop=True, jobs=2).text() == kill_matrix(mutants, stop=True, jobs=1).text()


def test_the_matrix_in_words() -> None:
    text = "\n".join(summary_lines(small()))
    for part in ("4 mutants, 4 vectors", "m.3: another reading of an ambiguity (v.c)", "m.4: a reason",
                 "2 vectors are enough for all 3", "1 vectors are the only ones", "3 vectors show none"):  # fmt: skip
        assert part in text
    lines = list(mutant_lines(small()))
    assert lines[0] == "+ m.1 (FBA-1): m.1"
    assert "    v.a and 1 more" in lines
    assert any(line.startswith("~ m.3") for line in lines)
    assert "    a reason" in lines
    assert "| `m.4` | m.4 | FBA-1 | none: a reason |" in list(markdown_lines(small()))


def test_the_page_holds_everything_and_asks_for_nothing(matrix: Matrix) -> None:
    text = "".join(page(matrix))
    assert all(line.id in text for line in matrix.lines)
    assert "http" not in text and "src=" not in text
    nasty = Line("m.1", "<b>&", ("FBA-1",), ("a < b",), "values", False, "", "v.a", {HOW[0]: ("v.a",)})
    assert "&lt;b&gt;&amp;" in "".join(page(Matrix("1", ("v.a",), True, (nasty,))))


# -- the command -------------------------------------------------------------------------------------------------------


@pytest.fixture
def run() -> Iterator[CliRunner]:
    yield CliRunner()


def test_the_command_prints_the_matrix(run: CliRunner, tmp_path: Path, matrix: Matrix) -> None:
    done = run.invoke(snhc, ["coverage", "--mutants"])
    assert done.exit_code == 0
    assert f"{len(matrix.lines)} mutants" in done.stdout
    done = run.invoke(snhc, ["coverage", "--mutants", "--format", "json"])
    assert json.loads(done.stdout) == matrix.as_json()
    done = run.invoke(snhc, ["coverage", "--mutants", "-o", str(tmp_path / "m.html")])
    assert done.exit_code == 0 and (tmp_path / "m.html").read_text().startswith("<!doctype html>")
    done = run.invoke(snhc, ["coverage", "--mutants", "--mutant", "fba.value.clipped*"])
    assert done.stdout.count("\n+ ") + done.stdout.count("\n~ ") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["--mutants", "--mutant", "no.such"], ["--mutant", "x"], ["--mutants", "--update", "--mutant", "no.such"],
        ["--mutants", "--book", "x"],
    ],
)  # fmt: skip
def test_words_that_do_not_go_together(run: CliRunner, arguments: list[str]) -> None:
    assert run.invoke(snhc, ["coverage", *arguments]).exit_code == 2


def test_the_command_checks(run: CliRunner, tmp_path: Path, matrix: Matrix) -> None:
    good = run.invoke(snhc, ["coverage", "--mutants", "--check", "--mutant", "fapu.per-1000", "-j", "1"])
    assert good.exit_code == 0, good.stdout
    assert "1 mutants: no kill is lost" in good.stdout
    one = next(line for line in matrix.lines if line.id == "fapu.per-1000")
    other = Line(
        one.id, one.title, one.rules, one.change, one.topic, False, "", one.first, {"fail": ("fap.arith.example.1",)}
    )
    path = tmp_path / "m.json"
    path.write_text(Matrix(matrix.suite, matrix.vectors, True, (other,)).text())
    bad = run.invoke(
        snhc, ["coverage", "--mutants", "--check", "--mutant", "fapu.per-1000", "--matrix", str(path), "-j", "1"]
    )
    assert bad.exit_code == 1
    assert "lost: fap.arith.example.1 no longer shows fapu.per-1000" in bad.stdout
