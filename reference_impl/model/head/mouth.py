"""Motions of the jaw, the lips and the tongue.

Rules: FAC-4, FAC-10, FAT-2, FAT-5: FAPs 3 .. 17 without 18, 43 .. 47, 51 .. 60.

FAP 3 moves the jaw, the lower teeth and the chin but not the lips: table 7 of the paper says "does not affect mouth
opening". Inner lip FAPs leave the outer contour alone and the other way round; what lies between takes a share of
both. Weights and borders are in `motion.json`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .moves import Array, Model, Move, Moves, both, pieces, smooth, weighted
from .skin import MOUTH_RING

_AU = 1e-5


def mouth_moves(model: Model) -> Moves:
    """The moves of the FAPs of jaw, lips and tongue. Rules: FAC-4, FAT-1."""
    return _jaw(model) | _lips(model) | _tongue(model)


def _jaw_weights(model: Model) -> dict[int, float]:
    jaw = model.motion["jaw"]
    (zf, yf), (zb, yb) = jaw["front"], jaw["back"]
    half = MOUTH_RING // 2
    out: dict[int, float] = {}
    for i, key in enumerate(model.skin.keys):
        _, y, z = (float(v) for v in model.skin.vertices[i])
        if key[0] == "lip":
            below = max(0.0, -math.cos(math.pi * key[2] / half))
            w = jaw["bag"].get(str(key[1]), 0.0) * below
        elif key[0] == "grid":
            u = min(max((z - zb) / (zf - zb), 0.0), 1.0)
            line = yb + (yf - yb) * u
            w = smooth((line - y) / jaw["depth"]) * smooth(
                (z - jaw["behind"][0]) / (jaw["behind"][1] - jaw["behind"][0])
            )
            if key[1] < len(jaw["neck"]):
                w *= jaw["neck"][key[1]]
        else:
            continue
        if w > 0.004:
            out[i] = w
    return out


def _jaw(model: Model) -> Moves:
    jaw = model.motion["jaw"]
    chin = model.point("2.1")
    hy, hz = jaw["hinge"]
    tongue = model.meshes["tongue"]
    zs = tongue[:, 2]
    t = (zs - zs.min()) / (zs.max() - zs.min())
    low, high = jaw["tongue"]
    weights = {
        "skin": _jaw_weights(model),
        "teeth_lower": dict.fromkeys(range(len(model.meshes["teeth_lower"])), 1.0),
        "tongue": {i: float(low + (high - low) * v) for i, v in enumerate(t)},
    }

    def swing(p: Array, angle: float) -> Array:
        c, s = math.cos(angle), math.sin(angle)
        y, z = float(p[1]) - hy, float(p[2]) - hz
        return np.array([0.0, y * c - z * s - y, y * s + z * c - z])

    def angle_for(drop: float) -> float:
        # The angle whose fall of the chin is exactly the FAP value; it grows steadily up to the last border.
        a, b = 0.0, math.pi / 4
        for _ in range(80):
            mid = (a + b) / 2
            a, b = (mid, b) if -float(swing(chin, mid)[1]) < drop else (a, mid)
        return (a + b) / 2

    def pose(mesh: str) -> Callable[[int, float], dict[int, Array]]:
        def at(value: int, unit: float) -> dict[int, Array]:
            angle = angle_for(value * unit) if value else 0.0
            return {i: w * swing(model.meshes[mesh][i], angle) for i, w in weights[mesh].items()}

        return at

    out: Moves = {3: [pieces(m, jaw["borders"], model.units["MNS"], pose(m)) for m in weights]}
    out[14] = [weighted(m, jaw["thrust"], w, (0, 0, 1)) for m, w in weights.items()]
    out[15] = [weighted(m, jaw["shift"], w, (-1, 0, 0)) for m, w in weights.items()]
    return out


def _mouth_place(model: Model) -> dict[int, tuple[int, float, float]]:
    """Skin vertices at and around the mouth: ring (0 = skin around), position along the ring, fade."""
    skin, lips = model.skin, model.motion["lips"]
    ax, ay = lips["across"]
    half = MOUTH_RING // 2
    corner_y = float(model.point("8.3")[1])
    orbit = skin.shape["mouth"]["orbit"]
    turns = [math.atan2(x / ax, (y - corner_y) / ay) for x, y in orbit]
    out: dict[int, tuple[int, float, float]] = {}
    for i, key in enumerate(skin.keys):
        x, y, z = (float(v) for v in skin.vertices[i])
        if key[0] == "lip":
            out[i] = (key[1], float(key[2]), 1.0)
        elif key[0] == "grid" and z > 30 and not (key[1] > 10 and abs(key[2]) < 3):
            k = float(np.interp(math.atan2(abs(x) / ax, (y - corner_y) / ay), turns, range(half + 1)))
            reach = math.hypot(x / ax, (y - corner_y) / ay) - 1
            fade = smooth(1 - max(reach, 0.0) / lips["reach"])
            out[i] = (0, k if x >= 0 else (MOUTH_RING - k) % MOUTH_RING, fade)
    return out


def _hats(contour: list[list[float]]) -> dict[str, list[float]]:
    """Influence of the lip feature points along a ring of 20: middle, left half point, left corner; sums are 1."""
    half, edge = MOUTH_RING // 2, contour[MOUTH_RING // 4][0]
    s = [contour[k][0] / edge if k <= half else -contour[MOUTH_RING - k][0] / edge for k in range(MOUTH_RING)]
    rise = [math.cos(math.pi * v) ** 2 for v in s]
    upper = [k <= half // 2 or k >= MOUTH_RING - half // 2 for k in range(MOUTH_RING)]
    lower = [half // 2 <= k <= MOUTH_RING - half // 2 for k in range(MOUTH_RING)]
    return {
        "top": [r if abs(v) < 0.5 and u else 0.0 for r, v, u in zip(rise, s, upper, strict=True)],
        "bottom": [r if abs(v) < 0.5 and u else 0.0 for r, v, u in zip(rise, s, lower, strict=True)],
        "top_left": [1 - r if v > 0 and u else 0.0 for r, v, u in zip(rise, s, upper, strict=True)],
        "bottom_left": [1 - r if v > 0 and u else 0.0 for r, v, u in zip(rise, s, lower, strict=True)],
        "corner": [r if v > 0.5 else 0.0 for r, v in zip(rise, s, strict=True)],
        "top_push": [math.cos(math.pi / 2 * v) if u else 0.0 for v, u in zip(s, upper, strict=True)],
        "bottom_push": [math.cos(math.pi / 2 * v) if u else 0.0 for v, u in zip(s, lower, strict=True)],
    }


def _lips(model: Model) -> Moves:
    lips, mouth = model.motion["lips"], model.skin.shape["mouth"]
    places = _mouth_place(model)
    hats = {"inner": _hats(mouth["inner"]), "outer": _hats(mouth["outer"])}

    def weights(rings: str, hat: str) -> dict[int, float]:
        out = {}
        factors = lips[rings]
        for i, (ring, k, fade) in places.items():
            factor = factors.get(str(ring), 0.0) * fade
            values = hats["outer" if ring < 3 else "inner"][hat]
            a = math.floor(k)
            value = values[a] + (values[(a + 1) % MOUTH_RING] - values[a]) * (k - a)
            if factor * value > 0.004:
                out[i] = factor * value
        return out

    def move(rings: str, hat: str, by: tuple[float, float, float], borders: str = "borders") -> list[Move]:
        return [weighted("skin", lips[borders], weights(rings, hat), by)]

    back = lips["corner_back"]
    out: Moves = {16: move("push", "bottom_push", (0, 0, 1)), 17: move("push", "top_push", (0, 0, 1))}
    for rings, top in (("inner", 4), ("outer", 51)):
        out[top] = move(rings, "top", (0, -1, 0))
        out[top + 1] = move(rings, "bottom", (0, 1, 0), "raise")
        out |= both(model, top + 2, top + 3, move(rings, "corner", (1, 0, back)))
        out |= both(model, top + 4, top + 5, move(rings, "top_left", (0, -1, 0)))
        out |= both(model, top + 6, top + 7, move(rings, "bottom_left", (0, 1, 0), "raise"))
        out |= both(model, top + 8, top + 9, move(rings, "corner", (0, 1, 0)))
    return out


def _tongue(model: Model) -> Moves:
    spec = model.motion["tongue"]
    mesh = model.meshes["tongue"]
    tip, body = float(model.point("6.1")[2]), float(model.point("6.2")[2])
    z = [float(v) for v in mesh[:, 2]]
    front = {i: smooth((v - spec["root"]) / (tip - spec["root"])) for i, v in enumerate(z)}
    end = {i: smooth((v - body) / (tip - body)) for i, v in enumerate(z)}
    hump = {i: (1 - end[i]) * math.exp(-(((v - body) / spec["hump"]) ** 2)) for i, v in enumerate(z)}
    a, b = spec["roll_from"]
    height = float(model.point("6.2")[1])

    def roll(value: int, unit: float) -> dict[int, Array]:
        out = {}
        for i, p in enumerate(mesh):
            angle = value * unit * smooth((z[i] - a) / (b - a))
            # Each half turns upward about the middle line at the height of 6.2.
            side = math.copysign(1.0, float(p[0])) if p[0] else 0.0
            x, y = abs(float(p[0])), float(p[1]) - height
            c, sine = math.cos(angle), math.sin(angle)
            out[i] = np.array([side * (x * (c - 1) - y * sine), abs(side) * (x * sine + y * (c - 1)), 0.0])
        return out

    borders = spec["borders"]
    return {
        43: [weighted("tongue", borders, front, (-1, 0, 0))],
        44: [weighted("tongue", borders, end, (0, 1, 0))],
        45: [weighted("tongue", borders, front, (0, 0, 1))],
        46: [weighted("tongue", borders, hump, (0, 1, 0))],
        47: [pieces("tongue", spec["roll"], _AU, roll)],
    }
