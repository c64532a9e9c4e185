"""Profiles and levels: tools outside the signalled profile, and the limits of Simple Face.

Rules: SYS-8, SYS-9, SYS-10, SYS-11, SYS-12.
"""

from __future__ import annotations

import json
import tracemalloc
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from snhc.analyzer.profiles import LevelReport, check_profile, name_of, profile_of
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import ResourceLimit
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import Options, write_stream
from snhc.reference_impl.systems.visual import StreamItem, profile_name
from snhc.reference_impl.tables import profile_level_codes, profile_tools
from snhc.vectors.builders import body, end_code, face_object, inter, intra, sequence, user_data, visual_object

FACES = {profile.profile for profile in profile_level_codes()} - {"Scalable Texture"}


def speech(count: int, rate: int = 25, faps: int = 30, start: int | None = None) -> list[FbaPlane]:
    """Planes of which every one has the same FAPs; the first at `start` seconds."""
    chosen = dict.fromkeys(range(3, 3 + faps), 1)
    first = intra(chosen, rate=(rate, 0, 0), time=None if start is None else (0, 0, start))
    return [first, *(inter(first, dict.fromkeys(chosen, (-1) ** n)) for n in range(count - 1))]


def signalled(code: int, *objects: list[FbaPlane]) -> bytes:
    items: list[StreamItem] = [sequence(code)]
    for planes in objects:
        items += [visual_object(), face_object(planes)]
    return write_stream([*items, end_code()])


def criterion(report: LevelReport, name: str) -> tuple[Fraction, Fraction | None, str]:
    (one,) = [one for one in report.criteria if one.name == name]
    return one.measured, one.limit, one.verdict


def run(*args: object, stdin: bytes) -> Result:
    return CliRunner().invoke(snhc, ["check", *map(str, args), "-"], input=stdin)


# -- SYS-8, SYS-9 ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text", ["simple-face@L1", "Simple Face Animation@1", "simple_face_animation@l1", "SIMPLEFACE@L1"]
)
def test_names(text: str) -> None:
    entry = profile_of(text)
    assert entry is not None
    assert (entry.code, name_of(entry)) == (0x61, "simple-face-animation@L1")


def test_every_name_names_itself() -> None:
    for entry in profile_level_codes():
        assert profile_of(name_of(entry)) == entry
    assert profile_of("simple-face@L3") is None
    assert profile_of("simple-face") is None


def _outside(data: bytes) -> list[Finding]:
    found: list[Finding] = []
    check_profile(data, on_finding=found.append)
    return [finding for finding in found if finding.id == "profile-tool"]


@pytest.mark.parametrize("entry", profile_level_codes(), ids=name_of)
def test_tools_of_the_profiles(entry: object) -> None:
    code = entry.code  # type: ignore[attr-defined]
    tools = profile_tools()[entry.profile]  # type: ignore[attr-defined]
    assert ("face" in tools) == (profile_name(code)[:-3] in FACES)
    data = signalled(code, [intra({3: 1}), body({8: 1}, face=intra({3: 1})), body({9: 1})])
    outside = _outside(data)
    # 32 bits of the sequence's code, 8, then 32 and 8 of the visual object's: the object begins at bit 80.
    expected = [(80, 81)] if "face" not in tools else []
    assert [finding.bits for finding in outside[: len(expected)]] == expected
    bodies = outside[len(expected) :]
    assert len(bodies) == ("body" not in tools), "once, however many planes have them"
    if bodies:
        # bap_quant 1 is the first element of the BAP data.
        bits = bodies[0].bits
        assert bits is not None
        start = bits[0]
        assert bits == (start, start + 1)
        number = int.from_bytes(data, "big") >> (8 * len(data) - start - 5)
        assert number & 31 == 1
        assert bodies[0].rule == "SYS-9"


def test_nothing_is_outside_of_what_is_not_known() -> None:
    for code in (0x00, 0xFE, 0xFF, 0x65):
        assert _outside(signalled(code, [body({8: 1})])) == []
    assert _outside(write_stream([face_object([body({8: 1})]), end_code()])) == []


# -- SYS-10, SYS-11, SYS-12 --------------------------------------------------------------------------------------------


def test_the_peak_decides_not_the_mean() -> None:
    # 10 s of silence with one second in which every plane has 60 FAPs.
    loud = speech(25, faps=60)
    quiet = speech(250, faps=1, start=2)
    data = signalled(0x61, loud + quiet)
    report = check_profile(data)
    peak, limit, verdict = criterion(report, "bit_rate")
    mean, _, free = criterion(report, "mean_bit_rate")
    # Headers are the first plane's, so the first second is all up to its 25th plane's end.
    assert (peak, limit, verdict) == (loud[24].end, 16_000, "pass")
    assert mean < peak / 4
    assert free == "info"


