"""`snhc encode`: `.fap` text to a face stream; mesh documents and pictures to a mesh stream (`encode_mesh`).

Rules: CNF-19, FBA-43, FBA-50, FBA-52, FBA-54, MSH-23.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import Final

import click

from .common import Common, Output, common_options, open_binary, progress
from .encode_mesh import MeshOptions, encode_meshes, kind_of

_LAST_FAP: Final = 68
_PIECE: Final = 1 << 16


def parse_masks(value: str | None) -> frozenset[int] | None:
    """`3-14,48` as the set of FAP numbers. Rules: CNF-19, FBA-10. Raises click.BadParameter."""
    if value is None:
        return None
    numbers: set[int] = set()
    for token in value.split(","):
        match = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", token.strip(), re.ASCII)
        if match is None:
            raise click.BadParameter(f"{token!r} is not of the form N or N-M")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= last <= _LAST_FAP:
            raise click.BadParameter(f"{token!r}: FAPs are numbered 1..{_LAST_FAP}")
        numbers.update(range(first, last + 1))
    return frozenset(numbers)


def parse_profile(value: str | None) -> int | None:
    """A number 0..255, also hexadecimal with 0x. Rules: CNF-19, SYS-2. Raises click.BadParameter."""
    if value is None:
        return None
    if re.fullmatch(r"0[xX][0-9a-fA-F]{1,2}|[0-9]{1,3}", value, re.ASCII) is None or int(value, 0) > 255:
        raise click.BadParameter(f"{value!r} is not a number 0..255 (or 0x00..0xFF)")
    return int(value, 0)


def parse_rate(value: str | None) -> Fraction | None:
    """`25`, `12.5` or `30000/1001` as a fraction above 0. Rules: CNF-19, FBA-37. Raises click.BadParameter."""
    if value is None:
        return None
    match = re.fullmatch(r"(\d{1,9})(?:/(\d{1,9})|\.(\d{1,9}))?", value, re.ASCII)
    if match is None or (match[2] is not None and int(match[2]) == 0) or Fraction(value) == 0:
        raise click.BadParameter(f"{value!r} is not of the form P or P/Q, above 0")
    return Fraction(value)


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--epf", metavar="FILE", help="Encoder parameters per frame; they override the options.")
@click.option("--bap", metavar="FILE", help="Body parameters that ride along, as .bap text.")
@click.option("--mode", type=click.Choice(("arithmetic", "dct")), default="arithmetic", show_default=True)
@click.option("--quant", type=click.IntRange(0, 31), default=1, show_default=True, help="fap_quant; 0 is lossless.")
@click.option("--bap-quant", type=click.IntRange(0, 31), default=1, show_default=True, help="bap_quant.")
@click.option(
    "--intra-period", type=click.IntRange(min=1), metavar="N",
    help="Planes from one intra plane to the next. Default: one second.",
)  # fmt: skip
@click.option(
    "--masks", metavar="LIST", callback=lambda ctx, param, value: parse_masks(value),
    help="Code exactly these FAPs in every frame, e.g. 3-14,48; what a frame lacks holds its value.",
)  # fmt: skip
@click.option(
    "--mask-type", type=click.IntRange(1, 2), default=1, show_default=True,
    help="What FAPs left out of a group do: 1 keep their value, 2 are interpolated.",
)  # fmt: skip
@click.option(
    "--ranges", type=click.Choice(("auto", "widen", "max")), default="auto", show_default=True,
    help="auto: the smallest; widen: those in force as long as they hold; max: the widest.",
)  # fmt: skip
@click.option(
    "--start-codes", type=click.Choice(("none", "intra", "all")), default="none", show_default=True,
    help="Which planes get a start code.",
)  # fmt: skip
@click.option("--gender", type=click.Choice(("female", "male")), default="female", show_default=True)
@click.option(
    "--profile", metavar="NUMBER", callback=lambda ctx, param, value: parse_profile(value),
    help="Write sequence headers with this profile_and_level_indication.",
)  # fmt: skip
@click.option(
    "--rate", metavar="P[/Q]", callback=lambda ctx, param, value: parse_rate(value),
    help="Meshes: planes per second. Default: 30, or what the times of a document need.",
)  # fmt: skip
@click.option(
    "--far", type=click.Choice(("error", "intra")), default="error", show_default=True,
    help="Meshes: what becomes of vectors outside -2048..2047; intra: a new intra plane.",
)  # fmt: skip
@click.option(
    "--design", type=click.Choice(("content", "uniform")), default="content", show_default=True,
    help="Pictures: a Delaunay mesh that fits the first one, or a uniform mesh.",
)  # fmt: skip
@click.option("--mask", metavar="IMAGE", help="Pictures: where the object is on the first one (not black).")
@click.option(
    "--interior-nodes", type=click.IntRange(0, 64512), default=100, show_default=True, help="Pictures: at most so many."
)
@click.option(
    "--spacing", type=click.FloatRange(min=1), default=6.0, show_default=True,
    help="Pictures: pixels between interior nodes.",
)  # fmt: skip
@click.option(
    "--search",
    type=click.IntRange(0, 64),
    default=7,
    show_default=True,
    help="Pictures: reach of the tracking, pixels.",
)
@click.option("--no-end-code", is_flag=True, help="End without visual_object_sequence_end_code.")
@common_options(reads="text")
def command(
    files: tuple[str, ...],
    epf: str | None,
    bap: str | None,
    mode: str,
    quant: int,
    bap_quant: int,
    intra_period: int | None,
    masks: frozenset[int] | None,
    mask_type: int,
    ranges: str,
    start_codes: str,
    gender: str,
    profile: int | None,
    rate: Fraction | None,
    far: str,
    design: str,
    mask: str | None,
    interior_nodes: int,
    spacing: float,
    search: int,
    no_end_code: bool,
    common: Common,
) -> None:
    """Encode FAP text, a mesh document, pictures or a dump as a stream.

    FILE is .fap text, a mesh document (JSON, or the NDJSON that decode writes), one of the pictures of a sequence, or
    the JSON of `snhc dump`, which gives the dumped bytes again, or what its edited values say; - for standard input.
    What it is is told by its content. A mesh is designed for the first picture and tracked over the others; how well
    the first one stands for them is reported in dB.
    """
    if common.output in (None, "-") and sys.stdout.isatty():
        raise click.UsageError("a stream is not for terminals; give -o FILE")
    if [*files, epf, bap, mask].count("-") > 1:
        raise click.UsageError("only one input can be standard input")
    from snhc.reference_impl.documents.kinds import HEAD_BYTES

    with open_binary(files[0]) as stream:
        head = stream.read(HEAD_BYTES)
        kind = kind_of(head)
        if kind == "fap" and len(files) == 1:
            text = chain((head,), iter(lambda: stream.read(_PIECE), b""))
            options = FaceOptions(
                epf, bap, mode, quant, bap_quant, intra_period, masks, mask_type, ranges, start_codes,
                1 if gender == "male" else 0, profile, not no_end_code,
            )  # fmt: skip
            encode_faces(text, options, common)
            return
        if kind != "pictures" and len(files) > 1:
            raise click.UsageError("only pictures make a sequence of files")
        first = head + stream.read()
    meshes = MeshOptions(rate, far, design, mask, interior_nodes, spacing, search, profile, not no_end_code)
    encode_meshes(kind, first, files, meshes, common)


@dataclass(frozen=True, slots=True)
class FaceOptions:
    """How a text is to be encoded, as on the command line. Rules: FBA-43, FBA-52, FBA-54."""

    epf: str | None
    bap: str | None
    mode: str
    quant: int
    bap_quant: int
    intra_period: int | None
    masks: frozenset[int] | None
    mask_type: int
    ranges: str
    start_codes: str
    gender: int
    profile: int | None
    end_code: bool


def encode_faces(text: Iterable[bytes], options: FaceOptions, common: Common) -> None:
    """A `.fap` text to a stream, with the .epf and .bap texts that go with it: all read while it is written.

    Rules: CNF-22, FBA-52, FBA-54.
    """
    from snhc.reference_impl.face.bap_text import BapReader
    from snhc.reference_impl.face.encode import EncoderOptions
    from snhc.reference_impl.face.epf_text import EpfReader
    from snhc.reference_impl.face.fap_text import FapReader
    from snhc.reference_impl.syntax.writer import Writer
    from snhc.reference_impl.systems.encoding import encode_text

    how = EncoderOptions(intra_period=options.intra_period, ranges=options.ranges, start_codes=options.start_codes)
    writer = Writer(limits=common.limits, profile=common.entropy_profile())
    with ExitStack() as stack:
        out = stack.enter_context(Output(common.output, common.keep_partial))
        reader = FapReader(text, strict=common.strict, limits=common.limits)
        parameters = bodies = None
        if options.epf is not None:
            stream = stack.enter_context(open_binary(options.epf))
            parameters = EpfReader(stream, strict=common.strict, limits=common.limits)
        if options.bap is not None:
            stream = stack.enter_context(open_binary(options.bap))
            bodies = BapReader(stream, strict=common.strict, limits=common.limits)
        with progress(common, "encoding", reader.nframes) as advance:
            pieces = encode_text(
                reader,
                writer,
                how,
                epf=parameters,
                baps=bodies,
                masks=options.masks,
                quant=options.quant,
                bap_quant=options.bap_quant,
                gender=options.gender,
                partial_type=options.mask_type,
                mode=options.mode,
                profile=options.profile,
                end_code=options.end_code,
                on_finding=common.report,
                on_progress=advance,
            )
            for piece in pieces:
                out.write(piece)
        for one in (reader, parameters, bodies):
            for finding in one.findings() if one is not None else ():
                common.report(finding)
