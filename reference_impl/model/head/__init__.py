"""The shipped head: an original model of about 1,500 vertices, made by `build`.

Rules: FAC-3, FAC-10.
Not here: evaluation (`fat`), deformers, pictures.

Coordinates are millimetres from feature point 7.1, right-handed: x to the face's left, y up, z out of the face.
`head.json` is generated; change `shape.json`, `motion.json`, `poses.json` or `palette.json` and run `build`.
"""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.model.feature_motion import HEAD_ORDERS

# AMB-FAC-2.
HEAD_ORDER: Final = "yaw-pitch-roll"
HEAD_FILE: Final = Path(__file__).with_name("head.json")
_POSES_FILE: Final = HEAD_FILE.with_name("poses.json")


def load_head(order: str = HEAD_ORDER) -> dict[str, Any]:
    """The head as a FAT document, ready for `fat_from_json`, and its looks.

    Rules: FAC-5 (AMB-FAC-2), FAC-10, FAT-1, FAT-9. `order`: of the head's rotations, outermost first.
    Beside the document's own keys (`fapu`, `meshes`, `tables`, `transforms`):

    `face`: the face definition (`head_definition`). `palette`: {name: [r, g, b]}, 0..255, sRGB. `colors`: per mesh
    one palette index per face. Meshes: skin, left_eye, right_eye, left_brow, right_brow, left_ear, right_ear,
    teeth_upper, teeth_lower, tongue, hair; all closed, faces counter-clockwise from outside. The vertices of the
    eyeballs are relative to their centres: the nodes `left_eye_yaw` and `right_eye_yaw` put them in their places.
    """
    document: dict[str, Any] = json.loads(HEAD_FILE.read_bytes())
    if order != HEAD_ORDER:
        nodes, meshes = document["transforms"], document["transforms"][_chain(HEAD_ORDER)[-1]]["meshes"]
        rest = {name: node for name, node in nodes.items() if name not in _chain(order)}
        for node in rest.values():
            if node["parent"] == _chain(HEAD_ORDER)[-1]:
                node["parent"] = _chain(order)[-1]
        document["transforms"] = head_nodes(meshes, order) | rest
    return document


def head_nodes(meshes: list[str], order: str = HEAD_ORDER) -> dict[str, Any]:
    """The nodes that turn the head, one per axis, as in figure 4 of the paper; the innermost holds the meshes.

    Rules: FAC-5 (AMB-FAC-2), FAT-9. `order`: one of HEAD_ORDERS. Raises `InputFormat` for another.
    """
    if order not in HEAD_ORDERS:
        raise InputFormat("FAC-5", "order", value=order, allowed=", ".join(sorted(HEAD_ORDERS)))
    chain = _chain(order)
    above = {name: {"parent": parent} for parent, name in pairwise(chain)}
    return {chain[0]: {}, **above, chain[-1]: {**above[chain[-1]], "meshes": meshes}}


def _chain(order: str) -> list[str]:
    return [f"head_{axis}" for axis in order.split("-")]


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
