"""Arithmetic of mesh motion: differentials, wrapping, prediction, new positions, foldover.

Rules implemented: MSH-12, MSH-13, MSH-14, MSH-15, MSH-16, MSH-17, MSH-24 (moved positions). Not implemented
here: the fields and their codes (MSH-40, MSH-41: syntax). Everything is in half pixels; x to the right, y
down.
"""

from __future__ import annotations

from typing import Final, final

from snhc.reference_impl.bitstream.errors import EncodeError, ForbiddenValue, RangeViolation
from snhc.reference_impl.mesh.topology import MeshTopology

MIN_POSITION: Final = -(1 << 31)
MAX_POSITION: Final = (1 << 31) - 1


@final
class VectorCode:
    """What the wire says of one motion vector.

    Rules: MSH-12, MSH-14, MSH-41.

    `zero`: node_motion_vector_flag, 1 = the zero vector, nothing follows. `x_vlc`, `y_vlc`: -32..32. `x_res`,
    `y_res`: 0..2^(r-1) - 1, 0 where no bits are sent.
    """

    __slots__ = ("x_res", "x_vlc", "y_res", "y_vlc", "zero")

    def __init__(self, zero: int, x_vlc: int = 0, x_res: int = 0, y_vlc: int = 0, y_res: int = 0) -> None:
        self.zero = zero
        self.x_vlc = x_vlc
        self.x_res = x_res
        self.y_vlc = y_vlc
        self.y_res = y_res


def motion_range(range_code: int) -> int:
    """R: vectors lie in -R..R - 1 half pixels.

    Rules: MSH-13.

    `range_code`: motion_range_code, 1..7. Raises ForbiddenValue.
    """
    if not 1 <= range_code <= 7:
        raise ForbiddenValue("MSH-40", "motion_range_code", value=range_code, allowed="1..7")
    return 16 << range_code


def has_residual(vlc: int, range_code: int) -> bool:
    """Whether residual bits follow the code word. Rules: MSH-12, MSH-41."""
    return range_code != 1 and vlc != 0


def differential(vlc: int, res: int, range_code: int) -> int:
    """The differential d of one component.

    Rules: MSH-12.

    `vlc`: value of the code word, -32..32. `res`: residual, 0..2^(range_code - 1) - 1. `range_code`: 1..7.
    """
    if vlc == 0 or range_code == 1:
        return vlc
    if vlc > 0:
        return ((vlc - 1) << (range_code - 1)) + res + 1
    return -(((-vlc - 1) << (range_code - 1)) + res + 1)


def differential_code(d: int, range_code: int) -> tuple[int, int]:
    """The code word's value and the residual that give a differential.

    Rules: MSH-12.

    `d`: -R..R half pixels. Returns (vlc, res). Raises EncodeError.
    """
    limit = motion_range(range_code)
    if not -limit <= d <= limit:
        raise EncodeError("MSH-12", "delta_mv", value=d, allowed=f"{-limit}..{limit}")
    if d == 0 or range_code == 1:
        return d, 0
    size = (d if d > 0 else -d) - 1
    vlc = (size >> (range_code - 1)) + 1
    return (vlc if d > 0 else -vlc), size & ((1 << (range_code - 1)) - 1)


def wrap(v: int, range_code: int) -> int:
    """Prediction plus differential, taken back into -R..R - 1 by one period of 2 R.

    Rules: MSH-13.

    `v`: half pixels, -2 R..2 R - 1 when prediction and differential are in range.
    """
    limit = 16 << range_code
    if v < -limit:
        return v + 2 * limit
    if v > limit - 1:
        return v - 2 * limit
    return v


def decode_component(prediction: int, vlc: int, res: int, range_code: int) -> int:
    """One component of a motion vector. Rules: MSH-12, MSH-13."""
    return wrap(prediction + differential(vlc, res, range_code), range_code)


