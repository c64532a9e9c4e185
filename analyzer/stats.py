"""What a stream costs and holds: planes, times, bit rates, bits per part and per FAP, masks, ranges of values.

Rules: SYS-11, SYS-12, FBA-10, FBA-18, FBA-38, CNF-21.

A plane's bits run from the end of the plane before it to its own end (SYS-11). Bits of one FAP inside an arithmetic
segment are what its symbols cost in their models, log2(total / width of the bin): their sum is the segment but for
its end and guards. The codewords of a DCT segment are counted as they are.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import log2
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, ResourceLimit
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.temporal import Clock
from snhc.reference_impl.syntax.tracer import Trace
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, TracePart, is_object, trace_stream
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem
from snhc.reference_impl.tables import fap_groups, fap_table

FAPS: Final = 68
PARTS: Final = (
    "headers", "plane header", "FAP header", "masks", "ranges", "FAP 1 (viseme)", "FAP 2 (expression)",
    "FAP values (arithmetic)", "FAP values (DCT)", "BAP", "mesh geometry", "mesh motion",
)  # fmt: skip
MASK_TYPES: Final = ("none", "mask, others keep", "mask, others interpolated", "all")
_MASKS: Final = ("fap_mask_type", "fap_group_mask")
_SEGMENTS: Final = {"viseme_segment": PARTS[5], "expression_segment": PARTS[6], "fap_segment": PARTS[7]}
_LABEL: Final = re.compile(r"FAP (\d+)\b")


@dataclass(frozen=True, slots=True)
class Peak:
    """The fullest window of one second. Rules: SYS-11. `start`: seconds; `bits`, `planes` in [start, start + 1)."""

    start: Fraction
    bits: int
    planes: int


@dataclass(slots=True)
class FapUse:
    """What happens to one FAP. Rules: FBA-18. `frames`: with state T. `bits`: see the module."""

    frames: int = 0
    low: int | None = None
    high: int | None = None
    bits: float = 0.0

    def take(self, value: int | None) -> None:
        """Count one transmitted value; None: FAP 1 and 2 have none. Rules: FBA-18."""
        self.frames += 1
        if value is not None:
            self.low = value if self.low is None else min(self.low, value)
            self.high = value if self.high is None else max(self.high, value)


@dataclass(slots=True)
class StreamStats:
    """The sums over one object.

    Rules: SYS-11, SYS-12, FBA-10, FBA-38.

    `times`, `bits`, `intra`: one entry per plane. `rates`: declared frames per second, in the order in which they come.
    `period`: the last one's. `parts`: bits per part of PARTS. `masks`: per FAP group (1..10) how many intra planes have
    each mask type. `faps`: per FAP number. `curves`: frames, if they were asked for.
    """

    kind: str = ""
    times: list[Fraction] = field(default_factory=list)
    bits: list[int] = field(default_factory=list)
    intra: list[bool] = field(default_factory=list)
    frames: int = 0
    skipped_frames: int = 0
    rates: list[Fraction] = field(default_factory=list)
    period: Fraction = Fraction(1, 30)
    coding: dict[str, int] = field(default_factory=dict)
    parts: dict[str, int] = field(default_factory=dict)
    masks: dict[int, list[int]] = field(default_factory=dict)
    faps: dict[int, FapUse] = field(default_factory=dict)
    curves: list[FaceFrame] = field(default_factory=list)

    @property
    def total_bits(self) -> int:
        """Bits of all planes. Rules: SYS-11."""
        return sum(self.bits)

    @property
    def duration(self) -> Fraction:
        """Last time - first time + one period, seconds. Rules: SYS-11."""
        return max(self.times) - min(self.times) + self.period if self.times else Fraction(0)

    @property
    def mean_rate(self) -> Fraction:
        """Bits per second over the whole. Rules: SYS-11."""
        return self.total_bits / self.duration if self.duration else Fraction(0)

    @property
    def measured_frame_rate(self) -> Fraction | None:
        """(n - 1) / (last time - first time); None for less than two planes. Rules: SYS-12."""
        span = max(self.times) - min(self.times) if self.times else Fraction(0)
        return (len(self.times) - 1) / span if span else None

    def peak(self) -> Peak | None:
        """The fullest window, the earliest of equals; None without planes. Rules: SYS-11."""
        return peak_window(self.times, self.bits)

    def as_json(self) -> dict[str, Any]:
        """All sums as a JSON object; its keys stand in docs/formats-model.md. Rules: CNF-25."""
        peak = self.peak()
        measured = self.measured_frame_rate
        return {
            "format": "snhc-stats",
            "version": 1,
            "kind": self.kind,
            "planes": len(self.times),
            "intra": sum(self.intra),
            "frames": self.frames,
            "skipped_frames": self.skipped_frames,
            "first_time": _text(min(self.times)) if self.times else None,
            "last_time": _text(max(self.times)) if self.times else None,
            "duration": _text(self.duration),
            "declared_frame_rates": [_text(rate) for rate in self.rates],
            "measured_frame_rate": None if measured is None else _text(measured),
            "bits": self.total_bits,
            "mean_bit_rate": float(self.mean_rate),
            "peak": None if peak is None else {"start": _text(peak.start), "bits": peak.bits, "planes": peak.planes},
            "coding": self.coding,
            "bits_per_part": {part: self.parts[part] for part in PARTS if part in self.parts},
            "masks": {str(group): dict(zip(MASK_TYPES, counts, strict=True)) for group, counts in self.masks.items()},
            "faps": {
                str(fap): {"frames": use.frames, "min": use.low, "max": use.high, "bits": round(use.bits, 1)}
                for fap, use in sorted(self.faps.items())
            },
        }


def _text(value: Fraction) -> str:
    return f"{value.numerator}/{value.denominator}"


def peak_window(times: Sequence[Fraction], bits: Sequence[int]) -> Peak | None:
    """Over every plane's time t, the largest sum of the planes in [t, t + 1 s). Rules: SYS-11."""
    order = sorted(range(len(times)), key=lambda n: times[n])
    best: Peak | None = None
    total = last = 0
    for first, n in enumerate(order):
        while last < len(order) and times[order[last]] < times[n] + 1:
            total += bits[order[last]]
            last += 1
        if best is None or total > best.bits:
            best = Peak(times[n], total, last - first)
        total -= bits[n]
    return best


