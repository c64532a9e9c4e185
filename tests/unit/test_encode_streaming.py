"""Encoding while reading: the same bytes as from a collected text, and memory that does not grow with it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from random import Random

import pytest

from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics, InputFormat
from snhc.reference_impl.bitstream.sink import BitSink
from snhc.reference_impl.face.bap_text import BapReader, read_bap
from snhc.reference_impl.face.epf_text import EpfReader, read_epf
from snhc.reference_impl.face.fap_text import FapReader, read_fap
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.masks import with_masks
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.base import END, STUFFED_CODE
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.encoding import encode_fap, encode_text, stream_around
from snhc.reference_impl.systems.stream import decode_frames, write_pieces, write_stream


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
    data = b"".join(text(400, Random(seed)))
    faps = read_fap([data])
    whole = write_stream(encode_fap(faps if masks is None else with_masks(faps, masks), mode=mode, quant=3))
    pieces = list(encode_text(FapReader([data]), Writer(), masks=masks, mode=mode, quant=3))
    assert b"".join(pieces) == whole
    assert len(pieces) > 2


def companions(frames: int, rng: Random) -> tuple[bytes, bytes, bytes]:
    """`.fap`, `.epf` and `.bap` texts of the same frames, not all of which are coded or have a body."""
    faps, blocks, bodies = [b"2.1 generated 25 %d\n" % frames], [], [b"2.1 generated 25 %d\n" % frames]
    mask = " ".join("1" if fap in (3, 17, 48) else "0" for fap in range(1, 69))
    body_mask = " ".join("1" if bap in (1, 50) else "0" for bap in range(1, 187))
    number = 0
    for i in range(frames):
        values = " ".join(str(rng.randint(-900, 900)) for _ in range(3))
        faps.append(f"{mask}\n{number} {values}\n".encode())
        body = i == 0 or rng.random() < 0.5
        if body:
            bodies.append(f"{body_mask}\n{number} {rng.randint(-99, 99)} {rng.randint(-99, 99)}\n".encode())
        if i == 0 or rng.random() < 0.8:
            tags = [f"FBM {3 if body else 1}", f"FFR {number}"] + [f"BFR {number}"] * body
            if i % 9 == 0:
                tags += ["ISI 1", f"FQU {rng.randint(0, 9)}", f"CDM {rng.randint(0, 1)}"]
            blocks.append("\n".join(tags) + "\n")
        number += rng.choice((1, 1, 3))
    return b"".join(faps), "".join(blocks).encode(), b"".join(bodies)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("with_epf", [True, False])
def test_the_same_bytes_with_companions(with_epf: bool, seed: int) -> None:
    faps, epf, baps = companions(80, Random(seed))
    whole = write_stream(
        encode_fap(read_fap([faps]), epf=read_epf([epf]) if with_epf else None, baps=read_bap([baps]), bap_quant=2)
    )
    pieces = encode_text(
        FapReader([faps]), Writer(), epf=EpfReader([epf]) if with_epf else None, baps=BapReader([baps]), bap_quant=2
    )
    assert b"".join(pieces) == whole
    frames = [frame for frame in decode_frames(whole) if isinstance(frame, FaceFrame)]
    assert sum(frame.baps is not None for frame in frames) > 5


def test_companions_are_read_in_step() -> None:
    """Pieces come before any text ends; what is wrong at an end that nobody refers to is found, all the same."""
    texts = companions(200, Random(1))
    for broken in range(3):
        # The last line of each, a mask of no use.
        faps, epf, baps = ([text, b"0 0 x\n"] if n == broken else [text] for n, text in enumerate(texts))
        pieces = encode_text(FapReader(faps), Writer(), epf=EpfReader(epf), baps=BapReader(baps))
        assert len([next(pieces) for _ in range(5)]) == 5
        with pytest.raises(InputFormat):
            list(pieces)


def test_the_numbers_of_all_blocks_ascend() -> None:
    faps, _, _ = companions(3, Random(2))
    epf = b"FBM 1\nFFR 1\nFBM 1\n"
    with pytest.raises(InconsistentSemantics, match=r"FFR \(the number of the block\)=1 at line 3.*above 1"):
        list(encode_text(FapReader([faps.replace(b"\n3 ", b"\n1 ")]), Writer(), epf=EpfReader([epf])))


def test_a_body_without_a_face_is_refused_where_it_stands() -> None:
    faps, _, _ = companions(4, Random(2))
    mask = " ".join("1" if bap == 1 else "0" for bap in range(1, 187))
    for number in (2, 99):
        baps = f"2.1 x 25 1\n{mask}\n{number} 5\n".encode()
        numbers = [int(line.split()[0]) for line in faps.splitlines()[2::2]]
        assert number not in numbers
        with pytest.raises(InconsistentSemantics, match=f"frame number={number} at line 2"):
            list(encode_text(FapReader([faps]), Writer(), baps=BapReader([baps])))


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
from snhc.reference_impl.face.bap_text import BapReader, read_bap
from snhc.reference_impl.face.epf_text import EpfReader, read_epf
from snhc.reference_impl.face.fap_text import FapReader
from snhc.reference_impl.syntax.base import END, STUFFED_CODE
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


def test_what_is_final_when_an_error_comes_is_handed_on() -> None:
    """All but the last plane, though it is less than what is handed on at once (CNF-22)."""

    def planes() -> Iterator[FbaPlane]:
        for _ in range(30):
            plane = FbaPlane()
            plane.boundary = STUFFED_CODE
            plane.start_code = 0x1BB
            yield plane
        raise RuntimeError

    writer = Writer()
    pieces = write_pieces(stream_around(planes()), writer)
    got = [next(pieces)]
    with pytest.raises(RuntimeError):
        got.extend(pieces)
    assert b"".join(got).count(b"\x01\xbb") >= 29
