"""Streams with DCT segments as records, made from the rules of the specification (DCT rules).

What decides the shape of a stream is drawn; masses of small numbers come from a seed that is drawn too.
"""

from __future__ import annotations

from random import Random
from typing import Any, Final

from fba_helpers import RECORDS, fields_of
from hypothesis import strategies as st
from plain_dct import BASE_STEP, SCALE, PlainPayload, values

from snhc.reference_impl.face.dct_syntax import CoefficientRun, SegmentData
from snhc.reference_impl.face.records import FbaObject, FbaPlane
from snhc.reference_impl.systems.stream import Options, trace_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem
from snhc.vectors.builders import all_lists, body, empty, inter, intra, stream, timed, with_code
from snhc.vectors.dct_builders import Expression, Viseme, coefficients, dct_inter, dct_intra

DCT_ELEMENTS = {
    "dc", "dc_escape", "dc_difference", "dc_difference_escape", "dc_difference_escape_wide", "run", "ac", "ac_escape",
    "ac_escape_wide", "viseme_select1", "viseme_select1_difference", "expression_select1",
    "expression_select1_difference",
}  # fmt: skip
STYLES: Final = ("zeros", "small", "dense", "wild", "edges")
EDGES: Final = (
    255, 256, -255, -256, -257, 32767, -32767, 32768, -32768, -32769, 2**30 - 1, -(2**30),
)  # fmt: skip


SEGMENT_FIELDS: Final = ("viseme", "viseme_def", "expression", "init_face", "expression_def", "runs")


def segment_records(segment: SegmentData) -> object:
    """A segment as nested lists and dicts: what was sent, however it is kept."""
    return {name: plain(getattr(segment, name)) for name in SEGMENT_FIELDS}


def plain(value: object) -> object:
    """A record with its segments as nested lists and dicts, for comparison."""
    if isinstance(value, SegmentData):
        return segment_records(value)
    if isinstance(value, (*RECORDS, CoefficientRun)):
        return {name: plain(getattr(value, name)) for name in fields_of(value)}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return value


def level(rng: Random, style: str) -> int:
    if style == "edges":
        return rng.choice(EDGES)
    if style == "wild":
        return rng.choice((1, -1)) * rng.getrandbits(rng.randint(0, 30)) or 7
    return rng.choice((-3, -2, -1, 1, 2, 5))


def fap_run(rng: Random, style: str, is_intra: bool, odd: bool) -> CoefficientRun:
    """The coefficients of one FAP; `odd`: with escapes where none is needed, and zeros sent."""
    density = {"zeros": 0.0, "small": 0.15, "dense": 0.9}.get(style, 0.3)
    ac = {k: level(rng, style) for k in range(1, 16) if rng.random() < density}
    dc = 0 if style == "zeros" else level(rng, style)
    if not is_intra and style == "edges" and rng.random() < 0.2:
        dc = rng.choice((2**31 - 1, -(2**31)))
    run = coefficients(dc, ac, is_intra=is_intra)
    if odd:
        run.dc_escape = max(run.dc_escape, rng.randint(0, 1 if is_intra else 2))
        run.levels = [0 if rng.random() < 0.2 else value for value in run.levels]
        run.escapes = [
            max(escape, rng.randint(0 if value else 1, 2))
            for escape, value in zip(run.escapes, run.levels, strict=True)
        ]
    return run


def visemes(rng: Random) -> list[Viseme]:
    return [(rng.randint(0, 14), rng.randint(0, 14), rng.randint(0, 63), rng.getrandbits(1)) for _ in range(16)]


def expressions(rng: Random) -> list[Expression]:
    return [
        (rng.randint(0, 6), rng.randint(0, 6), rng.choice((0, 63, rng.randint(0, 63))), rng.randint(0, 63),
         rng.getrandbits(1), rng.getrandbits(1))
        for _ in range(16)
    ]  # fmt: skip


