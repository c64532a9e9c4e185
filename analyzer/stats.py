"""What a stream costs and holds: planes, times, bit rates, bits per part and per FAP, masks, ranges of values.

Rules: SYS-11, SYS-12, FBA-10, FBA-18, FBA-38, CNF-21.

A plane's bits run from the end of the plane before it to its own end (SYS-11). Bits of one FAP inside an arithmetic
segment are what its symbols cost in their models, log2(total / width of the bin): their sum is the segment but for
its end and guards. The codewords of a DCT segment are counted as they are.

Planes are summed as they come, and none is kept. Where a time code goes back, the windows of one second need all
planes: then the stream is read twice (`windows`).
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import log2
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.syntax.element import STEPS
from snhc.reference_impl.syntax.temporal import Clock
from snhc.reference_impl.syntax.tracer import ROOT, Trace
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, TracePart, is_object, trace_stream
from snhc.reference_impl.systems.visual import AnyPlane, StreamItem
from snhc.reference_impl.tables import fap_groups, fap_table

from .windows import Peak, RunningPeak, check_collected, collected_peaks, time_of

FAPS: Final = 68
PARTS: Final = (
    "headers", "plane header", "FAP header", "masks", "ranges", "FAP 1 (viseme)", "FAP 2 (expression)",
    "FAP values (arithmetic)", "FAP values (DCT)", "BAP", "mesh geometry", "mesh motion",
)  # fmt: skip
MASK_TYPES: Final = ("none", "mask, others keep", "mask, others interpolated", "all")
_ELEMENTS: Final = {
    "viseme_segment": PARTS[5], "viseme_def": PARTS[5],
    "expression_segment": PARTS[6], "init_face": PARTS[6], "expression_def": PARTS[6],
    "fap_segment": PARTS[7],
}  # fmt: skip
_LABEL: Final = re.compile(r"FAP (\d+)\b")
# Selections of FAPs: a hostile stream has another one in each intra plane.
_KEPT: Final = 1000
# What the rows of a path are counted as, and the FAP whose bits they are; else the element decides.
_BY_ELEMENT: Final = ""
_INSTANT: Final = "instant"
_SECOND_STEP: Final = {"bap": PARTS[9], "geometry": PARTS[10], "motion": PARTS[11]}
_THIRD_STEP: Final = {"group": (PARTS[3], 0), "new_minmax": (PARTS[4], 0), "instant": (_INSTANT, 0)}


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
            if self.low is None or value < self.low:
                self.low = value
            if self.high is None or value > self.high:
                self.high = value


@dataclass(slots=True)
class Curves:
    """What there is to draw. Rules: SYS-11. `times`, `bits`, `intra`: one entry per plane. `frames`: of a face."""

    times: list[Fraction] = field(default_factory=list)
    bits: list[int] = field(default_factory=list)
    intra: list[bool] = field(default_factory=list)
    frames: list[FaceFrame] = field(default_factory=list)


@dataclass(slots=True)
class StreamStats:
    """The sums over one object.

    Rules: SYS-11, SYS-12, FBA-10, FBA-38.

    `first`, `last`: the earliest and the latest time of a plane, None without planes. `total_bits`: of all planes.
    `peak`: the fullest window. `rates`: declared frames per second, in the order in which they come. `period`: the
    last one's. `parts`: bits per part of PARTS. `masks`: per FAP group (1..10) how many intra planes have each mask
    type. `faps`: per FAP number. `curves`: empty but where they were asked for.
    """

    kind: str = ""
    planes: int = 0
    intra: int = 0
    first: Fraction | None = None
    last: Fraction | None = None
    total_bits: int = 0
    peak: Peak | None = None
    frames: int = 0
    skipped_frames: int = 0
    rates: list[Fraction] = field(default_factory=list)
    period: Fraction = Fraction(1, 30)
    coding: dict[str, int] = field(default_factory=dict)
    parts: dict[str, int] = field(default_factory=dict)
    masks: dict[int, list[int]] = field(default_factory=dict)
    faps: dict[int, FapUse] = field(default_factory=dict)
    curves: Curves = field(default_factory=Curves)

    @property
    def span(self) -> Fraction:
        """Last time - first time, seconds. Rules: SYS-11."""
        return Fraction(0) if self.first is None or self.last is None else self.last - self.first

    @property
    def duration(self) -> Fraction:
        """Last time - first time + one period, seconds. Rules: SYS-11."""
        return self.span + self.period if self.planes else Fraction(0)

    @property
    def mean_rate(self) -> Fraction:
        """Bits per second over the whole. Rules: SYS-11."""
        return self.total_bits / self.duration if self.duration else Fraction(0)

    @property
    def measured_frame_rate(self) -> Fraction | None:
        """(n - 1) / (last time - first time); None for less than two planes. Rules: SYS-12."""
        return (self.planes - 1) / self.span if self.span else None

    def as_json(self) -> dict[str, Any]:
        """All sums as a JSON object; its keys stand in docs/formats-model.md. Rules: CNF-25."""
        peak = self.peak
        measured = self.measured_frame_rate
        return {
            "format": "snhc-stats",
            "version": 1,
            "kind": self.kind,
            "planes": self.planes,
            "intra": self.intra,
            "frames": self.frames,
            "skipped_frames": self.skipped_frames,
            "first_time": None if self.first is None else _text(self.first),
            "last_time": None if self.last is None else _text(self.last),
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


class _Collector:
    def __init__(self, options: Options, keep: bool) -> None:
        self.stats = StreamStats()
        self.running = RunningPeak()
        self._options = options
        self._keep = keep
        self._clock = Clock()
        self._behind = 0
        self._rates: dict[Fraction, Fraction] = {}
        self._uses: dict[tuple[str, ...], list[FapUse]] = {}
        self._states: dict[str, list[tuple[int, FapUse]]] = {}
        self._waiting: dict[str, int] = {}

    def headers(self, trace: Trace) -> None:
        """What stands before a plane is its (SYS-11)."""
        for row in range(len(trace)):
            self._wait(PARTS[0], trace.end[row] - trace.start[row])

    def _wait(self, part: str, bits: int) -> None:
        self._waiting[part] = self._waiting.get(part, 0) + bits

    def passed(self, end: int) -> None:
        """Another object's plane ended here; what came before is not ours."""
        self._behind = end
        self._waiting.clear()

    def plane(self, plane: AnyPlane, trace: Trace) -> None:
        stats = self.stats
        paths = _paths(trace)
        # What stands behind the end, such as stuffing, is the next plane's.
        inside = bisect_left(trace.start, plane.end)
        for row in range(inside):
            self._row(trace, row, paths)
        for part, bits in self._waiting.items():
            stats.parts[part] = stats.parts.get(part, 0) + bits
        self._waiting.clear()
        for row in range(inside, len(trace)):
            self._row(trace, row, paths)
        size = plane.end - self._behind
        self._behind = plane.end
        time = time_of(plane)
        if stats.first is None or stats.last is None:
            stats.first = stats.last = time
        elif time > stats.last:
            stats.last = time
        elif time < stats.first:
            stats.first = time
        self.running.add(time, size)
        self._rate(plane)
        stats.planes += 1
        stats.intra += bool(plane.is_intra)
        stats.total_bits += size
        stats.skipped_frames += plane.header.number_of_frames_to_skip
        stats.frames += len(plane.frames)
        if self._keep:
            check_collected(len(stats.curves.times), self._options.limits)
            stats.curves.times.append(time)
            stats.curves.bits.append(size)
            stats.curves.intra.append(bool(plane.is_intra))
        if isinstance(plane, FbaPlane):
            self._face(plane)
        else:
            assert isinstance(plane, MeshPlane)

    def _rate(self, plane: AnyPlane) -> None:
        stats = self.stats
        if stats.rates and not plane.header.is_frame_rate:
            return
        self._clock.tick(plane.header, False)
        rate = self._rates.setdefault(self._clock.rate, self._clock.rate)
        if not stats.rates or stats.rates[-1] != rate:
            check_collected(len(stats.rates), self._options.limits)
            stats.rates.append(rate)
            stats.period = 1 / rate

    def _row(self, trace: Trace, row: int, paths: Sequence[tuple[str, int]]) -> None:
        bits = trace.end[row] - trace.start[row]
        path = trace.path[row]
        part, fap = (PARTS[0], 0) if path == ROOT else paths[path]
        if part == _BY_ELEMENT:
            element = trace.el(row).name
            part = _ELEMENTS.get(element, PARTS[2])
            if row in trace.segments:
                self._symbols(trace, row, element)
        elif part == _INSTANT:
            fap = 1 if trace.el(row).name.startswith("viseme") else 2
            part = PARTS[4 + fap]
        if fap:
            self._use(fap).bits += bits
        self._waiting[part] = self._waiting.get(part, 0) + bits

    def _symbols(self, trace: Trace, row: int, element: str) -> None:
        segment, labels = trace.segments[row]
        key = (element, *labels)
        uses = self._uses.get(key)
        if uses is None:
            if len(self._uses) >= _KEPT:
                self._uses.clear()
            uses = self._uses[key] = [self._use(_fap_of(label, element)) for label in labels]
        for use, width, total in zip(uses, segment.widths, segment.totals, strict=True):
            use.bits += log2(total / width)

    def _sent(self, state: str) -> list[tuple[int, FapUse]]:
        sent = self._states.get(state)
        if sent is None:
            if len(self._states) >= _KEPT:
                self._states.clear()
            sent = self._states[state] = [(n, self._use(n + 1)) for n, letter in enumerate(state) if letter == "T"]
        return sent

    def _use(self, fap: int) -> FapUse:
        use = self.stats.faps.get(fap)
        if use is None:
            use = self.stats.faps[fap] = FapUse()
        return use

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
            for place, use in self._sent(frame.state):
                use.take(frame.faps[place])
            if self._keep:
                stats.curves.frames.append(frame)


