"""What the planes decode to, as columns for a page: FAP values and mesh nodes.

Rules: CNF-1, CNF-22, FAC-6, MSH-8, MSH-15, MSH-21.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Final

from snhc.analyzer.face_scene import FaceModel, posed_frames
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.model.fat import FrameLike

from .columns import too_large
from .packing import packed

# A FAP without a value; no FAP reaches it.
UNSET: Final = -(1 << 31)
MOST_FAP_VALUES: Final = 8_000_000
MOST_NODES: Final = 4_000_000


class FaceFrames:
    """The frames of a face. Rules: CNF-1."""

    def __init__(self) -> None:
        self.frames: list[FaceFrame] = []

    def add(self, frame: FaceFrame) -> None:
        """Take a frame. Rules: CNF-22. Raises ResourceLimit."""
        self.frames.append(frame)
        if len(self.frames) * 68 > MOST_FAP_VALUES:
            raise too_large("FAP values", MOST_FAP_VALUES)

    def as_json(self, model: FaceModel) -> dict[str, object]:
        """Times, the FAPs that ever have a value, visemes and expressions as they are, and the posed FAPs.

        Rules: CNF-1, FAC-6. `pose`: FAPs with those of visemes and expressions, where a frame has any.
        """
        frames = self.frames
        used = [n for n in range(68) if any(frame.faps[n] is not None for frame in frames)]
        out: dict[str, object] = {
            "time": packed("d", [frame.time[0] / frame.time[1] for frame in frames]),
            "faps": {str(n + 1): _column([frame.faps[n] for frame in frames]) for n in used},
            "visemes": _rows([frame.viseme for frame in frames], 4),
            "expressions": _rows([frame.expression for frame in frames], 6),
        }
        if any(frame.viseme is not None or frame.expression is not None for frame in frames):
            posed: Sequence[FrameLike] = posed_frames(model, frames)
            moved = [n for n in range(2, 68) if any(frame.faps[n] for frame in posed)]
            out["pose"] = {str(n + 1): packed("f", [frame.faps[n] or 0 for frame in posed]) for n in moved}
        return out


def _column(values: Sequence[int | None]) -> str:
    numbers = [UNSET if value is None else value for value in values]
    # A DCT segment can give more than any FAP can mean.
    return packed("i" if all(abs(number) <= -UNSET for number in numbers) and max(numbers) < -UNSET else "d", numbers)


def _rows(values: Sequence[Sequence[int] | None], width: int) -> str | None:
    if all(value is None for value in values):
        return None
    return packed("i", [number for value in values for number in (value or [-1] * width)])


class MeshFrames:
    """The frames of a mesh. Rules: CNF-1, MSH-8, MSH-21."""

    def __init__(self) -> None:
        self._time = array("d")
        # Motion may carry a node beyond 16 bits.
        self._nodes = array("i")
        self._first = array("I", [0])
        self._geometry = array("i")
        self._meshes: list[dict[str, object]] = []

    def __len__(self) -> int:
        return len(self._time)

    def add(self, frame: MeshFrame) -> None:
        """Take a frame. Rules: CNF-22. Raises ResourceLimit."""
        self._time.append(frame.time[0] / frame.time[1])
        for node in frame.nodes:
            self._nodes.extend(node)
        self._first.append(len(self._nodes) // 2)
        if self._first[-1] > MOST_NODES:
            raise too_large("mesh nodes", MOST_NODES)
        if frame.triangles is not None and frame.order is not None:
            corners = [corner for triangle in frame.triangles for corner in triangle]
            self._meshes.append({"triangles": packed("I", corners), "order": packed("I", frame.order)})
        self._geometry.append(len(self._meshes) - 1)

    def as_json(self) -> dict[str, object]:
        """Times, node positions in half pixels, and per frame the number of its triangles. Rules: CNF-1."""
        return {
            "time": packed("d", self._time),
            "nodes": packed("i", self._nodes),
            "first": packed("I", self._first),
            "geometry": packed("i", self._geometry),
            "meshes": self._meshes,
        }
