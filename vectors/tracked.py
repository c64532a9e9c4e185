"""Meshes that move as if tracked in pictures, made from a seed: a flag in the wind, a talking head.

Rules: CNF-4 (own generator; floats are made of + - * / alone, in one fixed order), MSH-5, MSH-6, MSH-37.
Positions are in half pixels; y grows downwards.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.face.dct_transform import round_half_away

from .movers import Draw, Spring, smooth

Point = tuple[int, int]
Nodes = list[Point]

# Contour of a head, clockwise on screen from the top, then what moves within; about the middle of the face.
HEAD_BOUNDARY: Final = (
    (3, -100), (41, -91), (68, -63), (77, -21), (71, 24), (55, 66), (29, 99), (1, 111), (-30, 97), (-57, 64),
    (-73, 22), (-76, -24), (-66, -66), (-38, -92),
)  # fmt: skip
"""The contour of the head of `head`, in half pixels about its middle. Rules: MSH-5."""
_BROWS: Final = ((-44, -42), (-19, -47), (20, -46), (45, -41))
_UPPER_LIDS: Final = ((-32, -27), (33, -26))
_LOWER_LIDS: Final = ((-31, -14), (31, -15))
_NOSE: Final = ((0, 13), (-12, 21), (13, 22))
_CORNERS: Final = ((-26, 51), (27, 50))
_UPPER_LIP: Final = ((1, 44),)
_LOWER_LIP: Final = ((0, 58),)
_CHIN: Final = ((2, 83),)
_INNER: Final = (*_BROWS, *_UPPER_LIDS, *_LOWER_LIDS, *_NOSE, *_CORNERS, *_UPPER_LIP, *_LOWER_LIP, *_CHIN)


def _wave(phase: float) -> float:
    """Much like a sine of period 1, of two parabolas."""
    x = phase - int(phase)
    if x < 0.0:
        x = x + 1.0
    return 16.0 * x * (0.5 - x) if x < 0.5 else -16.0 * (x - 0.5) * (1.0 - x)


def flag(frames: int, seed: int = 1, *, columns: int = 8, rows: int = 5, cell: Point = (20, 20)) -> list[Nodes]:
    """A flag on a pole at its left: it hangs still, then waves run through it. Rules: CNF-4, MSH-6.

    Positions by frame, row by row; the first frame is the grid itself. `cell`: width and height. Each node is off by
    up to one half pixel, as a tracker's would be.
    """
    draw = Draw(seed)
    speed, length = draw.between(0.05, 0.08), draw.between(0.8, 1.2)
    gust = Spring(0.35)
    out: list[Nodes] = []
    for number in range(frames):
        if number % 12 == 0:
            gust.target = draw.between(0.5, 1.0)
        strength = gust.step(1.0) if number else 0.0
        nodes: Nodes = []
        for row in range(rows):
            for column in range(columns):
                far = column / (columns - 1)
                phase = far * length - number * speed + 0.04 * row
                up = strength * far * (0.7 * cell[1] * _wave(phase) + 0.15 * cell[1] * _wave(2.3 * phase))
                slack = strength * far * 0.3 * cell[0] * (1.0 - _wave(phase + 0.25))
                noise = (draw.among(-1, 1), draw.among(-1, 1)) if number and column else (0, 0)
                nodes.append(
                    (
                        column * cell[0] - round_half_away(slack) + noise[0],
                        row * cell[1] + round_half_away(up) + noise[1],
                    )
                )
        out.append(nodes)
    return out


def head(frames: int, seed: int = 1, *, rate: int = 15, middle: Point = (352, 288), size: float = 1.0) -> list[Nodes]:
    """A head that talks, nods, turns a little and blinks: the contour first, then brows, lids, nose, mouth, chin.

    Rules: CNF-4, MSH-5, MSH-37. Positions by frame; `len(HEAD_BOUNDARY)` boundary nodes. `size`: 1.0 is 150 half
    pixels wide. Nodes are off by up to one half pixel.
    """
    draw = Draw(seed)
    sway, nod, tilt, jaw = Spring(4.0), Spring(4.0), Spring(3.0), Spring(9.0)
    due = syllable = 0.0
    blink = draw.between(0.3, 0.9)
    out: list[Nodes] = []
    for number in range(frames):
        now = number / rate
        if now >= due:
            due = now + draw.between(0.5, 1.4)
            sway.target, nod.target = draw.between(-22.0, 22.0), draw.between(-12.0, 12.0)
            tilt.target = draw.between(-0.06, 0.06)
        if now >= syllable:
            syllable = now + draw.between(0.12, 0.3)
            jaw.target = draw.between(0.0, 18.0)
        if now > blink + 0.5:
            blink = now + draw.between(0.8, 2.5)
        lids = 9.0 * smooth((now - blink) / 0.08) * (1.0 - smooth((now - blink - 0.1) / 0.18))
        x0, y0, half, opened = sway.step(1.0 / rate), nod.step(1.0 / rate), tilt.step(1.0 / rate), jaw.step(1.0 / rate)
        # A turn by twice the angle whose tangent is `half`.
        cosine, sine = (1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half)
        nodes: Nodes = []
        for x, y in (*HEAD_BOUNDARY, *_INNER):
            down = 0.0
            if (x, y) in _UPPER_LIDS:
                down = lids
            elif (x, y) in _LOWER_LIP:
                down = opened
            elif (x, y) in _CHIN:
                down = 0.8 * opened
            elif (x, y) in _CORNERS:
                down = 0.3 * opened
            px, py = size * x, size * (y + down)
            noise = (draw.among(-1, 1), draw.among(-1, 1)) if number else (0, 0)
            nodes.append(
                (
                    middle[0] + round_half_away(x0 + cosine * px - sine * py) + noise[0],
                    middle[1] + round_half_away(y0 + sine * px + cosine * py) + noise[1],
                )
            )
        out.append(nodes)
    return out
