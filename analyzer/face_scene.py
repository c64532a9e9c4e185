"""From decoded frames to the vertices of a head.

Rules: FAC-5, FAC-6, FAC-10, FAT-2..9, CNF-2 (vertices), CNF-24.

A model is a FAT document with its looks. The shipped head also has its visemes and expressions as low-level FAPs, so
that FAP 1 and 2 can be over-ruled FAP by FAP (FAC-6); of other models the tables of FAP 1 and 2 are used, and what
they give adds to the low-level FAPs (FAT-7). A low-level FAP over-rules from the moment it has a value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import InputFormat, RangeViolation
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.documents.json_text import as_array, as_int, as_object, parse_json
from snhc.reference_impl.model.fat import FatReadings, FrameLike, evaluate
from snhc.reference_impl.model.fat_bulk import BLOCK_FRAMES, BulkFat, Float32Array
from snhc.reference_impl.model.fat_document import FatDocument, FloatArray
from snhc.reference_impl.model.fat_json import definition_reader, fat_from_json
from snhc.reference_impl.model.fat_text import parse_fat_text
from snhc.reference_impl.model.feature_motion import Pose, high_level_faps
from snhc.reference_impl.model.head import HEAD_ORDER, head_poses, load_head
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings

Colours = NDArray[np.uint8]

HEAD: Final = "head"
FOLLOWED: Final = FatReadings()
# Meshes that come without colours.
PLAIN: Final = (200, 190, 180)
_MILLIMETRE: Final = 0.001


@dataclass(frozen=True, slots=True, eq=False)
class FaceModel:
    """A face model that can be drawn.

    Rules: FAC-10. `colours`: per mesh one sRGB colour per face, uint8 (F, 3). `visemes`, `expressions`: low-level FAPs
    at amplitude 63, empty where only tables are known. `unit`: metres per model unit, 1 where nobody says.
    """

    document: FatDocument
    colours: Mapping[str, Colours]
    visemes: Mapping[int, Pose]
    expressions: Mapping[int, Pose]
    unit: float = 1.0


@dataclass(frozen=True, slots=True)
class _Posed:
    faps: Sequence[int | None]
    viseme: Sequence[int] | None = None
    expression: Sequence[int] | None = None


def head_order(readings: Readings = DEFAULT_READINGS) -> str:
    """The order of the shipped head's rotations as it was chosen. Rules: CNF-24 (AMB-FAC-2)."""
    return readings.chosen.get("AMB-FAC-2", HEAD_ORDER)


def fat_readings(readings: Readings = DEFAULT_READINGS) -> FatReadings:
    """The readings of the FAT rules as they were chosen. Rules: CNF-24 (AMB-FAT-1, AMB-FAT-2, AMB-FAT-3)."""
    get = readings.chosen.get
    return FatReadings(get("AMB-FAT-1", "direction"), get("AMB-FAT-2", "blend"), get("AMB-FAT-3", "additive"))


def load_model(
    name: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    on_finding: Callable[[Finding], None] | None = None,
    readings: Readings = DEFAULT_READINGS,
) -> FaceModel:
    """A model: the shipped head (None or `head`), or a file of either FAT form, told apart by content.

    Rules: FAC-5, FAC-10, FAT-1, FAT-11, CNF-2, CNF-22. `readings`: AMB-FAC-2 is followed by the shipped head; other
    models turn as their nodes say. In a JSON document the keys `palette` ({name: [r, g, b]}) and `colors`
    ({mesh: one palette number per face}) may give colours. Raises as `read_model`, OSError.
    """
    if name is None or name == HEAD:
        return _shipped(head_order(readings))
    path = Path(name)
    with path.open("rb") as file:
        data = file.read(limits.json_bytes + 1)
    return read_model(data, path.parent, limits, on_finding)


def read_model(
    data: bytes,
    folder: Path | None = None,
    limits: Limits = DEFAULT_LIMITS,
    on_finding: Callable[[Finding], None] | None = None,
) -> FaceModel:
    """A model from the bytes of a file of either FAT form, told apart by content.

    Rules: FAC-10, FAT-1, FAT-11, CNF-22. `folder`: where the face definition that the model may name stands; None: it
    may name none. Raises as `fat_from_json` and `parse_fat_text`.
    """
    if data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] != b"{":
        document, findings = parse_fat_text(data, max_vertices=limits.fat_vertices, limit=limits.json_bytes)
        if on_finding is not None:
            for finding in findings:
                on_finding(finding)
        return FaceModel(document, _colours(document, {}), {}, {})
    value = parse_json(data, rule="FAT-1", what="FAT document", limit=limits.json_bytes)
    return model_from_json(as_object(value, "", "FAT-1"), folder, limits)


def model_from_json(
    root: Mapping[str, object], folder: Path | None = None, limits: Limits = DEFAULT_LIMITS
) -> FaceModel:
    """A model from parsed JSON. Rules: FAC-10, FAT-1, FAT-11. Arguments and errors as `read_model`."""
    reader = None if folder is None else definition_reader(folder)
    document = fat_from_json(root, read_definition=reader, max_vertices=limits.fat_vertices)
    return FaceModel(document, _colours(document, root), {}, {})


