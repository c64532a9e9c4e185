"""Coefficient documents: quantised DCT integers as JSON, decoded to FAP values without any entropy table.

Rules: DCT-3 (inter DC), DCT-5, DCT-6, DCT-7, DCT-13 (sixteen instants per segment), CNF-1 (lines), CNF-22,
CNF-25. Ambiguities: AMB-DCT-1, AMB-DCT-2.

Not here: FAP 1 and FAP 2 (DCT-9, DCT-10): a document that has them is `InputFormat`.

    {"fap_quant": 8, "segments": [{"intra": true, "coefficients": {"3": [6, -5, 0, 2, 0, ...16 integers]}}]}

The form of a document is checked whole before anything is decoded; what depends on earlier segments is found
where it stands, when the lines before it have been made.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat
from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES, as_array, as_int, as_object, parse_json
from snhc.reference_impl.face.dct_transform import (
    FOLLOWED,
    SEGMENT_FRAMES,
    DctReading,
    ac_step,
    reconstruct_values,
)

FRAME_RATE: Final = 30
_FAPS: Final = 68
_KEYS: Final = {str(fap): fap for fap in range(3, _FAPS + 1)}
# What the widest field of the syntax, s(32) of DCT-3, can carry.
_LEAST: Final = -(1 << 31)
_GREATEST: Final = (1 << 31) - 1


@dataclass(frozen=True, slots=True)
class CoefficientSegment:
    """One segment of a document.

    Rules: DCT-1, DCT-3.

    `intra`: DC values; else DC differences to the same FAP's last segment. `coefficients`: FAP 3..68,
    ascending -> 16 quantised integers.
    """

    intra: bool
    coefficients: dict[int, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class CoefficientDocument:
    """A document of the right form. Rules: DCT-5, DCT-13. `fap_quant`: 0..31."""

    fap_quant: int
    segments: tuple[CoefficientSegment, ...]


@dataclass(frozen=True, slots=True)
class DctFrame:
    """One decoded instant.

    Rules: CNF-1, DCT-13.

    `index`: from 0. `time`: seconds. `intra`: of its segment. `faps`: 68 values in FAP units, FAP 1 first,
    None while unset. `state`: 68 letters T, R, U.
    """

    index: int
    time: Fraction
    intra: bool
    faps: tuple[int | None, ...]
    state: str

    def as_json(self) -> dict[str, object]:
        """The object of a `snhc-decoded` line. Rules: CNF-1."""
        return {
            "index": self.index,
            "time": f"{self.time.numerator}/{self.time.denominator}",
            "intra": self.intra,
            "faps": list(self.faps),
            "viseme": None,
            "expression": None,
            "state": self.state,
        }


def parse_document(data: bytes | str, *, limit: int = MAX_JSON_BYTES) -> CoefficientDocument:
    """Read a coefficient document.

    Rules: DCT-1, DCT-5, CNF-22, CNF-25.

    `data`: JSON text, `limit` bytes at most. Unknown keys are ignored. Raises `ResourceLimit` past the limit,
    `InputFormat` (line and column, or path) for what is no such document: not JSON, a key missing, FAP 1 or 2
    or no FAP at all, other than 16 integers; `RangeViolation` (path) for fap_quant outside 0..31 and for
    integers that no field of the syntax holds (32 bits).
    """
    root = as_object(parse_json(data, rule="DCT-1", what="coefficient document", limit=limit), "", "DCT-1")
    fap_quant = as_int(_member(root, "fap_quant", ""), "fap_quant", "DCT-5", 0, 31)
    segments = as_array(_member(root, "segments", ""), "segments", "DCT-1")
    return CoefficientDocument(fap_quant, tuple(_segment(s, f"segments[{i}]") for i, s in enumerate(segments)))


def _member(holder: object, key: str, path: str) -> object:
    members = as_object(holder, path, "DCT-1")
    if key not in members:
        raise InputFormat("DCT-1", key, value="missing", allowed=f"an object with the key {key}", path=path)
    return members[key]


def _segment(value: object, path: str) -> CoefficientSegment:
    intra = _member(value, "intra", path)
    if not isinstance(intra, bool):
        raise InputFormat("DCT-1", "intra", value=_shown(intra), allowed="true, false", path=f"{path}.intra")
    inside = f"{path}.coefficients"
    members = as_object(_member(value, "coefficients", path), inside, "DCT-1")
    coefficients: dict[int, tuple[int, ...]] = {}
    for key in members:
        if key not in _KEYS:
            raise InputFormat("DCT-1", "FAP", value=key[:40], allowed="3..68", path=inside)
    for key, fap in _KEYS.items():
        if key not in members:
            continue
        where = f"{inside}.{key}"
        array = as_array(members[key], where, "DCT-1")
        if len(array) != SEGMENT_FRAMES:
            raise InputFormat(
                "DCT-1",
                "coefficients",
                value=len(array),
                allowed="16 integers",
                path=where,
                expected=SEGMENT_FRAMES,
            )
        coefficients[fap] = tuple(
            as_int(v, f"{where}[{k}]", "DCT-3" if k == 0 else "DCT-4", _LEAST, _GREATEST) for k, v in enumerate(array)
        )
    return CoefficientSegment(intra, coefficients)


def _shown(value: object) -> str:
    return repr(value)[:40] if isinstance(value, (str, float, int)) else type(value).__name__


def decode_document(document: CoefficientDocument, reading: DctReading = FOLLOWED) -> Iterator[DctFrame]:
    """Decode a document segment by segment.

    Rules: DCT-3, DCT-5, DCT-6, DCT-7, DCT-13, CNF-1. Ambiguities: AMB-DCT-1, AMB-DCT-2.

    Yields 16 frames per segment at 30 Hz from time 0. A FAP of the segment is T, one that was sent before R
    with its last value, any other U. The predictor of an inter DC is the quantised DC of the FAP's last
    segment, so rounding does not accumulate. Raises `InconsistentSemantics` (path) at an inter segment that
    comes first or has a FAP never sent; frames of the segments before it have been yielded by then.
    """
    last_dc: dict[int, int] = {}
    held: list[int | None] = [None] * _FAPS
    index = 0
    for i, segment in enumerate(document.segments):
        values = _decode_segment(segment, f"segments[{i}]", i == 0, document.fap_quant, last_dc, reading)
        state = "".join("T" if fap in values else "U" if held[fap - 1] is None else "R" for fap in range(1, _FAPS + 1))
        for t in range(SEGMENT_FRAMES):
            for fap, curve in values.items():
                held[fap - 1] = curve[t]
            yield DctFrame(index, Fraction(index, FRAME_RATE), segment.intra, tuple(held), state)
            index += 1


def _decode_segment(
    segment: CoefficientSegment,
    path: str,
    first: bool,
    fap_quant: int,
    last_dc: dict[int, int],
    reading: DctReading,
) -> dict[int, tuple[int, ...]]:
    if first and not segment.intra:
        raise InconsistentSemantics(
            "DCT-13", "intra", value="false", allowed="true in the first segment", path=f"{path}.intra"
        )
    curves: dict[int, tuple[int, ...]] = {}
    for fap, coefficients in segment.coefficients.items():
        dc = coefficients[0]
        if not segment.intra:
            if fap not in last_dc:
                raise InconsistentSemantics(
                    "DCT-13",
                    "FAP",
                    value=fap,
                    allowed="FAPs of earlier segments",
                    path=f"{path}.coefficients.{fap}",
                )
            dc += last_dc[fap]
        last_dc[fap] = dc
        curves[fap] = reconstruct_values((dc, *coefficients[1:]), ac_step(fap, fap_quant), reading)
    return curves
