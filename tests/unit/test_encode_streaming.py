"""Encoding while reading: the same bytes as from a collected text, and memory that does not grow with it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from random import Random

import pytest

from snhc.reference_impl.bitstream.errors import EncodeError, InputFormat
from snhc.reference_impl.bitstream.sink import BitSink
from snhc.reference_impl.face.fap_text import FapReader, read_fap
from snhc.reference_impl.face.masks import with_masks
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.base import END
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.encoding import encode_fap, encode_text, stream_around
from snhc.reference_impl.systems.stream import write_pieces, write_stream


def text(frames: int, rng: Random) -> Iterator[bytes]:
    """Frames with gaps, masks that change now and then, and values that pass the default limits."""
    yield b"2.1 generated 25 %d\n" % frames
    number = 0
    chosen: list[int] = []
    for i in range(frames):
        if i == 0 or rng.random() < 0.05:
            chosen = sorted(rng.sample(range(3, 69), rng.randint(1, 20)))
        number += rng.choice((1, 1, 1, 2, 9))
        mask = " ".join("1" if fap in chosen else "0" for fap in range(1, 69))
        yield f"{mask}\n{number} {' '.join(str(rng.randint(-900, 900)) for _ in chosen)}\n".encode()


@pytest.mark.parametrize("mode", ["arithmetic", "dct"])
@pytest.mark.parametrize("masks", [None, frozenset({3, 14, 48})])
@pytest.mark.parametrize("seed", range(3))
def test_the_same_bytes(mode: str, masks: frozenset[int] | None, seed: int) -> None:
    data = b"".join(text(120, Random(seed)))
    faps = read_fap([data])
    whole = write_stream(encode_fap(faps if masks is None else with_masks(faps, masks), mode=mode, quant=3))
    pieces = list(encode_text(FapReader([data]), Writer(), masks=masks, mode=mode, quant=3))
    assert b"".join(pieces) == whole
    assert len(pieces) > 2


def test_pieces_come_before_the_text_ends() -> None:
    def broken() -> Iterator[bytes]:
        yield from text(200, Random(1))
        yield b"no mask\n"

    pieces = encode_text(FapReader(broken()), Writer())
    assert len([next(pieces) for _ in range(5)]) == 5
    with pytest.raises(InputFormat):
        list(pieces)


@pytest.mark.parametrize("count", [1, 4, 5, 6, 23, 24, 25, 40])
def test_runs_of_planes_without_data(count: int) -> None:
    """Planes of zero bits would read as a start code: the writer must still reach back to where the run began."""

    def planes() -> list[FbaPlane]:
        return [FbaPlane() for _ in range(count)]

    items = stream_around(iter(planes()))
    streamed = Writer()
    whole = Writer()
    others = stream_around(iter(planes()))
    assert b"".join(write_pieces(items, streamed)) == write_stream(others, whole)


def test_a_last_plane_of_zeros_is_refused_as_when_collected() -> None:
    for writes in (write_stream, lambda items, writer: b"".join(write_pieces(items, writer))):
        items = stream_around(iter([FbaPlane(), FbaPlane()]), end_code=False)
        assert items[-1].fba is not None
        items[-1].fba.end = END
        with pytest.raises(EncodeError, match="last plane"):
            writes(items, Writer())


def test_a_sink_keeps_what_may_still_change() -> None:
    sink = BitSink()
    sink.write(0xABCDEF, 24)
    sink.write(5, 3)
    assert sink.take(before=17) == b"\xab\xcd"
    assert sink.take(before=17) == b""
    assert sink.bits_from(16, 11) == 0xEF << 3 | 5
    sink.cut(20)
    sink.write(1, 4)
    assert (sink.tell(), sink.getvalue()) == (24, b"\xe1")


MEMORY = """
import resource, sys
from itertools import islice, cycle
from snhc.reference_impl.face.fap_text import FapReader
from snhc.reference_impl.syntax.base import END
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.encoding import encode_text
frames = int(sys.argv[1])
mask = " ".join("1" if 3 <= fap < 43 else "0" for fap in range(1, 69))
def text():
    yield b"2.1 long 25 %d\\n" % frames
    for i in range(frames):
        yield f"{mask}\\n{i} {' '.join(str(i * n % 90) for n in range(40))}\\n".encode()
size = sum(map(len, encode_text(FapReader(text()), Writer())))
print(size, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_memory_does_not_grow_with_the_text() -> None:
    def run(frames: int) -> tuple[int, int]:
        out = subprocess.run([sys.executable, "-c", MEMORY, str(frames)], capture_output=True, text=True, check=True)
        size, peak = map(int, out.stdout.split())
        return size, peak

    (small, before), (large, after) = run(300), run(6000)
    assert large > 15 * small
    # KiB: collected, 6,000 frames took 20 MiB more.
    assert after < before + 4096
