"""Builders of planes with DCT segments, beside `builders`: coefficients in, records out.

Rules: DCT-1, DCT-2, DCT-3, DCT-4, DCT-9, DCT-10, DCT-13. Escapes are what DCT-2..4 ask for, or what a test wants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, TypeVar

from snhc.reference_impl.face.dct_syntax import SEGMENT, CoefficientRun, SegmentData
from snhc.reference_impl.face.parameters import fap_set
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.face.syntax import DCT

from .builders import coded, inter, intra, timed

Viseme = tuple[int, int, int, int]
"""select1, select2, blend, viseme_def of one instant. Rules: DCT-9."""
Expression = tuple[int, int, int, int, int, int]
"""select1, select2, intensity1, intensity2, init_face, expression_def of one instant. Rules: DCT-10."""

_Fields = TypeVar("_Fields")
_S16: Final = range(-32767, 32768)
_DC_TABLE: Final = range(-255, 256)
_AC_TABLE: Final = range(-256, 256)


def coefficients(
    dc: int,
    ac: Mapping[int, int] | None = None,
    *,
    is_intra: bool = True,
    dc_escape: int | None = None,
    escapes: Mapping[int, int] | None = None,
) -> CoefficientRun:
    """The coefficients of one FAP in one segment. Rules: DCT-2, DCT-3, DCT-4.

    `dc`: the value, or the difference (inter). `ac`: level by index 1..15. `dc_escape`, `escapes` (by index): the
    number of escape fields where it is not the least that holds the value; a level 0 is only possible with one.
    """
    run = CoefficientRun()
    run.dc = dc
    if dc_escape is not None:
        run.dc_escape = dc_escape
    elif is_intra:
        run.dc_escape = 0 if dc in _S16 else 1
    else:
        run.dc_escape = 0 if dc in _DC_TABLE else 1 if dc in _S16 else 2
    before = 0
    for index, level in sorted((ac or {}).items()):
        least = 0 if level in _AC_TABLE else 1 if level in _S16 else 2
        run.runs.append(index - before - 1)
        run.levels.append(level)
        run.escapes.append((escapes or {}).get(index, least))
        before = index
    return run


def listed(values: Sequence[int], *, is_intra: bool = True) -> CoefficientRun:
    """Coefficients given one after the other, DC first; missing ones are 0. Rules: DCT-4."""
    return coefficients(values[0], {k: v for k, v in enumerate(values) if k and v}, is_intra=is_intra)


def _segment(
    numbers: Sequence[int],
    faps: Mapping[int, CoefficientRun],
    viseme: Sequence[Viseme] | None,
    expression: Sequence[Expression] | None,
) -> SegmentData:
    segment = SegmentData()
    for select1, select2, blend, definition in _sixteen(viseme):
        segment.viseme.append([select1, select2, blend])
        segment.viseme_def.append(definition)
    for *fields, init_face, definition in _sixteen(expression):
        segment.expression.append(fields)
        segment.init_face.append(init_face)
        segment.expression_def.append(definition)
    segment.runs = [faps[number] if number in faps else CoefficientRun() for number in numbers]
    return segment


def _sixteen(instants: Sequence[_Fields] | None) -> Sequence[_Fields]:
    return [] if not instants else [*instants, *[instants[-1]] * (SEGMENT - len(instants))]


def dct_intra(
    faps: Mapping[int, CoefficientRun] | None = None,
    *,
    quant: int = 8,
    types: Mapping[int, int] | None = None,
    viseme: Sequence[Viseme] | None = None,
    expression: Sequence[Expression] | None = None,
    gender: int = 0,
    rate: tuple[int, int, int] | None = None,
    time: tuple[int, int, int] | None = None,
    skip: int | None = None,
) -> FbaPlane:
    """An intra plane with a DCT segment. Rules: DCT-1, DCT-9, DCT-10, DCT-13, DCT-14.

    `faps`: by FAP 3..68; coded FAPs that are not given have only zeros. `types`: mask types as in `builders.intra`.
    `viseme`, `expression`: up to 16 instants, the last one repeated.
    """
    given = faps or {}
    plane = intra(
        dict.fromkeys(given, 0), quant=quant, types=types, gender=gender, rate=rate, time=time, skip=skip,
        viseme=(0, 0, 0, 0) if viseme else None, expression=(0, 0, 0, 0, 0, 0) if expression else None,
    )  # fmt: skip
    assert plane.faps is not None
    plane.faps.coding_type = DCT
    plane.faps.levels = []
    plane.faps.limits = []
    plane.faps.segment = _segment(coded(plane.faps, fap_set()), given, viseme, expression)
    return plane


def dct_inter(
    first: FbaPlane,
    faps: Mapping[int, CoefficientRun] | None = None,
    *,
    viseme: Sequence[Viseme] | None = None,
    expression: Sequence[Expression] | None = None,
    baps: Mapping[int, int] | None = None,
    skip: int | None = None,
) -> FbaPlane:
    """An inter plane with the masks of the intra plane `first`; arguments as `dct_intra`. Rules: DCT-3, DCT-13.

    A viseme or expression that `first` codes has to be given. `baps`: levels, where `first` has BAPs too.
    """
    assert first.faps is not None
    plane = inter(first, baps=baps)
    assert plane.faps is not None
    plane.faps.levels = []
    plane.faps.limits = []
    plane.faps.segment = _segment(coded(first.faps, fap_set()), faps or {}, viseme, expression)
    return timed(plane, skip=skip)
