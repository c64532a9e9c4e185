"""Writers of decoded frames: what whole streams of the other tests do not reach."""

from __future__ import annotations

import io
import pickle

import numpy as np
import pytest

from snhc.conformance.candidate import ndjson
from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.face.syntax import new_plane
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.systems.output import FapFrames, NpzWriter
from snhc.reference_impl.systems.stream import Options, decode_frames, write_stream
from snhc.vectors.builders import intra, stream
from snhc.vectors.decoding import decode_input


def plane_of(mask: int, *, skipped: int = 0, rate: int = 0, baps: dict[int, int] | None = None) -> FbaPlane:
    plane = new_plane(mask, 1)
    header = plane.header
    header.skip_frames, header.number_of_frames_to_skip = int(skipped > 0), skipped
    header.is_frame_rate, header.frame_rate = int(rate > 0), rate
    state = "UUT" + "U" * 65 if mask & 1 else "UUR" + "U" * 65
    faps = (None, None, 7, *[None] * 65)
    plane.frames = [FaceFrame(0, (0, 1), True, faps, None, None, state, None, None, None, baps)]
    return plane


def test_numbers_count_periods_from_the_first_frame_with_fap_data() -> None:
    frames = FapFrames()
    planes = [plane_of(0, skipped=3), plane_of(1, skipped=2), plane_of(0, skipped=1), plane_of(1)]
    # 0, then 2 skipped, 1 period without FAP data (number 3), 1 skipped: 5.
    assert [[text.number for text in frames.of(plane)] for plane in planes] == [[], [0], [], [5]]


def test_a_change_of_the_rate_is_noticed() -> None:
    frames = FapFrames()
    for plane in (plane_of(1, rate=25), plane_of(1), plane_of(1, rate=25)):
        list(frames.of(plane))
    assert (frames.rate, frames.rate_changes) == (25, False)
    list(frames.of(plane_of(1, rate=30)))
    assert (frames.rate, frames.rate_changes) == (25, True)


def test_npz_of_bodies() -> None:
    pieces: list[bytes] = []
    writer = NpzWriter(pieces.append)
    writer.begin("fba")
    writer.plane(plane_of(1))
    writer.plane(plane_of(2, baps={1: 5, 296: -3}))
    writer.end()
    with np.load(io.BytesIO(b"".join(pieces))) as arrays:
        assert arrays["baps"][1, 0] == 5
        assert arrays["baps"][1, 295] == -3
        assert np.argwhere(arrays["baps_set"]).tolist() == [[1, 0], [1, 295]]
        assert arrays["fap_quant"].tolist() == [-1, -1]


def test_a_time_that_an_archive_cannot_hold_is_an_error_and_what_was_before_it_is_whole() -> None:
    # Every new rate is a new prime in the denominator: 12 of them are more than 64 bits.
    primes = [rate for rate in range(200, 256) if all(rate % n for n in range(2, 16))]
    rates = [*primes, *(191, 193, 197, 199)]
    data = write_stream(stream(*(intra({3: 1}, rate=(rate, 0, 0)) for rate in rates)))
    frames = list(decode_frames(data))
    assert len(rates) == 12
    assert frames[-1].time[1] >= 1 << 63
    # What prints such times is judged as any other decoder.
    every = write_stream(stream(*(intra({3: 1}, rate=(rate, 0, 0)) for rate in range(1, 256))))
    decoded = decode_input("fba", every, None, Options())
    assert len(str(list(decode_frames(every))[-1].time[1])) > 31
    assert len(ndjson(decoded.text.encode())) == 255
    pieces: list[bytes] = []
    writer = NpzWriter(pieces.append)
    writer.begin("fba")
    with pytest.raises(EncodeError, match=r"npz: frame [0-9]+.*64 bits"):
        for frame in frames:
            writer.frame(frame)
    writer.end()
    with np.load(io.BytesIO(b"".join(pieces))) as arrays:
        kept = len(arrays["time"])
        assert 0 < kept < len(frames)
        assert [tuple(row) for row in arrays["time"].tolist()] == [frame.time for frame in frames[:kept]]
        assert len(arrays["faps"]) == len(arrays["state"]) == kept


def test_such_a_time_of_a_mesh_too() -> None:
    writer = NpzWriter(lambda piece: None)
    writer.begin("mesh")
    with pytest.raises(EncodeError, match="npz: frame 0"):
        writer.frame(MeshFrame(0, (1, 1 << 63), True, ((0, 0),), None, None))


def test_a_frame_is_a_value() -> None:
    """Frozen, without other attributes, equal by fields, and whole after a trip to another process."""
    frame = FaceFrame(3, (1, 25), True, (None,) * 68, (1, 2, 3, 0), None, "T" * 68, baps={1: 2})
    for name in ("index", "faps", "other"):
        with pytest.raises(AttributeError):
            setattr(frame, name, 4)
    assert not hasattr(frame, "__dict__")
    assert pickle.loads(pickle.dumps(frame)) == frame == frame._replace(index=3) != frame._replace(index=4)
    assert repr(frame).startswith("FaceFrame(index=3, time=(1, 25), intra=True, faps=(None, ")
