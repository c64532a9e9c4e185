"""The shipped head as data of a page, with all that poses it.

Rules: FAC-3, FAC-10, FAT-2..5, FAT-9. The page poses by the same hinges as `fat_bulk`; visemes and expressions come to
it as low-level FAPs (FAC-6).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from snhc.analyzer.face_scene import FaceModel, fat_readings, load_model
from snhc.reference_impl.model.fapu import fap_unit_names
from snhc.reference_impl.model.fat_bulk import hinges
from snhc.reference_impl.syntax.element import Readings

from .packing import packed

_FIRST_LOW: Final = 3


def head_data(readings: Readings) -> dict[str, object]:
    """Vertices, triangles, colours, hinges and nodes.

    Rules: FAT-2..5, FAT-9. All meshes in one numbering. `hinges`: FAP, start, side, length (0: no end), sign, number of
    vertices; `moved`, `by`: their vertices and displacements per FAP unit, one after the other. `nodes`: by name, with
    the moves of the FAPs in the order of application; `under`: per mesh its nodes, innermost first, and its vertices.
    """
    return _head(load_model(readings=readings), readings)


def _head(model: FaceModel, readings: Readings) -> dict[str, object]:
    document = model.document
    first: dict[str, int] = {}
    vertices, faces, colours = [], [], []
    count = 0
    for name, mesh in document.meshes.items():
        first[name] = count
        vertices.append(mesh.vertices)
        faces.append(mesh.faces + count)
        colours.append(model.colours[name])
        count += len(mesh.vertices)
    rows: list[list[float]] = []
    moved, by = [], []
    units = [document.fapu.unit(name) or 0.0 for name in fap_unit_names()]
    for table in document.tables:
        if table.fap_id < _FIRST_LOW:
            continue
        unit = units[table.fap_id - 1]
        for item in table.meshes:
            if not len(item.coord_index):
                continue
            for interval, hinge in hinges(item.interval_borders, table.fap_id - 1, fat_readings(readings)):
                length = 0.0 if np.isinf(hinge.length) else hinge.length
                rows.append([table.fap_id, hinge.start, hinge.side, length, hinge.sign, len(item.coord_index)])
                moved.append(item.coord_index + first[item.mesh])
                by.append(unit * item.displacements[:, interval])
    nodes = {
        node.name: {
            "parent": node.parent,
            "translation": list(node.translation),
            "rotation": list(node.rotation),
            "scale": list(node.scale),
            "moves": [
                [table.fap_id, item.field, units[table.fap_id - 1], *item.definition]
                for table in sorted(document.tables, key=lambda table: table.fap_id)
                for item in table.transforms
                if item.node == node.name
            ],
        }
        for node in document.transforms.values()
    }
    return {
        "vertices": packed("f", np.concatenate(vertices).ravel()),
        "triangles": packed("H", np.concatenate(faces).ravel()),
        "colours": packed("B", np.concatenate(colours).ravel()),
        "hinges": packed("f", np.array(rows).ravel()),
        "moved": packed("H", np.concatenate(moved)),
        "by": packed("f", np.concatenate(by).ravel()),
        "nodes": nodes,
        "meshes": [[name, first[name], len(mesh.vertices)] for name, mesh in document.meshes.items()],
        "under": {mesh: node.name for node in document.transforms.values() for mesh in node.meshes},
    }
