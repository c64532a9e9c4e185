"""The 16-point transform of the DCT mode: step sizes, dequantisation, IDCT, rounding.

Rules: DCT-5, DCT-6, DCT-7. Ambiguities: AMB-DCT-1, AMB-DCT-2.

Not here: segment syntax (DCT-1..4, DCT-9..15), the comparison model (`dct_comparison`, DCT-8), the forward
transform (`dct_encode`).

Every result is made of + - * / on float64 in one fixed order from decimal literals, so that it is the same on
every platform. `inverse_transforms` is the same arithmetic over arrays, equal bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Final, Literal

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.tables.loader import fap_dct_base_step, fap_dct_scale

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SEGMENT_FRAMES: Final = 16
MAX_EXACT: Final = 1 << 53

# sqrt(2/16) cos(j pi/32), j = 0..16: shortest decimals of the nearest floats (17 digits of the real number
# would be rounded twice). The product is rounded once: at j = 8 it is exactly 1/4, so that a value which
# lies exactly between two integers (only DC and coefficient 8 can make one) is rounded as DCT-7 says.
_ORTHONORMAL: Final[tuple[float, ...]] = (
    0.3535533905932738, 0.3518509343815956, 0.3467599613305369, 0.33832950029358816,
    0.32664074121909414, 0.31180625324666783, 0.29396890060483966, 0.2733004667504394,
    0.25, 0.22429189658565907, 0.19642373959677553, 0.16666391461943664,
    0.13529902503654925, 0.10263113188058935, 0.06897484482073575, 0.03465429229977286,
    0.0,
)  # fmt: skip
# cos(j pi/32), j = 0..16.
_COSINES: Final[tuple[float, ...]] = (
    1.0, 0.9951847266721969, 0.9807852804032304, 0.9569403357322088,
    0.9238795325112867, 0.881921264348355, 0.8314696123025452, 0.773010453362737,
    0.7071067811865476, 0.6343932841636455, 0.5555702330196022, 0.47139673682599764,
    0.3826834323650898, 0.2902846772544624, 0.19509032201612828, 0.0980171403295606,
    0.0,
)  # fmt: skip

Normalisation = Literal["orthonormal", "unnormalised"]


@dataclass(frozen=True, slots=True)
class DctReading:
    """The readings that concern the transform.

    Rules: DCT-5, DCT-7. Ambiguities: AMB-DCT-1, AMB-DCT-2.

    `dc_step_ratio`: AC step / DC step, 3 or (paper) 4. `normalisation`: `orthonormal`, or `unnormalised`: the
    forward transform is the plain sum of f[t] cos, its inverse has c_0 = 1/16 and c_k = 2/16.
    """

    dc_step_ratio: int = 3
    normalisation: Normalisation = "orthonormal"

    def __post_init__(self) -> None:
        if self.dc_step_ratio not in (3, 4):
            raise RangeViolation("DCT-5", "dc_step_ratio", value=self.dc_step_ratio, allowed="3, 4")
        if self.normalisation not in ("orthonormal", "unnormalised"):
            raise RangeViolation(
                "DCT-7", "normalisation", value=self.normalisation, allowed="orthonormal, unnormalised"
            )

    @property
    def dc_divisor(self) -> int:
        """1 / c_0: 4, or 16 unnormalised. Rules: DCT-7."""
        return 4 if self.normalisation == "orthonormal" else 16


FOLLOWED: Final = DctReading()


@cache
def ac_step(fap: int, fap_quant: int) -> Fraction:
    """Step size of the AC coefficients, in FAP units, exact.

    Rules: DCT-5.

    `fap`: 3..68. `fap_quant`: 0..31, index of the scale list (0 is an ordinary index). Raises
    `RangeViolation`.
    """
    if not 3 <= fap <= 68:
        raise RangeViolation("DCT-5", "fap", value=fap, allowed="3..68")
    scale = fap_dct_scale()
    if not 0 <= fap_quant < len(scale):
        raise RangeViolation("DCT-5", "fap_quant", value=fap_quant, allowed=f"0..{len(scale) - 1}")
    return scale[fap_quant] * fap_dct_base_step()[fap - 1]


def dc_step(fap: int, fap_quant: int, reading: DctReading = FOLLOWED) -> Fraction:
    """Step size of the DC coefficient, in FAP units, exact: AC step / `dc_step_ratio`.

    Rules: DCT-5. Ambiguities: AMB-DCT-1. Arguments and errors as `ac_step`.
    """
    return ac_step(fap, fap_quant) / reading.dc_step_ratio


@cache
def basis(normalisation: Normalisation = "orthonormal") -> tuple[tuple[float, ...], ...]:
    """Factors of the AC terms of the IDCT: `basis()[k][t]` = c_k cos((2t+1) k pi / 32); row 0 holds c_0.

    Rules: DCT-7. Ambiguities: AMB-DCT-2.
    """
    if normalisation == "orthonormal":
        zero, magnitudes = 0.25, _ORTHONORMAL
    else:
        # Division by a power of two is exact.
        zero, magnitudes = 0.0625, tuple(cosine / 8.0 for cosine in _COSINES)
    rows: list[tuple[float, ...]] = [(zero,) * SEGMENT_FRAMES]
    for k in range(1, SEGMENT_FRAMES):
        row: list[float] = []
        for t in range(SEGMENT_FRAMES):
            # cos(m pi/32) has period 64 and is even; cos(pi - x) = -cos x.
            m = (2 * t + 1) * k % 64
            m = min(m, 64 - m)
            row.append(magnitudes[m] if m <= 16 else -magnitudes[32 - m])
        rows.append(tuple(row))
    return tuple(rows)


def inverse_transform(coefficients: Sequence[int], step: Fraction, reading: DctReading = FOLLOWED) -> tuple[float, ...]:
    """Dequantise 16 coefficients and transform them back; values not yet rounded.

    Rules: DCT-5, DCT-6, DCT-7. Ambiguities: AMB-DCT-1, AMB-DCT-2.

    `coefficients`: 16 quantised integers, DC first (the value, not a difference). `step`: AC step
    (`ac_step`). Result: 16 values in FAP units, float64: terms k = 1..15 ascending, the DC term added last.
    The DC term is one rounding of the exact quotient. Raises `RangeViolation` where the values leave the
    range of float64.
    """
    if len(coefficients) != SEGMENT_FRAMES:
        raise RangeViolation("DCT-7", "coefficients", value=len(coefficients), allowed="16 integers")
    numerator, denominator = step.numerator, step.denominator
    table = basis(reading.normalisation)
    sums = [0.0] * SEGMENT_FRAMES
    try:
        for k in range(1, SEGMENT_FRAMES):
            # A term of a zero coefficient is +0 or -0 and changes no sum that began with +0.
            if coefficients[k]:
                value = coefficients[k] * numerator / denominator
                sums = [total + value * factor for total, factor in zip(sums, table[k])]
        constant = coefficients[0] * numerator / (denominator * reading.dc_step_ratio * reading.dc_divisor)
    except OverflowError:
        raise RangeViolation("DCT-6", "coefficients", allowed="values that float64 holds") from None
    return tuple([total + constant for total in sums])


def round_half_away(value: float) -> int:
    """Nearest integer, halves away from zero, exact for every finite float64.

    Rules: DCT-7.

    Adding 0.5 first would round on its own: 0.49999999999999994 + 0.5 is 1.
    """
    whole = int(value)
    rest = value - whole
    if rest >= 0.5:
        return whole + 1
    if rest <= -0.5:
        return whole - 1
    return whole


def reconstruct_values(coefficients: Sequence[int], step: Fraction, reading: DctReading = FOLLOWED) -> tuple[int, ...]:
    """The 16 decoded FAP values of a segment: `inverse_transform`, rounded.

    Rules: DCT-5, DCT-6, DCT-7. Arguments and errors as `inverse_transform`.
    """
    out: list[int] = []
    for value in inverse_transform(coefficients, step, reading):
        # `round_half_away`, without the call.
        whole = int(value)
        rest = value - whole
        out.append(whole + 1 if rest >= 0.5 else whole - 1 if rest <= -0.5 else whole)
    return tuple(out)


def inverse_transforms(
    coefficients: NDArray[np.int64], steps: Sequence[Fraction], reading: DctReading = FOLLOWED
) -> NDArray[np.float64]:
    """`inverse_transform` of many segments at once, equal bit for bit.

    Rules: DCT-5, DCT-6, DCT-7.

    `coefficients`: (n, 16) int64, DC first. `steps`: n AC steps. Result: (n, 16) float64, not rounded. Raises
    `RangeViolation` for another shape, and where a coefficient times its step's numerator passes 2**53 (only
    there could integers and floats disagree; no value that the syntax can carry gets so far).
    """
    import numpy as np

    if coefficients.ndim != 2 or coefficients.shape != (len(steps), SEGMENT_FRAMES):
        raise RangeViolation("DCT-7", "coefficients", value=str(coefficients.shape), allowed=f"({len(steps)}, 16)")
    numerators = [step.numerator for step in steps]
    denominators = np.array([float(step.denominator) for step in steps])
    largest = max(-int(coefficients.min(initial=0)), int(coefficients.max(initial=0)))
    if largest * max((abs(n) for n in numerators), default=0) > MAX_EXACT:
        raise RangeViolation("DCT-6", "coefficients", value=largest, allowed="at most 2**53 / step")
    scaled = (coefficients * np.array(numerators, dtype=np.int64)[:, None]).astype(np.float64)
    table = np.array(basis(reading.normalisation))
    values = scaled / denominators[:, None]
    sums = np.zeros(coefficients.shape)
    for k in range(1, SEGMENT_FRAMES):
        sums += values[:, k, None] * table[k]
    constants = scaled[:, 0] / (denominators * float(reading.dc_step_ratio * reading.dc_divisor))
    result: NDArray[np.float64] = sums + constants[:, None]
    return result


def round_all_half_away(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """`round_half_away` of an array.

    Rules: DCT-7.

    `values`: any shape, magnitudes below 2**63. Result: int64 of the same shape.
    """
    import numpy as np

    whole = np.trunc(values)
    rest = values - whole
    result: NDArray[np.int64] = (whole + (rest >= 0.5) - (rest <= -0.5)).astype(np.int64)
    return result
