"""The tolerance that goes with a DCT vector: model, version and the bound computed from its coefficients.

Rules: DCT-8, CNF-3, CNF-16. The derivation is in `reference_impl/face/dct_comparison.py`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from snhc.reference_impl.face.coefficients import CoefficientDocument
from snhc.reference_impl.face.dct_comparison import MODEL, VERSION, comparison_bound
from snhc.reference_impl.face.dct_transform import FOLLOWED, DctReading, ac_step
from snhc.reference_impl.face.reconstruct import dct_reading
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far a decoder may be off. Rules: DCT-8, CNF-3. `bound`: from the reference before rounding, FAP units."""

    model: str
    version: int
    bound: float

    def as_json(self) -> dict[str, str | int | float]:
        """The manifest's `tolerance`."""
        return {"model": self.model, "version": self.version, "bound": self.bound}


def of_planes(planes: Iterable[FbaPlane], readings: Readings = DEFAULT_READINGS) -> Tolerance | None:
    """The tolerance of a decoded object; None where no plane has coefficients: the comparison is exact then.

    Rules: DCT-3, DCT-8. `planes`: of one object, from its first, each with its frames.
    """
    reading = dct_reading(readings.dc_step_ratio, readings.normalisation)
    bounds: list[float] = []
    dc: dict[int, int] = {}
    quant = 0
    for plane in planes:
        data = plane.faps
        if data is None or data.segment is None:
            continue
        if plane.is_intra:
            quant = data.quant
            dc = {}
        coded = [fap for fap in range(3, 69) if plane.frames[0].state[fap - 1] == "T"]
        for fap, run in zip(coded, data.segment.runs, strict=True):
            coefficients = run.coefficients()
            coefficients[0] += dc.get(fap, 0)
            dc[fap] = coefficients[0]
            bounds.append(comparison_bound(coefficients, ac_step(fap, quant), reading))
    return _tolerance(bounds)


def of_document(document: CoefficientDocument, reading: DctReading = FOLLOWED) -> Tolerance | None:
    """The tolerance of a coefficient document without faults. Rules: DCT-3, DCT-8."""
    bounds: list[float] = []
    dc: dict[int, int] = {}
    for segment in document.segments:
        for fap, (first, *rest) in segment.coefficients.items():
            dc[fap] = first if segment.intra else dc[fap] + first
            step: Fraction = ac_step(fap, document.fap_quant)
            bounds.append(comparison_bound([dc[fap], *rest], step, reading))
    return _tolerance(bounds)


def _tolerance(bounds: list[float]) -> Tolerance | None:
    return Tolerance(MODEL, VERSION, max(bounds)) if bounds else None
