"""The mesh side of `snhc encode`: documents and pictures.

Rules: CNF-1, CNF-19, CNF-22, MSH-23.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import click

from .common import Common, Output, open_binary
from .extras import needs_view

if TYPE_CHECKING:
    from collections.abc import Sequence
    from fractions import Fraction

    from snhc.reference_impl.systems.visual import StreamItem

ENCODES: Final = "FAP text, a mesh document, pictures or a dump"


@dataclass(frozen=True, slots=True)
class MeshOptions:
    """What the verb says about meshes; see its help. Rules: CNF-19."""

    rate: Fraction | None
    far: str
    design: str
    mask: str | None
    interior_nodes: int
    spacing: float
    search: int
    profile: int | None
    end_code: bool


def kind_of(head: bytes) -> str:
    """How to encode an input: `pictures`, `document`, or else `fap`.

    Rules: CNF-2, CNF-19. Raises InputFormat for what is known and cannot be encoded.
    """
    from snhc.reference_impl.bitstream.errors import InputFormat
    from snhc.reference_impl.documents.kinds import hint, kind_of_input

    kind = kind_of_input(head)
    if kind in ("pictures", "fap", ""):
        return kind or "fap"
    if kind in ("dump", "mesh", "decoded", "json"):
        return "document"
    if kind == "mp4":
        raise InputFormat("CNF-2", "file", value="MP4", allowed=ENCODES)
    raise InputFormat("CNF-2", "file", value=head[:4].hex(), allowed=f"{ENCODES}; {hint(head)}")


def encode_meshes(kind: str, first: bytes, files: Sequence[str], options: MeshOptions, common: Common) -> None:
    """Encode a dump, a mesh document, or pictures of which `first` is the first. Rules: CNF-19, CNF-25, MSH-23."""
    from snhc.reference_impl.systems.stream import write_stream

    with Output(common.output, common.keep_partial) as out:
        if kind == "document":
            from snhc.analyzer.dump_encode import encode_dump, is_dump

            if is_dump(first):
                out.write(encode_dump(first, limits=common.limits, profile=common.entropy_profile()))
                return
        items = _document(first, options, common) if kind == "document" else _pictures(first, files, options, common)
        out.write(write_stream(items))


def _document(data: bytes, options: MeshOptions, common: Common) -> list[StreamItem]:
    from snhc.reference_impl.mesh.document import read_mesh_document
    from snhc.reference_impl.systems.mesh_encoding import encode_mesh

    return encode_mesh(
        read_mesh_document(data, limits=common.limits),
        rate=options.rate,
        far=options.far,
        profile=options.profile,
        end_code=options.end_code,
        readings=common.readings,
        limits=common.limits,
    )


def _pictures(first: bytes, files: Sequence[str], options: MeshOptions, common: Common) -> list[StreamItem]:
    with needs_view("encode of pictures"):
        import numpy as np

        from snhc.reference_impl.mesh.render import open_picture
        from snhc.reference_impl.systems.mesh_encoding import encode_pictures

        def luminance(name: str, data: bytes | None = None) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
            if data is None:
                with open_binary(name) as file:
                    data = file.read()
            return np.asarray(open_picture(data, name).convert("L"))

        pictures = [luminance(files[0], first), *(luminance(name) for name in files[1:])]
        made = encode_pictures(
            pictures,
            design=options.design,
            mask=luminance(options.mask) if options.mask is not None else None,
            interior_nodes=options.interior_nodes,
            spacing=options.spacing,
            search=options.search,
            rate=options.rate,
            profile=options.profile,
            end_code=options.end_code,
        )
    if not common.quiet:
        click.echo(f"{made.nodes} nodes, {made.triangles} triangles", err=True)
        for number, value in enumerate(made.psnr, 1):
            click.echo(f"self-transfiguration, picture {number}: {value:.2f} dB", err=True)
    return made.items
