"""How far a decoder's FAP values may lie from the reference in the DCT mode.

Rules: DCT-8, CNF-16.

Derivation of model `dct-8`, version 1. A candidate computes each value as a sum of 16 terms F[k] step c_k
cos(...) in arithmetic of unit roundoff u (default 2**-24, single precision: the least that is expected of a
decoder; better arithmetic lies inside). Each term passes at most 6 roundings before the sum: F as a float, F
* step, c_k, the cosine, and two products (DC: step / 3 is not exact, but its cosine is 1). Summing 16 terms
in any order adds at most 15. So every term carries at most n = 21 factors (1 + d), |d| <= u, and the value is
off by at most g(u) * S with g(u) = 21u / (1 - 21u), S = sum of |term|. The reference itself is off by at most
g(2**-53) * S. Hence

    |candidate before rounding - reference before rounding| <= E = (g(u) + g(2**-53)) * S,

and rounding moves the candidate by at most 0.5 more: its integers lie within **bound = E + 0.5** of the
reference before rounding (S is itself computed in float64: its own error is below 2**-40 of it, which E is
widened by). The reference's integers lie within 0.5 of that, so two integers differ by at most bound + 0.5,
and never by more than 1: that is what can be said from integers alone. With the unrounded reference at hand
the sharp test is applied too; it finds a decoder that truncates instead of rounding, which a tolerance of 1
alone would let pass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.face.dct_transform import FOLLOWED, SEGMENT_FRAMES, DctReading, basis

MODEL: Final = "dct-8"
VERSION: Final = 1
SINGLE_PRECISION: Final = 1.0 / (1 << 24)
_DOUBLE_PRECISION: Final = 1.0 / (1 << 53)
_ROUNDINGS: Final = 21
_WIDENING: Final = 1.0 + 1.0 / (1 << 40)


@dataclass(frozen=True, slots=True)
class Mismatch:
    """The first value that is out of tolerance.

    Rules: DCT-8, CNF-17.

    `index`: place in the sequences; the length of the shorter one where the lengths differ. `reference`,
    `candidate`: the values, None behind the end. `distance`: of the candidate from the reference (unrounded
    where `limit` is the bound). `limit`: what was allowed.
    """

    index: int
    reference: int | None
    candidate: int | None
    distance: float
    limit: float


def comparison_bounds(
    coefficients: Sequence[int],
    step: Fraction,
    reading: DctReading = FOLLOWED,
    unit_roundoff: float = SINGLE_PRECISION,
) -> tuple[float, ...]:
    """E + 0.5 for each of the 16 values of a segment: see the module's derivation.

    Rules: DCT-8.

    `coefficients`: 16 quantised integers, DC first (the value). `step`: AC step. `unit_roundoff`: of the
    candidate's arithmetic, 0 < u <= 2**-8. Result: 16 bounds in FAP units. Raises `RangeViolation`.
    """
    if len(coefficients) != SEGMENT_FRAMES:
        raise RangeViolation("DCT-8", "coefficients", value=len(coefficients), allowed="16 integers")
    if not 0.0 < unit_roundoff <= 1.0 / 256.0:
        raise RangeViolation("DCT-8", "unit_roundoff", value=repr(unit_roundoff), allowed="above 0, at most 2**-8")
    growth = _growth(unit_roundoff) + _growth(_DOUBLE_PRECISION)
    numerator, denominator = step.numerator, step.denominator
    sums = [0.0] * SEGMENT_FRAMES
    table = basis(reading.normalisation)
    try:
        for k in range(1, SEGMENT_FRAMES):
            value = abs(coefficients[k]) * numerator / denominator
            sums = [total + value * abs(factor) for total, factor in zip(sums, table[k], strict=True)]
        constant = abs(coefficients[0]) * numerator / (denominator * reading.dc_step_ratio * reading.dc_divisor)
    except OverflowError:
        raise RangeViolation("DCT-8", "coefficients", allowed="values that float64 holds") from None
    return tuple([(total + constant) * growth * _WIDENING + 0.5 for total in sums])


def comparison_bound(
    coefficients: Sequence[int],
    step: Fraction,
    reading: DctReading = FOLLOWED,
    unit_roundoff: float = SINGLE_PRECISION,
) -> float:
    """The largest of `comparison_bounds`: the bound of one segment; a vector's is the largest of its
    segments'.

    Rules: DCT-8. Arguments and errors as `comparison_bounds`.
    """
    return max(comparison_bounds(coefficients, step, reading, unit_roundoff))


def first_mismatch(
    reference: Sequence[int],
    candidate: Sequence[int],
    bound: float,
    unrounded: Sequence[float] | None = None,
) -> Mismatch | None:
    """Compare decoded values with the reference's; None: every value is within tolerance.

    Rules: DCT-8, CNF-16.

    `reference`, `candidate`: FAP values in the same order. `bound`: of the vector (`comparison_bound`).
    `unrounded`: the reference before rounding, where it is known. A value passes if it differs from the
    reference's by at most min(1, bound + 0.5) and, with `unrounded`, lies within `bound` of it. Other lengths
    are a mismatch. Raises `RangeViolation` where `unrounded` has another length than `reference`.
    """
    if unrounded is not None and len(unrounded) != len(reference):
        raise RangeViolation("DCT-8", "unrounded", value=len(unrounded), allowed=f"{len(reference)} values")
    limit = min(1.0, bound + 0.5)
    for i, (wanted, got) in enumerate(zip(reference, candidate, strict=False)):
        difference = abs(got - wanted)
        if difference > limit:
            return Mismatch(i, wanted, got, float(difference) if difference < 1 << 1000 else float("inf"), limit)
        if unrounded is not None:
            distance = abs(got - unrounded[i])
            if distance > bound:
                return Mismatch(i, wanted, got, distance, bound)
    if len(reference) == len(candidate):
        return None
    i = min(len(reference), len(candidate))
    wanted_end = reference[i] if i < len(reference) else None
    got_end = candidate[i] if i < len(candidate) else None
    return Mismatch(i, wanted_end, got_end, float("inf"), limit)


def _growth(unit_roundoff: float) -> float:
    return _ROUNDINGS * unit_roundoff / (1.0 - _ROUNDINGS * unit_roundoff)
