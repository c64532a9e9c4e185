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
from typing import TYPE_CHECKING, Final, Literal, final

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


Sixteen = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float, float, float, float,
]  # fmt: skip


@final
class _Row:
    """The first eight factors of a coefficient: the others are these backwards, of odd coefficients with the sign
    turned."""

    __slots__ = ("f0", "f1", "f2", "f3", "f4", "f5", "f6", "f7")

    def __init__(self, row: tuple[float, ...]) -> None:
        self.f0 = row[0]
        self.f1 = row[1]
        self.f2 = row[2]
        self.f3 = row[3]
        self.f4 = row[4]
        self.f5 = row[5]
        self.f6 = row[6]
        self.f7 = row[7]


@final
class Inverse:
    """The inverse transform of one reading. Rules: DCT-5, DCT-7."""

    __slots__ = ("dc_divisor", "rows")

    def __init__(self, reading: DctReading) -> None:
        # AC step / DC step, and 1 / c_0.
        self.dc_divisor = reading.dc_step_ratio * reading.dc_divisor
        self.rows = [_Row(row) for row in basis(reading.normalisation)]


@cache
def inverse_of(reading: DctReading = FOLLOWED) -> Inverse:
    """The inverse transform of a reading, made once. Rules: DCT-5, DCT-7."""
    return Inverse(reading)


@cache
def ac_steps(fap_quant: int) -> list[tuple[int, int]]:
    """`ac_step` by FAP number, as (numerator, denominator); entries 0 to 2 are (0, 1).

    Rules: DCT-5. Raises `RangeViolation` as `ac_step`.
    """
    steps = [ac_step(fap, fap_quant) for fap in range(3, 69)]
    return [(0, 1)] * 3 + [(step.numerator, step.denominator) for step in steps]


def _inverse(c: list[int], at: int, dc: int, numerator: int, denominator: int, inverse: Inverse) -> Sixteen:
    """`inverse_transform` of the AC coefficients behind `c[at]` and a DC."""
    # Sums by name: compiled, they are machine numbers.
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = 0.0
    s8 = s9 = s10 = s11 = s12 = s13 = s14 = s15 = 0.0
    try:
        for k in range(1, SEGMENT_FRAMES):
            level = c[at + k]
            # A term of a zero coefficient is +0 or -0 and changes no sum that began with +0.
            if level:
                value = level * numerator / denominator
                mirrored = -value if k & 1 else value
                row = inverse.rows[k]
                s0 += value * row.f0
                s1 += value * row.f1
                s2 += value * row.f2
                s3 += value * row.f3
                s4 += value * row.f4
                s5 += value * row.f5
                s6 += value * row.f6
                s7 += value * row.f7
                s8 += mirrored * row.f7
                s9 += mirrored * row.f6
                s10 += mirrored * row.f5
                s11 += mirrored * row.f4
                s12 += mirrored * row.f3
                s13 += mirrored * row.f2
                s14 += mirrored * row.f1
                s15 += mirrored * row.f0
        constant = dc * numerator / (denominator * inverse.dc_divisor)
    except OverflowError:
        raise RangeViolation("DCT-6", "coefficients", allowed="values that float64 holds") from None
    return (
        s0 + constant, s1 + constant, s2 + constant, s3 + constant,
        s4 + constant, s5 + constant, s6 + constant, s7 + constant,
        s8 + constant, s9 + constant, s10 + constant, s11 + constant,
        s12 + constant, s13 + constant, s14 + constant, s15 + constant,
    )  # fmt: skip


def inverse_transform(coefficients: Sequence[int], step: Fraction, reading: DctReading = FOLLOWED) -> tuple[float, ...]:
    """Dequantise 16 coefficients and transform them back; values not yet rounded.

    Rules: DCT-5, DCT-6, DCT-7. Ambiguities: AMB-DCT-1, AMB-DCT-2.

    `coefficients`: 16 quantised integers, DC first (the value, not a difference). `step`: AC step
    (`ac_step`). Result: 16 values in FAP units, float64: terms k = 1..15 ascending, the DC term added last.
    The DC term is one rounding of the exact quotient. Raises `RangeViolation` where the values leave the
    range of float64.
    """
    c = _sixteen(coefficients)
    return _inverse(c, 0, c[0], step.numerator, step.denominator, inverse_of(reading))


def _sixteen(coefficients: Sequence[int]) -> list[int]:
    if len(coefficients) != SEGMENT_FRAMES:
        raise RangeViolation("DCT-7", "coefficients", value=len(coefficients), allowed="16 integers")
    return list(coefficients)


def round_half_away(value: float) -> int:
    """Nearest integer, halves away from zero, exact for every finite float64.

    Rules: DCT-7.

    Adding 0.5 first would round on its own: 0.49999999999999994 + 0.5 is 1.
    """
    whole = int(value)
    rest = value - float(whole)
    if rest >= 0.5:
        return whole + 1
    if rest <= -0.5:
        return whole - 1
    return whole


def reconstruct_values(coefficients: Sequence[int], step: Fraction, reading: DctReading = FOLLOWED) -> tuple[int, ...]:
    """The 16 decoded FAP values of a segment: `inverse_transform`, rounded.

    Rules: DCT-5, DCT-6, DCT-7. Arguments and errors as `inverse_transform`.
    """
    c = _sixteen(coefficients)
    return block_values(c, 0, c[0], step.numerator, step.denominator, inverse_of(reading))


def block_values(
    blocks: list[int], at: int, dc: int, numerator: int, denominator: int, inverse: Inverse
) -> tuple[int, ...]:
    """`reconstruct_values` of a block among others: its AC coefficients stand behind `blocks[at]`.

    Rules: DCT-5, DCT-6, DCT-7. `dc`: the value. `numerator`, `denominator`: the AC step. Errors as `inverse_transform`.
    """
    s0, s1, s2, s3, s4, s5, s6, s7, \
        s8, s9, s10, s11, s12, s13, s14, s15 = _inverse(blocks, at, dc, numerator, denominator, inverse)  # fmt: skip
    return (
        round_half_away(s0), round_half_away(s1), round_half_away(s2), round_half_away(s3),
        round_half_away(s4), round_half_away(s5), round_half_away(s6), round_half_away(s7),
        round_half_away(s8), round_half_away(s9), round_half_away(s10), round_half_away(s11),
        round_half_away(s12), round_half_away(s13), round_half_away(s14), round_half_away(s15),
    )  # fmt: skip


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
