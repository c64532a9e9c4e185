"""Exact integer predicates and the insertion order of the triangulation.

Rules: MSH-8 (exact predicates). The in-circle question is asked of the two angles that face an edge: they sum
to more than 180 degrees exactly where the circle through one triangle holds the other's third node, and the
numbers stay within 64 bits for the positions of MSH-24.
"""

from __future__ import annotations


def orientation(xs: list[int], ys: list[int], a: int, b: int, c: int) -> int:
    """Twice the signed area of a-b-c: positive where it runs clockwise on screen (y down).

    Rules: MSH-8, MSH-10.

    `xs`, `ys`: positions in half pixels; `a`, `b`, `c`: node numbers.
    """
    ax = xs[a]
    ay = ys[a]
    return (xs[b] - ax) * (ys[c] - ay) - (ys[b] - ay) * (xs[c] - ax)


def opposite_angles(xs: list[int], ys: list[int], a: int, b: int, p: int, d: int) -> int:
    """The sign of sin(angle at p + angle at d), both facing the edge a-b from its two sides.

    Rules: MSH-8, MSH-9.

    Negative: d lies inside the circle through a, b, p; 0: the four nodes are on one circle; positive:
    outside. a-b-p runs clockwise on screen (or p lies between a and b), b-a-d too.
    """
    ax = xs[a]
    ay = ys[a]
    bx = xs[b]
    by = ys[b]
    px = xs[p]
    py = ys[p]
    dx = xs[d]
    dy = ys[d]
    cos_p = (ax - px) * (bx - px) + (ay - py) * (by - py)
    cos_d = (ax - dx) * (bx - dx) + (ay - dy) * (by - dy)
    if cos_p < 0 and cos_d < 0:
        return -1
    if cos_p >= 0 and cos_d >= 0:
        return 0 if cos_p == 0 and cos_d == 0 else 1
    sin_p = (ax - px) * (by - py) - (ay - py) * (bx - px)
    sin_d = (bx - dx) * (ay - dy) - (by - dy) * (ax - dx)
    return sin_p * cos_d + cos_p * sin_d


def _hilbert_tables() -> tuple[list[int], list[int]]:
    """Four levels of the Hilbert curve: (state, 4 bits of x, 4 bits of y) -> 8 bits of index, next state.

    States: bit 0 = the axes are swapped, bit 1 = both are mirrored.
    """
    index = [0] * 1024
    after = [0] * 1024
    for state in range(4):
        for x4 in range(16):
            for y4 in range(16):
                swapped = state & 1
                mirrored = state >> 1
                code = 0
                for bit in (3, 2, 1, 0):
                    x = (x4 >> bit) & 1
                    y = (y4 >> bit) & 1
                    if swapped:
                        x, y = y, x
                    if mirrored:
                        x ^= 1
                        y ^= 1
                    code = code * 4 + ((3 * x) ^ y)
                    if y == 0:
                        if x:
                            mirrored ^= 1
                        swapped ^= 1
                index[state << 8 | x4 << 4 | y4] = code
                after[state << 8 | x4 << 4 | y4] = mirrored << 1 | swapped
    return index, after


def insertion_order(xs: list[int], ys: list[int]) -> list[int]:
    """Node numbers in rounds of growing size, each along a Hilbert curve.

    Rules: MSH-8.

    The rounds (chosen by a fixed scrambling of the node number) keep the number of flips small for every
    arrangement of nodes, the curve keeps the next node near the last. `xs`, `ys`: within 16 bits of their
    smallest value.
    """
    index, after = _hilbert_tables()
    left = min(xs)
    top = min(ys)
    keys: list[int] = []
    for node in range(len(xs)):
        x = xs[node] - left
        y = ys[node] - top
        at = (x >> 12) << 4 | y >> 12
        code = index[at]
        at = after[at] << 8 | (x >> 4 & 0xF0) | (y >> 8 & 15)
        code = code << 8 | index[at]
        at = after[at] << 8 | (x & 0xF0) | (y >> 4 & 15)
        code = code << 8 | index[at]
        at = after[at] << 8 | (x << 4 & 0xF0) | (y & 15)
        code = code << 8 | index[at]
        # Each round is about four times as large as all rounds before it.
        lot = (node + 1) * 2654435761 & 0xFFFFFFFF
        lot ^= lot >> 15
        late = 9
        while late > 0 and lot & 3 == 0:
            lot >>= 2
            late -= 1
        keys.append(late << 32 | code)
    return sorted(range(len(xs)), key=keys.__getitem__)
