"""The list of verbs, `dump`, `encode`, `rules`, `--help`."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result
from syrupy.assertion import SnapshotAssertion

from snhc.conformance.cli import VERBS, common, encode, snhc
from snhc.reference_impl.face.fap_text import read_fap
from snhc.reference_impl.systems.stream import read_stream

WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
MASK = " ".join("1" if number in (3, 48) else "0" for number in range(1, 69))
FAP = f"2.1 test 25 3\n{MASK}\n0 100 -1400\n{MASK}\n1 140 -1700\n{MASK}\n19 140 85\n".encode()


def run(*args: str, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(snhc, list(args), input=stdin)


def command_of(verb: str) -> click.Command:
    command = importlib.import_module(f"snhc.conformance.cli.{verb}").command
    assert isinstance(command, click.Command)
    return command


@pytest.mark.parametrize("verb", list(VERBS))
def test_every_verb_is_a_command_that_says_what_the_list_says(verb: str) -> None:
    command = command_of(verb)
    assert command.help is not None
    assert command.help.splitlines()[0] == VERBS[verb]


@pytest.mark.parametrize("verb", ["", "decode", "encode", "dump", "rules", "doctor"])
def test_help(verb: str, snapshot: SnapshotAssertion) -> None:
    result = CliRunner().invoke(snhc, [*([verb] if verb else []), "--help"], prog_name="snhc", terminal_width=100)
    assert result.exit_code == 0
    assert result.stdout == snapshot


def test_version() -> None:
    result = run("--version")
    name, _, form = result.stdout.split()
    assert (name, form) in (("snhc", "(pure)"), ("snhc", "(compiled)"))


def test_unknown_verb() -> None:
    assert run("nothing").exit_code == 2


# -- dump --------------------------------------------------------------------------------------------------------------


def test_dump_as_tree_and_json(tmp_path: Path) -> None:
    result = run("dump", "-", stdin=WORKED)
    assert result.exit_code == 0
    assert "fba_object_start_code = 0x000001ba" in result.stdout
    target = tmp_path / "out.json"
    assert run("dump", "-", "-o", str(target), stdin=WORKED).exit_code == 0
    assert json.loads(target.read_text())["format"] == "snhc-dump"


def test_a_dump_of_a_bad_stream_is_whole_and_says_so(tmp_path: Path) -> None:
    target = tmp_path / "out.json"
    result = run("dump", "-", "-o", str(target), stdin=WORKED[:36])
    assert result.exit_code == 4
    assert "Truncated" in result.stderr
    assert json.loads(target.read_text())["error"]["bits"] == [282, 288]
    other = run("dump", "-", "-o", str(tmp_path / "other.json"), stdin=b"text")
    assert other.exit_code == 3
    assert not (tmp_path / "other.json").exists()


def test_decode_and_dump_report_the_same_fault() -> None:
    rate_zero = bytes.fromhex("000001bab00000000000")
    faults = [run(verb, "-", "--json-errors", stdin=rate_zero).stderr.splitlines()[-1] for verb in ("decode", "dump")]
    assert faults[0] == faults[1]
    assert json.loads(faults[0])["rule"] == "FBA-37"


def test_plane_ranges() -> None:
    assert common.parse_planes("2:5") == (2, 5)
    assert common.parse_planes("2:") == (2, None)
    assert common.parse_planes(":5") == (0, 5)
    assert common.parse_planes("3") == (3, 4)
    for wrong in ("", ":", "5:2", "a", "1:2:3", "-1"):
        with pytest.raises(click.BadParameter):
            common.parse_planes(wrong)
    result = run("dump", "-", "--planes", "1", stdin=WORKED)
    assert "plane[1]" in result.stdout
    assert "plane[0]" not in result.stdout


@pytest.mark.parametrize(
    ("args", "said"),
    [(("--planes", "3:"), "object 0 has 3 planes"), (("--planes", "0", "--object", "1"), "the stream has 1 object"),
     (("--planes", "9", "--format", "json"), "object 0 has 3 planes")],
)  # fmt: skip
def test_a_dump_of_planes_that_are_not_there_says_so(args: tuple[str, ...], said: str) -> None:
    result = run("dump", "-", *args, stdin=WORKED)
    assert result.exit_code == 0 and said in result.stderr and "plane[" not in result.stdout
    assert "note:" not in run("dump", "-", *args, "--quiet", stdin=WORKED).stderr
    assert "note:" not in run("dump", "-", "--planes", "2:9", stdin=WORKED).stderr
    # Where a fault ends the stream, nobody knows how many planes it has.
    assert "note:" not in run("dump", "-", *args, stdin=WORKED[:20]).stderr


# -- encode ------------------------------------------------------------------------------------------------------------


def test_encode_and_back(tmp_path: Path) -> None:
    source, stream, back = tmp_path / "test.fap", tmp_path / "test.fba", tmp_path / "back.fap"
    source.write_bytes(FAP)
    assert run("encode", str(source), "--quant", "0", "-o", str(stream)).exit_code == 0
    assert run("decode", str(stream), "-o", str(back)).exit_code == 0
    with source.open("rb") as wanted, back.open("rb") as got:
        assert read_fap(got).frames == read_fap(wanted).frames


def test_encode_from_a_pipe_to_a_pipe() -> None:
    result = run("encode", "-", stdin=FAP)
    assert result.exit_code == 0
    planes = next(item.fba.planes for item in read_stream(result.stdout_bytes) if item.fba is not None)
    assert [plane.is_intra for plane in planes] == [1, 0, 0]
    assert planes[1].header.number_of_frames_to_skip == 17


def test_encode_options() -> None:
    everything = ("--quant", "2", "--intra-period", "1", "--start-codes", "all", "--gender", "male", "--ranges", "max")
    stream = run("encode", "-", *everything, "--masks", "3-4,48", "--profile", "0x61", stdin=FAP).stdout_bytes
    items = read_stream(stream)
    assert items[0].profile == 0x61
    planes = next(item.fba.planes for item in items if item.fba is not None)
    assert [plane.is_intra for plane in planes] == [1, 1, 1]
    assert all(plane.start_code for plane in planes)
    faps = planes[0].faps
    assert faps is not None
    assert (faps.quant, faps.gender) == (2, 1)
    assert len(faps.levels) == 3
    assert faps.new == [1, 1, 1, 1]
    assert [limits[48] for limits in faps.limits] == [31] * 4
    assert stream.endswith(b"\0\0\1\xb1")
    assert not run("encode", "-", "--no-end-code", stdin=FAP).stdout_bytes.endswith(b"\0\0\1\xb1")


def test_mask_type() -> None:
    stream = run("encode", "-", "--mask-type", "2", stdin=FAP).stdout_bytes
    first = json.loads(run("decode", "-", stdin=stream).stdout.splitlines()[1])
    assert (first["state"][2], first["state"][3]) == ("T", "I")


def test_bodies_ride_along(tmp_path: Path) -> None:
    bodies = tmp_path / "test.bap"
    mask = " ".join("1" if number == 1 else "0" for number in range(1, 187))
    bodies.write_text(f"2.1 test 25 1\n{mask}\n0 1000\n")
    result = run("encode", "-", "--bap", str(bodies), "--bap-quant", "3", stdin=FAP)
    assert result.exit_code == 0, result.stderr
    planes = next(item.fba.planes for item in read_stream(result.stdout_bytes) if item.fba is not None)
    assert [plane.fba_object_mask for plane in planes] == [3, 1, 1]
    assert planes[0].baps is not None
    assert planes[0].baps.quant == 3


def test_masks_hold_what_frames_lack() -> None:
    other = " ".join("1" if number == 5 else "0" for number in range(1, 69))
    text = f"2.1 test 25 2\n{MASK}\n0 100 -3400\n{other}\n1 7\n".encode()
    stream = run("encode", "-", "--quant", "0", "--masks", "3,5", stdin=text).stdout_bytes
    lines = [json.loads(line) for line in run("decode", "-", stdin=stream).stdout.splitlines()][1:]
    assert [(line["faps"][2], line["faps"][4], line["faps"][47]) for line in lines] == [(100, 0, None), (100, 7, None)]


def test_mask_lists() -> None:
    assert encode.parse_masks("3-5, 48") == {3, 4, 5, 48}
    for wrong in ("", "0", "69", "5-3", "a", "3,,4"):
        with pytest.raises(click.BadParameter):
            encode.parse_masks(wrong)


def test_profiles() -> None:
    assert encode.parse_profile("0x61") == encode.parse_profile("97") == 97
    for wrong in ("", "256", "-1", "0x100", "x"):
        with pytest.raises(click.BadParameter):
            encode.parse_profile(wrong)


def test_encode_with_an_epf(tmp_path: Path) -> None:
    from snhc.reference_impl.face.epf_text import CodedFrame, EncoderParameters, PartParameters, write_epf

    blocks = [
        CodedFrame(is_intra=True, fba_object_mask=1, face=PartParameters(frame=0, quant=3)),
        CodedFrame(is_intra=False, fba_object_mask=1, face=PartParameters(frame=1)),
    ]
    epf = tmp_path / "test.epf"
    epf.write_bytes(b"".join(write_epf(EncoderParameters(blocks))))
    result = run("encode", "-", "--epf", str(epf), stdin=FAP)
    assert result.exit_code == 0, result.stderr
    planes = next(item.fba.planes for item in read_stream(result.stdout_bytes) if item.fba is not None)
    assert len(planes) == 2
    assert planes[0].faps is not None
    assert planes[0].faps.quant == 3


def test_encode_refuses_a_bitstream_and_two_standard_inputs() -> None:
    result = run("encode", "-", stdin=WORKED)
    assert result.exit_code == 3
    assert result.stdout_bytes == b""
    assert "InputFormat" in result.stderr
    assert run("encode", "-", "--epf", "-", stdin=FAP).exit_code == 2


def test_encode_reports_dialects() -> None:
    result = run("encode", "-", stdin=FAP.replace(b"\n", b"\r\n"))
    assert result.exit_code == 0
    assert "text-crlf" in result.stderr
    assert run("encode", "-", "--strict", stdin=FAP.replace(b"\n", b"\r\n")).exit_code == 3


# -- rules -------------------------------------------------------------------------------------------------------------


def test_rules_prints_all_kinds_of_entries() -> None:
    assert run("rules", "FBA-26").stdout.startswith("FBA-26: ")
    assert run("rules", "fba-26").stdout.startswith("FBA-26: ")
    assert run("rules", "AMB-FBA-6").stdout.startswith("AMB-FBA-6: ")
    assert run("rules", "no-end-code").stdout.startswith("no-end-code: ")
    everything = run("rules").stdout.splitlines()
    area = run("rules", "DCT").stdout.splitlines()
    assert area
    assert set(area) < set(everything)
    assert all(line.startswith("DCT-") for line in area)
    assert all(line.startswith("AMB-") for line in run("rules", "AMB").stdout.splitlines())
    assert any(line.startswith("zero-padding ") for line in run("rules", "findings").stdout.splitlines())


@pytest.mark.parametrize(
    ("id", "hint"), [("FBA-266", "FBA-26"), ("AMB-FBA-66", "AMB-FBA-6"), ("no-end", "no-end-code")]
)
def test_unknown_rules_have_near_matches(id: str, hint: str) -> None:
    result = run("rules", id)
    assert result.exit_code == 2
    assert hint in result.stderr
    assert result.stdout == ""


def test_rules_module_reads_one_area_only(monkeypatch: pytest.MonkeyPatch) -> None:
    from snhc.reference_impl.rules import register

    read: list[str] = []
    parse = register._parse
    monkeypatch.setattr(register, "_parse", lambda folder, file, rule: read.append(file) or parse(folder, file, rule))
    register._area.cache_clear()
    assert run("rules", "FBA-1").exit_code == 0
    assert [file for file in read if file != "ambiguities.toml"] == ["fba.toml"]