class _Collector:
    def __init__(self, options: Options, keep: bool) -> None:
        self.stats = StreamStats()
        self._options = options
        self._keep = keep
        self._clock = Clock()
        self._behind = 0
        self.parts_waiting: dict[str, int] = {}

    def headers(self, trace: Trace) -> None:
        """What stands before a plane is its (SYS-11)."""
        for row in range(len(trace)):
            self._wait(PARTS[0], trace.end[row] - trace.start[row])

    def _wait(self, part: str, bits: int) -> None:
        self.parts_waiting[part] = self.parts_waiting.get(part, 0) + bits

    def passed(self, end: int) -> None:
        """Another object's plane ended here; what came before is not ours."""
        self._behind = end
        self.parts_waiting.clear()

    def plane(self, plane: AnyPlane, trace: Trace) -> None:
        stats = self.stats
        # What stands behind the end, such as stuffing, is the next plane's.
        inside = [row for row in range(len(trace)) if trace.start[row] < plane.end]
        for row in inside:
            self._row(trace, row)
        for part, bits in self.parts_waiting.items():
            stats.parts[part] = stats.parts.get(part, 0) + bits
        self.parts_waiting.clear()
        for row in range(len(inside), len(trace)):
            self._row(trace, row)
        if len(stats.times) >= self._options.limits.collected_planes:
            raise ResourceLimit(
                "CNF-22", "planes", value=len(stats.times) + 1,
                allowed=f"at most {self._options.limits.collected_planes}",
            )  # fmt: skip
        time = self._clock.tick(plane.header, self._options.readings.skipped_frames == "before")
        if not stats.rates or stats.rates[-1] != self._clock.rate:
            stats.rates.append(self._clock.rate)
        stats.period = 1 / self._clock.rate
        stats.skipped_frames += plane.header.number_of_frames_to_skip
        stats.times.append(Fraction(*(plane.frames[0].time if plane.frames else time)))
        stats.bits.append(plane.end - self._behind)
        self._behind = plane.end
        stats.intra.append(bool(plane.is_intra))
        stats.frames += len(plane.frames)
        if isinstance(plane, FbaPlane):
            self._face(plane)
        else:
            assert isinstance(plane, MeshPlane)

    def _row(self, trace: Trace, row: int) -> None:
        bits = trace.end[row] - trace.start[row]
        path = [name for name, _ in trace.steps(trace.path[row])]
        element = trace.el(row).name
        if len(path) < 2:
            self._wait(PARTS[len(path)], bits)
        elif path[1] == "bap":
            self._wait("BAP", bits)
        elif path[1] in ("geometry", "motion"):
            self._wait(f"mesh {path[1]}", bits)
        elif len(path) == 2:
            part = _SEGMENTS.get(element, PARTS[5] if element == "viseme_def" else "")
            self._wait(part or (PARTS[6] if element in ("init_face", "expression_def") else PARTS[2]), bits)
            if row in trace.segments:
                self._symbols(trace, row, element)
        elif path[2] == "group":
            self._wait(PARTS[3], bits)
        elif path[2] == "new_minmax":
            self._wait(PARTS[4], bits)
        elif path[2] == "instant":
            fap = 1 if element.startswith("viseme") else 2
            self._wait(PARTS[4 + fap], bits)
            self._use(fap).bits += bits
        else:
            self._wait(PARTS[8], bits)
            self._use(trace.steps(trace.path[row])[2][1]).bits += bits

    def _symbols(self, trace: Trace, row: int, element: str) -> None:
        segment, labels = trace.segments[row]
        for step, label in zip(segment.steps, labels, strict=True):
            match = _LABEL.match(label)
            fap = int(match[1]) if match else 1 if element == "viseme_segment" else 2
            self._use(fap).bits += log2(step.total / (step.cum_high - step.cum_low))

    def _use(self, fap: int) -> FapUse:
        return self.stats.faps.setdefault(fap, FapUse())

    def _face(self, plane: FbaPlane) -> None:
        stats = self.stats
        coding = "no FAP data"
        if plane.faps is not None:
            coding = "DCT" if plane.faps.segment is not None else "arithmetic"
            if plane.is_intra:
                for group in range(1, len(fap_groups()) + 1):
                    stats.masks.setdefault(group, [0] * len(MASK_TYPES))[plane.faps.mask_type[group - 1]] += 1
        stats.coding[coding] = stats.coding.get(coding, 0) + 1
        if plane.faps is None:
            return
        for frame in plane.frames:
            for place, letter in enumerate(frame.state):
                if letter == "T":
                    self._use(place + 1).take(frame.faps[place])
            if self._keep:
                stats.curves.append(frame)


