"""What the arithmetic path costs: decode, trace, write. Run with `--benchmark-only`; nothing here is a timed test.

`extra_info` names what one round did: symbols, elements or bytes; divide by the time for rates.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from random import Random
from time import process_time
from typing import Any

import pytest
from strategies import FAP_GROUPS, Planes, written

from snhc.reference_impl.bitstream.cursor import BitCursor
from snhc.reference_impl.bitstream.sink import BitSink
from snhc.reference_impl.entropy.kernel import decode_segment, encode_segment
from snhc.reference_impl.entropy.literal import decode_literally
from snhc.reference_impl.entropy.model import Model
from snhc.reference_impl.face.records import FbaObject, FbaPlane
from snhc.reference_impl.systems.stream import decode_frames, read_stream, trace_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem

Benchmark = Any
FAPS = 66
PLANES = 300
SEGMENTS = 200


def _stream(planes: list[FbaPlane]) -> bytes:
    item = StreamItem(0x1BA)
    item.fba = FbaObject()
    item.fba.planes = planes
    return written([item, StreamItem(0x1B1)], False)


@cache
def small_residuals(planes: int = PLANES) -> bytes:
    """All 66 FAPs with 361 symbols each (limits +-180), residuals that cluster around 0 like real motion."""
    rng = Random(1)
    make = Planes(rng)
    intra = make.plane(intra=True, mask=1, density=0.0, lists=15)
    data = intra.faps
    assert data is not None
    data.mask_type = [0] + [3] * 9
    for limits in data.limits:
        for group in FAP_GROUPS[1:]:
            for number in group:
                limits[number] = 3
    data.levels = [0] * FAPS
    out = [intra]
    for _ in range(planes - 1):
        plane = make.plane(intra=False, mask=1)
        assert plane.faps is not None
        plane.faps.levels = [max(-180, min(180, round(rng.gauss(0, 3)))) for _ in range(FAPS)]
        out.append(plane)
    return _stream(out)


@cache
def segment(n: int, style: str) -> bytes:
    """One run of segments over 66 P models of n symbols."""
    rng = Random(n)
    lo, hi = -(n // 2), n - 1 - n // 2
    models = [Model(lo, hi, True) for _ in range(FAPS)]
    sink = BitSink()
    for _ in range(SEGMENTS):
        if style == "uniform":
            levels = [rng.randint(lo, hi) for _ in range(FAPS)]
        else:
            levels = [max(lo, min(hi, round(rng.gauss(0, 3)))) for _ in range(FAPS)]
        encode_segment(sink, models, levels)
    return sink.getvalue()


def _decode(data: bytes, n: int, decoder: Callable[[BitCursor, list[Model]], object]) -> None:
    lo, hi = -(n // 2), n - 1 - n // 2
    models = [Model(lo, hi, True) for _ in range(FAPS)]
    cursor = BitCursor.of(data)
    for _ in range(SEGMENTS):
        decoder(cursor, models)


@pytest.mark.parametrize(("n", "style"), [(361, "small"), (361, "uniform"), (3721, "small"), (3721, "uniform")])
def test_kernel(benchmark: Benchmark, n: int, style: str) -> None:
    data = segment(n, style)
    benchmark.extra_info["symbols"] = SEGMENTS * FAPS
    benchmark(_decode, data, n, decode_segment)


def test_literal_coder(benchmark: Benchmark) -> None:
    data = segment(361, "small")
    benchmark.extra_info["symbols"] = SEGMENTS * FAPS
    benchmark(_decode, data, 361, decode_literally)


@pytest.mark.parametrize("planes", [PLANES, 3 * PLANES, 10 * PLANES])
def test_decode_frames(benchmark: Benchmark, planes: int) -> None:
    """The same rate at every length: cost is linear."""
    data = small_residuals(planes)
    benchmark.extra_info["symbols"] = planes * FAPS
    benchmark.extra_info["bytes"] = len(data)
    benchmark(lambda: sum(1 for _ in decode_frames(data)))


def test_trace(benchmark: Benchmark) -> None:
    data = small_residuals()
    elements = sum(len(part.trace) for part in trace_stream(data))
    benchmark.extra_info["elements"] = elements
    benchmark.extra_info["symbols"] = PLANES * FAPS
    benchmark(lambda: sum(len(part.trace) for part in trace_stream(data)))


def test_trace_a_million_elements(benchmark: Benchmark) -> None:
    """Fields and levels into columns, no symbol shown: at most 5 s, also interpreted."""
    data = small_residuals(15_000)

    seconds: list[float] = []

    def run() -> int:
        began = process_time()
        count = sum(
            len(part.trace) + sum(len(segment.levels) for segment, _ in part.trace.segments.values())
            for part in trace_stream(data, symbols=False)
        )
        seconds.append(process_time() - began)
        return count

    elements = benchmark.pedantic(run, rounds=3)
    benchmark.extra_info["elements"] = elements
    assert elements > 1_000_000
    # Of the processor, not of the clock: others may be at work.
    assert min(seconds) < 5


def test_trace_of_headers(benchmark: Benchmark) -> None:
    """Intra planes of masks and range lists, with hardly a symbol."""
    make = Planes(Random(1))
    data = _stream([make.plane(intra=True, mask=1, density=0.1, lists=15, style="zero") for _ in range(PLANES)])
    benchmark.extra_info["elements"] = sum(len(part.trace) for part in trace_stream(data))
    benchmark(lambda: sum(len(part.trace) for part in trace_stream(data)))


def test_write(benchmark: Benchmark) -> None:
    items = read_stream(small_residuals())
    benchmark.extra_info["symbols"] = PLANES * FAPS
    benchmark(write_stream, items)
