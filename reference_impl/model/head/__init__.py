"""The shipped head: an original model of about 1,500 vertices, made by `build`.

Rules: FAC-3, FAC-10.
Not here: evaluation (`fat`), deformers, pictures.

Coordinates are millimetres from feature point 7.1, right-handed: x to the face's left, y up, z out of the face.
`head.json` is generated; change `shape.json`, `motion.json`, `poses.json` or `palette.json` and run `build`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

HEAD_FILE: Final = Path(__file__).with_name("head.json")
_POSES_FILE: Final = HEAD_FILE.with_name("poses.json")


def load_head() -> dict[str, Any]:
    """The head as a FAT document, ready for `fat_from_json`, and its looks.

    Rules: FAC-10, FAT-1, FAT-9. Beside the document's own keys (`fapu`, `meshes`, `tables`, `transforms`):

    `face`: the face definition (`head_definition`). `palette`: {name: [r, g, b]}, 0..255, sRGB. `colors`: per mesh
    one palette index per face. Meshes: skin, left_eye, right_eye, left_brow, right_brow, left_ear, right_ear,
    teeth_upper, teeth_lower, tongue, hair; all closed, faces counter-clockwise from outside. The vertices of the
    eyeballs are relative to their centres: the nodes `left_eye_yaw` and `right_eye_yaw` put them in their places.
    """
    document: dict[str, Any] = json.loads(HEAD_FILE.read_bytes())
    return document


def head_definition() -> dict[str, Any]:
    """The 84 feature points of the head with mesh and vertex, eye centres, iris and pupil diameters.

    Rules: FAC-2, FAC-3, FAC-10. The form of `face_definition_from_json`; positions in mm in the neutral face.
    """
    definition: dict[str, Any] = load_head()["face"]
    return definition


def feature_vertices() -> dict[str, tuple[str, int]]:
    """Mesh and vertex of every feature point. Rules: FAC-2, FAC-10."""
    points = head_definition()["points"]
    return {name: (entry["mesh"], entry["vertex"]) for name, entry in points.items()}


def head_poses() -> tuple[dict[int, dict[int, int]], dict[int, dict[int, int]]]:
    """Visemes and expressions as low-level FAPs at full amplitude (63).

    Rules: FAC-6, FAC-10. Two mappings {select: {FAP: value}}, visemes 1..14 and expressions 1..6: the ones that
    the tables of FAP 1 and 2 of the head are made from.
    """
    poses = json.loads(_POSES_FILE.read_bytes())
    visemes, expressions = (
        {int(select): {int(fap): value for fap, value in pose.items()} for select, pose in poses[kind].items()}
        for kind in ("visemes", "expressions")
    )
    return visemes, expressions
