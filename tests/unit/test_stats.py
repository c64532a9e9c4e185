"""Sums over streams, bit rate windows, plots."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import accumulate
from math import log2
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st
from strategies import Stream, streams

from snhc.analyzer.plot import plot
from snhc.analyzer.stats import PARTS, StreamStats, stream_stats, summary
from snhc.analyzer.windows import Peak, RunningPeak, peak_window
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics, ResourceLimit, SnhcError
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face.syntax import new_plane
from snhc.reference_impl.systems.encoding import stream_of
from snhc.reference_impl.systems.stream import (
    DEFAULT_OPTIONS,
    Options,
    decode_planes,
    trace_stream,
    write_stream,
)

SAMPLES = Path(__file__).parents[1] / "fixtures" / "samples"
WORKED = bytes.fromhex("000001bab19001960002492c921f97ffcbf97ffcbf37ff9bf37ff9befa128c9f1c4cfca00ae5000001b1")
STREAMS = sorted(SAMPLES.glob("fba/*/input.fba")) + sorted(SAMPLES.glob("dct/*/input.fba"))
MESHES = sorted(path for path in SAMPLES.glob("mesh/*/input.*") if path.suffix in (".m2d", ".bin"))


def run(*args: object, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(snhc, [str(arg) for arg in args], input=stdin)


@pytest.mark.parametrize("path", [*STREAMS, *MESHES], ids=lambda path: path.parent.name)
def test_sums_agree_with_the_decoder(path: Path) -> None:
    data = path.read_bytes()
    planes = list(decode_planes(data))
    stats = stream_stats(data, keep_frames=True)
    times = [Fraction(*plane.frames[0].time) for plane in planes]
    assert (stats.planes, stats.first, stats.last) == (len(planes), min(times), max(times))
    assert stats.frames == sum(len(plane.frames) for plane in planes)
    assert stats.curves.times == times
    assert stats.peak == peak_window(times, stats.curves.bits)
    assert sum(stats.curves.bits) == stats.total_bits
    assert sum(stats.curves.intra) == stats.intra
    # SYS-11: headers belong to the first plane, the end of the last plane ends the count.
    assert stats.total_bits == planes[-1].end
    assert sum(stats.parts.values()) == stats.total_bits
    assert set(stats.parts) <= set(PARTS)
    # Symbols cost what their segment costs, but for its end and guards.
    inside = sum(stats.parts.get(part, 0) for part in PARTS if part.startswith("FAP ") and part != "FAP header")
    spent = sum(use.bits for use in stats.faps.values())
    assert spent <= inside
    if "FAP values (arithmetic)" in stats.parts:
        assert spent > 0.9 * inside - 40 * len(planes)
    summary(stats)


def test_uses_of_faps() -> None:
    stats = stream_stats(WORKED, keep_frames=True)
    assert set(stats.faps) == {
        fap + 1 for frame in stats.curves.frames for fap, s in enumerate(frame.state) if s == "T"
    }
    for fap, use in stats.faps.items():
        sent = [frame.faps[fap - 1] for frame in stats.curves.frames if frame.state[fap - 1] == "T"]
        values = [value for value in sent if value is not None]
        assert (use.frames, use.low, use.high) == (len(sent), min(values), max(values))
    assert sum(sum(counts) for counts in stats.masks.values()) == 10 * stats.intra
    assert stats.rates == [Fraction(25)]
    # Three planes at 25 Hz: 0, 1/25, 2/25 s, and one period.
    assert stats.duration == Fraction(3, 25)
    assert stats.mean_rate == Fraction(stats.total_bits * 25, 3)


def literal_bits(data: bytes, options: Options = DEFAULT_OPTIONS) -> dict[int, float]:
    """Bits per FAP of the first object's arithmetic segments, as the literal coder meets them, one by one."""
    bits: dict[int, float] = {}
    first = None
    for part in trace_stream(data, options):
        first = part.item if first is None and part.item is not None and part.item.fba is not None else first
        if part.item is not first or first is None:
            continue
        for row, (segment, labels) in sorted(part.trace.segments.items()):
            element = part.trace.el(row).name
            for step, label in zip(segment.steps, labels, strict=True):
                if element != "bap_segment":
                    word = label.split()[1] if label.startswith("FAP ") else {"v": "1", "e": "2", "i": "2"}[label[0]]
                    cost = log2(step.total / (step.cum_high - step.cum_low))
                    bits[int(word)] = bits.get(int(word), 0.0) + cost
    return bits


@given(streams())
def test_costs_are_those_of_the_literal_coder(stream: Stream) -> None:
    """To the last digit: the sums are taken in the same order."""
    stats = stream_stats(stream.data, stream.options)
    assert {fap: use.bits for fap, use in stats.faps.items() if use.bits} == {
        fap: bits for fap, bits in literal_bits(stream.data, stream.options).items() if bits
    }


@pytest.mark.parametrize("path", STREAMS, ids=lambda path: path.parent.name)
def test_costs_of_samples(path: Path) -> None:
    data = path.read_bytes()
    stats = stream_stats(data)
    if "DCT" not in stats.coding:
        assert {fap: use.bits for fap, use in stats.faps.items() if use.bits} == {
            fap: bits for fap, bits in literal_bits(data).items() if bits
        }


