"""Face objects: parameters taken out of masks, levels and coefficients lowered.

Rules: CNF-17, FBA-10, FBA-14, FBA-28, DCT-2, DCT-4.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.face.dct_syntax import CoefficientRun
from snhc.reference_impl.face.parameters import ParameterSet, bap_set, fap_set
from snhc.reference_impl.face.records import FbaPlane, ParameterData
from snhc.reference_impl.systems.visual import StreamItem
from snhc.vectors.builders import coded

if TYPE_CHECKING:
    from .streams import Edit, Stream

_SETS: Final[dict[str, Callable[[], ParameterSet]]] = {"faps": fap_set, "baps": bap_set}
# Lists of levels of a plane.
_LEVELS: Final = ("levels", "viseme", "expression")


def _objects(items: list[StreamItem]) -> list[list[FbaPlane]]:
    return [item.fba.planes for item in items if item.fba is not None]


def parameters(stream: Stream) -> None:
    """FAPs and BAPs taken out of an object: out of the masks, and their levels out of every plane. Rules: CNF-17."""
    for which, make in _SETS.items():
        for number in range(len(_objects(stream.items()))):
            found: dict[int, None] = {}
            for plane in _objects(stream.items())[number]:
                data: ParameterData | None = getattr(plane, which)
                if data is not None and plane.is_intra:
                    found |= dict.fromkeys(_selected(data, make()))

            def keeping(
                kept: list[int], which: str = which, number: int = number, make: Callable[[], ParameterSet] = make
            ) -> Edit:
                def edit(items: list[StreamItem]) -> None:
                    _keep(_objects(items)[number], which, make(), set(kept))

                return edit

            stream.reduce(sorted(found), keeping)


def _selected(data: ParameterData, parameters: ParameterSet) -> list[int]:
    """All numbers that the masks select, FAP 1 and 2 too."""
    out: list[int] = []
    for g, group in enumerate(parameters.groups):
        mask_type, mask = data.mask_type[g], data.group_mask[g]
        for i, number in enumerate(group):
            if mask_type == 3 or (mask_type and mask >> (len(group) - 1 - i) & 1):
                out.append(number)
    return out


def _keep(planes: list[FbaPlane], which: str, parameters: ParameterSet, kept: set[int]) -> None:
    selected: list[int] = []
    for plane in planes:
        data: ParameterData | None = getattr(plane, which)
        if data is None:
            continue
        if plane.is_intra:
            selected = coded(data, parameters)
        places = [i for i, number in enumerate(selected) if number in kept]
        if data.segment is not None:
            data.segment.runs = [data.segment.runs[i] for i in places]
        else:
            data.levels = [data.levels[i] for i in places]
        if plane.is_intra:
            _mask(data, parameters, kept)


def _mask(data: ParameterData, parameters: ParameterSet, kept: set[int]) -> None:
    for g, group in enumerate(parameters.groups):
        mask_type = data.mask_type[g]
        if not mask_type or (mask_type == 3 and kept.issuperset(group)):
            continue
        mask = data.group_mask[g] if mask_type != 3 else (1 << len(group)) - 1
        for i, number in enumerate(group):
            if number not in kept:
                mask &= ~(1 << (len(group) - 1 - i))
        data.group_mask[g] = mask
        data.mask_type[g] = (1 if mask_type == 3 else mask_type) if mask else 0


# -- magnitudes --------------------------------------------------------------------------------------------------------


def _lists(items: list[StreamItem]) -> list[list[int]]:
    """Every list of numbers that may be lowered."""
    out: list[list[int]] = []
    for planes in _objects(items):
        for plane in planes:
            for data in (plane.faps, plane.baps):
                if data is None:
                    continue
                if data.segment is None:
                    out += [getattr(data, name) for name in _LEVELS]
                else:
                    segment = data.segment
                    out += [*segment.viseme, *segment.expression]
                    out += [segment.viseme_def, segment.init_face, segment.expression_def]
    return out


def magnitudes(stream: Stream) -> None:
    """Levels, and values of high-level FAPs: as many as possible 0, others as small as may be. Rules: CNF-17."""
    places = [(n, i) for n, values in enumerate(_lists(stream.items())) for i, value in enumerate(values) if value]

    def keeping(kept: list[tuple[int, int]]) -> Edit:
        def edit(items: list[StreamItem]) -> None:
            lists = _lists(items)
            for n, i in set(places) - set(kept):
                lists[n][i] = 0

        return edit

    for n, i in stream.reduce(places, keeping):

        def setting(value: int, n: int = n, i: int = i) -> Edit:
            def edit(items: list[StreamItem]) -> None:
                _lists(items)[n][i] = value

            return edit

        stream.lower(_lists(stream.items())[n][i], setting)


# -- DCT ---------------------------------------------------------------------------------------------------------------


def _runs(items: list[StreamItem]) -> list[CoefficientRun]:
    return [
        run
        for planes in _objects(items)
        for plane in planes
        if plane.faps is not None and plane.faps.segment is not None
        for run in plane.faps.segment.runs
    ]


def coefficients(stream: Stream) -> None:
    """DCT coefficients left out, and lowered. Rules: CNF-17, DCT-2, DCT-4."""
    places = [(n, k) for n, run in enumerate(_runs(stream.items())) for k in range(len(run.levels))]
    if not _runs(stream.items()):
        return

    def keeping(kept: list[tuple[int, int]]) -> Edit:
        def edit(items: list[StreamItem]) -> None:
            runs = _runs(items)
            for n in {n for n, _ in places}:
                _only(runs[n], [k for m, k in kept if m == n])

        return edit

    stream.reduce(places, keeping)
    for n, run in enumerate(_runs(stream.items())):
        for k in range(-1, len(run.levels)):

            def setting(value: int, n: int = n, k: int = k) -> Edit:
                def edit(items: list[StreamItem]) -> None:
                    run = _runs(items)[n]
                    # Without an escape where the number does without; else with those that it had.
                    if k < 0:
                        run.dc, run.dc_escape = value, run.dc_escape if abs(value) > _PLAIN else 0
                    else:
                        run.levels[k] = value
                        run.escapes[k] = run.escapes[k] if abs(value) > _PLAIN else 0

                return edit

            value = run.dc if k < 0 else run.levels[k]
            stream.lower(value, setting)


# Up to here a coefficient has a code word in every profile.
_PLAIN: Final = 100


def _only(run: CoefficientRun, kept: list[int]) -> None:
    """Leave coefficients out; the runs of zeros before the others grow by them."""
    runs, levels, escapes = [], [], []
    zeros = 0
    for k, (length, level) in enumerate(zip(run.runs, run.levels, strict=True)):
        zeros += length
        if k in kept:
            runs.append(zeros)
            levels.append(level)
            escapes.append(run.escapes[k])
            zeros = 0
        else:
            zeros += 1
    run.runs, run.levels, run.escapes = runs, levels, escapes
