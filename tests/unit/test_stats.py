"""Sums over streams, bit rate windows, plots."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from snhc.analyzer.plot import plot
from snhc.analyzer.stats import PARTS, Peak, StreamStats, peak_window, stream_stats, summary
from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics, ResourceLimit, SnhcError
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.systems.stream import Options, decode_planes

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
    stats = stream_stats(data)
    assert len(stats.times) == len(planes)
    assert stats.frames == sum(len(plane.frames) for plane in planes)
    assert stats.times == [Fraction(*plane.frames[0].time) for plane in planes if plane.frames]
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
    assert set(stats.faps) == {fap + 1 for frame in stats.curves for fap, s in enumerate(frame.state) if s == "T"}
    for fap, use in stats.faps.items():
        sent = [frame.faps[fap - 1] for frame in stats.curves if frame.state[fap - 1] == "T"]
        values = [value for value in sent if value is not None]
        assert (use.frames, use.low, use.high) == (len(sent), min(values), max(values))
    assert sum(sum(counts) for counts in stats.masks.values()) == 10 * sum(stats.intra)
    assert stats.rates == [Fraction(25)]
    # Three planes at 25 Hz: 0, 1/25, 2/25 s, and one period.
    assert stats.duration == Fraction(3, 25)
    assert stats.mean_rate == Fraction(stats.total_bits * 25, 3)


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


def test_faults_and_limits() -> None:
    with pytest.raises(SnhcError):
        stream_stats(WORKED[:30])
    with pytest.raises(InconsistentSemantics):
        stream_stats(WORKED, Options(object_number=1))
    with pytest.raises(ResourceLimit):
        stream_stats(WORKED, Options(limits=Limits(collected_planes=1)))
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
    assert plot(stream_stats(MESHES[0].read_bytes())).startswith(b"\x89PNG")


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