def _shipped(order: str) -> FaceModel:
    root = load_head(order)
    document = fat_from_json(root)
    visemes, expressions = head_poses()
    return FaceModel(document, _colours(document, root), visemes, expressions, _MILLIMETRE)


def _colours(document: FatDocument, root: Mapping[str, object]) -> dict[str, Colours]:
    palette = [
        [as_int(part, f"palette.{name}[{i}]", "FAC-10", 0, 255) for i, part in enumerate(_three(entry, name))]
        for name, entry in as_object(root.get("palette", {}), "palette", "FAC-10").items()
    ]
    given = as_object(root.get("colors", {}), "colors", "FAC-10")
    out: dict[str, Colours] = {}
    for name, mesh in document.meshes.items():
        if name not in given:
            out[name] = np.tile(np.array(PLAIN, dtype=np.uint8), (len(mesh.faces), 1))
            continue
        path = f"colors.{name}"
        numbers = as_array(given[name], path, "FAC-10")
        if len(numbers) != len(mesh.faces):
            raise InputFormat(
                "FAC-10", "colors", value=len(numbers), allowed="one per face", path=path, expected=len(mesh.faces)
            )
        picked = [as_int(n, f"{path}[{i}]", "FAC-10", 0, len(palette) - 1) for i, n in enumerate(numbers)]
        out[name] = np.array([palette[n] for n in picked], dtype=np.uint8).reshape(-1, 3)
    return out


def _three(entry: object, name: str) -> list[object]:
    parts = as_array(entry, f"palette.{name}", "FAC-10")
    if len(parts) != 3:
        raise InputFormat(
            "FAC-10", "palette", value=len(parts), allowed="red, green, blue", path=f"palette.{name}", expected=3
        )
    return list(parts)


def posed_frames(model: FaceModel, frames: Sequence[FrameLike]) -> Sequence[FrameLike]:
    """The frames with FAP 1 and 2 turned into low-level FAPs, where the model has them as such.

    Rules: FAC-6. The values are not rounded: amplitudes of tables are real numbers.
    """
    if not model.visemes and not model.expressions:
        return frames
    out: list[FrameLike] = []
    for frame in frames:
        if frame.viseme is None and frame.expression is None:
            out.append(frame)
        else:
            faps = high_level_faps(frame.faps, frame.viseme, frame.expression, model.visemes, model.expressions)
            # A frame holds whole FAP values, which the evaluation does not insist on.
            out.append(_Posed(cast("Sequence[int | None]", faps)))
    return out


def exact_vertices(model: FaceModel, frame: FrameLike, readings: FatReadings = FOLLOWED) -> dict[str, FloatArray]:
    """The vertices for one frame, {mesh: float64 (V, 3)}, model units, by the literal evaluation.

    Rules: FAC-6, FAT-2..9, CNF-2.
    """
    return evaluate(model.document, posed_frames(model, [frame])[0], readings)


class FaceScene:
    """A model made ready for many frames.

    Rules: FAC-5, FAC-6, FAT-2..9. Head and eyes turn as the Transform nodes of the model say.
    """

    def __init__(self, model: FaceModel, readings: FatReadings = FOLLOWED) -> None:
        self.model = model
        self.readings = readings
        self._bulk = BulkFat(model.document, readings)
        self._neutral = self._bulk.evaluate([NEUTRAL])

    def vertices(self, frames: Sequence[FrameLike]) -> dict[str, Float32Array]:
        """{mesh: float32 (N, V, 3)}, model units, all frames at once. Rules: FAC-6, FAT-2..9."""
        return self._bulk.evaluate(posed_frames(self.model, frames))

    def neutral(self) -> dict[str, Float32Array]:
        """{mesh: float32 (V, 3)} of the neutral face. Rules: FAC-3."""
        return {name: points[0] for name, points in self._neutral.items()}

    def each(self, frames: Sequence[FrameLike], size: int = BLOCK_FRAMES) -> Iterator[dict[str, Float32Array]]:
        """{mesh: float32 (V, 3)} frame by frame; `size` frames are computed at a time. Rules: FAT-2..9."""
        for start in range(0, len(frames), size):
            block = self.vertices(frames[start : start + size])
            for n in range(min(size, len(frames) - start)):
                yield {name: points[n] for name, points in block.items()}


NEUTRAL: Final = _Posed((None,) * 68)


def still(
    faps: Mapping[int, int] | None = None,
    viseme: tuple[int, int, int] | None = None,
    expression: tuple[int, int, int, int] | None = None,
) -> FrameLike:
    """A frame that holds the given FAPs and nothing else.

    Rules: CNF-1, FAC-4. `faps`: {3..68: value}. Raises RangeViolation for another number.
    """
    given = faps or {}
    for number in given:
        if not 3 <= number <= 68:
            raise RangeViolation("CNF-1", "FAP", value=number, allowed="3..68")
    return _Posed([given.get(n + 1) for n in range(68)], viseme, expression)
