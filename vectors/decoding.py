"""The reference decoder as the suite uses it: bytes in, CNF-1 lines and at most one fault out.

Rules: CNF-1, CNF-24, CNF-26. Documents (coefficients, tables, face definitions) are decoded in `documents`.
"""

from __future__ import annotations

from dataclasses import dataclass

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.systems.output import NdjsonWriter
from snhc.reference_impl.systems.stream import Options, decode_planes

from .manifest import DOCUMENTS


@dataclass(frozen=True, slots=True)
class Decoded:
    """What the reference decoder makes of an input.

    Rules: CNF-1, CNF-26. `lines`: with newlines, the header first (none for `InputFormat`); `frames`: one per line
    behind the header, of bitstreams; `error`: the fault that ended the stream; `kind`: of the object, `fba` or `mesh`,
    or of what the document gives.
    """

    lines: tuple[str, ...]
    frames: tuple[FaceFrame | MeshFrame, ...]
    findings: tuple[Finding, ...]
    error: SnhcError | None
    kind: str = ""

    @property
    def text(self) -> str:
        """All lines as one text."""
        return "".join(self.lines)


def decode(data: bytes, options: Options) -> Decoded:
    """Decode a whole stream, up to its first fault. Rules: CNF-1, CNF-26."""
    lines: list[bytes] = []
    frames: list[FaceFrame | MeshFrame] = []
    findings: list[Finding] = []
    error: SnhcError | None = None
    kinds: list[str] = []
    writer = NdjsonWriter(lines.append, readings=options.readings, profile=options.profile)

    def found(kind: str) -> None:
        kinds.append(kind)
        writer.begin(kind)

    try:
        for plane in decode_planes(data, options, findings.append, found):
            frames.extend(plane.frames)
            writer.plane(plane)
    except SnhcError as fault:
        error = fault
    writer.end()
    return Decoded(tuple(line.decode() for line in lines), tuple(frames), tuple(findings), error, "".join(kinds))


def decode_input(media: str, data: bytes, aux: bytes | None, options: Options) -> Decoded:
    """Decode the input of a vector, whatever it is. Rules: CNF-1, CNF-2, CNF-3. `aux`: the second file, or None."""
    if media not in DOCUMENTS:
        return decode(data, options)
    # Documents need numpy, which a decoder of streams must not wait for.
    from .documents import decode_document

    return decode_document(media, data, aux or b"", options)
