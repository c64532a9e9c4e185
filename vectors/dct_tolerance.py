"""The tolerance that goes with a DCT vector: model, version and the bound computed from its coefficients.

Rules: DCT-8, CNF-3, CNF-16. The derivation is in `reference_impl/face/dct_comparison.py`. Also the reference before
rounding, which the bound is held against: FAPs whose value does not come from a segment are exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Final

from snhc.reference_impl.face.coefficients import CoefficientDocument
from snhc.reference_impl.face.dct_comparison import MODEL, VERSION, comparison_bound
from snhc.reference_impl.face.dct_transform import (
    FOLLOWED,
    SEGMENT_FRAMES,
    DctReading,
    ac_step,
    inverse_transform,
)
from snhc.reference_impl.face.reconstruct import dct_reading
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings

from .manifest import Tolerance

Unrounded = tuple["float | None", ...]
"""By FAP, FAP 1 first: the value before rounding, None where the value does not come from a segment. Rules: DCT-8."""

_EXACT: Final[Unrounded] = (None,) * 68


def _segments(
    planes: Iterable[FbaPlane],
) -> Iterator[tuple[FbaPlane, list[tuple[int, list[int], Fraction]]]]:
    """Each plane with its segment's FAPs: number, coefficients (DC as a value), AC step."""
    dc: dict[int, int] = {}
    quant = 0
    for plane in planes:
        out: list[tuple[int, list[int], Fraction]] = []
        data = plane.faps
        if data is not None and data.segment is not None:
            if plane.is_intra:
                quant = data.quant
                dc = {}
            coded = [fap for fap in range(3, 69) if plane.frames[0].state[fap - 1] == "T"]
            for fap, run in zip(coded, data.segment.runs, strict=True):
                coefficients = run.coefficients()
                coefficients[0] += dc.get(fap, 0)
                dc[fap] = coefficients[0]
                out.append((fap, coefficients, ac_step(fap, quant)))
        yield plane, out


def of_planes(planes: Iterable[FbaPlane], readings: Readings = DEFAULT_READINGS) -> Tolerance | None:
    """The tolerance of a decoded object; None where no plane has coefficients: the comparison is exact then.

    Rules: DCT-3, DCT-8. `planes`: of one object, from its first, each with its frames.
    """
    reading = dct_reading(readings.dc_step_ratio, readings.normalisation)
    return _tolerance(
        [comparison_bound(numbers, step, reading) for _, segment in _segments(planes) for _, numbers, step in segment]
    )


def unrounded_planes(
    planes: Iterable[FbaPlane], readings: Readings = DEFAULT_READINGS
) -> Iterator[tuple[FbaPlane, list[Unrounded]]]:
    """Each plane with the reference before rounding, one entry per frame. Rules: DCT-8, DCT-13, FBA-37."""
    reading = dct_reading(readings.dc_step_ratio, readings.normalisation)
    held = list(_EXACT)
    for plane, segment in _segments(planes):
        curves = {fap: inverse_transform(numbers, step, reading) for fap, numbers, step in segment}
        rows: list[Unrounded] = []
        for i, frame in enumerate(plane.frames):
            for fap in range(3, 69):
                letter = frame.state[fap - 1]
                if letter == "T":
                    held[fap - 1] = curves[fap][i] if fap in curves else None
                elif letter != "R":
                    held[fap - 1] = None
            rows.append(tuple(held))
        yield plane, rows


def _document_segments(document: CoefficientDocument) -> Iterator[dict[int, tuple[list[int], Fraction]]]:
    dc: dict[int, int] = {}
    for segment in document.segments:
        out: dict[int, tuple[list[int], Fraction]] = {}
        for fap, (first, *rest) in segment.coefficients.items():
            dc[fap] = first if segment.intra else dc[fap] + first
            out[fap] = [dc[fap], *rest], ac_step(fap, document.fap_quant)
        yield out


def of_document(document: CoefficientDocument, reading: DctReading = FOLLOWED) -> Tolerance | None:
    """The tolerance of a coefficient document without faults. Rules: DCT-3, DCT-8."""
    return _tolerance(
        [
            comparison_bound(numbers, step, reading)
            for segment in _document_segments(document)
            for numbers, step in segment.values()
        ]
    )


def unrounded_document(document: CoefficientDocument, reading: DctReading = FOLLOWED) -> list[Unrounded]:
    """The reference before rounding, one entry per line. Rules: DCT-8, DCT-13."""
    held = list(_EXACT)
    out: list[Unrounded] = []
    for segment in _document_segments(document):
        curves = {fap: inverse_transform(numbers, step, reading) for fap, (numbers, step) in segment.items()}
        for t in range(SEGMENT_FRAMES):
            for fap, curve in curves.items():
                held[fap - 1] = curve[t]
            out.append(tuple(held))
    return out


def _tolerance(bounds: list[float]) -> Tolerance | None:
    return Tolerance(MODEL, VERSION, max(bounds)) if bounds else None
