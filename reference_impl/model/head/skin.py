"""The skin of the shipped head: a lofted head with edge loops around the eyes and the mouth.

Rules: FAC-3, FAC-10.
Not here: the other parts (`parts`), the motions (`mouth`, `face`).

Every number is in `shape.json`, in millimetres, eyes at y = 0; `build` moves the origin to feature point 7.1. Closed
curves (rows) from the neck to the crown are given by a front, a side and a back point; bumps are added; a grid of rows
and columns lies on that surface. A block of grid cells is left out around the mouth and around each eye, and its edge
is joined to concentric rings: lids and lips. Only the left half is computed; the right half is its mirror image.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Point: TypeAlias = tuple[float, float, float]
Key: TypeAlias = tuple[Any, ...]
Shape: TypeAlias = dict[str, Any]

MOUTH_ROWS, MOUTH_COLUMNS = (6, 10), 3
EYE_ROWS, EYE_COLUMNS = (15, 19), (2, 6)
EYE_RING, MOUTH_RING = 16, 20


def mirror_key(key: Key) -> Key:
    """The key of the mirrored vertex: the column, side or ring position is negated or reversed. Rules: FAC-10."""
    if key[0] == "grid":
        return ("grid", key[1], -key[2])
    if key[0] in ("lid", "nostril", "socket"):
        return (key[0], -key[1], *key[2:])
    if key[0] == "lip":
        return ("lip", key[1], -key[2] % MOUTH_RING)
    return key


class Loft:
    """The smooth surface under the skin: point as a function of row and angle. Rules: FAC-10."""

    def __init__(self, shape: Shape) -> None:
        self._t = np.array([float(t) for t in shape["rows"]])
        self._rows = np.array(list(shape["rows"].values()), dtype=np.float64)
        self._slope = np.array([_slopes(self._t, c) for c in self._rows.T]).T
        # The crown is round: heights end level, and the sections close faster.
        self._slope[-1, [0, 3, 5]] = 0.0
        self._slope[-1, [1, 2, 4, 6]] *= 1.15
        self._bumps = shape["bumps"]

    def _row(self, t: float) -> list[float]:
        t = min(max(t, 0.0), float(self._t[-1]))
        i = min(int(np.searchsorted(self._t, t, side="right")) - 1, len(self._t) - 2)
        h = float(self._t[i + 1] - self._t[i])
        s = (t - float(self._t[i])) / h
        a, b = (1 + 2 * s) * (1 - s) ** 2, s * s * (3 - 2 * s)
        c, d = s * (1 - s) ** 2 * h, s * s * (s - 1) * h
        r, m = self._rows, self._slope
        return [float(v) for v in a * r[i] + b * r[i + 1] + c * m[i] + d * m[i + 1]]

    def at(self, t: float, phi: float) -> Point:
        """Point (mm) of row `t` (0 neck, last crown) at `phi` (radians, 0 front, pi back). Rules: FAC-10."""
        yf, zf, xs, ys, zs, yb, zb = self._row(t)
        s, c = math.sin(phi), math.cos(phi)
        x, (y, z) = xs * s, (yf, zf) if c >= 0 else (yb, zb)
        y, z = ys + (y - ys) * c * c, zs + (z - zs) * abs(c)
        fade = min(max((z - 5) / 30, 0.0), 1.0)
        bx = by = bz = 0.0
        for bump in self._bumps:
            (ax, ay), (sx, sy), by3 = bump["at"], bump["size"], bump["by"]
            g = fade * math.exp(-(((abs(x) - ax) / sx) ** 2) - ((y - ay) / sy) ** 2)
            bx, by, bz = bx + g * by3[0], by + g * by3[1], bz + g * by3[2]
        return (x + math.copysign(bx, x) if x else 0.0, y + by, z + bz)

    def find(self, x: float, y: float, t: float, phi: float) -> tuple[float, float]:
        """Row and angle of the front point over (x, y), by Newton's method from a guess. Rules: FAC-10."""
        h = 1e-5
        for _ in range(60):
            p, pt, pp = self.at(t, phi), self.at(t + h, phi), self.at(t, phi + h)
            m = np.array([[pt[0] - p[0], pp[0] - p[0]], [pt[1] - p[1], pp[1] - p[1]]]) / h
            step = np.linalg.solve(m, np.array([x - p[0], y - p[1]]))
            t += min(max(float(step[0]), -1.0), 1.0)
            phi += min(max(float(step[1]), -0.2), 0.2)
        return t, phi