def _paths(trace: Trace) -> list[tuple[str, int]]:
    """Per path of a plane's trace: what its rows are counted as, and the FAP whose codewords they are (0: none)."""
    kinds: list[tuple[str, int]] = []
    depths: list[int] = []
    for parent, step, index in trace.paths:
        depth = 1 if parent == ROOT else depths[parent] + 1
        above = PARTS[1] if parent == ROOT else kinds[parent][0]
        name = STEPS[step].name
        if depth == 1:
            kind = (PARTS[1], 0)
        elif depth == 2:
            kind = (_SECOND_STEP.get(name, _BY_ELEMENT), 0)
        elif depth == 3 and above == _BY_ELEMENT:
            kind = _THIRD_STEP.get(name, (PARTS[8], index))
        else:
            kind = kinds[parent]
        depths.append(depth)
        kinds.append(kind)
    return kinds


def _fap_of(label: str, element: str) -> int:
    match = _LABEL.match(label)
    return int(match[1]) if match else 1 if element == "viseme_segment" else 2


def stream_stats(
    source: Source | bytes,
    options: Options = DEFAULT_OPTIONS,
    on_finding: Callable[[Finding], None] | None = None,
    keep_frames: bool = False,
) -> StreamStats:
    """The sums over the object `options.object_number`.

    Rules: SYS-11, SYS-12, FBA-10, FBA-38. `keep_frames`: keep `curves`, up to
    `collected_planes`. Memory does not grow with the stream otherwise, but where the time goes back: then times and
    sizes are kept, in a second reading. Raises what ends the stream; InconsistentSemantics where there is no such
    object.
    """
    collector = _Collector(options, keep_frames)
    number = -1
    current: StreamItem | None = None
    for part in trace_stream(source, options, symbols=False, shares=True):
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
    stats = collector.stats
    stats.peak = collector.running.peak()
    if not collector.running.ordered:
        stats.peak, _ = collected_peaks(source, options, {options.object_number})
    return stats


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
    out.append(f"planes           {stats.planes} ({stats.intra} intra), {stats.frames} frames")
    if stats.skipped_frames:
        out.append(f"skipped          {stats.skipped_frames} frames")
    peak = stats.peak
    if peak is not None and stats.first is not None and stats.last is not None:
        first, last = float(stats.first), float(stats.last)
        out.append(f"time             {first:.3f} s to {last:.3f} s, duration {float(stats.duration):.3f} s")
        rates = ", ".join(f"{float(rate):.6g}" for rate in stats.rates)
        measured = stats.measured_frame_rate
        out.append(
            f"frame rate       {rates} declared" + (f", {float(measured):.6g} planes/s measured" if measured else "")
        )
        out.append(f"bits             {stats.total_bits} ({stats.total_bits / stats.planes:.1f} per plane)")
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
