"""Frames through FIT, symmetry and a face model, as NDJSON lines.

Rules: CNF-1, CNF-2, CNF-24, CNF-25, FIT-4..8, FAT-2..9, FAC-6.

Lines that are complete before a fault are passed on before it is raised: blocks are computed at once, but a fault in
one does not take the frames before it away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from snhc.reference_impl.bitstream.errors import SnhcError, Unsupported
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.face.decoded import header_line
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.interpolation.fit import FitReadings, apply_symmetry, evaluate, load_fit
from snhc.reference_impl.interpolation.fit_bulk import BLOCK_FRAMES, evaluate_sequence
from snhc.reference_impl.interpolation.fit_table import FitTable
from snhc.reference_impl.interpolation.frames_json import (
    FrameLine,
    LineStream,
    faces_line,
    read_frames,
    vertices_line,
)
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.systems.output import FrameWriter

from .face_scene import FaceModel, exact_vertices, fat_readings


class Faults:
    """Passes frames on and keeps the fault that ends them until `check`. Rules: CNF-19, CNF-25."""

    def __init__(self, frames: Iterable[FrameLine]) -> None:
        self._frames = frames
        self.fault: SnhcError | None = None

    def __iter__(self) -> Iterator[FrameLine]:
        try:
            yield from self._frames
        except SnhcError as fault:
            self.fault = fault

    def check(self) -> None:
        """Raise what ended the frames, if it was a fault. Rules: CNF-25."""
        if self.fault is not None:
            raise self.fault


def fit_readings(readings: Readings = DEFAULT_READINGS) -> FitReadings:
    """The readings of the FIT rules as they were chosen. Rules: CNF-24 (AMB-FIT-1, AMB-FIT-2, AMB-FIT-3)."""
    get = readings.chosen.get
    return FitReadings(get("AMB-FIT-1", "from-0"), get("AMB-FIT-2", "next-nearest"), get("AMB-FIT-3", "topological"))


def load_table(name: str, readings: Readings = DEFAULT_READINGS, limits: Limits = DEFAULT_LIMITS) -> FitTable:
    """A FIT from a file of either form. Rules: FIT-1, FIT-9, CNF-22. Raises as `load_fit`."""
    chosen = fit_readings(readings)
    return load_fit(Path(name), chosen, max_sets=limits.fit_sets, max_links=limits.fit_links, limit=limits.json_bytes)


def plain_frame(frame: FaceFrame) -> FrameLine:
    """A decoded frame in the form that FIT and the lines work on, without further keys. Rules: CNF-1."""
    return FrameLine(
        frame.index,
        f"{frame.time[0]}/{frame.time[1]}",
        frame.intra,
        frame.faps,
        None if frame.viseme is None else frame.viseme[:3],
        None if frame.expression is None else frame.expression[:4],
        frame.state,
        {},
    )


Fill = Callable[[FaceFrame], FaceFrame]


def filler(
    table: FitTable | None, symmetry: bool, readings: Readings = DEFAULT_READINGS, as_sent: bool = False
) -> Fill:
    """A function that fills one decoded frame: by FIT (state F), then by symmetry (state S).

    Rules: FIT-4..8, CNF-2. `table`: None for no FIT. `as_sent`: the states become T, for formats that know no others.
    """
    chosen = fit_readings(readings)
    sent = str.maketrans("FS", "TT" if as_sent else "FS")

    def fill(frame: FaceFrame) -> FaceFrame:
        filled = plain_frame(frame)
        if table is not None:
            filled = evaluate(table, filled, chosen)
        if symmetry:
            filled = apply_symmetry(filled)
        return frame._replace(faps=filled.faps, state=filled.state.translate(sent))

    return fill


class VertexWriter(FrameWriter):
    """Vertices of the frames of a face as NDJSON lines. Rules: CNF-2, FAT-2..9, FAC-6."""

    def __init__(
        self,
        write: Callable[[bytes], None],
        model: FaceModel,
        most: int | None = None,
        readings: Readings = DEFAULT_READINGS,
    ) -> None:
        super().__init__(write, most)
        self._readings = readings
        self._line = vertex_lines(model, readings)

    def begin(self, kind: str) -> None:
        if kind != "fba":
            raise Unsupported("FAT-2", "kind of the object", value=kind, allowed="fba: meshes have no FAPs")
        self._write((header_line("vertices", self._readings) + "\n").encode())

    def frame(self, frame: FaceFrame | MeshFrame) -> None:
        assert isinstance(frame, FaceFrame)
        self._write((self._line(plain_frame(frame)) + "\n").encode())


def interpolated(
    frames: Iterable[FrameLine],
    table: FitTable | None,
    symmetry: bool = False,
    readings: Readings = DEFAULT_READINGS,
    block: int = BLOCK_FRAMES,
) -> Iterator[FrameLine]:
    """Frames after FIT (state F), and by symmetry (state S) where asked for.

    Rules: FIT-4..8. `table`: None for no FIT. `block`: frames that are held; 1 passes each on at once.
    """
    kept = Faults(frames)
    filled: Iterable[FrameLine] = kept
    if table is not None:
        filled = evaluate_sequence(table, kept, fit_readings(readings), block=block)
    for frame in filled:
        yield apply_symmetry(frame) if symmetry else frame
    kept.check()


Line = Callable[[FrameLine], str]


def vertex_lines(model: FaceModel, readings: Readings = DEFAULT_READINGS) -> Line:
    """A function that gives the CNF-2 line of a frame: all vertices by the literal evaluation.

    Rules: CNF-2, FAT-2..9, FAC-6.
    """
    chosen = fat_readings(readings)
    return lambda frame: vertices_line(frame, exact_vertices(model, frame, chosen))


def lines(frames: Iterable[FrameLine], kind: str, line: Line, readings: Readings = DEFAULT_READINGS) -> Iterator[str]:
    """The header and a line per frame, each with its newline.

    Rules: CNF-1, CNF-2, CNF-24. `kind`: `faces` or `vertices`. Nothing comes before it is known that there are frames
    to read.
    """
    kept = Faults(frames)
    header = header_line(kind, readings) + "\n"
    begun = False
    for frame in kept:
        if not begun:
            yield header
            begun = True
        yield line(frame) + "\n"
    # Not even a header line that could be read: there is no stream to name the kind of.
    if not begun and (kept.fault is None or (kept.fault.line or 1) > 1):
        yield header
    kept.check()


def face_lines(
    stream: LineStream, table: FitTable, symmetry: bool, readings: Readings, limits: Limits, block: int = BLOCK_FRAMES
) -> Iterator[str]:
    """What `snhc fit` prints. Rules: CNF-2, FIT-4..8."""
    frames = read_frames(stream, limit=limits.text_line_bytes)
    yield from lines(interpolated(frames, table, symmetry, readings, block), "faces", faces_line, readings)


def mesh_lines(stream: LineStream, model: FaceModel, readings: Readings, limits: Limits) -> Iterator[str]:
    """What `snhc fat` prints. Rules: CNF-2, FAT-2..9."""
    frames = read_frames(stream, limit=limits.text_line_bytes)
    yield from lines(frames, "vertices", vertex_lines(model, readings), readings)
