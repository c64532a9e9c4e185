"""Decoded frames: frozen, ready to be printed.

Rules: CNF-1, FBA-34.
"""

from __future__ import annotations

from typing import NamedTuple


class FaceFrame(NamedTuple):
    """One instant of a face animation.

    Rules: CNF-1, FBA-34.

    `time`: seconds as (numerator, denominator) in lowest terms. `faps`: 68 values in FAP units, None while unset or
    to be interpolated; entries 0 and 1 are always None. `viseme`: (select1, select2, blend, def); `expression`:
    (select1, intensity1, select2, intensity2, init_face, def). `state`: 68 letters T, R, I, U. `fap_quant`, `gender`,
    `coding_type`: of an intra plane with FAP data, else None. `baps`: the coded BAPs, {number: value}, or None.
    A named tuple: it is made in a fourth of the time of a frozen dataclass, and there are many.
    """

    # Nobody looks for a value in a frame: what `tuple.index` was is the frame's number.
    index: int  # type: ignore[assignment]
    time: tuple[int, int]
    intra: bool
    faps: tuple[int | None, ...]
    viseme: tuple[int, int, int, int] | None
    expression: tuple[int, int, int, int, int, int] | None
    state: str
    fap_quant: int | None = None
    gender: int | None = None
    coding_type: int | None = None
    baps: dict[int, int] | None = None