def test_windows_are_half_open() -> None:
    times = [Fraction(0), Fraction(1, 2), Fraction(1), Fraction(3, 2), Fraction(5)]
    assert peak_window(times, [1, 2, 4, 1, 5]) == Peak(Fraction(1, 2), 6, 2)
    assert peak_window(times, [3, 3, 3, 3, 6]) == Peak(Fraction(0), 6, 2)
    assert peak_window([], []) is None


@given(st.lists(st.tuples(st.fractions(0, 4, max_denominator=30), st.integers(0, 999)), min_size=1, max_size=25))
def test_the_peak_is_the_largest_window(planes: list[tuple[Fraction, int]]) -> None:
    times, bits = [time for time, _ in planes], [size for _, size in planes]
    peak = peak_window(times, bits)
    assert peak is not None
    sums = {t: sum(size for time, size in planes if t <= time < t + 1) for t in times}
    assert peak.bits == max(sums.values()) == sums[peak.start]
    assert peak.start == min(t for t in sums if sums[t] == peak.bits)
    assert peak.planes == sum(peak.start <= time < peak.start + 1 for time in times)


@given(st.lists(st.integers(-20, 90), max_size=60), st.lists(st.integers(1, 99), min_size=60, max_size=60))
def test_the_running_peak_knows_what_it_can_put_in_order(steps: list[int], sizes: list[int]) -> None:
    times = [Fraction(tick, 60) for tick in accumulate(steps)]
    running = RunningPeak()
    for time, bits in zip(times, sizes, strict=False):
        running.add(time, bits)
    peak = running.peak()
    if running.ordered:
        assert peak == peak_window(times, sizes[: len(times)])
    late = max((max(times[: n + 1]) - time for n, time in enumerate(times)), default=Fraction(0))
    assert running.ordered or late > 2


def test_what_comes_far_too_late_is_out_of_order() -> None:
    for late in (2, 3):
        running = RunningPeak()
        for time in (5, 6, 7, 8, 8 - late):
            running.add(Fraction(time), 1)
        running.peak()
        assert running.ordered == (late == 2)


def test_nothing_is_kept_of_what_is_out_of_order() -> None:
    # Behind a clock that has gone back every second would lie inside the window.
    running = RunningPeak()
    for time in (100, 103, 106, *(Fraction(n, 30) for n in range(300))):
        running.add(Fraction(time), 1)
    assert not running.ordered and not running._window and not running._coming


def timed(*codes: int) -> bytes:
    """Intra planes without FAPs at these seconds, then one a twenty-fifth later."""
    planes = []
    for seconds in codes:
        for second in (False, True):
            plane = new_plane(1, 1)
            plane.header.is_time_code = int(not second)
            plane.header.time_code_seconds = 0 if second else seconds
            planes.append(plane)
    return write_stream(stream_of(planes))


def test_a_clock_that_goes_back_is_read_twice() -> None:
    found: list[str] = []
    stats = stream_stats(timed(5, 9, 5, 1), on_finding=lambda finding: found.append(finding.id), keep_frames=True)
    assert (stats.first, stats.last) == (Fraction(1), Fraction(9) + Fraction(1, 30))
    assert stats.peak == peak_window(stats.curves.times, stats.curves.bits)
    assert stats.peak is not None
    assert (stats.peak.start, stats.peak.planes) == (5, 4)
    assert found.count("time-code-back") == 2
    # Only what must be kept is counted against the limit.
    few = Options(limits=Limits(collected_planes=3))
    assert stream_stats(timed(1, 3, 5, 5), few).peak is not None
    with pytest.raises(ResourceLimit):
        stream_stats(timed(5, 9, 5, 1), few)


def test_faults_and_limits() -> None:
    with pytest.raises(SnhcError):
        stream_stats(WORKED[:30])
    with pytest.raises(InconsistentSemantics):
        stream_stats(WORKED, Options(object_number=1))
    with pytest.raises(ResourceLimit):
        stream_stats(WORKED, Options(limits=Limits(collected_planes=1)), keep_frames=True)
    found: list[str] = []
    stream_stats(WORKED, on_finding=lambda finding: found.append(finding.id))
    assert found == ["no-sequence-header"]


def test_plots_are_the_same_every_time() -> None:
    stats = stream_stats(WORKED, keep_frames=True)
    svg = plot(stats, "svg")
    assert svg == plot(stats, "svg") and b"<svg" in svg
    assert b"open_jaw" in plot(stats, "svg") or len(stats.faps) > 0
    assert plot(stats).startswith(b"\x89PNG")
    with pytest.raises(EncodeError):
        plot(StreamStats())


def test_plots_of_meshes_have_rates_only() -> None:
    assert plot(stream_stats(MESHES[0].read_bytes(), keep_frames=True)).startswith(b"\x89PNG")


def test_verbs(tmp_path: Path) -> None:
    text = run("stats", "-", stdin=WORKED)
    assert text.exit_code == 0 and "kbit/s mean" in text.stdout
    target = tmp_path / "s.json"
    assert run("stats", "-", "-o", target, stdin=WORKED).exit_code == 0
    document = json.loads(target.read_text())
    assert (document["format"], document["version"], document["planes"]) == ("snhc-stats", 1, 3)
    assert run("stats", "-", stdin=WORKED[:30]).exit_code == 4
    assert run("stats", "-", stdin=b"text").exit_code == 3
    for name in ("p.svg", "p.png"):
        assert run("plot", "-", "-o", tmp_path / name, stdin=WORKED).exit_code == 0
        assert (tmp_path / name).stat().st_size > 1000
    assert run("plot", "-", "-o", tmp_path / "p.pdf", stdin=WORKED).exit_code == 2
