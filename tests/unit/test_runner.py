"""Running decoders: a bank of broken ones, each of which has to get exactly its status.

Rules: CNF-9, CNF-13, CNF-14, CNF-15, CNF-16, CNF-17, CNF-19.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner

from snhc.conformance.adapters import BuiltIn, OneShot, Outcome
from snhc.conformance.candidate import Malformed, ndjson
from snhc.conformance.cli.generate import command as generate_command
from snhc.conformance.cli.run import command as run_command
from snhc.conformance.compare import judge, overlap
from snhc.conformance.differences import Difference
from snhc.conformance.filters import selector
from snhc.conformance.reports.json import SCHEMA_FILE
from snhc.conformance.reports.terminal import terminal_text
from snhc.conformance.results import Report
from snhc.conformance.runner import run, verify
from snhc.conformance.where import locate
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import MANIFEST_NAME, SUITE, Entry, Manifest
from snhc.vectors.manifest import load as load_manifest

HARNESS = Path(__file__).parent.parent / "harness"
VALID = "fap.arith.example.1"
INVALID = "fba.error.time-code.hours-24"
# May be concealed; the fault lies in the first plane, a line before it there is not.
CONCEALABLE = "fba.error.marker.group-1"
MANIFEST = load_manifest(check_schema=False)
ENTRIES = {entry.id: entry for entry in MANIFEST.entries}


def decoder(name: str, *words: str, format: str = "ndjson", timeout: float = 20.0) -> OneShot:
    command = (sys.executable, str(HARNESS / f"{name}.py"), "{input}", *words)
    return OneShot(name, command, format, timeout, output_bytes=1 << 20)


def statuses(adapter: OneShot | BuiltIn, *ids: str) -> tuple[str, ...]:
    chosen = Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids))
    return tuple(result.status for result in run(chosen, [adapter], jobs=2).results)


@pytest.mark.parametrize("format", ["csv", "fap"])
def test_other_formats_are_taken(format: str) -> None:
    right = decoder("other_format", format, format=format)
    ids = (VALID, "fba.header.skip.31", "fap.highlevel.retained", "fba.body.alternating")
    assert statuses(right, *ids) == ("pass",) * 4
    wrong = decoder("correct", format=format)
    assert statuses(wrong, VALID) == ("error",)


def test_another_stream_in_fap_text_fails() -> None:
    # The decoder is asked for one vector and decodes another one.
    other = str(SUITE / ENTRIES["fap.arith.example.2"].file)
    adapter = OneShot("stale", (sys.executable, str(HARNESS / "other_format.py"), other, "fap"), "fap", 20.0)
    assert statuses(adapter, VALID, "fap.arith.example.2") == ("fail", "pass")


def test_a_program_that_is_not_there_is_an_adapter_fault() -> None:
    adapter = OneShot("nobody", ("./no-such-program", "{input}"))
    chosen = Manifest(MANIFEST.suite, (ENTRIES[VALID],))
    report = run(chosen, [adapter])
    assert report.results[0].status == "error" and "no-such-program" in report.results[0].reason
    assert report.exit_code == 5


def test_vectors_that_need_an_option_which_is_not_claimed_are_not_applicable() -> None:
    ids = ("fba.framing.draft-codes", "fba.framing.trailing-data.strict", "fba.error.limit.skipped-frames")
    assert statuses(decoder("correct"), *ids) == ("not_applicable",) * 3


def test_options_become_words_of_the_command(tmp_path: Path) -> None:
    script = tmp_path / "echo.py"
    script.write_text("import sys\nsys.stderr.write(' '.join(sys.argv[2:]))\nsys.exit(3)\n")
    adapter = OneShot(
        "echo", (sys.executable, str(script), "{input}"),
        options={"limit": ("--limit", "{name}={value}"), "object": ("-n{value}",)},
    )  # fmt: skip
    chosen = Manifest(
        "0.0.0", (ENTRIES["fba.error.limit.skipped-frames"], ENTRIES["fba.framing.objects.second-of-two"])
    )
    reasons = [result.reason for result in run(chosen, [adapter]).results]
    assert reasons == ["exit code 3: --limit skipped_frames=40", "exit code 3: -n1"]


def test_without_input_in_the_command_the_vector_is_standard_input(tmp_path: Path) -> None:
    script = tmp_path / "count.py"
    script.write_text("import sys\nsys.exit(f'{len(sys.stdin.buffer.read())} bytes' and 42)\n")
    adapter = OneShot("stdin", (sys.executable, str(script)))
    outcome = adapter.decode(ENTRIES[VALID], SUITE / ENTRIES[VALID].file)
    assert outcome.code == 42


# -- frame numbers -----------------------------------------------------------------------------------------------------


def test_frame_numbers_of_fap_text_are_held_against_the_skips(tmp_path: Path) -> None:
    from snhc.reference_impl.systems.output import frame_writer
    from snhc.reference_impl.systems.stream import decode_planes

    entry = ENTRIES["fba.header.skip.31"]
    pieces: list[bytes] = []
    writer = frame_writer("fap", pieces.append)
    writer.begin("fba")
    for plane in decode_planes((SUITE / entry.file).read_bytes()):
        writer.plane(plane)
    writer.end()
    writer.close()
    text = b"".join(pieces)
    assert judge(entry, _outcome(0, text), SUITE, "fap").status == "pass"
    # The third frame is number 33: 31 are skipped behind number 1.
    verdict = judge(entry, _outcome(0, text.replace(b"\n33 ", b"\n32 ")), SUITE, "fap")
    assert verdict.difference is not None and verdict.difference.what == "frame number"


# -- comparing ---------------------------------------------------------------------------------------------------------


def _outcome(code: int, stdout: bytes = b"", said: str = "") -> Outcome:
    return Outcome(code, stdout, said.encode())


def _judged(id: str, outcome: Outcome) -> str:
    return judge(ENTRIES[id], outcome, SUITE, "ndjson").status


@pytest.mark.parametrize(
    ("said", "status"),
    [
        ('{"class":"ForbiddenValue"}', "pass"),
        ('{"class":"ForbiddenValue","bits":[%d,%d]}', "pass"),
        ('{"bits":[0,100000]}', "pass"),
        ('{"bit":%d}', "pass"),
        ("some words\n", "pass"),
        ('{"class":"MarkerBit"}', "fail"),
        ('{"class":"Unsupported"}', "not_applicable"),
        ('{"bits":[0,1]}', "fail"),
        ('{"bit":1}', "fail"),
        ('{"bits":"0,1"}', "error"),
        ('{"bit":1.5}', "error"),
    ],
)
def test_what_a_rejection_says_is_held_against_the_manifest(said: str, status: str) -> None:
    expect = ENTRIES[INVALID].expect.as_json()["reject"]["bits"]
    text = said % tuple(expect[: said.count("%d")]) if "%d" in said else said
    assert _judged(INVALID, _outcome(1, said=text)) == status


def test_spans_overlap() -> None:
    assert overlap((0, 5), (4, 6)) and not overlap((0, 4), (4, 6))
    assert overlap((8, 8), (8, 8)) and overlap((8, 8), (0, 8)) and not overlap((9, 9), (0, 8))


def test_concealing_means_going_on() -> None:
    before = (SUITE / "fap/fap.arith.example.2.ndjson").read_bytes()
    header, first, second = before.splitlines(keepends=True)
    id = "fap.arith.error.guard-zero"
    assert _judged(id, _outcome(0, before)) == "pass"
    assert _judged(id, _outcome(0, header + first)) == "pass"
    assert _judged(id, _outcome(0, header)) == "fail"
    second_plane = "fap.arith.error.guard-zero.second"
    assert _judged(second_plane, _outcome(0, header + first + second)) == "fail"


def test_each_reading_of_an_ambiguous_vector_passes_and_is_named() -> None:
    from snhc.reference_impl.rules import ambiguity
    from snhc.reference_impl.syntax.element import Readings
    from snhc.vectors.decoding import decode

    entry = ENTRIES["fba.ambiguous.skipped-frames"]
    for key in ambiguity("AMB-FBA-6").readings:
        options = entry.options.for_decoder(Readings({"AMB-FBA-6": key}))
        text = decode((SUITE / entry.file).read_bytes(), options).text
        verdict = judge(entry, _outcome(0, text.encode()), SUITE, "ndjson")
        assert (verdict.status, verdict.reading) == ("pass", f"AMB-FBA-6={key}")
    third = text.replace('"time":"', '"time":"1')
    assert _judged(entry.id, _outcome(0, third.encode())) == "fail"


def test_a_rejection_is_a_reading_too() -> None:
    verdict = judge(ENTRIES["fba.ambiguous.unstuffed-plane"], _outcome(1, said='{"bit":40}'), SUITE, "ndjson")
    assert (verdict.status, verdict.reading) == ("pass", "AMB-FBA-8=error")


@pytest.mark.parametrize(
    "text",
    [
        b"", b"{}\n", b"[]\n", b'{"format":"snhc-decoded","version":2,"kind":"fba"}\n',
        b'{"format":"snhc-decoded","version":1,"kind":"mesh"}\n', b"\xff",
        b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n{"index":0}\n',
        b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n\n', b"[" * 100_000,
    ],
)  # fmt: skip
def test_malformed_output_is_named(text: bytes) -> None:
    with pytest.raises(Malformed):
        ndjson(text)


# -- reports -----------------------------------------------------------------------------------------------------------


def _report(name: str, *ids: str) -> Report:
    return run(Manifest(MANIFEST.suite, tuple(ENTRIES[id] for id in ids)), [decoder(name)], jobs=2)


def test_a_failure_says_where() -> None:
    result = _report("wrong_value", VALID).results[0]
    assert result.difference is not None and result.location is not None
    assert (result.difference.frame, result.difference.fap) == (2, 3)
    assert (result.difference.reference, result.difference.candidate) == (140, 141)
    assert (result.location.plane, result.location.plane_bits) == (2, (270, 302))
    assert (result.location.element, result.location.bits, result.location.rule) == (
        "fap_segment",
        (282, 302),
        "FBA-28",
    )
    assert result.reproduce.endswith(f"--filter {VALID}")


def test_the_place_in_fap_text_leaves_out_planes_without_fap_data() -> None:
    entry = ENTRIES["fba.body.alternating"]
    difference = Difference(1, "faps", 3, 24, 25)
    lines, text = locate(entry, SUITE, difference), locate(entry, SUITE, difference, fap_frames=True)
    assert lines is not None and (lines.plane, lines.element) == (1, "")
    assert text is not None and (text.plane, text.element) == (2, "fap_segment")
    assert locate(entry, SUITE, Difference(99, "faps", 3, 24, 25)) is None


def test_the_mask_of_the_group_carries_a_state() -> None:
    found = locate(ENTRIES[VALID], SUITE, Difference(0, "state", 48, "T", "U"))
    assert found is not None and (found.element, found.path) == ("fap_mask_type", "plane[0].fap.group[7]")


def test_two_adapters_of_one_name_are_refused() -> None:
    with pytest.raises(InputFormat, match="correct"):
        run(MANIFEST, [decoder("correct"), decoder("correct")])


def test_reports_fit_the_schema_and_show_the_failure() -> None:
    report = _report("wrong_value", VALID, INVALID)
    jsonschema.validate(report.as_json(), json.loads(SCHEMA_FILE.read_text()))
    text = terminal_text(report)
    assert "frame 2, FAP 3 (faps): reference 140, candidate 141" in text
    assert "plane[2] at bits [270, 302)" in text and "wrong_value: FAIL (1 pass, 1 fail; suite " in text
    assert "\x1b" not in text


def test_control_characters_of_a_decoder_do_not_reach_the_terminal() -> None:
    result = replace(_report("prints_garbage", VALID).results[0], reason="bell \x07 and \x1b[2J")
    assert "\x1b" not in terminal_text(Report("0.0.0", "", ("x",), (result,)))


def test_not_applicable_alone_is_no_pass() -> None:
    report = _report("unsupported", VALID)
    assert not report.passed("unsupported") and report.exit_code == 1


def test_errors_alone_are_an_adapter_fault_and_failures_win() -> None:
    assert _report("prints_garbage", VALID).exit_code == 5
    assert _report("prints_garbage", VALID, INVALID).exit_code == 1


def test_changed_files_of_a_suite_are_refused(tmp_path: Path) -> None:
    entry = ENTRIES[VALID]
    (tmp_path / "fap").mkdir()
    for name in (entry.file, entry.file.replace(".fba", ".ndjson")):
        shutil.copy(SUITE / name, tmp_path / name)
    verify([entry], tmp_path)
    (tmp_path / entry.file).write_bytes(b"other")
    with pytest.raises(InputFormat, match=VALID):
        verify([entry], tmp_path)
    with pytest.raises(InputFormat):
        verify([replace(entry, file="../secret.fba")], tmp_path)


# -- filters, adapter files, command line ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "holds"),
    [
        ("", True), (VALID, True), ("fap.arith.*", True), ("fba.*", False), ("tier=semantic", True),
        ("tier=error|semantic rule=FBA-26", True), ("!tier=semantic", False), ("rule=FBA-25", False),
        ("feature=skip !kind=invalid", True), ("rule=FBA-2?", True), ("id=*example*", True), ("FAP.*", False),
    ],
)  # fmt: skip
def test_filters(expression: str, holds: bool) -> None:
    assert selector(expression)(ENTRIES[VALID]) is holds


def test_a_filter_with_an_unknown_field_is_refused() -> None:
    with pytest.raises(InputFormat, match="colour=red"):
        selector("colour=red")


def test_the_built_in_decoder_passes_the_whole_suite() -> None:
    result = CliRunner().invoke(run_command, ["--format", "json"])
    assert result.exit_code == 0, result.output
    document = json.loads(result.output)
    jsonschema.validate(document, json.loads(SCHEMA_FILE.read_text()))
    assert {entry["status"] for entry in document["results"]} == {"pass"}
    assert len(document["results"]) == len(ENTRIES)


def test_a_bug_of_the_built_in_decoder_is_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(media: str, data: bytes, aux: object, options: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("snhc.conformance.adapters.builtin.decode_input", broken)
    assert statuses(BuiltIn(), VALID, INVALID) == ("crash", "crash")


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--filter", "no.such.vector"], 1),
        (["--filter", "colour=red"], 2),
        (["--filter", VALID], 0),
        (["--filter", VALID, "--adapter-command", f"{sys.executable} {HARNESS}/rejects_everything.py"], 1),
        (["--filter", VALID, "--adapter-command", f"{sys.executable} {HARNESS}/prints_nothing.py"], 5),
        (["--filter", VALID, "--adapter-command", f"{sys.executable} {HARNESS}/correct.py {{input}}"], 0),
    ],
)
def test_exit_codes(words: list[str], code: int) -> None:
    result = CliRunner().invoke(run_command, words)
    assert result.exit_code == code, result.output


def test_an_adapter_file_that_is_missing_is_an_input_error() -> None:
    command = [sys.executable, "-m", "snhc.conformance.cli", "run", "no-such-file.toml"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout) == (3, "")
    assert "no-such-file.toml" in result.stderr


def test_the_report_goes_to_a_file_in_the_format_of_its_name(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    result = CliRunner().invoke(run_command, ["--filter", VALID, "-o", str(path)])
    # The verdict is told to people all the same.
    assert (result.exit_code, result.stdout) == (0, "")
    assert re.fullmatch(r"snhc: pass \(1 pass; suite \d+\.\d+\.\d+\)\n", result.stderr)
    assert json.loads(path.read_text())["format"] == "snhc-report"
    quiet = CliRunner().invoke(run_command, ["--filter", VALID, "-o", str(path), "--quiet"])
    assert (quiet.exit_code, quiet.output) == (0, "")


def test_generate_check_names_the_file_and_exits_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "snhc.vectors.generate.build_suite", lambda: {MANIFEST_NAME: b'{"vectors":[]}', "fap/a.fba": b"a"}
    )
    runner = CliRunner()
    assert runner.invoke(generate_command, ["--suite", str(tmp_path)]).exit_code == 0
    assert runner.invoke(generate_command, ["--suite", str(tmp_path), "--check"]).exit_code == 0
    (tmp_path / "fap/a.fba").write_bytes(b"b")
    result = runner.invoke(generate_command, ["--suite", str(tmp_path), "--check"])
    assert (result.exit_code, result.output) == (1, "differs: fap/a.fba\n")
    assert (tmp_path / "fap/a.fba").read_bytes() == b"b"


def test_entries_are_those_of_the_suite() -> None:
    assert isinstance(ENTRIES[VALID], Entry) and {VALID, INVALID, CONCEALABLE} <= set(ENTRIES)
