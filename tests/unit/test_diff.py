"""What differs between two streams or decodes: laws, exact places, statistics, pages.

Rules: CNF-1, CNF-16, CNF-17, CNF-19.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from math import log10
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from snhc.analyzer.diff import instants
from snhc.analyzer.diff.align import pairs
from snhc.analyzer.diff.compare import compare
from snhc.analyzer.diff.html import html_text
from snhc.analyzer.diff.report import SCHEMA, Comparison, terminal_lines
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.systems.stream import read_stream, write_stream
from snhc.vectors.builders import inter, intra, stream

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
# Tracing is literal; the largest sample alone would take as long as all others.
STREAMS = sorted(
    path
    for path in SAMPLES.glob("*/*/input.*")
    if path.suffix in (".fba", ".m2d") and "neg" not in path.parts and path.stat().st_size < 10_000
)
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")


def diff(a: bytes, b: bytes, **options: object) -> Comparison:
    return compare(BytesSource(a), BytesSource(b), **options)  # type: ignore[arg-type]


def run(*args: object, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(snhc, ["diff", *map(str, args)], input=stdin)


def document(comparison: Comparison) -> dict[str, object]:
    out = json.loads(json.dumps(comparison.as_json(), allow_nan=False))
    jsonschema.validate(out, json.loads(SCHEMA.read_text()))
    assert isinstance(out, dict)
    return out


# -- laws --------------------------------------------------------------------------------------------------------------


@given(st.lists(st.integers(0, 9)), st.lists(st.integers(0, 9)), st.booleans())
def test_every_element_comes_once_and_in_order(a: list[int], b: list[int], by_key: bool) -> None:
    found = list(
        pairs([(n, v) for n, v in enumerate(a)], [(n, v) for n, v in enumerate(b)], _second if by_key else None)
    )
    assert [x for x, _ in found if x is not None] == list(enumerate(a))
    assert [y for _, y in found if y is not None] == list(enumerate(b))
    assert all(x[1] == y[1] for x, y in found if x is not None and y is not None) or not by_key


def _second(pair: tuple[int, int]) -> int:
    return pair[1]


@given(st.sets(st.integers(0, 30)), st.sets(st.integers(0, 30)))
def test_rising_keys_pair_wherever_they_can(a: set[int], b: set[int]) -> None:
    found = list(pairs(sorted(a), sorted(b), lambda n: n))
    assert {x for x, y in found if x is not None and y is not None} == a & b


@pytest.mark.parametrize("path", STREAMS[::3], ids=lambda path: path.parent.name)
def test_a_stream_is_equal_to_itself(path: Path) -> None:
    data = path.read_bytes()
    comparison = diff(data, data, curves=True)
    assert comparison.equal
    assert document(comparison)["equal"] is True
    assert comparison.syntax is not None
    assert comparison.syntax.pairs == comparison.syntax.planes_a == comparison.syntax.planes_b > 0
    assert "No difference" in html_text(comparison)


@pytest.mark.parametrize("path", [p for p in STREAMS if p.suffix == ".fba"][:40:3], ids=lambda path: path.parent.name)
def test_swapping_swaps(path: Path) -> None:
    a = path.read_bytes()
    items = read_stream(a)
    planes = next(item.fba.planes for item in items if item.fba is not None)
    planes[-1].header.skip_frames = 1 - planes[-1].header.skip_frames
    b = write_stream(items)
    ours, theirs = diff(a, b, shown=10**6), diff(b, a, shown=10**6)
    assert ours.syntax is not None
    assert theirs.syntax is not None
    assert not ours.equal
    assert len(ours.syntax.shown) == ours.syntax.differences == theirs.syntax.differences
    assert sorted(str((d.path, d.element, d.a, d.b)) for d in ours.syntax.shown) == sorted(
        str((d.path, d.element, d.b, d.a)) for d in theirs.syntax.shown
    )


# -- the place ---------------------------------------------------------------------------------------------------------


def speech() -> list[FbaPlane]:
    first = intra({3: 5, 48: 7, 61: 8}, quant=2, rate=(25, 0, 0))
    return [first, *(inter(first, {3: n, 48: -n, 61: 1}) for n in range(1, 6))]


def changed(change: Callable[[list[FbaPlane]], None]) -> tuple[bytes, bytes]:
    ours, theirs = speech(), speech()
    change(theirs)
    return write_stream(stream(*ours)), write_stream(stream(*theirs))


def test_the_first_divergence_is_the_element_that_was_changed() -> None:
    def change(planes: list[FbaPlane]) -> None:
        assert planes[3].faps is not None
        planes[3].faps.levels[1] += 2

    a, b = changed(change)
    comparison = diff(a, b)
    syntax, values = comparison.syntax, comparison.values
    assert syntax is not None
    assert values is not None
    first = syntax.first
    assert first is not None
    assert (first.plane_a, first.plane_b, first.rule) == (3, 3, "FBA-28")
    assert (first.path, first.element) == ("fap.fap_segment", "FAP 48 head_pitch")
    assert (first.a, first.b) == (-3, -1)
    assert first.bits_a is not None
    planes = next(item.fba.planes for item in read_stream(a) if item.fba is not None)
    assert planes[3].start < first.bits_a[0] < first.bits_a[1] == planes[3].end
    # Two levels of QP 170 and quantiser 2 from plane 3 on: 680 in planes 3, 4 and 5.
    assert syntax.elements["FAP 48 head_pitch"].different == 1
    channel = values.channels["FAP 48"]
    assert (channel.compared, channel.different, channel.largest) == (6, 3, 680.0)
    assert values.first is not None
    assert (values.first.index_a, values.first.time, values.first.channel) == (3, Fraction(3, 25), "FAP 48")
    text = "".join(terminal_lines(comparison))
    assert "first divergence: plane 3: fap.fap_segment.FAP 48 head_pitch: A -3 at bits [" in text
    document(comparison)


def test_a_missing_plane_pairs_by_time_not_by_number() -> None:
    def change(planes: list[FbaPlane]) -> None:
        # The level of plane 2 goes into plane 3, so that all later values are as before.
        assert planes[1].faps is not None and planes[2].faps is not None and planes[3].faps is not None
        gone = planes.pop(2)
        assert gone.faps is not None
        planes[2].faps.levels = [x + y for x, y in zip(planes[2].faps.levels, gone.faps.levels, strict=True)]
        planes[1].header.skip_frames = planes[1].header.number_of_frames_to_skip = 1

    a, b = changed(change)
    values = diff(a, b).values
    assert values is not None
    assert (values.compared, values.only_a, values.only_b, values.differences) == (5, 1, 0, 1)
    syntax = diff(a, b).syntax
    assert syntax is not None
    assert (syntax.pairs, syntax.planes_a, syntax.planes_b) == (5, 6, 5)
    assert syntax.elements["skip_frames"].different == 1
    assert syntax.elements["number_of_frames_to_skip"].only_b == 1
    by_number = diff(a, b, align="number").values
    assert by_number is not None
    assert by_number.differences > 5


def test_an_end_that_no_encoder_writes_is_a_difference() -> None:
    finding = Path(__file__).parents[1] / "fuzz_findings" / "segment-ends-unlike-the-encoder.bin"
    odd = finding.read_bytes()
    items = read_stream(odd)
    tails = 0
    for item in items:
        for plane in item.fba.planes if item.fba is not None else ():
            for data in (plane.faps, plane.baps):
                if data is not None and any(data.tails):
                    tails += 1
                    data.tails = [0] * len(data.tails)
    assert tails
    even = write_stream(items)
    comparison = diff(odd, even)
    assert comparison.syntax is not None
    assert not comparison.syntax.equal
    assert comparison.values is not None
    assert comparison.values.equal


def test_a_fault_ends_a_side_and_is_told() -> None:
    cut = WORKED[:30]
    comparison = diff(WORKED, cut)
    assert comparison.syntax is not None
    assert comparison.syntax.error_b is not None
    assert comparison.syntax.error_a is None
    assert not comparison.equal
    assert comparison.error is comparison.syntax.error_b
    assert "B ends with an error: Truncated" in "".join(terminal_lines(comparison))
    assert "ends with an error" in html_text(comparison)
    # Both end with the same fault: still no stream that decodes.
    assert diff(cut, cut).error is not None


# -- statistics --------------------------------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.integers(-500, 500), st.integers(-500, 500)), min_size=2, max_size=30), st.integers(0, 40))
def test_statistics_are_those_of_numpy(rows: list[tuple[int, int]], tolerance: int) -> None:
    def text(column: int) -> bytes:
        lines = ['{"format":"snhc-decoded","version":1,"kind":"mesh"}']
        for n, row in enumerate(rows):
            lines.append(json.dumps({"index": n, "time": f"{n}/25", "intra": True, "nodes": [[row[column], 0]]}))
        return ("\n".join(lines) + "\n").encode()

    values = diff(text(0), text(1), tolerance=tolerance).values
    assert values is not None
    channel = values.channels["x"]
    a, b = (np.array([row[column] for row in rows], dtype=float) for column in (0, 1))
    gaps = np.abs(a - b)
    assert channel.different == int((gaps > tolerance).sum()) == values.differences
    assert channel.largest == gaps.max()
    assert channel.rms == pytest.approx(float(np.sqrt((gaps**2).mean())))
    peak = float(a.max() - a.min())
    if peak and gaps.max():
        assert channel.psnr == pytest.approx(10 * log10(peak**2 / float((gaps**2).mean())))
    else:
        assert channel.psnr is None
    assert values.kind_a == values.kind_b == "mesh"


def test_what_is_not_there_differs_from_any_number() -> None:
    ours, theirs = intra({3: 5}), intra({3: 5, 48: 0})
    values = diff(write_stream(stream(ours)), write_stream(stream(theirs))).values
    assert values is not None
    assert values.channels["FAP 48"].missing == 1
    assert values.words["state"] == [1, 1]


# -- forms of input ----------------------------------------------------------------------------------------------------


def test_a_stream_against_its_own_decoded_lines(tmp_path: Path) -> None:
    for path in STREAMS[::7]:
        lines = tmp_path / "lines.ndjson"
        assert CliRunner().invoke(snhc, ["decode", str(path), "--quiet", "-o", str(lines)]).exit_code == 0
        result = run(path, lines)
        assert result.exit_code == 0, (path, result.output)
        assert "syntax" not in result.stdout


def test_a_stream_against_its_own_text(tmp_path: Path) -> None:
    source = tmp_path / "worked.fba"
    source.write_bytes(WORKED)
    text = tmp_path / "worked.fap"
    assert CliRunner().invoke(snhc, ["decode", str(source), "--quiet", "-o", str(text)]).exit_code == 0
    result = run(source, text, "--format", "json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["syntax"] is None


def test_vertices_are_compared_by_place() -> None:
    head = '{"format":"snhc-decoded","version":1,"kind":"vertices"}\n'
    line = '{"index":0,"time":"0/1","meshes":{"lips":[[0.5,1.0,-2.25],[0.0,0.0,%s]]}}\n'
    values = diff((head + line % "0.0").encode(), (head + line % "0.25").encode()).values
    assert values is not None
    assert values.first is not None
    assert (values.first.channel, values.first.place, values.first.a, values.first.b) == ("lips.z", 1, 0.0, 0.25)


# -- the verb ----------------------------------------------------------------------------------------------------------


def test_exit_codes(tmp_path: Path) -> None:
    a, b, cut, junk, gone = (tmp_path / name for name in ("a.fba", "b.fba", "cut.fba", "junk", "gone"))
    first, second = changed(lambda planes: planes.pop() and None)
    a.write_bytes(first)
    b.write_bytes(second)
    cut.write_bytes(first[:30])
    junk.write_bytes(b"\x00\x01\x02\x03\x04")
    assert run(a, a).exit_code == 0
    assert run(a, b).exit_code == 1
    assert run(a, cut).exit_code == 4
    assert run(a, junk).exit_code == 3
    assert run(a, gone).exit_code == 3
    assert run("-", "-").exit_code == 2
    assert run("-", b, stdin=second).exit_code == 0
    text = tmp_path / "a.fap"
    text.write_text("2.1 x 25 0\n")
    assert run(a, text, "--level", "syntax").exit_code == 3
    assert run(a, text, "--level", "values").exit_code == 1
    bad = tmp_path / "bad.ndjson"
    bad.write_text('{"format":"snhc-decoded","version":1,"kind":"fba"}\n{"index":0}\n')
    result = run(a, bad)
    assert result.exit_code in (3, 4)
    assert "Traceback" not in result.output


def test_the_page_holds_what_inputs_say_as_text(tmp_path: Path) -> None:
    evil = tmp_path / "<img src=x onerror=alert(1)>.fba"
    evil.write_bytes(WORKED)
    other = tmp_path / "b.fba"
    other.write_bytes(write_stream(stream(*speech())))
    page = tmp_path / "diff.html"
    assert run(evil, other, "-o", page).exit_code == 1
    text = page.read_text()
    assert "<img" not in text
    assert "&lt;img" in text
    assert "<svg" in text
    assert "http" not in text.replace("http://www.w3.org", ""), "nothing from outside"


@pytest.mark.parametrize("end", [b"", b"\n"])
@pytest.mark.parametrize("length", [1, 65_535, 65_536, 65_537, 200_000])
def test_lines_come_whole_wherever_the_pieces_end(length: int, end: bytes) -> None:
    data = b"\n".join([b"", b"a" * length, b"", b"b" * 70_000, b"c" * length]) + end
    assert list(instants._lines(BytesSource(data))) == data.splitlines(keepends=True)


@pytest.mark.parametrize("end", [b"", b"\n"])
def test_a_line_without_end_is_one_error(end: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(instants, "LONGEST_LINE", 150_000)
    assert len(list(instants._lines(BytesSource(b"a" * 150_000 + end)))) == 1
    with pytest.raises(InputFormat, match="150000"):
        list(instants._lines(BytesSource(b"a" * 150_001 + end)))