def _padded(bits: int) -> bytes:
    """A face of level 1 whose only second has exactly so many bits, by user data in front of it."""

    def made(planes: list[FbaPlane], count: int) -> bytes:
        items = [sequence(0x61), user_data(b"\xff" * count), visual_object(), face_object(planes), end_code()]
        return write_stream(items)

    # Some number of FAPs makes the last plane end where whole bytes in front of it can move it.
    for faps in range(1, 60):
        planes = speech(10, faps=faps)
        made(planes, 0)
        missing = bits - planes[-1].end
        if missing > 0 and missing % 8 == 0:
            data = made(planes, missing // 8)
            assert planes[-1].end == bits
            return data
    raise AssertionError("no stream ends there")


def test_the_limit_itself_is_allowed() -> None:
    at = check_profile(_padded(16_000))
    assert criterion(at, "bit_rate") == (16_000, 16_000, "pass")
    assert at.verdict == "pass"
    over = check_profile(_padded(16_001))
    assert criterion(over, "bit_rate") == (16_001, 16_000, "fail")
    assert [finding.id for finding in over.findings] == ["level-bit-rate", "rate-above-15"]
    assert over.verdict == "fail"
    # Level 2 has twice the rate.
    assert check_profile(_padded(16_001), asked=profile_of("simple-face@L2")).verdict == "pass"


@given(st.integers(1, 255))
def test_declared_rates_are_findings(rate: int) -> None:
    data = signalled(0x61, speech(3, rate))
    report = check_profile(data)
    assert criterion(report, "frame_rate") == (rate, None, "info")
    assert ("rate-above-15" in {finding.id for finding in report.findings}) == (rate > 15)
    assert report.verdict == "pass"
    # AMB-SYS-2: read as a bound on the stream.
    coded = check_profile(data, Options(readings=Readings({"AMB-SYS-2": "coded"})))
    assert coded.verdict == ("fail" if rate > 15 else "pass")
    assert "rate-above-15" not in {finding.id for finding in coded.findings}


def test_faces_count_where_their_times_overlap() -> None:
    one_by_one = signalled(0x61, speech(25), speech(25, start=1), speech(25, start=2))
    assert criterion(check_profile(one_by_one), "faces") == (1, 1, "pass")
    together = signalled(0x61, speech(26), speech(25, start=1))
    report = check_profile(together)
    assert criterion(report, "faces") == (2, 1, "fail")
    assert "level-faces" in {finding.id for finding in report.findings}
    four = [speech(5, 15, 1) for _ in range(4)]
    assert check_profile(signalled(0x62, *four)).verdict == "pass"
    assert check_profile(signalled(0x62, *four, speech(5, 15, 1))).verdict == "fail"


def test_level_2_adds_up_all_faces() -> None:
    faces = [speech(25, 15, 40) for _ in range(3)]
    report = check_profile(signalled(0x62, *faces))
    # The first second holds 15 planes of each face; what stands between two objects is the next plane's.
    ends = [0, faces[0][-1].end, faces[1][-1].end]
    assert criterion(report, "planes_per_second")[0] == 45
    assert criterion(report, "frame_rate")[0] == 45
    assert criterion(report, "bit_rate")[0] == sum(face[14].end - end for face, end in zip(faces, ends, strict=True))
    five = [speech(2, 16, 1) for _ in range(4)]
    assert "rate-sum-above-60" in {finding.id for finding in check_profile(signalled(0x62, *five)).findings}


def test_other_profiles_are_measured_and_not_checked() -> None:
    report = check_profile(signalled(0x63, [body({8: 1})] * 3))
    assert report.verdict == "not_checked"
    assert {criterion.verdict for criterion in report.criteria} == {"not_checked"}
    assert criterion(report, "bit_rate")[0] > 0, "bodies have bits, too"
    assert check_profile(write_stream([face_object(speech(3)), end_code()])).checked is None


def test_what_is_asked_for_counts() -> None:
    data = signalled(0x63, [body({8: 1}, face=intra({3: 1}))])
    report = check_profile(data, asked=profile_of("simple-face@L1"))
    assert [(finding.id, finding.rule) for finding in report.findings if finding.severity == "error"] == [
        ("profile-tool", "SYS-9")
    ]
    assert report.verdict == "fail"


def test_an_object_without_planes_and_limits() -> None:
    report = check_profile(signalled(0x61, []))
    assert criterion(report, "bit_rate")[0] == 0
    with pytest.raises(ResourceLimit):
        check_profile(signalled(0x61, speech(4), speech(1)), Options(limits=Limits(collected_planes=3)))
    # One object is measured as it comes.
    assert criterion(check_profile(signalled(0x61, speech(4)), Options(limits=Limits(collected_planes=3))), "faces")


# -- the verb ----------------------------------------------------------------------------------------------------------


def test_what_is_kept_of_an_object_is_little() -> None:
    # A stream of some megabytes may hold a hundred thousand objects.
    def peak(count: int) -> int:
        tracemalloc.start()
        try:
            check_profile(b"".join(write_stream([face_object(speech(1))]) for _ in range(count)))
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(3)
    few, many = peak(50), peak(250)
    assert many - few < 200 * 2000


def test_the_verb() -> None:
    good = signalled(0x61, speech(3, 15, 2))
    result = run("--profile", "signalled", stdin=good)
    assert result.exit_code == 0, result.output
    assert "profile: Simple Face Animation L1 (as signalled): pass" in result.stdout
    assert "bit_rate" in result.stdout
    bad = signalled(0x61, [body({8: 1}, face=intra({3: 1}))])
    assert run(stdin=bad).exit_code == 1, "a tool outside needs no --profile"
    result = run("--profile", "simple-fba@L1", "--format", "json", stdin=bad)
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert lines[-1]["format"] == "snhc-profile"
    assert lines[-1]["checked"] == "simple-fba@L1"
    assert lines[-1]["verdict"] == "not_checked"


def test_the_verb_refuses_what_it_cannot_hold_against() -> None:
    result = run("--profile", "simple-face@L9", stdin=b"")
    assert result.exit_code == 2
    assert "simple-face-animation@L1" in result.stderr
    face = Path(__file__).parents[2] / "reference_impl" / "model" / "head" / "head.json"
    result = CliRunner().invoke(snhc, ["check", "--profile", "signalled", str(face)])
    assert result.exit_code in (2, 3), "no stream"


def test_a_second_objects_tool_is_found_too() -> None:
    data = signalled(0x61, speech(3, 15, 2), [body({8: 1})])
    assert run("--quiet", stdin=data).exit_code == 0
    result = run("--profile", "signalled", stdin=data)
    assert result.exit_code == 1
    assert result.stdout.count("profile-tool") == 1
