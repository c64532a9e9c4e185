"""Decoded meshes as files: CSV, npz, and mesh formats through trimesh. The forms stand in docs/formats-mesh.md.

Rules: CNF-1, CNF-22, CNF-25. Not here: NDJSON (`decoded`), pictures (`drawing`, `rasteriser`). numpy and trimesh are
imported when they are needed.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable, Sequence
from typing import Any, Final, final

from ..bitstream.errors import EncodeError, ResourceLimit
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..documents.archive import write_npz
from ..syntax.element import DEFAULT_READINGS, Readings
from .records import MeshFrame

CSV_COLUMNS: Final = ("index", "time", "intra", "node", "x", "y")
MODEL_FORMATS: Final = ("obj", "ply", "stl", "off", "glb")

Write = Callable[[bytes], None]


def csv_header() -> str:
    """The first line of the CSV form, with its newline. Rules: CNF-25."""
    return ",".join(CSV_COLUMNS) + "\n"


def csv_rows(frame: MeshFrame) -> str:
    """One line per node, none for a frame without nodes; positions in half pixels. Rules: CNF-1, CNF-25."""
    head = f"{frame.index},{frame.time[0]}/{frame.time[1]},{1 if frame.intra else 0}"
    return "".join(f"{head},{node},{x},{y}\n" for node, (x, y) in enumerate(frame.nodes))


@final
class MeshArrays:
    """Collects frames and writes them as a numpy archive.

    Rules: CNF-1, CNF-22, CNF-25.

    What differs in length from frame to frame is one long array with offsets. Raises ResourceLimit past
    `limits.collected_planes` frames.
    """

    def __init__(self, readings: Readings = DEFAULT_READINGS, limits: Limits = DEFAULT_LIMITS) -> None:
        self._readings = readings
        self._limits = limits
        self._time = array("q")
        self._intra = array("b")
        self._long: dict[str, array[int]] = {name: array("q") for name in ("nodes", "triangles", "order")}
        self._offsets: dict[str, array[int]] = {name: array("q", [0]) for name in self._long}

    def add(self, frame: MeshFrame) -> None:
        """Take in the next frame. Rules: CNF-1, CNF-22. Raises OverflowError as `FaceColumns.add`."""
        if len(self._intra) >= self._limits.collected_planes:
            raise ResourceLimit(
                "CNF-22", "frames kept", value=len(self._intra) + 1, allowed=f"at most {self._limits.collected_planes}"
            )
        self._time.extend(array("q", frame.time))
        self._intra.append(frame.intra)
        nodes, triangles = self._long["nodes"], self._long["triangles"]
        for node in frame.nodes:
            nodes.extend(node)
        for triangle in frame.triangles or ():
            triangles.extend(triangle)
        self._long["order"].extend(frame.order or ())
        for name, width in (("nodes", 2), ("triangles", 3), ("order", 1)):
            self._offsets[name].append(len(self._long[name]) // width)

    def write(self, write: Write) -> None:
        """The archive, piece by piece. Rules: CNF-25."""
        import numpy as np

        arrays: dict[str, Any] = {
            "time": np.array(self._time, np.int64).reshape(-1, 2),
            "intra": np.array(self._intra, np.bool_),
        }
        for name, width in (("nodes", 2), ("triangles", 3), ("order", 1)):
            column = np.array(self._long[name], np.int64)
            arrays[name] = column.reshape(-1, width) if width > 1 else column
            arrays[f"{name}_offsets"] = np.array(self._offsets[name], np.int64)
        header = {"format": "snhc-decoded-npz", "version": 1, "kind": "mesh", "readings": self._readings.chosen}
        arrays["header"] = np.array(json.dumps(header))
        write_npz(arrays, write)


def model_bytes(nodes: Sequence[tuple[int, int]], triangles: Sequence[tuple[int, int, int]], format: str) -> bytes:
    """One instant of a mesh as a file of a mesh format, in pixels, y up and z 0, so that viewers show it upright.

    Rules: CNF-25. `nodes`: half pixels. `triangles`: clockwise on screen; their faces look along +z, to the viewer.
    `format`: one of MODEL_FORMATS. Raises EncodeError.
    """
    import numpy as np
    import trimesh

    if format not in MODEL_FORMATS:
        raise EncodeError("CNF-25", "format", value=format, allowed=", ".join(MODEL_FORMATS))
    if not nodes or not triangles:
        raise EncodeError("CNF-25", "mesh", value="no triangles", allowed="a frame with a mesh")
    flat = np.array(nodes, np.float64) * (0.5, -0.5)
    vertices = np.column_stack([flat + 0.0, np.zeros(len(flat))])
    # What is clockwise on screen is so with y up too, and faces are counter-clockwise as seen from outside.
    faces = np.array(triangles, np.int64)[:, [0, 2, 1]]
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    exported: Any = mesh.export(file_type=format)
    return exported.encode() if isinstance(exported, str) else bytes(exported)


@final
class ModelFrames:
    """Which triangles stand for each frame: those of the last intra plane. Rules: MSH-16, CNF-25."""

    def __init__(self) -> None:
        self._triangles: tuple[tuple[int, int, int], ...] = ()

    def model(self, frame: MeshFrame, format: str) -> bytes | None:
        """The next frame as a file, None for one without a mesh. Rules: MSH-16, CNF-25."""
        if frame.triangles is not None:
            self._triangles = frame.triangles
        return model_bytes(frame.nodes, self._triangles, format) if self._triangles else None
