"""What the figures are measured on: generated, from fixed seeds, of any length."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from random import Random

from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.face.state import FaceState
from snhc.reference_impl.face.syntax import new_plane
from snhc.reference_impl.syntax.element import DEFAULT_READINGS
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.encoding import stream_around
from snhc.reference_impl.systems.stream import write_pieces

HOUR = 90_000
SPEECH_FAPS = (*range(3, 25), *range(31, 37), 41, 42, 48, 49, 50, *range(51, 58))


def speech_text(frames: int) -> Iterator[bytes]:
    """25 Hz, 40 FAPs (jaw, lips, lids, brows, cheeks, head): slow sines, and syllables that pause between phrases."""
    rng = Random(1)
    waves = [
        (rng.uniform(20, 200), rng.uniform(0.05, 0.3), rng.uniform(2, 6), rng.uniform(0, 6), rng.uniform(5, 60))
        for _ in SPEECH_FAPS
    ]
    mask = " ".join("1" if fap in SPEECH_FAPS else "0" for fap in range(1, 69))
    yield f"2.1 speech 25 {frames}\n".encode()
    for number in range(frames):
        t = number / 25
        gate = max(0.0, math.sin(t * 0.4))
        values = [
            int(slow * math.sin(6.28 * f * t + phase) + gate * fast * math.sin(6.28 * syllables * t + phase))
            for slow, f, syllables, phase, fast in waves
        ]
        yield f"{mask}\n{number} {' '.join(map(str, values))}\n".encode()


def wide_planes(size: int) -> Iterator[FbaPlane]:
    """Intra planes of all 66 FAPs with levels anywhere in their default ranges, until `size` bytes are full.

    About 100 bytes a plane: the streams of which a decoder has least to do per byte.
    """
    rng = Random(2)
    state = FaceState(DEFAULT_READINGS)
    first = new_plane(1, 1)
    data = first.faps
    assert data is not None
    data.quant = 1
    data.mask_type = [0] + [3] * 9
    state.select_faps(data)
    state.faps.set_ranges(data, DEFAULT_READINGS)
    models = state.faps.i_models
    # Drawing 57 million numbers would take longer than decoding them.
    drawn = [[rng.randrange(model.lo, model.lo + model.n) for model in models] for _ in range(500)]
    bits = sum(math.log2(model.n) for model in models) + 60
    for i in range(int(size * 8 / bits) + 1):
        plane = new_plane(1, 1)
        assert plane.faps is not None
        plane.faps.quant = 1
        plane.faps.mask_type = data.mask_type
        plane.faps.limits = []
        plane.faps.levels = drawn[i % len(drawn)]
        yield plane


def write_wide(path: Path, size: int) -> None:
    """A file of about `size` bytes of `wide_planes`."""
    with path.open("wb") as file:
        file.writelines(write_pieces(stream_around(wide_planes(size)), Writer()))


def write_speech(path: Path, frames: int) -> None:
    """A `.fap` file."""
    with path.open("wb") as file:
        file.writelines(speech_text(frames))


def write_companions(path: Path, frames: int) -> None:
    """`.epf` and `.bap` files beside a `.fap` file of `write_speech`: every frame named, two BAPs in each."""
    mask = " ".join("1" if bap in (1, 50) else "0" for bap in range(1, 187))
    with path.with_suffix(".epf").open("w") as blocks, path.with_suffix(".bap").open("w") as bodies:
        bodies.write(f"2.1 speech 25 {frames}\n")
        for number in range(frames):
            bodies.write(f"{mask}\n{number} {number % 90} {number % 50}\n")
            blocks.write(f"FBM 3\nFFR {number}\nBFR {number}\n" + ("ISI 1\n" if number % 25 == 0 else ""))
