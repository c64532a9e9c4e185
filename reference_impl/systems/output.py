"""Decoded planes as files: NDJSON, CSV, npz, `.fap` text for faces, mesh formats for meshes.

The forms are described in docs/formats.md and docs/formats-mesh.md.

Rules: CNF-1 (NDJSON), CNF-22 (frames collected), CNF-25 (CSV, npz, mesh formats are this project's), FBA-54 (`.fap`).
Not here: FITted frames and vertices (CNF-2).

Every writer takes planes one by one and passes whole lines on; NDJSON and CSV keep nothing.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar, Final

from ..bitstream.errors import EncodeError, ResourceLimit
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..documents.archive import write_npz
from ..entropy.profile import EntropyProfile, load_profile
from ..face.columns import FAPS, FaceColumns
from ..face.decoded import EXPRESSION_KEYS, VISEME_KEYS, frame_line, header_line
from ..face.fap_text import FapTextFrame, fap_frame, fap_header
from ..face.frames import FaceFrame
from ..face.records import FbaPlane
from ..mesh.decoded import mesh_line
from ..mesh.output import MODEL_FORMATS, MeshArrays, ModelFrames, csv_header, csv_rows
from ..mesh.records import MeshFrame
from ..syntax.element import DEFAULT_READINGS, Readings
from ..syntax.temporal import Clock
from .visual import AnyPlane

if TYPE_CHECKING:
    from typing import IO

BAPS: Final = 296
COPY_BYTES: Final = 1 << 16

CSV_COLUMNS: Final = (
    "index", "time", "intra", "state", "gender", "coding_type", "fap_quant",
    *(f"viseme_{key}" for key in VISEME_KEYS),
    *(f"expression_{key}" for key in EXPRESSION_KEYS),
    *(f"fap_{number}" for number in range(3, FAPS + 1)),
    "baps",
)  # fmt: skip

Write = Callable[[bytes], None]


class FrameWriter:
    """Takes a decoded object: `begin`, then each plane, then `end`.

    Rules: CNF-1, FBA-54.

    `write`: takes pieces of whole lines. `most`: frames to write at most, None for all; `full` tells when they are.
    `KINDS`: the kinds of objects that the format can hold.
    """

    KINDS: ClassVar[tuple[str, ...]] = ("fba", "mesh")

    def __init__(self, write: Write, most: int | None = None) -> None:
        self._write = write
        self._most = most
        self.frames = 0

    @property
    def full(self) -> bool:
        """Whether no more frames are wanted. Rules: FBA-54."""
        return self._most is not None and self.frames >= self._most

    def begin(self, kind: str) -> None:
        """The object has been found; `kind`: `fba` or `mesh`. Rules: CNF-26.

        Raises EncodeError where the format has no form for the kind.
        """
        if kind not in self.KINDS:
            raise EncodeError(
                "CNF-25", "kind of the object", value=kind,
                allowed=f"{', '.join(self.KINDS)} in this format; ndjson takes all",
            )  # fmt: skip

    def plane(self, plane: AnyPlane) -> None:
        """The frames of one plane. Rules: CNF-1."""
        for frame in plane.frames:
            if self.full:
                return
            self.frame(frame)
            self.frames += 1

    def frame(self, frame: FaceFrame | MeshFrame) -> None:
        """One frame. Rules: CNF-1."""
        raise NotImplementedError

    def end(self) -> None:
        """Nothing more comes, be it that an error ended it. Rules: CNF-1."""

    def close(self) -> None:
        """Let go of what is held; nothing is written. Rules: CNF-22."""


class NdjsonWriter(FrameWriter):
    """The convention `snhc-decoded` version 1. Rules: CNF-1, CNF-24, CNF-26, DCT-1.

    The header waits for the first plane, or the end: it names the entropy profile of a stream that begins with a DCT
    segment.
    """

    def __init__(
        self,
        write: Write,
        most: int | None = None,
        readings: Readings = DEFAULT_READINGS,
        profile: EntropyProfile | None = None,
    ) -> None:
        super().__init__(write, most)
        self._readings = readings
        self._profile = profile
        self._kind = ""

    def begin(self, kind: str) -> None:
        self._kind = kind

    def _header(self, profile: str = "") -> None:
        if self._kind:
            self._write((header_line(self._kind, self._readings, profile) + "\n").encode())
            self._kind = ""

    def plane(self, plane: AnyPlane) -> None:
        if self._kind:
            profile = ""
            if isinstance(plane, FbaPlane) and plane.faps is not None and plane.faps.segment is not None:
                profile = (self._profile if self._profile is not None else load_profile()).label
            self._header(profile)
        super().plane(plane)

    def end(self) -> None:
        self._header()

    def frame(self, frame: FaceFrame | MeshFrame) -> None:
        line = mesh_line(frame) if isinstance(frame, MeshFrame) else frame_line(frame)
        self._write((line + "\n").encode())


class CsvWriter(FrameWriter):
    """Faces: one row per frame, the columns of CSV_COLUMNS; an empty cell where NDJSON has null. Meshes: one per node.

    Rules: CNF-1, CNF-25.
    """

    def begin(self, kind: str) -> None:
        super().begin(kind)
        header = csv_header() if kind == "mesh" else ",".join(CSV_COLUMNS) + "\n"
        self._write(header.encode())

    def frame(self, frame: FaceFrame | MeshFrame) -> None:
        rows = csv_rows(frame) if isinstance(frame, MeshFrame) else csv_row(frame) + "\n"
        self._write(rows.encode())


def csv_row(frame: FaceFrame) -> str:
    """One frame as the cells of CSV_COLUMNS, without the newline. Rules: CNF-1, CNF-25."""
    cells: list[object] = [
        frame.index,
        f"{frame.time[0]}/{frame.time[1]}",
        1 if frame.intra else 0,
        frame.state,
        frame.gender,
        frame.coding_type,
        frame.fap_quant,
        *(frame.viseme if frame.viseme is not None else (None,) * len(VISEME_KEYS)),
        *(frame.expression if frame.expression is not None else (None,) * len(EXPRESSION_KEYS)),
        *frame.faps[2:],
        None if frame.baps is None else " ".join(f"{number}:{value}" for number, value in frame.baps.items()),
    ]
    return ",".join("" if cell is None else str(cell) for cell in cells)


# -- .fap --------------------------------------------------------------------------------------------------------------


class FapFrames:
    """Turns planes into frames of a `.fap` text.

    Rules: FBA-54, FBA-37.

    One frame per frame with FAP data; the number counts frame periods from the first of them, planes without FAP
    data and skipped frames included. `rate`: frames per second of the first plane; `rate_changes`: later planes say
    another one, which the text cannot hold.
    """

    def __init__(self, readings: Readings = DEFAULT_READINGS) -> None:
        self._skipped_before = readings.skipped_frames == "before"
        self._clock = Clock()
        self._number = -1
        self.rate: Fraction | None = None
        self.rate_changes = False

    def of(self, plane: FbaPlane) -> Iterator[FapTextFrame]:
        """The frames of the next plane. Rules: FBA-54."""
        self._clock.tick(plane.header, self._skipped_before)
        if self.rate is None:
            self.rate = self._clock.rate
        elif self.rate != self._clock.rate:
            self.rate_changes = True
        skipped = plane.header.number_of_frames_to_skip
        if self._skipped_before:
            self._pass(skipped)
        for frame in plane.frames:
            if plane.faps is not None:
                self._number = max(self._number, 0)
                yield fap_text_frame(frame, self._number)
            self._pass(1)
        if not self._skipped_before:
            self._pass(skipped)

    def _pass(self, periods: int) -> None:
        # Before the first frame with FAP data there is nothing to count from.
        if self._number >= 0:
            self._number += periods


def fap_text_frame(frame: FaceFrame, number: int) -> FapTextFrame:
    """A frame as `.fap` text has it: the parameters of state T. Rules: FBA-54, FBA-50."""
    mask = tuple(1 if letter == "T" else 0 for letter in frame.state)
    values = [value if digit else None for value, digit in zip(frame.faps, mask, strict=True)]
    viseme = frame.viseme if mask[0] else None
    expression = frame.expression if mask[1] else None
    return FapTextFrame(number, mask, values, viseme, expression)


class FapWriter(FrameWriter):
    """`.fap` text; the frames are spooled, because the header before them says how many there are.

    Rules: FBA-54, FBA-50. Raises EncodeError for a value outside 32 bits.
    """

    KINDS = ("fba",)

    def __init__(
        self, write: Write, most: int | None = None, readings: Readings = DEFAULT_READINGS, name: str = ""
    ) -> None:
        super().__init__(write, most)
        self._name = name
        self._texts = FapFrames(readings)
        self._previous = -1
        self._spool: IO[bytes] = tempfile.SpooledTemporaryFile(max_size=1 << 20)  # noqa: SIM115 (closed by close)

    @property
    def rate_changes(self) -> bool:
        """Whether the frame rate changed, which the text cannot say. Rules: FBA-54."""
        return self._texts.rate_changes

    def plane(self, plane: AnyPlane) -> None:
        assert isinstance(plane, FbaPlane)
        for text in self._texts.of(plane):
            if self.full:
                return
            self._spool.write(fap_frame(text, self._previous, f"frames[{self.frames}]"))
            self._previous = text.number
            self.frames += 1

    def end(self) -> None:
        rate = self._texts.rate if self._texts.rate is not None else Clock().rate
        self._write(fap_header(self._name, rate, self.frames))
        self._spool.seek(0)
        while chunk := self._spool.read(COPY_BYTES):
            self._write(chunk)

    def close(self) -> None:
        self._spool.close()


# -- npz ---------------------------------------------------------------------------------------------------------------


class NpzWriter(FrameWriter):
    """Arrays with one row per frame, in a numpy archive; the keys stand in docs/formats.md.

    Rules: CNF-1, CNF-22, CNF-25. Collects; raises ResourceLimit past `limits.collected_planes`, EncodeError for a
    number that 64 bits do not hold.
    """

    def __init__(
        self,
        write: Write,
        most: int | None = None,
        readings: Readings = DEFAULT_READINGS,
        limits: Limits = DEFAULT_LIMITS,
    ) -> None:
        super().__init__(write, most)
        self._readings = readings
        self._limits = limits
        self._faces = FaceColumns()
        self._meshes: MeshArrays | None = None

    def begin(self, kind: str) -> None:
        super().begin(kind)
        if kind == "mesh":
            self._meshes = MeshArrays(self._readings, self._limits)

    def frame(self, frame: FaceFrame | MeshFrame) -> None:
        try:
            self._add(frame)
        except OverflowError:
            raise EncodeError(
                "CNF-25", f"npz: frame {frame.index}", value="a time or value of more than 64 bits",
                allowed="64 bits; NDJSON and CSV hold any",
            ) from None  # fmt: skip

    def _add(self, frame: FaceFrame | MeshFrame) -> None:
        if isinstance(frame, MeshFrame):
            assert self._meshes is not None
            self._meshes.add(frame)
            return
        if self.frames >= self._limits.collected_planes:
            raise ResourceLimit(
                "CNF-22", "frames kept", value=self.frames + 1, allowed=f"at most {self._limits.collected_planes}"
            )
        self._faces.add(frame)

    def end(self) -> None:
        if self._meshes is not None:
            self._meshes.write(self._write)
        else:
            write_npz(face_arrays(self._faces, self._readings), self._write)


def face_arrays(columns: FaceColumns, readings: Readings) -> dict[str, Any]:
    """The arrays of the archive, without copies of the columns. Rules: CNF-1, CNF-25."""
    import numpy as np

    n = columns.rows
    arrays: dict[str, Any] = {
        "time": np.frombuffer(columns.time, np.int64).reshape(n, 2),
        "intra": np.frombuffer(columns.intra, np.bool_),
        "gender": np.frombuffer(columns.gender, np.int8),
        "coding_type": np.frombuffer(columns.coding_type, np.int8),
        "fap_quant": np.frombuffer(columns.fap_quant, np.int8),
        "faps": np.frombuffer(columns.faps, np.int64).reshape(n, FAPS),
        "faps_set": np.frombuffer(columns.faps_set, np.bool_).reshape(n, FAPS),
        "viseme": np.frombuffer(columns.viseme, np.int64).reshape(n, len(VISEME_KEYS)),
        "viseme_set": np.frombuffer(columns.viseme_set, np.bool_),
        "expression": np.frombuffer(columns.expression, np.int64).reshape(n, len(EXPRESSION_KEYS)),
        "expression_set": np.frombuffer(columns.expression_set, np.bool_),
        "state": np.frombuffer(columns.state, "S1").reshape(n, FAPS),
    }
    if columns.baps:
        baps = np.zeros((n, BAPS), dtype=np.int64)
        baps_set = np.zeros((n, BAPS), dtype=np.bool_)
        for row, values in columns.baps.items():
            for number, value in values.items():
                baps[row, number - 1] = value
                baps_set[row, number - 1] = True
        arrays["baps"], arrays["baps_set"] = baps, baps_set
    header = {"format": "snhc-decoded-npz", "version": 1, "kind": "fba", "readings": readings.chosen}
    arrays["header"] = np.array(json.dumps(header))
    return arrays


# -- mesh formats ------------------------------------------------------------------------------------------------------


class ModelWriter(FrameWriter):
    """Meshes in a mesh format: the first frame that has one, or every such frame as a file of its own.

    Rules: CNF-25, MSH-16. `each`: takes the number of a frame and its file; None: the first goes to `write`. Frames
    without a mesh are not counted.
    """

    KINDS = ("mesh",)

    def __init__(
        self, write: Write, most: int | None, format: str, each: Callable[[int, bytes], None] | None = None
    ) -> None:
        super().__init__(write, most if each is not None else 1)
        self._format = format
        self._each = each
        self._models = ModelFrames()

    def plane(self, plane: AnyPlane) -> None:
        for frame in plane.frames:
            assert isinstance(frame, MeshFrame)
            model = None if self.full else self._models.model(frame, self._format)
            if model is not None:
                if self._each is None:
                    self._write(model)
                else:
                    self._each(frame.index, model)
                self.frames += 1

    def end(self) -> None:
        if not self.frames:
            raise EncodeError("CNF-25", "frames with a mesh", value=0, allowed="1 or more")


FORMATS: Final = ("ndjson", "fap", "csv", "npz", *MODEL_FORMATS)
SUFFIXES: Final = {
    ".ndjson": "ndjson", ".jsonl": "ndjson", ".fap": "fap", ".csv": "csv", ".npz": "npz",
    **{f".{name}": name for name in MODEL_FORMATS},
}  # fmt: skip


def frame_writer(
    format: str,
    write: Write,
    *,
    most: int | None = None,
    readings: Readings = DEFAULT_READINGS,
    limits: Limits = DEFAULT_LIMITS,
    name: str = "",
    each: Callable[[int, bytes], None] | None = None,
    profile: EntropyProfile | None = None,
) -> FrameWriter:
    """The writer of a format of FORMATS. Rules: CNF-1, CNF-25, FBA-54.

    `name`: of the sequence, for `.fap`. `each`: as in `ModelWriter`. `profile`: entropy tables of DCT segments.
    """
    if format == "ndjson":
        return NdjsonWriter(write, most, readings, profile)
    if format == "csv":
        return CsvWriter(write, most)
    if format == "fap":
        return FapWriter(write, most, readings, name)
    if format in MODEL_FORMATS:
        return ModelWriter(write, most, format, each)
    assert format == "npz", format
    return NpzWriter(write, most, readings, limits)
