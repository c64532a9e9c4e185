"""`snhc decode`: a face or mesh stream to frames.

Rules: CNF-1, CNF-2, CNF-19, CNF-24, CNF-26, FBA-44, FBA-54, FIT-4..8.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, format_of, open_input
from .extras import needs_view

if TYPE_CHECKING:
    from snhc.analyzer.face_lines import Fill

# The keys of `output.FORMATS` and `SUFFIXES`, spelled out so that `--help` loads no codec; a test compares them.
MODELS = ("obj", "ply", "stl", "off", "glb")
FORMATS = ("ndjson", "fap", "csv", "npz", *MODELS)
SUFFIXES = {
    ".ndjson": "ndjson", ".jsonl": "ndjson", ".fap": "fap", ".csv": "csv", ".npz": "npz",
    **{f".{name}": name for name in MODELS},
}  # fmt: skip
PLACEHOLDER = "{index}"


@click.command()
@click.argument("file")
@click.option("--format", "format_", type=click.Choice(FORMATS), help="Default: by the extension of -o, else ndjson.")
@click.option("--fit", "table", metavar="TABLE", help="Fill frames by a FAP interpolation table (state F).")
@click.option("--symmetry", is_flag=True, help="Let the one side of the face copy the other (state S, informative).")
@click.option("--vertices", "model", metavar="MODEL|head", help="The vertices of a model, or of the shipped head.")
@click.option("--nframes", type=click.IntRange(min=1), metavar="N", help="Stop after N frames.")
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(
    file: str,
    format_: str | None,
    table: str | None,
    symmetry: bool,
    model: str | None,
    nframes: int | None,
    object_number: int,
    common: Common,
) -> None:
    """Decode a face or mesh stream to frames.

    FILE is a visual stream, - for standard input. NDJSON and CSV are written as they are decoded; lines before an
    error stay. obj, ply, stl, off and glb hold the first mesh; with {index} in -o, as in mesh-{index}.obj, every frame
    becomes a file. With --vertices ndjson has the vertices of a model instead of FAPs.
    """
    chosen = format_of(format_, common.output, SUFFIXES, "ndjson")
    if model is not None and chosen != "ndjson":
        raise click.UsageError("--vertices gives ndjson only")
    if (table is not None or symmetry) and chosen in MODELS:
        raise click.UsageError(f"--fit and --symmetry are for faces, which {chosen} does not hold")
    if chosen in MODELS:
        with needs_view(f"decode to {chosen}"):
            import trimesh  # noqa: F401 (said now, not after half the work)
    if common.output is not None and PLACEHOLDER in common.output:
        if chosen not in MODELS:
            raise click.UsageError(f"{PLACEHOLDER} in -o is for {', '.join(MODELS)}")
        _decode_models(file, chosen, nframes, object_number, common)
        return
    if chosen in ("npz", "stl", "glb") and common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError(f"{chosen} is not for terminals; give -o FILE")
    _decode(file, chosen, nframes, object_number, common, Faces(table, symmetry, model))


@dataclass(frozen=True, slots=True)
class Faces:
    """What is made of the frames of a face. Rules: CNF-2. `table`, `model`: files, None for none."""

    table: str | None
    symmetry: bool
    model: str | None

    @property
    def fill(self) -> bool:
        """Whether frames are to be filled. Rules: CNF-2."""
        return self.table is not None or self.symmetry


def _decode_models(file: str, chosen: str, nframes: int | None, object_number: int, common: Common) -> None:
    from snhc.reference_impl.systems.output import frame_writer
    from snhc.reference_impl.systems.stream import decode_planes

    pattern = common.output
    assert pattern is not None

    def each(index: int, model: bytes) -> None:
        with Output(pattern.replace(PLACEHOLDER, str(index)), common.keep_partial) as out:
            out.write(model)

    with open_input(file) as source:
        writer = frame_writer(chosen, _nothing, most=nframes, each=each)
        for plane in decode_planes(source, common.options(object_number), common.report, writer.begin):
            writer.plane(plane)
            if writer.full:
                break
        writer.end()


def _nothing(data: bytes) -> None:
    raise AssertionError("every frame has a file of its own")


def _decode(file: str, chosen: str, nframes: int | None, object_number: int, common: Common, faces: Faces) -> None:
    from snhc.reference_impl.bitstream.errors import SnhcError, Unsupported
    from snhc.reference_impl.bitstream.findings import Finding
    from snhc.reference_impl.bitstream.source import PipeSource
    from snhc.reference_impl.face.records import FbaPlane
    from snhc.reference_impl.rules import finding as registered_finding
    from snhc.reference_impl.systems.output import FapWriter, FrameWriter, frame_writer
    from snhc.reference_impl.systems.stream import decode_planes

    found = False

    def begin(kind: str) -> None:
        nonlocal found
        if fill is not None and kind != "fba":
            raise Unsupported("FIT-6", "kind of the object", value=kind, allowed="fba with --fit and --symmetry")
        writer.begin("faces" if fill is not None and faces.model is None and chosen == "ndjson" else kind)
        found = True

    def make(write: Callable[[bytes], None]) -> FrameWriter:
        if faces.model is not None:
            from snhc.analyzer.face_lines import VertexWriter
            from snhc.analyzer.face_scene import load_model

            loaded = load_model(faces.model, common.limits, common.report, common.readings)
            return VertexWriter(write, loaded, nframes, common.readings)
        return frame_writer(
            chosen,
            write,
            most=nframes,
            readings=common.readings,
            limits=common.limits,
            name=name,
            profile=common.entropy_profile(),
        )

    name = "" if file == "-" else PurePath(file).stem
    fill = _filler(faces, chosen == "fap", common) if faces.fill else None
    with (
        open_input(file) as source,
        Output(common.output, common.keep_partial, prompt=isinstance(source, PipeSource)) as out,
        closing(make(out.write)) as writer,
    ):
        try:
            for plane in decode_planes(source, common.options(object_number), common.report, begin):
                if fill is not None and isinstance(plane, FbaPlane):
                    plane.frames = [fill(frame) for frame in plane.frames]
                writer.plane(plane)
                if writer.full:
                    break
        except SnhcError:
            # An archive is no sequence of lines: half of one goes nowhere unless it is asked for.
            if found and chosen not in MODELS and (chosen != "npz" or common.keep_partial):
                writer.end()
            raise
        writer.end()
    if isinstance(writer, FapWriter) and writer.rate_changes:
        kind = registered_finding("fap-rate-changes")
        common.report(Finding(kind.id, kind.severity, kind.rule, "a later plane changes the frame rate"))


def _filler(faces: Faces, as_sent: bool, common: Common) -> Fill:
    from snhc.analyzer.face_lines import filler, load_table

    table = None if faces.table is None else load_table(faces.table, common.readings, common.limits)
    return filler(table, faces.symmetry, common.readings, as_sent)
