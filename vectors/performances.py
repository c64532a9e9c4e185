"""Plausible high-level and body sequences, made from a seed: a talk in visemes and expressions, and gestures.

Rules: CNF-4 (own generator; floats are made of + - * / alone, in one fixed order), FBA-50, FBA-53 (the results are
texts as objects). Low-level speech and expressions: `sequences`.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Final

from snhc.reference_impl.face.bap_text import BapFile, BapTextFrame
from snhc.reference_impl.face.dct_transform import round_half_away
from snhc.reference_impl.face.fap_text import Expression, FapFile, FapTextFrame, Viseme

from .movers import ANGLES, Draw, Eyes, Head, Spring, smooth

_SHOWN_ALONE: Final = 63
_NEUTRAL: Final = 0
_VISEMES: Final = tuple(range(1, 15))
_EXPRESSIONS: Final = (1, 2, 3, 4, 5, 6)
# Lids, gaze, head, brows: what a talk in visemes moves by itself.
_LOW_LEVEL: Final = (19, 20, 21, 22, 23, 24, 25, 26, 31, 32, 33, 34, 35, 36, 48, 49, 50)
# Twists of shoulders, elbows and wrists, bends of the neck and the middle of the spine. Their base steps are not in
# dispute (AMB-FBA-5).
GESTURES: Final = (36, 37, 40, 41, 46, 47, 51, 52, 53, 57, 58, 59)
"""The BAPs that `gestures` moves. Rules: FBA-40."""


def _visemes(frames: int, rate: int, draw: Draw) -> list[Viseme]:
    """One viseme fades into the next: viseme_blend falls from 63, which shows viseme_select1 alone, to 0."""
    out: list[Viseme] = []
    shown, coming = _NEUTRAL, draw.one_of(_VISEMES)
    since, length, left = 0.0, 0.3, draw.among(5, 14)
    for number in range(frames):
        now = number / rate
        while now >= since + length:
            since = since + length
            shown = coming
            left -= 1
            if left < 0:
                coming, left = _NEUTRAL, draw.among(5, 14)
                length = draw.between(0.25, 0.6)
            else:
                while coming == shown:
                    coming = draw.one_of(_VISEMES)
                length = draw.between(0.07, 0.18)
        # It stands for the first third of its time.
        gone = smooth(((now - since) / length - 0.33) / 0.67)
        out.append((shown, coming, _SHOWN_ALONE - round_half_away(_SHOWN_ALONE * gone), 0))
    return out


def _expressions(frames: int, rate: int, draw: Draw) -> list[Expression]:
    """Two at a time: what fades, and what comes."""
    out: list[Expression] = []
    fading, coming = draw.one_of(_EXPRESSIONS), draw.one_of(_EXPRESSIONS)
    since, length, size = 0.0, draw.between(0.8, 1.6), draw.between(20.0, 63.0)
    before = draw.between(20.0, 63.0)
    for number in range(frames):
        now = number / rate
        while now >= since + length:
            since, length = since + length, draw.between(0.8, 1.6)
            fading, coming = coming, draw.one_of(_EXPRESSIONS)
            before, size = size, draw.between(20.0, 63.0)
        gone = smooth((now - since) / length)
        out.append((fading, round_half_away(before * (1.0 - gone)), coming, round_half_away(size * gone), 0, 0))
    return out


def talk(frames: int, seed: int = 1, *, rate: int = 25, noise: int = 0) -> FapFile:
    """Someone talks: visemes (FAP 1) and expressions (FAP 2), with lids, gaze, brows and head. Rules: CNF-4, FBA-28.

    `frames`: 1 or more. `rate`: per second, 1..255. `noise`: as in `sequences.speech`.
    """
    draw = Draw(seed)
    visemes, shown = _visemes(frames, rate, draw), _expressions(frames, rate, draw)
    eyes, head = Eyes(draw), Head(draw)
    file = FapFile(name=f"talk-{seed}", frame_rate=Fraction(rate), nframes=frames)
    for number in range(frames):
        values: dict[int, float] = dict.fromkeys(_LOW_LEVEL, 0.0)
        eyes.add(number / rate, values)
        head.add(number / rate, 1.0 / rate, values)
        whole: list[int | None] = [None] * 68
        mask = [1, 1] + [0] * 66
        for fap in _LOW_LEVEL:
            error = draw.among(-noise, noise) * (30 if fap in ANGLES else 1)
            whole[fap - 1] = round_half_away(values[fap]) + error
            mask[fap - 1] = 1
        file.frames.append(FapTextFrame(number, tuple(mask), whole, visemes[number], shown[number]))
    return file


def gestures(frames: int, seed: int = 1, *, rate: int = 25) -> BapFile:
    """Hands and upper body accompany speech, every joint on its own springs. Rules: CNF-4, FBA-40. As `talk`."""
    draw = Draw(seed)
    springs = {bap: Spring(draw.between(3.0, 7.0)) for bap in GESTURES}
    due = dict.fromkeys(GESTURES, 0.0)
    file = BapFile(name=f"gestures-{seed}", frame_rate=Fraction(rate), nframes=frames)
    mask = tuple(int(number + 1 in GESTURES) for number in range(186))
    for number in range(frames):
        now = number / rate
        values: list[int | None] = [None] * 186
        for bap, spring in springs.items():
            if now >= due[bap]:
                due[bap] = now + draw.between(0.4, 1.4)
                # 1e-5 rad: arms twist by up to half a radian, vertebrae by a twentieth.
                spring.target = draw.between(-1.0, 1.0) * (50_000.0 if bap < 48 else 5_000.0)
            values[bap - 1] = round_half_away(spring.step(1.0 / rate))
        file.frames.append(BapTextFrame(number, mask, values))
    return file