def stream_stats(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
    keep_frames: bool = False,
) -> StreamStats:
    """The sums over the object `options.object_number`.

    Rules: SYS-11, SYS-12, FBA-10, FBA-38. `keep_frames`: keep the frames of a face for curves. Memory grows with the
    number of planes only. Raises what ends the stream; InconsistentSemantics where there is no such object.
    """
    collector = _Collector(options, keep_frames)
    number = -1
    current: StreamItem | None = None
    for part in trace_stream(source, options):
        if on_finding is not None:
            for finding in part.findings:
                on_finding(finding)
        if part.error is not None:
            raise part.error
        number, current = _take(collector, part, number, current, options.object_number)
    if number < options.object_number:
        raise InconsistentSemantics(
            "FBA-44", "objects in the stream", value=number + 1, allowed=f"{options.object_number + 1} or more"
        )
    return collector.stats


def _take(
    collector: _Collector, part: TracePart, number: int, current: StreamItem | None, wanted: int
) -> tuple[int, StreamItem | None]:
    item = part.item
    if item is not None and is_object(item) and item is not current:
        current = item
        number += 1
        if number == wanted:
            collector.stats.kind = "mesh" if item.mesh is not None else "fba"
    if number > wanted or (number == wanted and item is not current):
        return number, current
    if part.plane is None:
        collector.headers(part.trace)
    elif number == wanted:
        collector.plane(part.plane, part.trace)
    else:
        collector.passed(part.plane.end)
    return number, current


# -- for people --------------------------------------------------------------------------------------------------------


def summary(stats: StreamStats) -> str:
    """The sums as lines of text. Rules: SYS-11, SYS-12."""
    out = [f"kind             {stats.kind}"]
    intra = sum(stats.intra)
    out.append(f"planes           {len(stats.times)} ({intra} intra), {stats.frames} frames")
    if stats.skipped_frames:
        out.append(f"skipped          {stats.skipped_frames} frames")
    peak = stats.peak()
    if peak is not None:
        first = float(min(stats.times))
        out.append(
            f"time             {first:.3f} s to {float(max(stats.times)):.3f} s, duration {float(stats.duration):.3f} s"
        )
        rates = ", ".join(f"{float(rate):.6g}" for rate in stats.rates)
        measured = stats.measured_frame_rate
        out.append(
            f"frame rate       {rates} declared" + (f", {float(measured):.6g} planes/s measured" if measured else "")
        )
        out.append(f"bits             {stats.total_bits} ({stats.total_bits / len(stats.times):.1f} per plane)")
        out.append(
            f"bit rate         {float(stats.mean_rate) / 1000:.3f} kbit/s mean, {peak.bits / 1000:.3f} kbit/s peak "
            f"(from {float(peak.start):.3f} s, {peak.planes} planes)"
        )
    if stats.coding:
        out.append("coding           " + ", ".join(f"{count} {name}" for name, count in stats.coding.items()))
    out += _table(
        ("part", "bits", "share"),
        [
            (part, str(stats.parts[part]), f"{100 * stats.parts[part] / max(stats.total_bits, 1):.1f} %")
            for part in PARTS
            if part in stats.parts
        ],
    )
    used = [group for group, counts in stats.masks.items() if any(counts[1:])]
    names = {group.group: group.name for group in fap_groups()}
    out += _table(
        ("group", *MASK_TYPES),
        [(f"{group} {names[group]}", *map(str, stats.masks[group])) for group in used],
    )
    out += _table(
        ("FAP", "frames", "min", "max", "bits", "per frame"),
        [
            (
                f"{fap} {fap_table()[fap - 1].name}", str(use.frames), _or_dash(use.low), _or_dash(use.high),
                f"{use.bits:.0f}", f"{use.bits / use.frames:.2f}" if use.frames else "-",
            )
            for fap, use in sorted(stats.faps.items())
        ],
    )  # fmt: skip
    return "\n".join(out) + "\n"


def _or_dash(value: int | None) -> str:
    return "-" if value is None else str(value)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    if not rows:
        return []
    widths = [max(len(row[n]) for row in (head, *rows)) for n in range(len(head))]
    lines = [""]
    for row in (head, *rows):
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        lines.append("  ".join(cells).rstrip())
    return lines
