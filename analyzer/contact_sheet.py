"""Contact sheets of the shipped head: `python -m snhc.analyzer.contact_sheet -o docs/pictures`.

Rules: FAC-4, FAC-6, FAC-10.

Every FAP at an amplitude that shows what it does, all visemes and expressions, the head from all sides. Drawn in
software, so that the files are the same wherever they are made.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from snhc.reference_impl.model.fat import FrameLike
from snhc.reference_impl.tables import expressions, fap_table, visemes

from .face_pictures import png, sheet
from .face_render import Camera, Picture, SoftwareRenderer
from .face_scene import FaceScene, load_model, still

_COLOURS: Final = 250
# Cameras by what they look at: azimuth, elevation, focus, half of the height, in millimetres.
_HEAD: Final = Camera(0, 0, (0, 18, 10), 155)
_MOUTH: Final = Camera(10, 0, (0, -30, 60), 60)
_INSIDE: Final = Camera(0, 0, (0, -40, 60), 38)
_CHIN: Final = Camera(25, 0, (0, -30, 60), 75)
_CHIN_FRONT: Final = Camera(0, 0, (0, -30, 60), 75)
_CHIN_SIDE: Final = Camera(80, 0, (0, -30, 60), 75)
_LIPS_SIDE: Final = Camera(70, 0, (0, -30, 60), 60)
_EYES: Final = Camera(0, 0, (0, 42, 60), 52)
_EYES_SIDE: Final = Camera(70, 0, (0, 42, 60), 52)
_NOSE: Final = Camera(20, 0, (0, 0, 60), 55)
# An open mouth, to see the tongue in.
_OPEN: Final = {3: 500, 5: -700, 10: -500, 11: -500, 52: -600, 57: -450, 58: -450}
_UNIT_AMPLITUDE: Final = {"ENS": 250, "ES": 150, "MW": 150, "MNS": 250, "IRISD": 300, "AU": 35_000, "na": 0}
_AMPLITUDE: Final = {
    3: 500, 4: -200, 5: -300, 6: 60, 7: 60, 8: -200, 9: -200, 10: -300, 11: -300, 14: 400, 16: 300, 17: 300, 18: 300,
    19: 700, 20: 700, 25: 30_000, 26: 30_000, 27: 80, 28: 80, 29: 250, 30: 250, 39: 130, 40: 130, 41: 250, 42: 250,
    44: 300, 45: 300, 46: 300, 47: 90_000, 49: 50_000, 52: 300, 57: 300, 58: 300, 61: 100, 62: 100,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture of a sheet. Rules: FAC-10."""

    label: str
    frame: FrameLike
    camera: Camera


def _camera(fap: int) -> Camera:
    if fap == 14:
        return _CHIN_SIDE
    if fap == 15:
        return _CHIN_FRONT
    if fap in (16, 17):
        return _LIPS_SIDE
    if fap in (27, 28):
        return _EYES_SIDE
    if fap in (3, 18) or 39 <= fap <= 42:
        return _CHIN
    if 19 <= fap <= 38:
        return _EYES
    if 43 <= fap <= 47:
        return _INSIDE
    if 48 <= fap <= 50 or fap >= 65:
        return _HEAD
    return _NOSE if fap >= 61 else _MOUTH


def fap_shots() -> list[Shot]:
    """FAPs 3..68, one shot each. Rules: FAC-4."""
    out = []
    for record in fap_table()[2:]:
        fap = record.number
        value = _AMPLITUDE.get(fap, _UNIT_AMPLITUDE[record.unit])
        given = {**_OPEN, fap: value} if 43 <= fap <= 47 else {fap: value}
        out.append(Shot(f"{fap} {record.name} {value}", still(given), _camera(fap)))
    return out


def sheets() -> Iterator[tuple[str, list[Shot], tuple[int, int], int]]:
    """Name, shots, size of a picture, columns of every sheet. Rules: FAC-4, FAC-6, FAC-10."""
    around = (("front", 0, 0), ("three-quarter", 35, 5), ("side", 90, 0), ("back", -140, 10), ("below", 0, -35))
    faces = [Shot(name, still(), Camera(a, e, _HEAD.focus, 155)) for name, a, e in (*around, ("above", 20, 40))]
    yield "head", faces, (250, 310), 6
    moods = [
        Shot(
            f"{record.expression_select} {record.label}",
            still(expression=(record.expression_select, 63, 0, 0)),
            Camera(12, 0, (0, 10, 40), 125),
        )
        for record in expressions()
    ]
    yield "expressions", moods, (250, 290), 7
    mouths = [
        Shot(
            f"{r.viseme_select} {r.label}: {r.example}",
            still(viseme=(r.viseme_select, 0, 63)),
            Camera(15, 0, (0, -25, 60), 72),
        )
        for r in visemes()
    ]
    yield "visemes", mouths, (230, 240), 5
    shots = fap_shots()
    yield "faps-03-35", shots[:33], (215, 205), 7
    yield "faps-36-68", shots[33:], (215, 205), 7


def draw(shots: Sequence[Shot], size: tuple[int, int], columns: int, scene: FaceScene) -> Picture:
    """One sheet. Rules: FAC-10. `size`: of each picture, width and height in pixels."""
    renderer = SoftwareRenderer(scene.model, size)
    poses = scene.each([shot.frame for shot in shots])
    pictures = [renderer.picture(pose, shot.camera) for pose, shot in zip(poses, shots, strict=True)]
    return sheet(pictures, [shot.label for shot in shots], columns)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the sheets as PNG files into a folder. Rules: FAC-10."""
    parser = argparse.ArgumentParser(prog="contact_sheet", description="Contact sheets of the shipped head.")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the PNG files")
    folder: Path = parser.parse_args(arguments).output
    folder.mkdir(parents=True, exist_ok=True)
    scene = FaceScene(load_model())
    for name, shots, size, columns in sheets():
        (folder / f"{name}.png").write_bytes(png(draw(shots, size, columns, scene), _COLOURS))
    return 0


if __name__ == "__main__":
    sys.exit(main())
