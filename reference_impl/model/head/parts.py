"""The other parts of the shipped head: eyeballs, teeth, tongue, ears, brows, hair.

Rules: FAC-3, FAC-10.
Not here: the skin (`skin`), the motions (`mouth`, `face`).

Each maker returns a `Part`: a closed mesh with outward faces, a palette name per face, and the vertices that are
feature points. Numbers come from `shape.json`, in millimetres, eyes at y = 0 (eyeballs: from their own centre).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from .skin import Loft, Point, Shape, Skin

Face = tuple[int, int, int]


@dataclass(slots=True)
class Part:
    """A mesh under construction. Rules: FAC-10.

    `vertices` in mm, `faces` counter-clockwise from outside, `colours` one palette name per face, `marks` feature
    points (number as text) to vertex.
    """

    vertices: list[Point] = field(default_factory=list)
    faces: list[Face] = field(default_factory=list)
    colours: list[str] = field(default_factory=list)
    marks: dict[str, int] = field(default_factory=dict)

    def add(self, points: Sequence[Point]) -> list[int]:
        """Append vertices; returns their indices. Rules: FAC-10."""
        first = len(self.vertices)
        self.vertices += points
        return list(range(first, len(self.vertices)))

    def band(self, outer: Sequence[int], inner: Sequence[int], colour: str, *, closed: bool = True) -> None:
        """Join two rings that both run clockwise when seen from outside, `inner` in front. Rules: FAC-10."""
        n = len(outer)
        for k in range(n if closed else n - 1):
            a, b, c, d = outer[k], inner[k], inner[(k + 1) % n], outer[(k + 1) % n]
            p = self.vertices
            if math.dist(p[a], p[c]) <= math.dist(p[b], p[d]) + 1e-6:
                self._take([(a, b, c), (a, c, d)], colour)
            else:
                self._take([(a, b, d), (b, c, d)], colour)

    def fan(self, ring: Sequence[int], centre: int, colour: str) -> None:
        """Close a ring that runs clockwise when seen from outside. Rules: FAC-10."""
        n = len(ring)
        self._take([(ring[k], centre, ring[(k + 1) % n]) for k in range(n)], colour)

    def _take(self, faces: list[Face], colour: str) -> None:
        self.faces += faces
        self.colours += [colour] * len(faces)

    def mirrored(self, marks: dict[str, str]) -> Part:
        """The same part on the other side of the head; `marks` renames feature points. Rules: FAC-10."""
        return Part(
            [(-x if x else 0.0, y, z) for x, y, z in self.vertices],
            [(a, c, b) for a, b, c in self.faces],
            list(self.colours),
            {marks[k]: v for k, v in self.marks.items()},
        )


def eyeball(shape: Shape) -> Part:
    """Eyeball about its own centre: pupil a third of the iris, gaze along +z. Rules: FAC-3."""
    spec, radius, part = shape["iris"], shape["eye"]["radius"], Part()
    n = spec["around"]

    def ring(r: float, z: float) -> list[int]:
        turns = [math.pi * (2 * k + 1) / n for k in range(n)]
        return part.add([(r * math.sin(a), r * math.cos(a), z) for a in turns])

    centre = part.add([(0.0, 0.0, radius)])[0]
    part.marks["pupil"] = centre
    inner: list[int] = []
    for r, colour in spec["rings"]:
        outer = ring(r, math.sqrt(radius * radius - r * r))
        if inner:
            part.band(outer, inner, colour)
        else:
            part.fan(outer, centre, colour)
        inner = outer
    part.fan(inner[::-1], part.add([(0.0, 0.0, -radius)])[0], "sclera")
    return part


def teeth(shape: Shape, which: str) -> Part:
    """One row of teeth as a closed arch; upper and lower touch in the neutral face. Rules: FAC-3."""
    spec, part = shape["teeth"], Part()
    n, (top, bottom) = spec["around"], spec[which]
    inset = spec["inset"][which == "lower"]
    sections = []
    for k in range(n):
        u = 2 * k / (n - 1) - 1
        a = u * 1.35
        s, c = math.sin(a) / math.sin(1.35), (math.cos(a) - math.cos(1.35)) / (1 - math.cos(1.35))
        corner = []
        root, bite = spec["thickness"]
        inner_top, inner_bottom = (root, bite) if which == "upper" else (bite, root)
        for y, deep in ((top, 0.0), (bottom, 0.0), (bottom, inner_bottom), (top, inner_top)):
            w = spec["half_width"] - inset - deep
            z = spec["front"] - spec["depth"] + (spec["depth"] - inset - deep) * c
            corner.append((w * s if k != n // 2 else 0.0, y, z))
        sections.append(part.add(corner))
    for k, (a4, b4) in enumerate(pairwise(sections)):
        # Neighbouring teeth differ a little in shade.
        part.band(a4[::-1], b4[::-1], "tooth" if min(k, n - 2 - k) % 2 else "tooth_dark")
    for end, flip in ((sections[0], True), (sections[-1], False)):
        a, b, c4, d = end[::-1] if flip else end
        part.faces += [(a, b, c4), (a, c4, d)]
        part.colours += ["tooth", "tooth"]
    middle = sections[n // 2]
    part.marks = {"9.8": middle[0], "9.10": middle[1]} if which == "upper" else {"9.11": middle[0], "9.9": middle[1]}
    return part


def tongue(shape: Shape) -> Part:
    """Tongue: flat, its tip at the boundary of the teeth. Rules: FAC-3."""
    spec, part = shape["tongue"], Part()
    rings = []
    top = spec["top"]
    for z, w, h in spec["sections"]:
        edge = [
            (0.0, 0.0),
            (0.6, -0.02),
            (1.0, -0.35),
            (0.55, -1.0),
            (0.0, -1.0),
            (-0.55, -1.0),
            (-1.0, -0.35),
            (-0.6, -0.02),
        ]
        rings.append(part.add([(w * x, top + h * y, z) for x, y in edge]))
    tip = part.add([(spec["tip"][0], spec["tip"][1], spec["tip"][2])])[0]
    part.fan(rings[0], tip, "tongue")
    for front, back in pairwise(rings):
        part.band(back, front, "tongue")
    z, w, h = spec["sections"][-1]
    part.fan(rings[-1][::-1], part.add([(0.0, top - h / 2, z - 6)])[0], "tongue")
    body = rings[3]
    part.marks = {"6.1": tip, "6.2": body[0], "6.3": body[2], "6.4": body[6]}
    return part


def ear(shape: Shape) -> Part:
    """Left ear: a dished disc with its foot in the head. Rules: FAC-10."""
    spec, part = shape["ear"], Part()
    n, (cz, cy) = spec["around"], spec["centre"]
    lean = math.tan(math.radians(spec["tilt"]))

    def place(x: float, z: float, y: float) -> Point:
        # The ear leans back by a shear, which keeps its back at half height (table 6, 10.3), and flares: its back
        # edge stands farther from the head than its front edge.
        return (x - spec["flare"] * (z + spec["hinge"]), cy + y, cz + z - y * lean)

    def ring(name: str) -> list[int]:
        w, h = spec[name]["size"]
        points = []
        for k in range(n):
            a = 2 * math.pi * k / n
            s, c = math.sin(a), math.cos(a)
            # Narrower towards the lobe. Seen from the left, front (+z) is on the left: clockwise is top, back, lobe.
            narrow = 1 if c > 0 else 1 - (1 - spec["lobe"]) * c * c
            points.append(place(spec[name]["x"], -w * s * narrow, h * c))
        return part.add(points)

    foot, back, front, inner = (ring(name) for name in ("base", "back", "front", "inner"))
    z, y = spec["hollow"]["at"]
    part.band(foot, back, "ear")
    part.band(back, front, "ear")
    part.band(front, inner, "ear")
    part.fan(inner, part.add([place(spec["hollow"]["x"], z, y)])[0], "ear_inner")
    part.fan(foot[::-1], part.add([place(spec["base"]["x"] - 8, 0.0, 0.0)])[0], "ear")
    # Ring positions: 0 top, 3 back, 6 lobe, 9 front.
    part.marks = {
        "10.1": front[0], "10.3": back[3], "10.5": front[6], "10.7": back[8], "10.9": back[11],
    }  # fmt: skip
    return part


def brow(shape: Shape, loft: Loft) -> Part:
    """Left eyebrow: a thin strip over the skin. Rules: FAC-10."""
    spec, part = shape["brow"], Part()
    n = spec["along"]
    (x0, y0), (x1, y1), (x2, y2) = spec["inner"], spec["middle"], spec["outer"]
    sections = []
    for k in range(n):
        u = k / (n - 1)
        a, b, c = (1 - u) * (1 - 2 * u), 4 * u * (1 - u), u * (2 * u - 1)
        x, y = a * x0 + b * x1 + c * x2, a * y0 + b * y1 + c * y2
        width = a * spec["width"][0] + b * spec["width"][1] + c * spec["width"][2]
        corner = []
        for dy, lift in ((-width, spec["lift"][0]), (-width / 2, spec["lift"][1]), (0.0, spec["lift"][0])):
            px, py, pz = loft.at(*loft.find(x, y + dy, 20.0, math.asin(x / 76)))
            corner.append((px, py, pz + lift))
        sections.append(part.add(corner))
    for front, back in pairwise(sections):
        part.band(front, back, "brow")
    for end in (sections[0], sections[-1][::-1]):
        part.faces.append((end[0], end[1], end[2]))
        part.colours.append("brow")
    part.marks = {"4.1": sections[0][2], "4.3": sections[n // 2][2], "4.5": sections[-1][2]}
    return part


def hair(shape: Shape, skin: Skin) -> Part:
    """Hair: a cap over the skull from the hairline to the crown, closed by a floor inside the head. Rules: FAC-10."""
    spec, loft, part = shape["hair"], skin.loft, Part()
    half = len(spec["columns"])
    columns = [*range(half), *range(half - 2, 0, -1)]
    crown = skin.points["crown",]
    rings: list[list[int]] = []
    for step, rise in zip(spec["steps"], spec["rise"], strict=True):
        points = []
        for k, j in enumerate(columns):
            phi, line = math.radians(spec["columns"][j]), spec["line"][j]
            t = line + (skin.last_row - line) * step
            x, y, z = loft.at(t, phi)
            # Outwards from a point inside the skull, thicker towards the crown.
            d = (x, y - 25.0, z + 10.0)
            grow = rise * (spec["thickness"] + (spec["crown"] - spec["thickness"]) * step) / math.hypot(*d)
            x, y, z = x + d[0] * grow, y + d[1] * grow, z + d[2] * grow
            side = 0.0 if j in (0, half - 1) else 1.0 if k < half else -1.0
            points.append((side * x, y, z))
        rings.append(part.add(points))
    top = part.add([(crown[0], crown[1] + spec["crown"], crown[2])])[0]
    # From above the columns run front, left, back: counter-clockwise, so the rings are turned for `band`.
    for low, high in pairwise(rings):
        part.band(low[::-1], high[::-1], "hair")
    part.fan(rings[-1][::-1], top, "hair")
    part.fan(rings[0], part.add([(0.0, 30.0, -12.0)])[0], "hair")
    part.marks = {"11.5": top, "11.1": rings[1][0], "11.3": rings[1][4], "11.2": rings[1][-4]}
    return part
