"""Rates of one form, as JSON lines: `python measures.py`. `figures.py` runs this once per form.

Every figure is the smallest processor time of several runs: on a shared machine the time that other programs take is
none of ours. `calibration` is a loop of plain Python that is run beside each figure; the ratio of the two is what is
compared from one machine, or one day, to another.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

from test_bench_dct import stream_of_segments
from test_bench_fba import FAPS, SEGMENTS, segment, small_residuals
from test_bench_mesh import _stream as mesh_stream
from workloads import speech_text

from snhc.reference_impl.bitstream.cursor import BitCursor
from snhc.reference_impl.bitstream.sink import BitSink
from snhc.reference_impl.entropy.kernel import decode_segment, encode_segment
from snhc.reference_impl.entropy.literal import decode_literally
from snhc.reference_impl.entropy.model import Model
from snhc.reference_impl.face.fap_text import FapReader
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.encoding import encode_text
from snhc.reference_impl.systems.stream import decode_planes, read_stream, trace_stream, write_stream

RUNS = 5
SPEECH = 5_000

Measure = Callable[[], tuple[int, Callable[[], object]]]


def calibrate() -> float:
    """Seconds of a loop of plain Python, which no form of the codec changes."""
    start = time.process_time()
    total = 0
    table = list(range(256))
    for i in range(200_000):
        total = (total * 31 + table[i & 255]) & 0xFFFFFF
    assert total
    return time.process_time() - start


def _models(n: int) -> list[Model]:
    lo, hi = -(n // 2), n - 1 - n // 2
    return [Model(lo, hi, True) for _ in range(FAPS)]


def _symbols(n: int, style: str, decode: Callable[[BitCursor, list[Model]], object]) -> Measure:
    def measure() -> tuple[int, Callable[[], object]]:
        data = segment(n, style)

        def run() -> None:
            models = _models(n)
            cursor = BitCursor.of(data)
            for _ in range(SEGMENTS):
                decode(cursor, models)

        return SEGMENTS * FAPS, run

    return measure


def _encoded(n: int, style: str) -> Measure:
    def measure() -> tuple[int, Callable[[], object]]:
        cursor = BitCursor.of(segment(n, style))
        models = _models(n)
        levels = [decode_segment(cursor, models)[0] for _ in range(SEGMENTS)]

        def run() -> None:
            fresh = _models(n)
            sink = BitSink()
            for row in levels:
                encode_segment(sink, fresh, row)

        return SEGMENTS * FAPS, run

    return measure


def _made(n: int) -> Measure:
    def measure() -> tuple[int, Callable[[], object]]:
        def run() -> None:
            for _ in range(20):
                for model in _models(n):
                    model.rebuild()

        return 20 * FAPS, run

    return measure


@cache
def speech() -> bytes:
    return b"".join(encode_text(FapReader(speech_text(SPEECH)), Writer()))


def _planes() -> tuple[int, Callable[[], object]]:
    return SPEECH, lambda: sum(1 for _ in decode_planes(speech()))


def _encode_text() -> tuple[int, Callable[[], object]]:
    text = list(speech_text(SPEECH))
    return SPEECH, lambda: sum(map(len, encode_text(FapReader(text), Writer())))


def _dct() -> tuple[int, Callable[[], object]]:
    data, count = stream_of_segments(20_000)
    return count, lambda: sum(1 for _ in decode_planes(data))


def _dct_values() -> tuple[int, Callable[[], object]]:
    data, _ = stream_of_segments(20_000)
    planes = list(decode_planes(data))
    return sum(len(plane.frames) * 66 for plane in planes), lambda: sum(1 for _ in decode_planes(data))


def _traced(data: bytes, symbols: bool) -> tuple[int, Callable[[], object]]:
    elements = sum(len(part.trace) for part in trace_stream(data, symbols=symbols))
    return elements, lambda: sum(len(part.trace) for part in trace_stream(data, symbols=symbols))


def _headers() -> tuple[int, Callable[[], object]]:
    from random import Random

    from strategies import Planes
    from test_bench_fba import _stream

    make = Planes(Random(1))
    planes = [make.plane(intra=True, mask=1, density=0.1, lists=15, style="zero") for _ in range(1000)]
    return _traced(_stream(planes), False)


def _literal_trace() -> tuple[int, Callable[[], object]]:
    data = small_residuals()
    return 300 * FAPS, lambda: sum(len(part.trace) for part in trace_stream(data))


def _motion() -> tuple[int, Callable[[], object]]:
    data = mesh_stream("uniform", 1000, 20)
    return 20 * 961, lambda: sum(len(plane.frames) for plane in decode_planes(data))


def _rewrite() -> tuple[int, Callable[[], object]]:
    items = read_stream(small_residuals())
    return 300 * FAPS, lambda: write_stream(items)


MEASURES: dict[str, tuple[str, Measure]] = {
    "decode, 361 symbols, small residuals": ("symbols", _symbols(361, "small", decode_segment)),
    "decode, 361 symbols, uniform": ("symbols", _symbols(361, "uniform", decode_segment)),
    "decode, 3,721 symbols, small residuals": ("symbols", _symbols(3721, "small", decode_segment)),
    "decode, 3,721 symbols, uniform": ("symbols", _symbols(3721, "uniform", decode_segment)),
    "models made, 361 symbols": ("models", _made(361)),
    "models made, 3,721 symbols": ("models", _made(3721)),
    "decode literally, 361 symbols": ("symbols", _symbols(361, "small", decode_literally)),
    "encode, 361 symbols, small residuals": ("symbols", _encoded(361, "small")),
    "encode, 3,721 symbols, uniform": ("symbols", _encoded(3721, "uniform")),
    "speech, 40 FAPs: bits to frames": ("frames", _planes),
    "speech, 40 FAPs: text to bits": ("frames", _encode_text),
    "DCT: bits to frames": ("coefficients sent", _dct),
    "DCT: bits to frames, by values": ("values", _dct_values),
    "trace of headers": ("elements", _headers),
    "trace with every symbol": ("symbols", _literal_trace),
    "mesh motion: bits to frames": ("nodes", _motion),
    "records to bits": ("symbols", _rewrite),
}


def main() -> None:
    for name, (unit, measure) in MEASURES.items():
        count, run = measure()
        seconds = calibration = float("inf")
        for _ in range(RUNS):
            calibration = min(calibration, calibrate())
            start = time.process_time()
            run()
            seconds = min(seconds, time.process_time() - start)
        line = {"name": name, "unit": unit, "rate": count / seconds, "calibration": calibration}
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
