"""The reference decoder for documents: coefficients, tables with frames, face definitions; texts are in `texts`.

Rules: CNF-1, CNF-2, CNF-16, CNF-24, CNF-25, DCT-3, DCT-5..7, DCT-13, FIT-1..9, FAT-1..9, FAT-11, FAC-1.

Output: `dctcoef`, `fap` and `bap` kind `fba`, `fit` kind `faces`, `fat` kind `vertices`. CNF-2 has no kind for the
units of a face: the suite's own is `fapu`, one line behind the header:

    {"format":"snhc-decoded","version":1,"kind":"fapu"}
    {"index":0,"units":{"ES":...,"ENS":...,"MNS":...,"MW":...,"IRISD":...,"AU":1e-05},"faps":[null,null,...68 entries]}

`units`: FAC-1, distance / 1024 in model units, AU in radians. `faps[i]`: what one step of FAP i + 1 is worth, in model
units or radians; null for FAP 1 and 2.

Tolerance model `geometry`, version 1. A decoder may compute vertices and units in single precision: the least that is
expected of it. For vertices the bound is that of `reference_impl/model/fat_bulk.py` (its derivation stands there), the
largest over all frames, meshes and coordinates. A unit is |a - b| / 1024: a and b as floats are off by u|a| and u|b|,
the difference by u|a - b| more, and the division is exact; so 2u(|a| + |b|) / 1024 bounds it, u = 2**-24, and twice
that is allowed. Either is rounded up to a power of two, so that it does not hang on the last bits of a matrix product.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from io import BytesIO
from math import frexp
from typing import Final

from snhc.analyzer.face_lines import fit_readings
from snhc.analyzer.face_scene import fat_readings
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.coefficients import decode_document as decode_coefficients
from snhc.reference_impl.face.coefficients import parse_document
from snhc.reference_impl.face.decoded import header_line
from snhc.reference_impl.face.reconstruct import dct_reading
from snhc.reference_impl.interpolation import fit
from snhc.reference_impl.interpolation.frames_json import faces_line, read_frames, vertices_line
from snhc.reference_impl.model import fat
from snhc.reference_impl.model.face_checks import check_neutral
from snhc.reference_impl.model.face_definition import FaceDefinition, parse_face_definition_json
from snhc.reference_impl.model.fapu import AU, UNIT_NAMES, fap_unit_names
from snhc.reference_impl.model.fat_bulk import BulkFat
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.systems.stream import Options

from .dct_tolerance import Unrounded, of_document, unrounded_document
from .decoding import Decoded
from .manifest import BAP, DCT_COEFFICIENTS, FACE, FAP, FAT, FIT, Tolerance
from .texts import bap_lines, fap_lines

GEOMETRY: Final = "geometry"
GEOMETRY_VERSION: Final = 1
KINDS: Final = {DCT_COEFFICIENTS: "fba", FIT: "faces", FAT: "vertices", FACE: "fapu", FAP: "fba", BAP: "fba"}
_U: Final = 2.0**-24
# The points whose distances are the units: FAC-1.
_MEASURED: Final = (("3.5", "3.6", 0), ("3.5", "9.15", 1), ("9.15", "2.2", 1), ("8.3", "8.4", 0), ("3.1", "3.3", 1))

_Report = Callable[[Finding], None]


def decode_document(media: str, data: bytes, aux: bytes, options: Options) -> Decoded:
    """Decode a document, up to its first fault. Rules: CNF-1, CNF-2, CNF-25.

    `media`: one of `manifest.DOCUMENTS`. `aux`: the frames that a table is used on.
    """
    lines: list[str] = []
    findings: list[Finding] = []
    error: SnhcError | None = None
    try:
        for line in _LINES[media](data, aux, options, findings.append):
            lines.append(line + "\n")
    except SnhcError as fault:
        error = fault
    return Decoded(tuple(lines), (), tuple(findings), error, KINDS[media])


def _coefficients(data: bytes, _: bytes, options: Options, report: _Report) -> Iterator[str]:
    document = parse_document(data, limit=options.limits.json_bytes)
    yield header_line("fba", options.readings)
    reading = dct_reading(options.readings.dc_step_ratio, options.readings.normalisation)
    for frame in decode_coefficients(document, reading):
        yield json.dumps(frame.as_json(), separators=(",", ":"))


def _faces(data: bytes, aux: bytes, options: Options, report: _Report) -> Iterator[str]:
    readings = fit_readings(options.readings)
    table = fit.parse_fit_json(
        data, impulse=readings.impulse, max_sets=options.limits.fit_sets, max_links=options.limits.fit_links
    )
    yield header_line("faces", options.readings)
    for frame in read_frames(BytesIO(aux), limit=options.limits.text_line_bytes):
        yield faces_line(fit.evaluate(table, frame, readings))


def _vertices(data: bytes, aux: bytes, options: Options, report: _Report) -> Iterator[str]:
    readings = fat_readings(options.readings)
    document = fat.parse_fat_json(data, max_vertices=options.limits.fat_vertices)
    yield header_line("vertices", options.readings)
    for frame in read_frames(BytesIO(aux), limit=options.limits.text_line_bytes):
        yield vertices_line(frame, fat.evaluate(document, frame, readings))


def _units(data: bytes, _: bytes, options: Options, report: _Report) -> Iterator[str]:
    face = parse_face_definition_json(data)
    units = face.fapu()
    for check in check_neutral(face):
        report(check.finding)
    yield header_line("fapu", options.readings)
    line = {
        "index": 0,
        "units": {**{name: units.unit(name) for name in UNIT_NAMES}, "AU": AU},
        "faps": [units.unit(name) if i >= 2 else None for i, name in enumerate(fap_unit_names())],
    }
    yield json.dumps(line, separators=(",", ":"))


def _fap(data: bytes, _: bytes, options: Options, report: _Report) -> Iterator[str]:
    return fap_lines(data, options, report)


def _bap(data: bytes, _: bytes, options: Options, report: _Report) -> Iterator[str]:
    return bap_lines(data, options, report)


_LINES: Final[dict[str, Callable[[bytes, bytes, Options, _Report], Iterator[str]]]] = {
    DCT_COEFFICIENTS: _coefficients, FIT: _faces, FAT: _vertices, FACE: _units, FAP: _fap, BAP: _bap,
}  # fmt: skip


def tolerance_of(media: str, data: bytes, aux: bytes, readings: Readings = DEFAULT_READINGS) -> Tolerance | None:
    """The tolerance of a document without faults; None for `fit` and texts, which are exact. Rules: CNF-16, DCT-8."""
    if media == DCT_COEFFICIENTS:
        return of_document(parse_document(data), dct_reading(readings.dc_step_ratio, readings.normalisation))
    if media == FAT:
        return _geometry(_vertex_bound(data, aux, readings))
    if media == FACE:
        return _geometry(_unit_bound(parse_face_definition_json(data)))
    return None


def unrounded(data: bytes, readings: Readings = DEFAULT_READINGS) -> list[Unrounded]:
    """The reference before rounding of a coefficient document, by line. Rules: DCT-8."""
    return unrounded_document(parse_document(data), dct_reading(readings.dc_step_ratio, readings.normalisation))


def _vertex_bound(data: bytes, aux: bytes, readings: Readings) -> float:
    frames = list(read_frames(BytesIO(aux)))
    bulk = BulkFat(fat.parse_fat_json(data), fat_readings(readings))
    return max((float(bound.max(initial=0.0)) for bound in bulk.bound(frames).values()), default=0.0)


def _unit_bound(face: FaceDefinition) -> float:
    sizes = [abs(face.point(one)[axis]) + abs(face.point(other)[axis]) for one, other, axis in _MEASURED]
    return 4.0 * _U * max(*sizes, 1024.0 * AU) / 1024.0


def _geometry(bound: float) -> Tolerance:
    # frexp: bound = fraction * 2**exponent, 1/2 <= fraction < 1.
    return Tolerance(GEOMETRY, GEOMETRY_VERSION, 2.0 ** frexp(bound)[1])
