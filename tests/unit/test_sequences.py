"""Sequences from a seed, and the rate-distortion experiment on them (CNF-4)."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from math import log10
from pathlib import Path

import pytest

from snhc.reference_impl.face.fap_text import FapFile, read_fap, write_fap
from snhc.vectors.rate_distortion import FRAMES, HEADER, Point, measure, psnr, savings
from snhc.vectors.sequences import expressions, speech

COMMITTED = Path(__file__).parents[2] / "docs" / "experiments" / "rate_distortion.csv"


def text(file: FapFile) -> bytes:
    return b"".join(write_fap(file))


@pytest.mark.parametrize(
    ("make", "digest"),
    [
        (speech, "abc8905f4c67f195fff94e04ae83153818b610588add453256f3cbb6f7b79495"),
        (expressions, "4e66c5deed0a0094ea7391c42b6b18edde763298e61b99e7f732d738f11c5216"),
    ],
)
def test_the_same_on_every_platform(make: Callable[..., FapFile], digest: str) -> None:
    """CNF-4: pinned for ever; vectors are made of these."""
    assert sha256(text(make(300, 7))).hexdigest() == digest
    assert text(make(100, 7))[:200] != text(make(100, 8))[:200]


@pytest.mark.parametrize("make", [speech, expressions])
def test_a_sequence_is_a_fap_text(make: Callable[..., FapFile]) -> None:
    file = make(40, 3, rate=25, noise=0)
    assert read_fap([text(file)]) == file


def test_a_shorter_sequence_is_the_beginning_of_a_longer_one() -> None:
    # But for the noise, which is drawn last.
    assert speech(50, 2, noise=0).frames == speech(90, 2, noise=0).frames[:50]


def test_speech_looks_like_speech() -> None:
    frames = speech(1_500, 1, noise=0).frames
    curves = {fap: [frame.values[fap - 1] or 0 for frame in frames] for fap in (3, 5, 16, 19, 49)}
    assert 250 < max(curves[3]) < 500 and min(curves[3]) >= 0
    assert max(curves[16]) > 100
    # The jaw opens a few times a second, and is shut in pauses.
    opened = sum(a <= 120 < b for a, b in zip(curves[3], curves[3][1:], strict=False))
    assert 1.0 < opened / 50 < 5.0
    assert sum(value < 15 for value in curves[3]) > 50
    # Eyes close entirely, for a few frames, every few seconds.
    blinks = sum(a < 900 <= b for a, b in zip(curves[19], curves[19][1:], strict=False))
    assert 8 <= blinks <= 30
    # No jumps: the head turns at most some degrees a frame (1e-5 rad).
    assert max(abs(a - b) for a, b in zip(curves[49], curves[49][1:], strict=False)) < 3_000


@pytest.mark.parametrize("make", [speech, expressions])
@pytest.mark.parametrize("rate", [5, 10, 60])
def test_a_face_stays_a_face_at_any_rate(make: Callable[..., FapFile], rate: int) -> None:
    """Springs that are stepped too far would throw brows and head away."""
    seen = [v for frame in make(8 * rate, 5, rate=rate).frames for n, v in enumerate(frame.values, 1) if v is not None
            and not 23 <= n <= 26 and not 48 <= n <= 50]  # fmt: skip
    assert max(map(abs, seen)) < 1200


def test_psnr_is_relative_to_each_range() -> None:
    def frames(*rows: tuple[int, int]) -> list[list[int | None]]:
        return [[None, None, *row, *[None] * 64] for row in rows]

    original = frames((0, 0), (100, 0), (50, 0))
    # FAP 3: error 10 in one of three, range 100. FAP 4 has range 0 and does not count.
    assert psnr(original, frames((10, 5), (100, 5), (50, 5))) == pytest.approx(-10 * log10(100 / 3 / 10_000))
    assert psnr(original, original) is None
    # Frames behind the last of the original do not count.
    assert psnr(original, original + frames((9, 9))) is None


def test_rates_at_equal_psnr() -> None:
    def point(mode: str, quant: int, bits: int, level: float) -> Point:
        return Point("s", mode, quant, bits, 1.0, level)

    found = [
        point("arithmetic", 0, 9_999, 11.0), point("arithmetic", 1, 4_000, 30.0), point("arithmetic", 2, 2_000, 20.0),
        point("dct", 0, 3_000, 26.0), point("dct", 2, 1_000, 16.0),
    ]  # fmt: skip
    assert list(savings(found, "s", [10.0, 21.0, 28.0])) == [(21.0, 2.2, 2.0)]


def test_the_committed_results_are_those_of_this_code() -> None:
    lines = COMMITTED.read_text().splitlines(keepends=True)
    assert lines[0] == HEADER
    assert len(lines) == 1 + 2 * 2 * 32
    sequence = expressions(FRAMES, 1, rate=25)
    for mode, quant in (("dct", 18), ("arithmetic", 31)):
        row = measure(sequence, mode, quant).row()
        assert row in lines
        assert ("P1" in row) == (mode == "dct")
