"""Writers of decoded frames: what whole streams of the other tests do not reach."""

from __future__ import annotations

import io

import numpy as np

from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.face.syntax import new_plane
from snhc.reference_impl.systems.output import FapFrames, NpzWriter


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
