"""Encoder side of the DCT mode: forward transform, quantiser, runs and levels, escapes.

Rules: DCT-2, DCT-3, DCT-4 (as data: which symbols and fields; the bits are the syntax functions'), DCT-5,
DCT-6, DCT-7 and the informative encoder of the same text (DCT-II, mid-tread quantiser, halves away from
zero). Ambiguities: AMB-DCT-1, AMB-DCT-2, AMB-DCT-4.

Not here: rate control, viseme and expression segments (DCT-9, DCT-10).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics, RangeViolation
from snhc.reference_impl.face.dct_transform import (
    FOLLOWED,
    MAX_EXACT,
    SEGMENT_FRAMES,
    DctReading,
    basis,
    round_all_half_away,
    round_half_away,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

END_OF_SEGMENT: Final = 15
AC_ESCAPE: Final = 256
DC_ESCAPE: Final = 0
SYMBOL_OFFSET: Final = 256
_WIDE_ESCAPE: Final = -(1 << 15)


def forward_transform(values: Sequence[int], reading: DctReading = FOLLOWED) -> tuple[float, ...]:
    """16-point DCT-II of FAP values.

    Rules: DCT-7 (its inverse). Ambiguities: AMB-DCT-2.

    `values`: 16 FAP values. Result: 16 float64, DC first: DC is one rounding of the exact quotient, the
    others are sums over t = 0..15 ascending. Raises `EncodeError` for another number of values or one beyond
    2**53.
    """
    if len(values) != SEGMENT_FRAMES:
        raise EncodeError("DCT-7", "values", value=len(values), allowed="16 integers")
    if max(values) > MAX_EXACT or min(values) < -MAX_EXACT:
        raise EncodeError("DCT-7", "values", allowed="-2**53..2**53")
    out = [sum(values) / _forward_divisor(reading)]
    for factors in _forward_basis(reading)[1:]:
        total = 0.0
        for value, factor in zip(values, factors, strict=True):
            total += value * factor
        out.append(total)
    return tuple(out)


def quantise_segment(values: Sequence[int], step: Fraction, reading: DctReading = FOLLOWED) -> tuple[int, ...]:
    """Transform and quantise 16 FAP values.

    Rules: DCT-5, DCT-6. Ambiguities: AMB-DCT-1, AMB-DCT-2.

    `values`: 16 FAP values. `step`: AC step (`ac_step`). Result: 16 integers, DC first (the value, not yet a
    difference): nearest multiples of the step, halves away from zero; DC by exact integer arithmetic. Errors
    as `forward_transform`.
    """
    transformed = forward_transform(values, reading)
    size = step.numerator / step.denominator
    levels = [round_half_away(value / size) for value in transformed]
    levels[0] = _divide_half_away(*_dc_quotient(sum(values), step, reading))
    return tuple(levels)


def quantise_segments(
    values: NDArray[np.int64], steps: Sequence[Fraction], reading: DctReading = FOLLOWED
) -> NDArray[np.int64]:
    """`quantise_segment` of many segments at once, equal integer for integer.

    Rules: DCT-5, DCT-6.

    `values`: (n, 16) int64. `steps`: n AC steps. Result: (n, 16) int64, DC first. Raises `EncodeError` for
    another shape or values beyond 2**40.
    """
    import numpy as np

    if values.ndim != 2 or values.shape != (len(steps), SEGMENT_FRAMES):
        raise EncodeError("DCT-7", "values", value=str(values.shape), allowed=f"({len(steps)}, 16)")
    if values.size and (int(values.max()) > 1 << 40 or int(values.min()) < -(1 << 40)):
        raise EncodeError("DCT-7", "values", allowed="-2**40..2**40")
    table = np.array(_forward_basis(reading))
    sums = np.zeros(values.shape)
    exact = values.astype(np.float64)
    for t in range(SEGMENT_FRAMES):
        sums += exact[:, t, None] * table[:, t]
    sizes = np.array([step.numerator / step.denominator for step in steps])
    levels = round_all_half_away(sums / sizes[:, None])
    quotients = [_dc_quotient(1, step, reading) for step in steps]
    above = values.sum(axis=1) * np.array([n for n, _ in quotients], dtype=np.int64)
    below = np.array([d for _, d in quotients], dtype=np.int64)
    # The halves of integers: away from zero is |a| + b/2 divided downward, with the sign put back.
    levels[:, 0] = np.sign(above) * ((2 * np.abs(above) + below) // (2 * below))
    return levels


def run_levels(coefficients: Sequence[int], *, end_after_last: bool = False) -> list[tuple[int, int]]:
    """The (run, level) pairs of a segment's AC coefficients, with its end symbol as (`END_OF_SEGMENT`, 0).

    Rules: DCT-4. Ambiguities: AMB-DCT-4.

    `coefficients`: 16 quantised integers; the DC at index 0 is not looked at. `end_after_last`: the other
    reading, where an end symbol follows a coefficient at index 15 as well. Runs are 0..14; levels are never 0
    but in the end symbol. Raises `EncodeError` for another number of coefficients.
    """
    if len(coefficients) != SEGMENT_FRAMES:
        raise EncodeError("DCT-4", "coefficients", value=len(coefficients), allowed="16 integers")
    pairs: list[tuple[int, int]] = []
    run = 0
    for level in coefficients[1:]:
        if level:
            pairs.append((run, level))
            run = 0
        else:
            run += 1
    if run or end_after_last:
        pairs.append((END_OF_SEGMENT, 0))
    return pairs


def coefficients_of(pairs: Sequence[tuple[int, int]], dc: int = 0, *, end_after_last: bool = False) -> list[int]:
    """The inverse of `run_levels`: 16 coefficients, `dc` first.

    Rules: DCT-4. Ambiguities: AMB-DCT-4.

    `pairs`: as `run_levels` makes them; a level 0 (an escaped zero) is taken. Raises `RangeViolation` for a
    run that is none or leads past index 15, `InconsistentSemantics` for pairs that end too early or go on
    behind the end.
    """
    out = [dc] + [0] * (SEGMENT_FRAMES - 1)
    last = SEGMENT_FRAMES - 1
    k = 0
    ended = False
    for i, (run, level) in enumerate(pairs):
        path = f"pairs[{i}]"
        if ended or (k == last and not (end_after_last and run == END_OF_SEGMENT)):
            raise InconsistentSemantics("DCT-4", "run", value=run, allowed="nothing behind the end", path=path)
        if run == END_OF_SEGMENT:
            ended = True
            continue
        if not 0 <= run < END_OF_SEGMENT or k + 1 + run > last:
            raise RangeViolation("DCT-4", "run", value=run, allowed=f"0..{last - 1 - k}, {END_OF_SEGMENT}", path=path)
        k += 1 + run
        out[k] = level
    if not ended and (k < last or end_after_last):
        raise InconsistentSemantics("DCT-4", "run", allowed=f"{END_OF_SEGMENT} at the end", path=f"pairs[{len(pairs)}]")
    return out


def ac_symbol(level: int) -> int:
    """Symbol of vlc(AC) for a level: level + 256, or `AC_ESCAPE` outside -256..255.

    Rules: DCT-4. A level 0 (legal to read, never written) has no word of its own: the sum is the escape.
    """
    return level + SYMBOL_OFFSET if -256 <= level <= 255 else AC_ESCAPE


def dc_symbol(difference: int) -> int:
    """Symbol of vlc(DC) for an inter difference: difference + 256, or `DC_ESCAPE` outside -255..255.

    Rules: DCT-3.
    """
    return difference + SYMBOL_OFFSET if -255 <= difference <= 255 else DC_ESCAPE


def escape_fields(value: int, wide_bits: int) -> list[tuple[int, int]]:
    """The two's complement fields (value, bits) of an intra DC, or of what follows an escape symbol.

    Rules: DCT-2, DCT-3, DCT-4.

    `wide_bits`: size of the second field, 31 (intra DC, AC) or 32 (inter DC). One field s(16), or -32768 and
    the value in the second one. Raises `EncodeError` where even that does not hold it.
    """
    if _WIDE_ESCAPE < value < 1 << 15:
        return [(value, 16)]
    half = 1 << (wide_bits - 1)
    if not -half <= value < half:
        raise EncodeError("DCT-2", "coefficient", value=value, allowed=f"{-half}..{half - 1}")
    return [(_WIDE_ESCAPE, 16), (value, wide_bits)]


def _forward_divisor(reading: DctReading) -> int:
    return 4 if reading.normalisation == "orthonormal" else 1


def _forward_basis(reading: DctReading) -> tuple[tuple[float, ...], ...]:
    table = basis(reading.normalisation)
    if reading.normalisation == "orthonormal":
        return table
    # The inverse of this reading holds 1/16 and cos/8: times a power of two, hence exact.
    return (tuple(f * 16.0 for f in table[0]), *(tuple(f * 8.0 for f in row) for row in table[1:]))


def _dc_quotient(total: int, step: Fraction, reading: DctReading) -> tuple[int, int]:
    """The unrounded DC level of 16 values of sum `total`, as (above, below)."""
    return (
        total * step.denominator * reading.dc_step_ratio,
        step.numerator * _forward_divisor(reading),
    )


def _divide_half_away(above: int, below: int) -> int:
    rounded = (2 * abs(above) + below) // (2 * below)
    return -rounded if above < 0 else rounded