def _slopes(t: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    d = np.diff(v) / np.diff(t)
    h = np.diff(t)
    m = np.empty_like(v)
    m[0], m[-1] = d[0], d[-1]
    m[1:-1] = (d[:-1] * h[1:] + d[1:] * h[:-1]) / (h[1:] + h[:-1])
    return m


def mouth_edge() -> list[Key]:
    """Grid vertices around the left half of the mouth, top to bottom (11). Rules: FAC-10."""
    low, high = MOUTH_ROWS
    top = [("grid", high, j) for j in range(MOUTH_COLUMNS)]
    side = [("grid", i, MOUTH_COLUMNS) for i in range(high, low - 1, -1)]
    return [*top, *side, *(("grid", low, j) for j in range(MOUTH_COLUMNS - 1, -1, -1))]


def eye_edge() -> list[Key]:
    """Grid vertices around the left eye (16): from the top centre outwards and round. Rules: FAC-10."""
    (low, high), (inner, outer) = EYE_ROWS, EYE_COLUMNS
    ring: list[Key] = [("grid", high, j) for j in range(inner, outer)]
    ring += [("grid", i, outer) for i in range(high, low, -1)]
    ring += [("grid", low, j) for j in range(outer, inner, -1)]
    ring += [("grid", i, inner) for i in range(low, high)]
    start = ring.index(("grid", high, (inner + outer) // 2))
    return ring[start:] + ring[:start]


class Skin:
    """Vertices by key and oriented triangles with palette names. Rules: FAC-10."""

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        self.loft = Loft(shape)
        self.last_column = len(shape["columns"]) - 1
        self.last_row = int(list(shape["rows"])[-1])
        self.points: dict[Key, Point] = {}
        self._quads: list[tuple[tuple[Key, ...], str]] = []
        self._grid()
        self._eye_rings()
        self._mouth_rings()
        self._nostril()
        self._finish()

    def _grid(self) -> None:
        shape, phis = self.shape, [math.radians(v) for v in self.shape["columns"]]
        params: dict[Key, tuple[float, float]] = {}
        for i in range(self.last_row):
            for j, phi in enumerate(phis):
                if not self._in_hole(i, j):
                    params["grid", i, j] = (float(i), phi)
        fixed: dict[Key, Point] = {}
        place: dict[Key, list[float]] = {}
        for text, xyz in [*shape["points"].items(), *shape["targets"].items()]:
            row, column = text.split(",")
            place["grid", int(row), int(column)] = xyz
        place |= dict(zip(mouth_edge(), shape["mouth"]["orbit"], strict=True))
        place |= dict(zip(eye_edge(), shape["eye"]["orbit"], strict=True))
        shift: dict[Key, tuple[float, float]] = {}
        for key, xyz in place.items():
            t0, phi0 = params[key]
            t, phi = self.loft.find(xyz[0], xyz[1], t0, phi0)
            shift[key] = (t - t0, phi - phi0)
            if len(xyz) == 3:
                fixed[key] = (xyz[0], xyz[1], xyz[2])
        shift = self._spread(params, shift)
        for key, (t0, phi0) in params.items():
            dt, dphi = shift[key]
            j = key[2]
            self.points[key] = fixed.get(key) or self.loft.at(t0 + dt, 0.0 if j == 0 else phi0 + dphi)
        for i in range(self.last_row):
            _, y, z = self.points["grid", i, self.last_column]
            self.points["grid", i, self.last_column] = (0.0, y, z)
        self.points["crown",] = self.loft.at(self.last_row, 0.0)
        _, y, z = self.points["grid", 0, 0]
        self.points["neck",] = (0.0, y, (z + self.points["grid", 0, self.last_column][2]) / 2)
        for i in range(self.last_row - 1):
            for j in range(self.last_column):
                if not self._cell_in_hole(i, j) and (i, j) != (11, 1):
                    corners = (("grid", i, j), ("grid", i, j + 1), ("grid", i + 1, j + 1), ("grid", i + 1, j))
                    self._quads.append((corners, "skin"))
        for j in range(self.last_column):
            top = self.last_row - 1
            self._quads.append(((("grid", top, j), ("grid", top, j + 1), ("crown",)), "skin"))
            self._quads.append(((("neck",), ("grid", 0, j + 1), ("grid", 0, j)), "skin"))

    def _in_hole(self, i: int, j: int) -> bool:
        mouth = MOUTH_ROWS[0] < i < MOUTH_ROWS[1] and j < MOUTH_COLUMNS
        return mouth or (EYE_ROWS[0] < i < EYE_ROWS[1] and EYE_COLUMNS[0] < j < EYE_COLUMNS[1])

    def _cell_in_hole(self, i: int, j: int) -> bool:
        mouth = MOUTH_ROWS[0] <= i < MOUTH_ROWS[1] and j < MOUTH_COLUMNS
        return mouth or (EYE_ROWS[0] <= i < EYE_ROWS[1] and EYE_COLUMNS[0] <= j < EYE_COLUMNS[1])

    def _spread(
        self, params: dict[Key, tuple[float, float]], given: dict[Key, tuple[float, float]]
    ) -> dict[Key, tuple[float, float]]:
        # Free grid vertices take the mean shift of their neighbours: the rows and columns bend smoothly round
        # the openings. The neck, the crown and the back of the head keep their places.
        shift = {key: given.get(key, (0.0, 0.0)) for key in params}
        free = [k for k in params if k not in given and 2 < k[1] < 24 and k[2] < 9]
        near = {}
        for key in free:
            i, j = key[1], key[2]
            ring = [("grid", i - 1, j), ("grid", i + 1, j), ("grid", i, abs(j - 1)), ("grid", i, j + 1)]
            near[key] = [k for k in ring if k in params]
        for _ in range(400):
            for key in free:
                n = near[key]
                t = sum(shift[k][0] for k in n) / len(n)
                shift[key] = (t, 0.0 if key[2] == 0 else sum(shift[k][1] for k in n) / len(n))
        return shift

    def lid_opening(self, k: int, up: float, down: float, half_width: float) -> tuple[float, float]:
        """Offset (x, y) in mm of ring position `k` from the eye centre on an almond-shaped ring. Rules: FAC-3."""
        # From the top centre (0) over the outer corner (4) and the bottom (8) to the inner corner (12).
        angle = 2 * math.pi * k / EYE_RING
        x = half_width * math.copysign(abs(math.sin(angle)) ** 0.9, math.sin(angle))
        s = min(abs(x) / half_width, 1.0)
        base = self.shape["eye"]["corner_y"] * s * s
        arch = (1 - s * s) ** 0.75
        if k % 8 == 4:
            return x, base
        return x, base + (up if math.cos(angle) > 0 else -down) * arch

    def _eye_rings(self) -> None:
        eye = self.shape["eye"]
        cx, cy, cz = eye["centre"]
        iris, half = eye["iris"], eye["half_width"]
        rings = [
            (eye["outer"]["up"], eye["outer"]["down"], eye["outer"]["half_width"], eye["outer"]["radius"]),
            (eye["middle"]["up"], eye["middle"]["down"], eye["middle"]["half_width"], eye["middle"]["radius"]),
            (iris, iris, half, eye["edge_radius"]),
            (iris, iris, half, eye["rim_radius"]),
        ]
        for r, (up, down, width, radius) in enumerate(rings, 1):
            for k in range(EYE_RING):
                x, y = self.lid_opening(k, up, down, width)
                if r == 4:
                    x, y = x * 0.97, y * 0.97
                x, y = (0.0 if k % 8 == 0 else x), y
                z = math.sqrt(max(radius * radius - x * x - y * y, 9.0))
                self.points["lid", 1, r, k] = (cx + x, cy + y, cz + z)
        self.points["socket", 1] = (cx, cy, cz - eye["radius"] - 1)
        edge = eye_edge()
        for k in range(EYE_RING):
            n = (k + 1) % EYE_RING
            self._quads.append(((edge[k], ("lid", 1, 1, k), ("lid", 1, 1, n), edge[n]), "skin"))
            for r, colour in ((1, "lid"), (2, "lid"), (3, "lid_edge")):
                ring = (("lid", 1, r, k), ("lid", 1, r + 1, k), ("lid", 1, r + 1, n), ("lid", 1, r, n))
                # The edge of the upper lid carries the lashes.
                lash = r == 3 and (k < 4 or k >= 12)
                self._quads.append((ring, "lash" if lash else colour))
            self._quads.append(((("lid", 1, 4, k), ("socket", 1), ("lid", 1, 4, n)), "lid_edge"))

    def _mouth_rings(self) -> None:
        mouth, origin = self.shape["mouth"], self.shape["origin"]
        half = MOUTH_RING // 2
        line = mouth["inner"][half // 2][1]
        for r, name in enumerate(("border", "outer", "middle", "inner"), 1):
            for k, xyz in enumerate(mouth[name]):
                self.points["lip", r, k] = (xyz[0], xyz[1], xyz[2])
        gum, seal = mouth["gum"], mouth["seal"]
        for k in range(half + 1):
            a = math.pi * k / half
            s, c = (0.0 if k % half == 0 else math.sin(a)), math.cos(a)
            x, _, z = mouth["inner"][k]
            # Behind the closed lips the two sides overlap, so that the teeth do not shine through the line.
            self.points["lip", 5, k] = (x * 0.99, line - seal["overlap"] * c, z - seal["depth"][k > half // 2])
            z = gum["corner"] + (gum["front"] - gum["corner"]) * c * c
            self.points["lip", 6, k] = (gum["half_width"] * s, line + gum["up"] * c, z)
            for r, (width, height, depth) in enumerate(mouth["bag"], 7):
                self.points["lip", r, k] = (width * s, line + height * c, depth)
        self.points["spine",] = (origin[0], origin[1], origin[2])
        edge = mouth_edge()
        colours = ("skin", "lip", "lip", "inner_lip", "inner_lip", "mouth", "mouth")
        for k in range(half):
            n = k + 1
            self._quads.append(((edge[k], ("lip", 1, k), ("lip", 1, n), edge[n]), "skin"))
            for r, colour in enumerate(colours, 1):
                ring = (("lip", r, k), ("lip", r + 1, k), ("lip", r + 1, n), ("lip", r, n))
                self._quads.append((ring, colour))
            last = len(colours) + 1
            self._quads.append(((("lip", last, k), ("spine",), ("lip", last, n)), "mouth"))

    def _nostril(self) -> None:
        corners = (("grid", 11, 1), ("grid", 11, 2), ("grid", 12, 2), ("grid", 12, 1))
        pts = np.array([self.points[c] for c in corners])
        mid, inset = pts.mean(axis=0), self.shape["nostril"]["inset"]
        hole = mid + (pts - mid) * inset + np.array(self.shape["nostril"]["lift"])
        for k in range(4):
            self.points["nostril", 1, k] = (float(hole[k][0]), float(hole[k][1]), float(hole[k][2]))
        inner = tuple(("nostril", 1, k) for k in range(4))
        self._quads.append((inner, "nostril"))
        for k in range(4):
            n = (k + 1) % 4
            self._quads.append(((corners[k], corners[n], inner[n], inner[k]), "skin"))

    def _finish(self) -> None:
        left = list(self.points)
        for key in left:
            twin = mirror_key(key)
            x, y, z = self.points[key]
            if key[0] == "grid" and key[2] == self.last_column:
                continue
            if twin != key:
                self.points[twin] = (-x, y, z)
        self.keys = list(self.points)
        self.index = {key: i for i, key in enumerate(self.keys)}
        self.vertices = np.array([self.points[k] for k in self.keys])
        self.faces: list[tuple[int, int, int]] = []
        self.colours: list[str] = []
        for corners, colour in self._quads:
            for tri in self._split(corners):
                self.faces.append((self.index[tri[0]], self.index[tri[1]], self.index[tri[2]]))
                other = [self.twin(k) for k in tri]
                self.faces.append((self.index[other[0]], self.index[other[2]], self.index[other[1]]))
                self.colours += [colour, colour]

    def twin(self, key: Key) -> Key:
        """The key of the mirrored vertex; the back of the head and the centre are their own. Rules: FAC-10."""
        if key[0] == "grid" and key[2] == self.last_column:
            return key
        return mirror_key(key)

    def _split(self, corners: tuple[Key, ...]) -> list[tuple[Key, ...]]:
        if len(corners) == 3:
            return [corners]
        a, b, c, d = corners
        p = [np.array(self.points[k]) for k in corners]
        # The shorter diagonal; the margin keeps a tie from depending on the last bit.
        if float(np.linalg.norm(p[0] - p[2])) <= float(np.linalg.norm(p[1] - p[3])) + 1e-6:
            return [(a, b, c), (a, c, d)]
        return [(a, b, d), (b, c, d)]
