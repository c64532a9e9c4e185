"""Plausible face animation sequences, made from a seed: long speech, and expressions that come and go.

Rules: CNF-4 (own generator; floats are made of + - * / alone, in one fixed order), FBA-50 (the result is a `.fap` text
as object).

Speech: visemes follow each other in words and phrases; each is a target of jaw and lips, and the targets around an
instant are weighed by dominance functions a / (1 + ((t - centre) / width)^2)^2, so that neighbours colour each other.
Eyelids blink, eyes jump, brows and head follow phrases by damped springs. `noise` adds what a tracker would: whole
numbers, equally likely from -noise to noise, to each value.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Final, final

from snhc.reference_impl.face.dct_transform import round_half_away
from snhc.reference_impl.face.fap_text import FapFile, FapTextFrame

from .movers import ANGLES, Draw, Eyes, Head, smooth

# Lips and jaw of the 15 visemes of the standard's list: jaw (FAP 3), upper lip up, lower lip down (of the mouth's
# parting beyond the jaw's), corners outward, corners up, lips forward, and how strongly the viseme insists on it.
_VISEMES: Final = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6),
    (20.0, -45.0, -60.0, 0.0, 0.0, 30.0, 3.0),
    (70.0, 40.0, -110.0, 10.0, 0.0, 10.0, 2.5),
    (110.0, 40.0, 60.0, 10.0, 0.0, 0.0, 1.4),
    (120.0, 40.0, 70.0, 20.0, 5.0, 0.0, 1.2),
    (170.0, 50.0, 90.0, 10.0, 0.0, 0.0, 0.8),
    (110.0, 90.0, 100.0, -60.0, -5.0, 160.0, 1.8),
    (60.0, 60.0, 80.0, 60.0, 10.0, 0.0, 1.6),
    (130.0, 40.0, 70.0, 20.0, 0.0, 0.0, 1.0),
    (120.0, 60.0, 70.0, -50.0, 0.0, 110.0, 1.5),
    (460.0, 90.0, 230.0, 20.0, 0.0, 0.0, 1.4),
    (290.0, 80.0, 180.0, 80.0, 15.0, 0.0, 1.3),
    (180.0, 70.0, 130.0, 100.0, 20.0, 0.0, 1.3),
    (330.0, 70.0, 160.0, -90.0, -5.0, 140.0, 1.6),
    (150.0, 50.0, 90.0, -150.0, -10.0, 230.0, 2.0),
)
_VOWELS: Final = (10, 11, 12, 13, 14)
_CONSONANTS: Final = (1, 2, 3, 4, 5, 6, 7, 8, 9)
_PAUSE: Final = 0
_REACH: Final = 0.6

# The FAPs of each expression at full intensity.
_EXPRESSIONS: Final[tuple[Mapping[int, float], ...]] = (
    {  # joy
        3: 60, 4: -30, 5: -60, 6: 130, 7: 125, 8: -40, 9: -40, 10: -40, 11: -40, 12: 150, 13: 145, 19: 220, 20: 225,
        21: 240, 22: 245, 41: 180, 42: 175, 51: -30, 52: -50, 53: 120, 54: 115, 59: 150, 60: 145,
    },
    {  # sadness
        3: 30, 5: 60, 6: -20, 7: -20, 12: -110, 13: -115, 19: 260, 20: 265, 31: 160, 32: 155, 33: 40, 34: 40, 35: -60,
        36: -60, 37: 60, 38: 60, 48: 6_000, 59: -110, 60: -115,
    },
    {  # anger
        3: -20, 4: 40, 5: 60, 6: -40, 7: -40, 16: 60, 17: 50, 19: -150, 20: -150, 31: -170, 32: -175, 33: -90, 34: -95,
        35: 60, 36: 55, 37: 110, 38: 115, 48: 2_500, 51: 40, 52: 50,
    },
    {  # fear
        3: 170, 4: -30, 5: -120, 6: 60, 7: 60, 19: -280, 20: -275, 21: -60, 22: -60, 31: 220, 32: 215, 33: 150, 34: 150,
        35: 60, 36: 60, 37: 80, 38: 85, 48: -3_500, 52: -110,
    },
    {  # disgust
        4: -90, 5: 30, 6: -30, 7: -30, 8: -80, 9: -60, 12: 40, 13: 20, 19: 180, 20: 190, 31: -60, 32: -60, 33: -40,
        34: -40, 41: 90, 42: 80, 51: -80, 55: -70, 56: -50, 61: 60, 62: 50, 63: 40,
    },
    {  # surprise
        3: 420, 4: -60, 5: -250, 6: -60, 7: -60, 8: -50, 9: -50, 10: -210, 11: -210, 19: -320, 20: -315, 31: 290,
        32: 285, 33: 310, 34: 305, 35: 250, 36: 245, 48: -2_500, 51: -50, 52: -230,
    },
)  # fmt: skip


@final
class _Mouth:
    """Visemes, one after the other, and what the mouth makes of them."""

    __slots__ = ("_draw", "_end", "_left", "_spoken")

    def __init__(self, draw: Draw) -> None:
        self._draw = draw
        self._spoken: list[tuple[float, float, float, int]] = []  # centre, width, force, viseme
        self._end = 0.3
        self._left = draw.among(6, 24)

    def _speak(self, now: float) -> None:
        draw = self._draw
        while self._end < now + _REACH:
            if self._left == 0:
                self._left = draw.among(6, 24)
                viseme, length = _PAUSE, draw.between(0.25, 0.9)
            else:
                vowel = bool(self._spoken) and self._spoken[-1][3] not in _VOWELS
                viseme = draw.one_of(_VOWELS if vowel else _CONSONANTS)
                length = draw.between(0.07, 0.17) if vowel else draw.between(0.05, 0.11)
                self._left -= 1
            force = draw.between(0.7, 1.15)
            self._spoken.append((self._end + 0.5 * length, 0.5 * length, force, viseme))
            self._end = self._end + length
        while self._spoken and self._spoken[0][0] < now - _REACH:
            del self._spoken[0]

    def add(self, now: float, values: dict[int, float]) -> None:
        self._speak(now)
        weights = 0.2
        sums = [0.0] * 6
        for centre, width, force, viseme in self._spoken:
            target = _VISEMES[viseme]
            far = (now - centre) / (width + 0.02)
            near = 1.0 / (1.0 + far * far)
            weight = target[6] * near * near
            weights = weights + weight
            for i in range(6):
                sums[i] = sums[i] + weight * force * target[i]
        jaw, upper, lower, wide, corner, forward = [total / weights for total in sums]
        parting = lower + 0.45 * jaw
        for fap, value in (
            (3, jaw), (4, -upper), (5, -parting), (6, wide), (7, 0.97 * wide), (8, -0.8 * upper), (9, -0.78 * upper),
            (10, -0.8 * parting), (11, -0.79 * parting), (12, corner), (13, 0.95 * corner), (16, 0.9 * forward),
            (17, forward), (51, -0.8 * upper), (52, -0.9 * parting), (53, 0.9 * wide), (54, 0.88 * wide),
            (55, -0.65 * upper), (56, -0.64 * upper), (57, -0.7 * parting), (58, -0.69 * parting), (59, 0.9 * corner),
            (60, 0.86 * corner),
        ):  # fmt: skip
            values[fap] = values.get(fap, 0.0) + value


def speech(frames: int, seed: int = 1, *, rate: int = 30, noise: int = 2) -> FapFile:
    """Someone speaks, in phrases with pauses. Rules: CNF-4.

    `frames`: 1 or more. `rate`: per second, 1..255. `noise`: 0 or more, in FAP units (angles: 30 times as much).
    """
    draw = Draw(seed)
    mouth, eyes, head = _Mouth(draw), Eyes(draw), Head(draw)
    seconds = 1.0 / rate
    out = []
    for number in range(frames):
        now = number / rate
        values: dict[int, float] = {}
        mouth.add(now, values)
        eyes.add(now, values)
        head.add(now, seconds, values)
        out.append(values)
    return _file(f"speech-{seed}", out, rate, noise, draw)


def expressions(frames: int, seed: int = 1, *, rate: int = 25, noise: int = 2) -> FapFile:
    """The six expressions in turn, each with onset, climax and relax, sometimes two at once. Rules: CNF-4.

    Arguments as `speech`.
    """
    draw = Draw(seed)
    eyes, head = Eyes(draw), Head(draw)
    seconds = 1.0 / rate
    # (start, onset, hold, relax, size, which): the shown ones.
    shown: list[tuple[float, float, float, float, float, int]] = []
    due = 0.4
    which = 0
    out = []
    faps = sorted({fap for targets in _EXPRESSIONS for fap in targets})
    for number in range(frames):
        now = number / rate
        if now >= due:
            onset, hold, relax = draw.between(0.2, 0.9), draw.between(0.3, 2.0), draw.between(0.4, 1.4)
            shown.append((now, onset, hold, relax, draw.between(0.5, 1.0), which % 6))
            which += draw.among(1, 5)
            due = now + onset + hold + draw.between(-0.1, 1.0) * relax + draw.between(0.0, 1.5)
        shown = [one for one in shown if now < one[0] + one[1] + one[2] + one[3]]
        values: dict[int, float] = dict.fromkeys(faps, 0.0)
        for start, onset, hold, relax, size, expression in shown:
            amount = size * smooth((now - start) / onset) * (1.0 - smooth((now - start - onset - hold) / relax))
            for fap, target in _EXPRESSIONS[expression].items():
                values[fap] = values[fap] + amount * target
        eyes.add(now, values)
        head.add(now, seconds, values)
        out.append(values)
    return _file(f"expressions-{seed}", out, rate, noise, draw)


def _file(name: str, frames: list[dict[int, float]], rate: int, noise: int, draw: Draw) -> FapFile:
    file = FapFile(name=name, frame_rate=Fraction(rate), nframes=len(frames))
    for number, values in enumerate(frames):
        whole: list[int | None] = [None] * 68
        mask = [0] * 68
        for fap in sorted(values):
            error = draw.among(-noise, noise) * (30 if fap in ANGLES else 1)
            whole[fap - 1] = round_half_away(values[fap]) + error
            mask[fap - 1] = 1
        file.frames.append(FapTextFrame(number, tuple(mask), whole))
    return file
