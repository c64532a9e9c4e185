"""Data that ends inside an element or where it should begin: the elements that `truncation` and the others leave.

A byte has to end there, so each recipe tries streams of different lengths until one does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from snhc.reference_impl.bitstream.errors import SnhcError, Truncated
from snhc.reference_impl.systems.stream import trace_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import all_lists, body, empty, end_code, face_object, intra, sequence, stream, visual_object
from ..dct_builders import coefficients, dct_inter, dct_intra
from ..manifest import CONCEAL, REJECT
from ..mesh_builders import delaunay, mesh_stream, mesh_timed, moved, still, uniform
from ..recipe import Reject, family
from .dct import NOTES, TOOLS

_Named = tuple[str, str]
"""An element: its rule and name."""


def _by_name(*elements: _Named) -> dict[str, _Named]:
    return {f"{name} {rule}": (rule, name) for rule, name in elements}


def _places(data: bytes, element: _Named) -> Iterator[tuple[int, int]]:
    """Where an element stands."""
    for part in trace_stream(data):
        for el, start, end, _, _ in part.trace.rows():
            if (el.rule, el.name) == element:
                yield start, end


def _cut(streams: Iterable[list[StreamItem]], element: _Named, allowed: tuple[str, ...] = (REJECT, CONCEAL)) -> Reject:
    """The first stream of which a byte ends inside the element, else where it begins."""
    begins: Reject | None = None
    for items in streams:
        data = write_stream(items)
        for start, end in _places(data, element):
            boundary = -(-start // 8) * 8
            if boundary >= end or not _is_cut(data[: boundary // 8], element):
                continue
            found = Reject(data[: boundary // 8], Truncated, element[0], bits=(start, boundary), allowed=allowed)
            if boundary > start:
                return found
            begins = begins or found
    if begins is None:
        raise TypeError(f"no byte ends at {element}")
    return begins


def _is_cut(data: bytes, element: _Named) -> bool:
    # What stands before may read otherwise where the data ends: the first bits of a plane can be stuffing.
    error: SnhcError | None = None
    for part in trace_stream(data):
        error = part.error
    return isinstance(error, Truncated) and (error.rule, error.what) == element


def _faces() -> Iterator[list[StreamItem]]:
    for variant in range(48):
        idle, groups = variant % 12, variant // 12
        face = intra(
            {3: 50, 48: 70, 61: 80}, types={5: groups & 1, 6: groups >> 1}, ranges=all_lists(9), time=(23, 59, 59),
        )  # fmt: skip
        first = body({8: 100, 9: 200}, types={11: groups & 1, 24: groups >> 1}, ranges=all_lists(7), face=face)
        headers = [sequence(0x61), visual_object(verid=2)]
        yield [*headers, face_object([*(empty(is_intra=1) for _ in range(idle)), first]), end_code()]


@family(
    _by_name(
        ("FBA-7", "marker_bit"), ("FBA-10", "marker_bit"), ("FBA-13", "is_i_new_min"), ("FBA-13", "is_p_new_max"),
        ("FBA-16", "marker_bit"), ("FBA-40", "marker_bit"), ("FBA-40", "bap_object_coding_type"),
        ("FBA-40", "is_i_new_max"), ("FBA-40", "is_i_new_min"), ("FBA-40", "is_p_new_max"), ("FBA-40", "is_p_new_min"),
        ("FBA-40", "bap_new_i_max"), ("FBA-40", "bap_new_i_min"), ("FBA-40", "bap_new_p_min"),
    ),
    id="fba.error.cut.{case}",
    title="The data ends at {case}",
    tier="error",
    rules=["CNF-21"],
    features=["truncated"],
    value_classes=["every-element"],
)  # fmt: skip
def face(element: _Named) -> Reject:
    """The data ends inside {case}, or where it should begin. A decoder may give the lines before it."""
    return _cut(_faces(), element)


@family(
    _by_name(("SYS-3", "is_visual_object_identifier")),
    id="sys.error.cut.{case}",
    title="The data ends at {case}",
    tier="error",
    rules=["CNF-21"],
    features=["truncated", "visual-object"],
)
def header(element: _Named) -> Reject:
    """The data ends directly behind visual_object_start_code."""
    return _cut(_faces(), element, (REJECT,))


def _dct() -> Iterator[list[StreamItem]]:
    for variant in range(64):
        idle, blend, fap = variant % 4, variant // 4 % 4, variant // 16
        viseme = [(1, 2, 3, 0), (2, 3, 3 + 7 * blend, 1), (3, 2, 9, 0)]
        expression = [(1, 2, 30, 40, 0, 1), (2, 1, 30 + 3 * blend, 47, 1, 0), (0, 1, 33, 44, 0, 0)]
        faps = {3: coefficients(1, {2: 3, 7: -9, 8: 40 << fap}), 5: coefficients(9, {1: 77})}
        first = dct_intra(faps, viseme=viseme, expression=expression)
        later = {3: coefficients(17 << fap, {1: -5}, is_intra=False), 5: coefficients(-3, {9: 2}, is_intra=False)}
        second = dct_inter(first, later, viseme=viseme, expression=expression)
        yield stream(*(empty(is_intra=1) for _ in range(idle)), first, second)


@family(
    _by_name(
        *(
            (rule, f"{name}{kind}")
            for rule, names in {
                "DCT-9": ("viseme_select1", "viseme_select2", "viseme_blend"),
                "DCT-10": (
                    "expression_select1", "expression_select2", "expression_intensity1", "expression_intensity2",
                ),
            }.items()
            for name in names
            for kind in ("", "_difference")
        ),
        ("DCT-9", "viseme_def"), ("DCT-10", "init_face"), ("DCT-10", "expression_def"), ("DCT-3", "dc_difference"),
        ("DCT-4", "run"), ("DCT-4", "ac"),
    ),
    id="fap.dct.error.cut.{case}",
    title="The data ends at {case}",
    tier="error",
    rules=["CNF-21", "DCT-1"],
    features=["truncated"],
    value_classes=["every-element"],
    tools=TOOLS,
    notes=NOTES,
)  # fmt: skip
def dct(element: _Named) -> Reject:
    """The data ends inside {case}, or where it should begin; no line of the segment can come."""
    return _cut(_dct(), element)


def _meshes() -> Iterator[list[StreamItem]]:
    for variant in range(24):
        rate, time, skip = variant & 1, variant >> 1 & 1, variant >> 2
        for first in (uniform(3, 2, 20, 16, 1), delaunay([(0, 0), (61, -7), (83, 40), (41, 73), (-13, 50)], 5)):
            motion = moved(first, {1: (3, -2), 2: (-7 + 3 * skip, 5)})
            for plane in (first, motion, last := still()):
                mesh_timed(plane, skip=(None, 0, 15, 30, 45, 60)[skip])
            mesh_timed(first, rate=(25, 0, 0) if rate else None, time=(1, 2, 3) if time else None)
            yield mesh_stream(first, motion, last)


@family(
    _by_name(
        ("MSH-2", "is_intra"), ("MSH-30", "mesh_type_code"), ("MSH-33", "marker_bit"),
        ("MSH-34", "mesh_rect_size_hor"), ("MSH-36", "triangle_split_code"), ("MSH-40", "motion_range_code"),
        ("MSH-41", "node_motion_vector_flag"),
    ),
    id="mesh.error.cut.{case}",
    title="The data ends at {case}",
    tier="error",
    rules=["CNF-21", "MSH-2"],
    features=["truncated"],
    value_classes=["every-element"],
    tools=("mesh",),
)  # fmt: skip
def mesh(element: _Named) -> Reject:
    """The data ends inside {case}, or where it should begin. A decoder may give the lines before it."""
    return _cut(_meshes(), element)