def vector_code(v: tuple[int, int], prediction: tuple[int, int], range_code: int) -> VectorCode:
    """The writer's code of a vector: the zero flag, or the differentials within -R..R - 1.

    Rules: MSH-12, MSH-13, MSH-14.

    `v`: the vector, components -R..R - 1 half pixels. `prediction`: of MSH-15. Raises EncodeError.
    """
    limit = motion_range(range_code)
    if not (-limit <= v[0] < limit and -limit <= v[1] < limit):
        raise EncodeError("MSH-13", "motion vector", value=f"{v}", allowed=f"{-limit}..{limit - 1}")
    if v[0] == 0 and v[1] == 0:
        return VectorCode(1)
    x_vlc, x_res = differential_code(wrap(v[0] - prediction[0], range_code), range_code)
    y_vlc, y_res = differential_code(wrap(v[1] - prediction[1], range_code), range_code)
    return VectorCode(0, x_vlc, x_res, y_vlc, y_res)


def decode_vector(code: VectorCode, prediction: tuple[int, int], range_code: int) -> tuple[int, int]:
    """The vector that a code stands for. Rules: MSH-12, MSH-13, MSH-14."""
    if code.zero:
        return 0, 0
    return (
        decode_component(prediction[0], code.x_vlc, code.x_res, range_code),
        decode_component(prediction[1], code.y_vlc, code.y_res, range_code),
    )


def predict(topology: MeshTopology, k: int, vx: list[int], vy: list[int]) -> tuple[int, int]:
    """The prediction of the k-th node's vector from vectors already decoded.

    Rules: MSH-15.

    `k`: position in `topology.order`. `vx`, `vy`: vectors by **node number**, in half pixels.
    """
    first, second = topology.predictors[k]
    if first < 0:
        return 0, 0
    return (vx[first] + vx[second] + 1) >> 1, (vy[first] + vy[second] + 1) >> 1


def smallest_range_code(vx: list[int], vy: list[int]) -> int:
    """The smallest motion_range_code whose range holds every vector.

    Rules: MSH-13, MSH-40.

    Raises EncodeError where even code 7 is too small.
    """
    # R - 1 on the upper side, -R on the lower one.
    largest = 0
    for values in (vx, vy):
        for v in values:
            size = v if v >= 0 else -v - 1
            if size > largest:
                largest = size
    for code in range(1, 8):
        if largest < 16 << code:
            return code
    raise EncodeError("MSH-13", "motion vector", value=largest, allowed="-2048..2047")


def first_out_of_range(xs: list[int], ys: list[int], vx: list[int], vy: list[int], order: list[int]) -> int:
    """The first position in `order` whose node leaves the 32-bit range, or -1.

    Rules: MSH-24.

    `xs`, `ys`, `vx`, `vy`: positions and vectors by node number, in half pixels.
    """
    for k in range(len(order)):
        node = order[k]
        x = xs[node] + vx[node]
        y = ys[node] + vy[node]
        if x < MIN_POSITION or x > MAX_POSITION or y < MIN_POSITION or y > MAX_POSITION:
            return k
    return -1


def move(xs: list[int], ys: list[int], vx: list[int], vy: list[int]) -> tuple[list[int], list[int]]:
    """The positions after a motion plane.

    Rules: MSH-16, MSH-24.

    All by node number, in half pixels. Raises RangeViolation, without bits, for a position beyond 32 bits:
    use `first_out_of_range` to locate it in the stream.
    """
    new_xs = [x + v for x, v in zip(xs, vx, strict=True)]
    new_ys = [y + v for y, v in zip(ys, vy, strict=True)]
    for values in (new_xs, new_ys):
        if values and (min(values) < MIN_POSITION or max(values) > MAX_POSITION):
            worst = min(values) if min(values) < MIN_POSITION else max(values)
            raise RangeViolation("MSH-24", "position", value=worst, allowed=f"{MIN_POSITION}..{MAX_POSITION}")
    return new_xs, new_ys


def foldovers(xs: list[int], ys: list[int], triangles: list[tuple[int, int, int]]) -> list[int]:
    """The triangles that have flipped over: negative area, clockwise on screen being positive.

    Rules: MSH-17.

    A triangle that has shrunk to a line has not flipped. Returns positions in `triangles`, ascending.
    """
    flipped: list[int] = []
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        if (xs[b] - xs[a]) * (ys[c] - ys[a]) < (ys[b] - ys[a]) * (xs[c] - xs[a]):
            flipped.append(t)
    return flipped
