"""Motions of lids, pupils, brows, cheeks, nose and ears.

Rules: FAC-4, FAC-10, FAT-2, FAT-3, FAT-5: FAPs 18 .. 22, 27 .. 42, 61 .. 68.
Not here: rotations and thrusts of whole eyeballs (`build` writes them as transforms).

Lids slide over the eyeball, piece by piece; the upper and the lower one meet all along when the FAPs of both lids of an
eye add up to 1024. Weights and borders are in `motion.json`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from .moves import Array, Model, Move, Moves, both, pieces, smooth, weighted
from .skin import EYE_RING, Key, eye_edge


def face_moves(model: Model) -> Moves:
    """The moves of the FAPs of lids, pupils, brows, cheeks, nose, chin and ears. Rules: FAC-4, FAT-1."""
    return _bells(model) | _lids(model) | _pupils(model) | _brows(model) | _ears(model)


def _bells(model: Model) -> Moves:
    out: Moves = {}
    for bell in model.motion["bells"]:
        centre, size, keep = model.point(bell["at"]), np.array(bell["size"]), bell["keep"]
        weights = {}
        for i, key in enumerate(model.skin.keys):
            p = model.skin.vertices[i]
            w = math.exp(-float((((p - centre) / size) ** 2).sum()))
            lip = key[0] in ("lip", "spine") and "lips" in keep
            lid = key[0] in ("lid", "socket") and ("lids" in keep or key[0] == "socket")
            if lid and key[0] == "lid" and key[2] == 1:
                w, lid = w * 0.3, False
            nose = key[0] == "grid" and abs(key[2]) < 3 and "nose" in keep
            if lip or lid or nose or key[0] in ("crown", "neck"):
                continue
            if bell.get("side"):
                w *= smooth(float(p[0]) / min(8.0, float(centre[0])))
            weights[i] = w
        move = weighted("skin", [-900, 900], weights, bell["by"])
        if bell.get("side"):
            out |= both(model, bell["fap"], bell["fap"] + 1, [move])
        else:
            out[bell["fap"]] = [move]
    return out


def _lids(model: Model) -> Moves:
    lids, skin = model.motion["lids"], model.skin
    eye = skin.shape["eye"]
    centre, full, half = np.array(eye["centre"]), 2 * eye["iris"], EYE_RING // 2
    upper = [k for k in range(EYE_RING) if k < half // 2 or k > EYE_RING - half // 2]
    lower = [k for k in range(EYE_RING) if half // 2 < k < EYE_RING - half // 2]

    def pose(ks: list[int], way: float) -> Callable[[int, float], dict[int, Array]]:
        def at(value: int, unit: float) -> dict[int, Array]:
            out = {}
            for r in (1, 2, 3, 4):
                share = lids["close" if value > 0 else "open"][str(r)]
                for k in ks:
                    i = skin.index["lid", 1, r, k]
                    p = skin.vertices[i] - centre
                    other = skin.vertices[skin.index["lid", 1, 3, (half - k) % EYE_RING]] - centre
                    edge = skin.vertices[skin.index["lid", 1, 3, k]] - centre
                    # Each vertex closes by its share of the local opening, so that the edges meet all along.
                    dy = way * value * unit * share * abs(float(edge[1] - other[1])) / full
                    # It slides over the ball on which it lies.
                    rest = float(p @ p) - float(p[0]) ** 2 - (float(p[1]) + dy) ** 2
                    z = math.sqrt(max(rest, 4.0))
                    out[i] = np.array([0.0, dy, z - float(p[2])])
            return out

        return at

    unit = model.units["IRISD"]
    out = both(model, 19, 20, [pieces("skin", lids["upper"], unit, pose(upper, -1.0))])
    out |= both(model, 21, 22, [pieces("skin", lids["lower"], unit, pose(lower, 1.0))])
    # The skin around the lids goes a part of the way, so that the ball stays behind it.
    pushed = {skin.index[key]: w for key, w in _lid_shares(lids["thrust"])}
    pushed |= {skin.index[key]: lids["thrust_around"] for key in eye_edge()}
    return out | both(model, 27, 28, [weighted("skin", [-600, 600], pushed, (0, 0, 1))])


def _lid_shares(shares: Mapping[str, float]) -> list[tuple[Key, float]]:
    return [(("lid", 1, int(r), k), w) for r, w in shares.items() for k in range(EYE_RING)]


def _pupils(model: Model) -> Moves:
    eye = model.skin.shape["eye"]
    mesh = model.meshes["left_eye"]
    start = model.skin.shape["iris"]["rings"][0][0]
    ring = [i for i, p in enumerate(mesh) if abs(math.hypot(float(p[0]), float(p[1])) - start) < 1e-6]

    def at(value: int, unit: float) -> dict[int, Array]:
        out = {}
        for i in ring:
            p = mesh[i]
            # The FAP is the growth of the diameter: half of it on each side.
            r = max(start + value * unit / 2, 0.0)
            z = math.sqrt(eye["radius"] ** 2 - r * r)
            out[i] = np.array([float(p[0]) * (r / start - 1), float(p[1]) * (r / start - 1), z - float(p[2])])
        return out

    return both(model, 29, 30, [pieces("left_eye", model.motion["pupil"], model.units["IRISD"], at)])


def _brows(model: Model) -> Moves:
    brow, skin = model.motion["brow"], model.skin
    inner, middle, outer = (model.point(p) for p in ("4.1", "4.3", "4.5"))
    x0, x1 = float(inner[0]), float(outer[0])
    past = 2 * x0 / (x1 - x0)

    def share(s: float) -> dict[str, float]:
        # The inner end fades out at the inner end of the other brow, the outer end behind the temple.
        before = math.cos(math.pi / 2 * min(-s / past, 1.0)) ** 2 if s < 0 else 1.0
        after = math.cos(math.pi / 2 * min((s - 1) / brow["beyond"], 1.0)) ** 2 if s > 1 else 1.0
        c = math.cos(math.pi * min(max(s, 0.0), 1.0)) ** 2
        reach = min(max(s, 0.0) / brow["squeeze"]["reach"], 1.0)
        # Between the brows both squeezes act: in a straight line from all to nothing they press the skin together
        # evenly, and no part of it passes another before the brows meet.
        between = max(1 + s / past, 0.0) if s < 0 else 1.0
        return {
            "inner": before * (c if s < 0.5 else 0.0),
            "middle": 1 - c,
            "outer": after * (c if s > 0.5 else 0.0),
            "squeeze": between * math.cos(math.pi / 2 * reach) ** 2,
        }

    line = [[float(p[0]) for p in (inner, middle, outer)], [float(p[1]) for p in (inner, middle, outer)]]
    weights: dict[str, dict[str, dict[int, float]]] = {name: {} for name in ("inner", "middle", "outer", "squeeze")}
    for mesh in ("skin", "left_brow"):
        for name in weights:
            weights[name][mesh] = {}
        for i, p in enumerate(model.meshes[mesh]):
            x, y, z = (float(v) for v in p)
            if mesh == "skin" and (skin.keys[i][0] != "grid" or z < 20):
                continue
            above = y - float(np.interp(x, line[0], line[1]))
            if mesh == "left_brow":
                fade = 1.0
            else:
                fade = math.exp(-((above / brow["up"]) ** 2)) if above > 0 else smooth(1 + above / brow["down"])
            for name, value in share((x - x0) / (x1 - x0)).items():
                weights[name][mesh][i] = value * fade
    out: Moves = {}
    for fap, name in ((31, "inner"), (33, "middle"), (35, "outer")):
        out |= both(model, fap, fap + 1, [weighted(m, brow["borders"], w, (0, 1, 0)) for m, w in weights[name].items()])
    return out | both(model, 37, 38, [_squeeze(model, mesh, w) for mesh, w in weights["squeeze"].items()])


def _squeeze(model: Model, mesh: str, weights: Mapping[int, float]) -> Move:
    """The brow along its line: as the value says until it presses against the other, then hardly any farther."""
    way = model.motion["brow"]["squeeze"]
    borders, reached = way["borders"], dict(zip(way["borders"], way["reached"], strict=True))
    kept = {i: w for i, w in weights.items() if w > 0.004}

    def at(value: int, unit: float) -> dict[int, Array]:
        return {i: np.array([-reached[value] * unit * w, 0.0, 0.0]) for i, w in kept.items()}

    return pieces(mesh, borders, model.units["ES"], at)


def _ears(model: Model) -> Moves:
    ear = model.motion["ear"]
    mesh = model.meshes["left_ear"]
    top, bottom, back = (model.point(p) for p in ("10.1", "10.5", "10.3"))
    front = float(mesh[:, 2].max())
    up, out = {}, {}
    for i, p in enumerate(mesh):
        down = min(max(float(top[1] - p[1]) / float(top[1] - bottom[1]), 0.0), 1.0)
        up[i] = 1 - (1 - ear["lobe"]) * down
        behind = min(max((front - float(p[2])) / (front - float(back[2])), 0.0), 1.0)
        out[i] = ear["front"] + (1 - ear["front"]) * behind
    moves = both(model, 65, 66, [weighted("left_ear", ear["borders"], up, (0, 1, 0))])
    return moves | both(model, 67, 68, [weighted("left_ear", ear["borders"], out, (1, 0, 0))])
