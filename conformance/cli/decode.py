"""`snhc decode`: a face or mesh stream to frames.

Rules: CNF-1, CNF-19, CNF-24, CNF-26, FBA-44, FBA-54.
"""

from __future__ import annotations

import sys
from contextlib import closing
from pathlib import PurePath

import click

from .common import Common, Output, common_options, format_of, open_input

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
@click.option("--nframes", type=click.IntRange(min=1), metavar="N", help="Stop after N frames.")
@click.option("--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N", help="Which object.")
@common_options()
def command(file: str, format_: str | None, nframes: int | None, object_number: int, common: Common) -> None:
    """Decode a face or mesh stream to frames.

    FILE is a visual stream, - for standard input. NDJSON and CSV are written as they are decoded; lines before an
    error stay. obj, ply, stl, off and glb hold the first mesh; with {index} in -o, as in mesh-{index}.obj, every frame
    becomes a file.
    """
    chosen = format_of(format_, common.output, SUFFIXES, "ndjson")
    if common.output is not None and PLACEHOLDER in common.output:
        if chosen not in MODELS:
            raise click.UsageError(f"{PLACEHOLDER} in -o is for {', '.join(MODELS)}")
        _decode_models(file, chosen, nframes, object_number, common)
        return
    if chosen in ("npz", "stl", "glb") and common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError(f"{chosen} is not for terminals; give -o FILE")
    _decode(file, chosen, nframes, object_number, common)


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


def _decode(file: str, chosen: str, nframes: int | None, object_number: int, common: Common) -> None:
    from snhc.reference_impl.bitstream.errors import SnhcError
    from snhc.reference_impl.bitstream.source import PipeSource
    from snhc.reference_impl.systems.output import FapWriter, frame_writer
    from snhc.reference_impl.systems.stream import decode_planes

    found = False

    def begin(kind: str) -> None:
        nonlocal found
        writer.begin(kind)
        found = True

    name = "" if file == "-" else PurePath(file).stem
    with (
        open_input(file) as source,
        Output(common.output, common.keep_partial, prompt=isinstance(source, PipeSource)) as out,
        closing(
            frame_writer(chosen, out.write, most=nframes, readings=common.readings, limits=common.limits, name=name)
        ) as writer,
    ):
        try:
            for plane in decode_planes(source, common.options(object_number), common.report, begin):
                writer.plane(plane)
                if writer.full:
                    break
        except SnhcError:
            # An archive is no sequence of lines: half of one goes nowhere unless it is asked for.
            if found and chosen not in MODELS and (chosen != "npz" or common.keep_partial):
                writer.end()
            raise
        writer.end()
    if isinstance(writer, FapWriter) and writer.rate_changes and not common.quiet:
        click.echo("warning: the frame rate changes, which .fap text cannot say; the first one stands", err=True)
