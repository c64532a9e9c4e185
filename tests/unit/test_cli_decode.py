"""`snhc decode` and what all verbs share, in one process."""

from __future__ import annotations

import csv
import io
import json
import shutil
import stat
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result

from snhc.conformance.cli import common, decode, failures, snhc
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.fap_text import read_fap
from snhc.reference_impl.systems import output
from snhc.reference_impl.tables.reading import TABLES

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples" / "fba"
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
# The third plane ends behind its first bits.
CUT = WORKED[:36]
# The first plane fails: frame_rate 0.
RATE_ZERO = bytes.fromhex("000001bab00000000000")


def run(*args: str, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(snhc, list(args), input=stdin)


def lines_of(result: Result) -> list[dict[str, object]]:
    assert result.stdout.endswith("\n")
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_ndjson_is_the_default() -> None:
    result = run("decode", "-", stdin=WORKED)
    assert result.exit_code == 0
    header, *frames = lines_of(result)
    assert header == {"format": "snhc-decoded", "version": 1, "kind": "fba"}
    assert [frame["time"] for frame in frames] == ["0/1", "1/25", "2/25"]
    assert [frame["faps"][47] for frame in frames] == [-3400, -1700, 170]  # type: ignore[index]


def test_samples_decode_to_their_lines(tmp_path: Path) -> None:
    for name in ("fba-11-00000", "fba-11-00003"):
        expected = [json.loads(line) for line in (SAMPLES / name / "expected.ndjson").read_text().splitlines()]
        result = run("decode", str(SAMPLES / name / "input.fba"), "--quiet")
        assert result.exit_code == 0
        for line, wanted in zip(lines_of(result), expected, strict=True):
            assert wanted.items() <= line.items()


def test_meshes_decode_too_but_not_to_fap() -> None:
    mesh = str(SAMPLES.parent / "mesh" / "mesh-11-00000" / "input.m2d")
    header, first, *_ = lines_of(run("decode", mesh))
    assert header["kind"] == "mesh"
    assert first["nodes"]
    result = run("decode", mesh, "--format", "fap")
    assert result.exit_code == 3
    assert result.stdout == ""


def test_lines_before_an_error_stay() -> None:
    result = run("decode", "-", stdin=CUT)
    assert result.exit_code == 4
    assert len(lines_of(result)) == 3
    assert result.stderr.splitlines()[-1].startswith("snhc: Truncated: fap_segment at bits [282, 288)")


def test_the_header_comes_before_a_first_plane_that_fails() -> None:
    result = run("decode", "-", stdin=RATE_ZERO)
    assert result.exit_code == 4
    assert [line["kind"] for line in lines_of(result)] == ["fba"]


@pytest.mark.parametrize("data", [b"", b"2.1 name 25 1\n", b"\0" * 64, b"\x89PNG\r\n"])
def test_other_files_print_nothing(data: bytes) -> None:
    result = run("decode", "-", stdin=data)
    assert result.exit_code == 3
    assert result.stdout == ""
    assert result.stderr.startswith("snhc: InputFormat: ")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize("format_", ["csv", "fap", "npz"])
def test_other_files_print_nothing_in_any_format(format_: str) -> None:
    for args in ((), ("--keep-partial",)):
        result = run("decode", "-", "--format", format_, *args, stdin=b"text")
        assert result.exit_code == 3
        assert result.stdout_bytes == b""


def test_nframes_cuts_and_looks_no_further() -> None:
    result = run("decode", "-", "--nframes", "2", stdin=CUT)
    assert result.exit_code == 0
    assert len(lines_of(result)) == 3
    assert run("decode", "-", "--nframes", "0", stdin=CUT).exit_code == 2


def test_another_object() -> None:
    two = WORKED[:-4] + WORKED
    assert len(lines_of(run("decode", "-", "--object", "1", stdin=two))) == 4
    missing = run("decode", "-", "--object", "2", stdin=two)
    assert missing.exit_code == 4
    assert missing.stdout == ""


def test_findings_on_standard_error_unless_quiet() -> None:
    assert run("decode", "-", stdin=WORKED).stderr.startswith("info: no-sequence-header at bits [0, 32)")
    assert run("decode", "-", "--quiet", stdin=WORKED).stderr == ""


def test_json_errors() -> None:
    result = run("decode", "-", "--json-errors", stdin=CUT)
    finding, error = (json.loads(line) for line in result.stderr.splitlines())
    assert finding["id"] == "no-sequence-header"
    assert (error["class"], error["rule"], error["bits"]) == ("Truncated", "FBA-27", [282, 288])
    missing = run("decode", "/no/such/file", "--json-errors")
    assert missing.exit_code == 3
    assert json.loads(missing.stderr)["class"] == "InputOutput"


@pytest.mark.parametrize(
    ("words", "element", "code"),
    [
        (["decode", "-", "--nframes", "0"], "--nframes", 2),
        (["decode"], "FILE", 2),
        (["decode", "-", "--nonsense"], "", 2),
        (["nonsense"], "", 2),
        (["run", "--filter", "=x"], "--filter", 2),
        (["check", __file__, "--profile", "x"], "--profile", 2),
    ],
)
def test_errors_of_usage_are_json_too(words: list[str], element: str, code: int) -> None:
    result = run(*words, "--json-errors")
    error = json.loads(result.stderr)
    assert list(error) == ["class", "rule", "element", "value", "allowed", "message"]
    assert (result.exit_code, error["class"], error["element"]) == (code, "Usage", element)
    assert error["message"] and result.stdout == ""
    plain = run(*[word for word in words if word != "--json-errors"])
    assert plain.exit_code == code and plain.stderr.splitlines()[-1] == f"Error: {error['message']}"


@pytest.mark.parametrize(
    "words",
    [
        ["check", "-", "--policy"], ["report"], ["run", "--ledger"], ["run", "--suite"], ["run", "--traces"],
        ["doctor", "x.toml", "--suite"], ["minimize", "snhc", "x", "--aux"], ["minimize", "snhc", "x", "--suite"],
    ],
)  # fmt: skip
def test_files_that_are_not_there_are_input_for_every_verb(words: list[str], tmp_path: Path) -> None:
    wrong = tmp_path
    if words[-1] in ("--suite", "--traces"):
        wrong = tmp_path / "file"
        wrong.write_bytes(b"x")
    for name in (tmp_path / "none", wrong):
        result = run(*words, str(name), "--json-errors", stdin=WORKED)
        error = json.loads(result.stderr)
        assert (result.exit_code, error["class"], error["element"]) == (3, "InputOutput", str(name))


def test_strict_and_trailing_bytes() -> None:
    assert run("decode", "-", stdin=WORKED + b"\x80").exit_code == 0
    strict = run("decode", "-", "--strict", stdin=WORKED + b"\x80")
    assert strict.exit_code == 4
    assert "TrailingData" in strict.stderr


def test_draft_start_codes() -> None:
    draft = b"\0\0\1\x01" + WORKED[4:]
    assert run("decode", "-", stdin=draft).exit_code == 4
    assert run("decode", "-", "--compat", "draft", stdin=draft).exit_code == 0


def test_readings() -> None:
    result = run("decode", "-", "--reading", "AMB-FBA-6=before", stdin=WORKED)
    header, *frames = lines_of(result)
    assert header["readings"] == {"AMB-FBA-6": "before"}
    assert frames[2]["time"] == "19/25"
    # The one followed anyway is not named.
    assert "readings" not in lines_of(run("decode", "-", "--reading", "AMB-FBA-6=after", stdin=WORKED))[0]


@pytest.mark.parametrize(
    ("option", "value", "hint"),
    [
        ("--reading", "AMB-FBA-6", "ID=KEY"),
        ("--reading", "AMB-FBA-66=x", "did you mean AMB-FBA-6"),
        ("--reading", "AMB-FBA-6=befor", "it has after, before"),
        ("--limit", "idle=3", "idle_planes"),
        ("--limit", "idle_planes=-3", "whole number"),
        ("--limit", "idle_planes", "whole number"),
    ],
)
def test_wrong_options_are_usage_errors(option: str, value: str, hint: str) -> None:
    result = run("decode", "-", option, value, stdin=WORKED)
    assert result.exit_code == 2
    assert hint in result.stderr
    assert result.stdout == ""


def test_the_last_reading_counts() -> None:
    assert common.parse_readings(("AMB-FBA-6=before", "AMB-FBA-6=after")) == {}


def test_readings_without_a_switch_are_refused() -> None:
    from snhc.reference_impl.rules import ambiguities

    unbuilt = [entry for entry in ambiguities().values() if not entry.built]
    for entry in unbuilt:
        first, second, *_ = entry.readings
        assert common.parse_readings((f"{entry.id}={first}",)) == {}
        with pytest.raises(click.BadParameter):
            common.parse_readings((f"{entry.id}={second}",))


def test_limits_are_lowered() -> None:
    result = run("decode", "-", "--limit", "skipped_frames=5", stdin=WORKED)
    assert result.exit_code == 4
    assert "ResourceLimit: number_of_frames_to_skip=15" in result.stderr


def test_other_entropy_tables(tmp_path: Path) -> None:
    sample = str(SAMPLES.parent / "dct" / "dct-11-00000" / "input.fba")
    for table in TABLES.glob("fap_dct_*.csv"):
        shutil.copy(table, tmp_path)
    header, *lines = run("decode", sample).stdout.splitlines()
    assert json.loads(header)["entropy_profile"] == "P1 (provisional entropy tables)"
    other, *same = run("decode", sample, "--dct-tables", str(tmp_path)).stdout.splitlines()
    assert same == lines
    # The folder's tables are the provisional ones still, under another name.
    assert json.loads(other)["entropy_profile"] == f"{tmp_path.name} (provisional entropy tables)"
    # The two shortest words of the ac table swapped: the same bits say something else.
    ac = next(tmp_path.glob("*ac_P1.csv"))
    head, *rows = [line.split(",") for line in ac.read_text().splitlines()]
    first, second = sorted(rows, key=lambda row: int(row[2]))[:2]
    first[2:], second[2:] = second[2:], first[2:]
    ac.write_text("".join(",".join(row) + "\n" for row in (head, *rows)))
    assert run("decode", sample, "--dct-tables", str(tmp_path)).stdout.splitlines()[1:] != lines
    ac.unlink()
    missing = run("decode", sample, "--dct-tables", str(tmp_path))
    assert missing.exit_code == 3
    assert missing.stdout == ""


# -- formats -----------------------------------------------------------------------------------------------------------


def test_the_formats_are_those_of_the_codec() -> None:
    assert decode.FORMATS == output.FORMATS
    assert decode.SUFFIXES == output.SUFFIXES


def test_csv_has_the_values() -> None:
    result = run("decode", "-", "--format", "csv", stdin=WORKED)
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    assert tuple(rows[0]) == output.CSV_COLUMNS
    assert len(rows) == 3
    assert [row["fap_48"] for row in rows] == ["-3400", "-1700", "170"]
    assert rows[0]["fap_4"] == rows[0]["viseme_blend"] == ""
    assert (rows[0]["fap_quant"], rows[1]["fap_quant"]) == ("1", "")
    assert all(row["state"].count("T") == 2 for row in rows)
    assert "\r" not in result.stdout


def test_npz_has_the_values(tmp_path: Path) -> None:
    target = tmp_path / "out.npz"
    source = SAMPLES / "fba-11-00000"
    assert run("decode", str(source / "input.fba"), "-o", str(target)).exit_code == 0
    expected = [json.loads(line) for line in (source / "expected.ndjson").read_text().splitlines()][1:]
    with np.load(target) as arrays:
        header = json.loads(str(arrays["header"]))
        assert (header["format"], header["version"]) == ("snhc-decoded-npz", 1)
        for row, frame in enumerate(expected):
            values, known = arrays["faps"][row].tolist(), arrays["faps_set"][row].tolist()
            assert [v if k else None for v, k in zip(values, known, strict=True)] == frame["faps"]
            assert b"".join(arrays["state"][row].tolist()).decode() == frame["state"]
            assert "{}/{}".format(*arrays["time"][row]) == frame["time"]
            assert bool(arrays["intra"][row]) == frame["intra"]
            assert bool(arrays["viseme_set"][row]) == (frame["viseme"] is not None)
            if frame["viseme"] is not None:
                assert arrays["viseme"][row].tolist() == list(frame["viseme"].values())
            if frame["expression"] is not None:
                assert arrays["expression"][row].tolist() == list(frame["expression"].values())


def test_npz_without_frames(tmp_path: Path) -> None:
    target = tmp_path / "out.npz"
    empty = bytes.fromhex("000001ba7f000001b1")
    assert run("decode", "-", "-o", str(target), stdin=empty).exit_code == 0
    with np.load(target) as arrays:
        assert arrays["faps"].shape == (0, 68)


def test_npz_collects_no_more_than_the_limit(tmp_path: Path) -> None:
    target = tmp_path / "out.npz"
    result = run("decode", "-", "-o", str(target), "--limit", "collected_planes=2", stdin=WORKED)
    assert result.exit_code == 4
    assert "ResourceLimit: frames kept=3" in result.stderr
    assert not target.exists()
    run("decode", "-", "-o", str(target), "--keep-partial", "--limit", "collected_planes=2", stdin=WORKED)
    with np.load(target) as arrays:
        assert arrays["faps"].shape == (2, 68)


def test_fap_text() -> None:
    # skip_frames of the first plane: the second one is number 18.
    result = run("decode", "-", "--format", "fap", stdin=WORKED)
    fap = read_fap(io.BytesIO(result.stdout_bytes))
    assert not fap.findings
    assert (fap.frame_rate, fap.nframes, [frame.number for frame in fap.frames]) == (25, 3, [0, 1, 2])
    assert [frame.values[47] for frame in fap.frames] == [-3400, -1700, 170]
    before = run("decode", "-", "--format", "fap", "--reading", "AMB-FBA-6=before", stdin=WORKED)
    assert [frame.number for frame in read_fap(io.BytesIO(before.stdout_bytes)).frames] == [0, 1, 19]


def test_fap_text_of_a_stream_that_fails_holds_what_came_before() -> None:
    result = run("decode", "-", "--format", "fap", stdin=CUT)
    assert result.exit_code == 4
    assert read_fap(io.BytesIO(result.stdout_bytes)).nframes == 2


def test_fap_text_cut() -> None:
    result = run("decode", "-", "--format", "fap", "--nframes", "1", stdin=WORKED)
    assert read_fap(io.BytesIO(result.stdout_bytes)).nframes == 1


def test_samples_to_fap_text_keep_values_and_numbers() -> None:
    for path in sorted(SAMPLES.glob("*/input.fba"))[:6]:
        ndjson = lines_of(run("decode", str(path), "--quiet"))[1:]
        fap = read_fap(io.BytesIO(run("decode", str(path), "--format", "fap", "--quiet").stdout_bytes))
        with_data = [frame for frame in ndjson if "T" in str(frame["state"])]
        assert len(fap.frames) >= len(with_data)
        by_number = iter(fap.frames)
        for frame in with_data:
            text = next(text for text in by_number if any(text.mask))
            state = str(frame["state"])
            assert [letter == "T" for letter in state] == [digit == 1 for digit in text.mask]
            faps = frame["faps"]
            assert isinstance(faps, list)
            assert [faps[i] for i in range(2, 68) if text.mask[i]] == [v for v in text.values if v is not None]


def test_the_format_follows_the_extension(tmp_path: Path) -> None:
    for suffix, start in (
        (".csv", b"index,"),
        (".fap", b"2.1 _ 25 3\n"),
        (".ndjson", b'{"format"'),
        ("", b'{"format"'),
    ):
        target = tmp_path / f"out{suffix}"
        assert run("decode", "-", "-o", str(target), stdin=WORKED).exit_code == 0
        assert target.read_bytes().startswith(start)
    result = run("decode", "-", "-o", str(tmp_path / "out.xlsx"), stdin=WORKED)
    assert result.exit_code == 2
    assert ".xlsx names no format" in result.stderr
    assert run("decode", "-", "-o", str(tmp_path / "out.xlsx"), "--format", "csv", stdin=WORKED).exit_code == 0


# -- -o FILE -----------------------------------------------------------------------------------------------------------


def test_a_file_is_whole_or_left_alone(tmp_path: Path) -> None:
    target = tmp_path / "out.ndjson"
    target.write_text("before")
    assert run("decode", "-", "-o", str(target), stdin=CUT).exit_code == 4
    assert target.read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == ["out.ndjson"]
    assert run("decode", "-", "-o", str(target), "--keep-partial", stdin=CUT).exit_code == 4
    assert len(target.read_text().splitlines()) == 3
    assert run("decode", "-", "-o", str(target), stdin=WORKED).exit_code == 0
    assert len(target.read_text().splitlines()) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["out.ndjson"]
    assert stat.S_IMODE(target.stat().st_mode) & 0o400


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    target, link = tmp_path / "out.ndjson", tmp_path / "link.ndjson"
    target.write_text("before")
    link.symlink_to(target)
    assert run("decode", "-", "-o", str(link), stdin=WORKED).exit_code == 0
    assert link.is_symlink()
    assert len(target.read_text().splitlines()) == 4


def test_output_that_cannot_be_opened(tmp_path: Path) -> None:
    result = run("decode", "-", "-o", str(tmp_path / "no" / "out.ndjson"), stdin=WORKED)
    assert result.exit_code == 3
    assert len(result.stderr.splitlines()) == 1


# -- findings and bugs -------------------------------------------------------------------------------------------------


def test_many_findings_are_summed_up(capsys: pytest.CaptureFixture[str]) -> None:
    report = common.FindingReport()
    for _ in range(common.SHOWN_PER_ID + 7):
        report(Finding("intensity-range", "warning", "FBA-32", "x"))
    report(Finding("zero-padding", "warning", "FBA-42", "y"))
    report.close()
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == common.SHOWN_PER_ID + 2
    assert lines[-1] == "... and 7 more `intensity-range`"


def test_findings_as_json_lines(capsys: pytest.CaptureFixture[str]) -> None:
    report = common.FindingReport(as_json=True)
    for _ in range(common.SHOWN_PER_ID + 1):
        report(Finding("intensity-range", "warning", "FBA-32", "x"))
    report.close()
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert lines[0] == {"id": "intensity-range", "severity": "warning", "rule": "FBA-32", "message": "x"}
    assert lines[-1]["more"] == 1


def test_bugs_are_reported_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*args: object) -> None:
        raise RuntimeError("two\nlines")

    monkeypatch.setattr(decode, "_decode", broken)
    monkeypatch.delenv("SNHC_DEBUG", raising=False)
    result = run("decode", "-", stdin=WORKED)
    assert result.exit_code == 70
    assert result.stderr.splitlines() == [
        "snhc: internal error: RuntimeError: two lines; please report it (SNHC_DEBUG=1 shows where)"
    ]
    monkeypatch.setenv("SNHC_DEBUG", "1")
    assert "Traceback" in run("decode", "-", stdin=WORKED).stderr
    as_json = run("decode", "-", "--json-errors", stdin=WORKED).stderr.splitlines()[-1]
    assert json.loads(as_json)["class"] == "Internal"


def test_interrupts(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(decode, "_decode", interrupted)
    assert run("decode", "-", stdin=WORKED).exit_code == failures.INTERRUPTED


def test_colour_needs_a_terminal_and_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert common.colour_allowed(True)
    assert not common.colour_allowed(False)
    monkeypatch.setenv("NO_COLOR", "1")
    assert not common.colour_allowed(True)
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "dumb")
    assert not common.colour_allowed(True)