def planes_of(draw: Any, max_planes: int, odd: bool) -> list[FbaPlane]:
    rng = Random(draw(st.integers(0, 2**32 - 1)))
    out: list[FbaPlane] = []
    in_force: FbaPlane | None = None
    kinds: tuple[str, ...]
    for _ in range(draw(st.integers(1, max_planes))):
        kinds = ("dct", "dct", "arithmetic", "empty")
        if in_force is not None:
            kinds = ("inter", "inter", "inter", "inter", "dct", "arithmetic", "empty")
        kind = draw(st.sampled_from(kinds))
        style = draw(st.sampled_from(STYLES))
        skip = draw(st.sampled_from((None, None, 0, 3, 16)))
        if kind == "empty":
            out.append(empty(is_intra=0 if out else 1, skip=skip))
            continue
        if kind == "dct":
            faps = rng.sample(range(3, 69), rng.choice((0, 1, 2, 5, 20)))
            # Type 3 codes a whole group, type 2 leaves the others of the group to be interpolated.
            types = {g: rng.choice((2, 3)) for g in rng.sample(range(2, 11), 2)} if draw(st.booleans()) else {}
            plane = dct_intra(
                {fap: fap_run(rng, style, True, odd) for fap in faps},
                quant=draw(st.sampled_from((0, 1, 31)) | st.integers(0, 31)),
                types=types,
                viseme=visemes(rng) if rng.random() < 0.3 else None,
                expression=expressions(rng) if rng.random() < 0.3 else None,
                rate=(25, 8, 1) if rng.random() < 0.2 else None,
                skip=skip,
            )
            if rng.random() < 0.2:
                plane = body({rng.randint(1, 100): 1}, face=plane, ranges=all_lists(1))
            in_force = plane
        elif kind == "arithmetic":
            plane = intra(dict.fromkeys(rng.sample(range(3, 47), 3), 1), quant=1)
            in_force = plane
        else:
            assert in_force is not None and in_force.faps is not None
            first = in_force.faps
            if first.coding_type:
                assert first.segment is not None
                numbers = first.segment.runs
                plane = dct_inter(
                    in_force,
                    viseme=visemes(rng) if first.segment.viseme else None,
                    expression=expressions(rng) if first.segment.expression else None,
                    skip=skip,
                )
                assert plane.faps is not None and plane.faps.segment is not None
                plane.faps.segment.runs = [fap_run(rng, style, False, odd) for _ in numbers]
            else:
                plane = timed(inter(in_force), skip=skip)
        for data in (plane.faps, plane.baps):
            if data is not None and not any(data.new):
                # A reader leaves the lists out where none was sent.
                data.limits = []
        if out and draw(st.integers(0, 4)) == 0:
            with_code(plane)
        out.append(plane)
    return out


class DctStream:
    """A generated stream: records and how to read them; the bytes are the test's to write."""

    def __init__(self, items: list[StreamItem], options: Options) -> None:
        self.items = items
        self.options = options

    @property
    def object(self) -> FbaObject:
        (found,) = [item.fba for item in self.items if item.fba is not None]
        return found

    def __repr__(self) -> str:
        return f"DctStream({write_stream(self.items).hex()})"


@st.composite
def dct_streams(draw: Any, max_planes: int = 5, odd: bool | None = None) -> DctStream:
    """A bare FBA object with planes of both coding types, and the end code."""
    unusual = draw(st.booleans()) if odd is None else odd
    return DctStream(stream(*planes_of(draw, max_planes, unusual)), Options())


def check_plainly(data: bytes) -> None:
    """The plain decoder reads what the codec reads, and reconstructs what it reconstructs."""
    second = PlainPayload(f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}")
    coded: list[int] = []
    quant = 0
    for part in trace_stream(data):
        plane = part.plane
        if plane is None or plane.faps is None:
            continue
        rows = list(part.trace.rows())
        if plane.is_intra:
            quant = plane.faps.quant
            state = plane.frames[0].state
            coded = [i for i, letter in enumerate(state, 1) if letter == "T"]
        segment = plane.faps.segment
        if segment is None:
            continue
        first = [start for el, start, _, _, _ in rows if el.name in DCT_ELEMENTS][:1]
        viseme, expression, runs = second.payload(first[0] if first else rows[-1][2], coded, bool(plane.is_intra))
        assert [row[:3] for row in viseme] == segment.viseme
        assert [row[3] for row in viseme] == segment.viseme_def
        assert [row[:4] for row in expression] == segment.expression
        assert [row[4] for row in expression] == segment.init_face
        assert [row[5] for row in expression] == segment.expression_def
        # Of an inter DC the record holds the difference.
        assert [c[1:] for c in runs.values()] == [run.coefficients()[1:] for run in segment.runs]
        body = [start for _, start, _, _, path in rows if ".bap" in path]
        if first:
            assert second.at == (body[0] if body else plane.end)
        for fap, c in runs.items():
            for t, (wanted, frame) in enumerate(zip(values(fap, quant, c), plane.frames, strict=True)):
                got = frame.faps[fap - 1]
                assert got is not None
                assert abs(got - wanted) <= 0.5 + 1e-9 * (1 + sum(map(abs, c)) * BASE_STEP[fap] * SCALE[quant]), (
                    fap,
                    t,
                )
