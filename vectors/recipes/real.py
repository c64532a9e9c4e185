"""Realistic sequences: speech, expressions and gestures as encoders send them, meshes as trackers give them.

All are made from seeds (`sequences`, `performances`, `tracked`) and coded by our own encoders: levels, ranges and
models move as they do in use, where the other tiers show one thing at a time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Final

from snhc.reference_impl.face.encode import EncoderOptions
from snhc.reference_impl.face.fap_text import FapFile, FapTextFrame
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.systems.encoding import encode_fap

from ..builders import sequence as sequence_header
from ..builders import user_data, visual_object
from ..mesh_builders import delaunay, mesh_stream, mesh_timed, moved, still, uniform
from ..performances import gestures, talk
from ..recipe import Accept, family, vector
from ..sequences import expressions, speech
from ..tracked import HEAD_BOUNDARY, Nodes, flag, head

_ARITHMETIC: Final = ("FBA-14", "FBA-16", "FBA-20", "FBA-24", "FBA-26", "FBA-30", "FBA-31")
_DCT: Final = ("DCT-1", "DCT-3", "DCT-4", "DCT-5", "DCT-7", "DCT-13")
_DCT_TOOLS: Final = ("fba", "dct-p1")
_DCT_NOTES: Final = "Entropy profile P1: provisional entropy tables."
_PROVISIONAL: Final = ("provisional-tables",)
_MESH: Final = ("mesh",)
_LIPS: Final = frozenset((*range(3, 14), 16, 17, *range(51, 61)))
_EYES: Final = frozenset((19, 20, 21, 22, 23, 24, 25, 26))


def _only(file: FapFile, faps: Iterable[int], frames: range) -> list[FapTextFrame]:
    """Some frames of a sequence, with some of its FAPs."""
    wanted = set(faps)
    out = []
    for frame in file.frames[frames.start : frames.stop : frames.step]:
        mask = tuple(int(bit and i + 1 in wanted) for i, bit in enumerate(frame.mask))
        values = [value if bit else None for value, bit in zip(frame.values, mask, strict=True)]
        out.append(replace(frame, mask=mask, values=values))
    return out


def _with(file: FapFile, frames: list[FapTextFrame]) -> FapFile:
    return replace(file, frames=frames, nframes=len(frames))


# -- arithmetic coding -------------------------------------------------------------------------------------------------


@family(
    {
        "quant 1 at 25 Hz": (1, 25), "quant 4 at 30 Hz": (4, 30), "quant 12 at 15 Hz": (12, 15),
        "quant 31 at 10 Hz": (31, 10),
    },
    id="fap.arith.real.speech.{case}",
    title="Two seconds of speech, {case}",
    tier="real",
    rules=_ARITHMETIC,
    features=["inter", "ranges", "fap-quant", "frame-rate"],
    seed=21,
)  # fmt: skip
def arithmetic_speech(case: tuple[int, int]) -> Accept:
    """Someone speaks: lips, jaw, lids, gaze, brows and head, {case}. An intra plane every second."""
    quant, rate = case
    return Accept(encode_fap(speech(2 * rate, 21, rate=rate), quant=quant), lines=2 * rate, findings=())


@family(
    {"quant 1": 1, "quant 7": 7, "quant 20": 20},
    id="fap.arith.real.expressions.{case}",
    title="Expressions that come and go, {case}",
    tier="real",
    rules=_ARITHMETIC,
    features=["inter", "ranges", "fap-quant"],
    seed=22,
)
def arithmetic_expressions(quant: int) -> Accept:
    """Two seconds of expressions at 25 Hz, with lids, gaze and head, {case}; long stretches hold nearly still."""
    file = expressions(50, 22, rate=25)
    return Accept(encode_fap(file, quant=quant), lines=50, findings=())


@vector(
    id="fap.arith.real.talk",
    title="A talk in visemes and expressions",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-28", "FBA-29", "FBA-32"],
    features=["inter", "viseme", "expression"],
    seed=23,
)
def arithmetic_talk() -> Accept:
    """Visemes fade into each other, two expressions at a time; lids, gaze, brows and head are FAPs of their own."""
    return Accept(encode_fap(talk(50, 23), quant=3), lines=50, findings=())


@vector(
    id="fap.arith.real.lips",
    title="Lips alone at 8 Hz, for a very low bit rate",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-10"],
    features=["inter", "mask-type-1", "frame-rate"],
    seed=24,
)
def arithmetic_lips() -> Accept:
    """Only the FAPs of lips and jaw, coarse, with one intra plane for all three seconds."""
    file = speech(24, 24, rate=8)
    frames = _only(file, _LIPS, range(24))
    return Accept(encode_fap(_with(file, frames), EncoderOptions(intra_period=24), quant=9), lines=24, findings=())


@vector(
    id="fap.arith.real.parts-in-turn",
    title="Parts of the face in turn",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-10", "FBA-15"],
    features=["inter", "mask-type-1", "mask-type-2", "states"],
    seed=25,
)
def parts_in_turn() -> Accept:
    """Lips, then eyes, then all, then lips again: masks change with intra planes, what is left out is retained.

    Groups that are sent in part have mask type 2: their other FAPs are left to the decoder.
    """
    file = speech(60, 25, rate=20)
    everything = range(3, 69)
    parts = (_LIPS, _EYES, everything, _LIPS)
    frames = [frame for i, part in enumerate(parts) for frame in _only(file, part, range(15 * i, 15 * i + 15))]
    return Accept(encode_fap(_with(file, frames), quant=3, partial_type=2), lines=60, findings=())


@vector(
    id="fap.arith.real.dropped-frames",
    title="An encoder drops frames to hold its rate",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-8", "FBA-38"],
    features=["inter", "skip"],
    seed=26,
)
def dropped_frames() -> Accept:
    """Speech at 30 Hz of which every third frame, and a run of ten, is left out: skip_frames tells how many."""
    file = speech(60, 26, rate=30)
    kept = [frame for frame in file.frames if frame.number % 3 != 2 and not 20 <= frame.number < 30]
    return Accept(
        encode_fap(_with(file, kept), quant=4), lines=len(kept), times={1: "1/30", 2: "1/10"}, findings=()
    )  # fmt: skip


@vector(
    id="fap.arith.real.every-plane-has-a-code",
    title="Speech with sequence headers, user data and a start code before every plane",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-2", "FBA-3", "SYS-2", "SYS-3", "SYS-5"],
    features=["inter", "plane-start-code", "sequence-header", "user-data"],
    profile="Simple Face Animation@L2",
    seed=27,
)
def every_plane_has_a_code() -> Accept:
    """As a streaming server sends it, to be entered anywhere: intra planes every five, all planes byte aligned."""
    file = speech(30, 27, rate=15)
    items = encode_fap(file, EncoderOptions(intra_period=5, start_codes="all"), quant=6)
    head_items = [sequence_header(0x62), user_data(b"snhc"), visual_object()]
    return Accept([*head_items, *items], lines=30, findings=())


@family(
    {"widest": "max", "widened": "widen"},
    id="fap.arith.real.ranges-{case}",
    title="Speech with ranges: {case}",
    tier="real",
    rules=_ARITHMETIC,
    features=["inter", "ranges"],
    seed=28,
)
def arithmetic_ranges(ranges: str) -> Accept:
    """An encoder that does not look ahead: ranges {case}. Models have many symbols, of which few ever come."""
    file = speech(40, 28, rate=20)
    return Accept(
        encode_fap(file, EncoderOptions(intra_period=10, ranges=ranges), quant=2), lines=40, findings=()
    )  # fmt: skip


@vector(
    id="fap.arith.real.broadcast-rate",
    title="Expressions at 30000/1001 Hz",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-6", "FBA-37"],
    features=["inter", "frame-rate"],
    seed=29,
)
def broadcast_rate() -> Accept:
    """frequency_offset 1: times are fractions that no float holds."""
    file = replace(expressions(32, 29, rate=30), frame_rate=Fraction(30000, 1001))
    return Accept(encode_fap(file, quant=5), lines=32, times={1: "1001/30000", 30: "1001/1000"}, findings=())


@vector(
    id="fba.body.real.speech-and-gestures",
    title="Speech with gestures of the upper body",
    tier="real",
    rules=[*_ARITHMETIC, "FBA-5", "FBA-39", "FBA-40"],
    features=["inter", "bap"],
    seed=30,
)
def speech_and_gestures() -> Accept:
    """Every plane holds FAP and BAP data. A decoder of faces reads over the bodies and must stay in step.

    The BAPs are those whose base step is not in dispute.
    """
    items = encode_fap(speech(30, 30, rate=15), baps=gestures(30, 30, rate=15), quant=4, bap_quant=2)
    return Accept(items, lines=30, findings=())


# -- DCT coding --------------------------------------------------------------------------------------------------------


@family(
    {
        "speech quant 1": (True, 1), "speech quant 6": (True, 6), "expressions quant 16": (False, 16),
        "speech quant 31": (True, 31),
    },
    id="fap.dct.real.short.{case}",
    title="Three segments: {case}",
    tier="real",
    rules=_DCT,
    features=["inter", "run", "fap-quant"],
    tools=_DCT_TOOLS,
    notes=_DCT_NOTES,
    seed=31,
)  # fmt: skip
def dct_short(case: tuple[bool, int]) -> Accept:
    """{case}: 48 frames at 25 Hz in the DCT mode, one intra segment and two inter segments."""
    spoken, quant = case
    file = (speech if spoken else expressions)(48, 31, rate=25)
    return Accept(encode_fap(file, quant=quant, mode="dct"), lines=48, findings=_PROVISIONAL)


@vector(
    id="fap.dct.real.talk",
    title="A talk in visemes and expressions, in the DCT mode",
    tier="real",
    rules=[*_DCT, "DCT-9", "DCT-10"],
    features=["inter", "viseme", "expression"],
    tools=_DCT_TOOLS,
    notes=_DCT_NOTES,
    seed=32,
)
def dct_talk() -> Accept:
    """Visemes and expressions by run length, the FAPs of lids, gaze, brows and head by coefficients."""
    return Accept(encode_fap(talk(48, 32), quant=4, mode="dct"), lines=48, findings=_PROVISIONAL)


@vector(
    id="fap.dct.real.lips",
    title="Lips alone in the DCT mode",
    tier="real",
    rules=[*_DCT, "FBA-10"],
    features=["inter", "run", "mask-type-1"],
    tools=_DCT_TOOLS,
    notes=_DCT_NOTES,
    seed=33,
)
def dct_lips() -> Accept:
    """Only lips and jaw: most coefficients behind the first few are zero."""
    file = speech(48, 33, rate=25)
    return Accept(
        encode_fap(_with(file, _only(file, _LIPS, range(48))), quant=10, mode="dct"), lines=48, findings=_PROVISIONAL
    )


# -- meshes ------------------------------------------------------------------------------------------------------------


def _tracked(first: MeshPlane, frames: list[Nodes], start: Nodes) -> list[MeshPlane]:
    """The geometry, then one plane per frame behind the first: what moved, or nothing."""
    planes = [first]
    before = start
    for nodes in frames[1:]:
        vectors = {
            i: (x - before[i][0], y - before[i][1]) for i, (x, y) in enumerate(nodes) if (x, y) != before[i]
        }  # fmt: skip
        planes.append(moved(first, vectors) if vectors else still())
        before = nodes
    return planes


@family(
    {"small": (5, 4, 24, 1), "dense": (14, 9, 14, 2)},
    id="mesh.real.flag.{case}",
    title="A flag in the wind, {case}",
    tier="real",
    rules=["MSH-6", "MSH-12", "MSH-13", "MSH-15", "MSH-21"],
    features=["mesh-uniform", "mesh-motion"],
    tools=_MESH,
    seed=41,
)
def waving_flag(case: tuple[int, int, int, int]) -> Accept:
    """A uniform mesh ({case}) that hangs still, then waves run through it; noise of one half pixel, as of a tracker."""
    columns, rows, cell, split = case
    frames = flag(20, 41, columns=columns, rows=rows, cell=(cell, cell))
    first = uniform(columns, rows, cell, cell, split)
    return Accept(mesh_stream(*_tracked(first, frames, frames[0])), lines=20, findings=())


@vector(
    id="mesh.real.head",
    title="A talking head, tracked",
    tier="real",
    rules=["MSH-5", "MSH-8", "MSH-12", "MSH-13", "MSH-15", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion", "frame-rate"],
    tools=_MESH,
    seed=42,
)
def talking_head() -> Accept:
    """A Delaunay mesh over a head and its features at 15 Hz: nods and turns move all, speech and lids a few nodes."""
    frames = head(30, 42)
    first = mesh_timed(delaunay(frames[0], len(HEAD_BOUNDARY)), rate=(15, 0, 0))
    return Accept(mesh_stream(*_tracked(first, frames, frames[0])), lines=30, times={15: "1/1"}, findings=())


@vector(
    id="mesh.real.head-cut",
    title="A cut from a head to a closer one",
    tier="real",
    rules=["MSH-5", "MSH-8", "MSH-11", "MSH-12", "MSH-15", "MSH-21"],
    features=["mesh-delaunay", "mesh-motion", "mesh-plane-without-data", "skip"],
    tools=_MESH,
    seed=43,
)
def head_cut() -> Accept:
    """Ten planes of one head, two without data while the tracker is lost, then a new mesh, half as large again."""
    before, after = head(10, 43), head(12, 44, middle=(300, 310), size=1.5)
    one = mesh_timed(delaunay(before[0], len(HEAD_BOUNDARY)), rate=(15, 0, 0))
    two = delaunay(after[0], len(HEAD_BOUNDARY))
    lost = [still(), mesh_timed(still(), skip=3)]
    planes = [*_tracked(one, before, before[0]), *lost, *_tracked(two, after, after[0])]
    return Accept(mesh_stream(*planes), lines=24, times={11: "11/15", 12: "1/1"}, findings=())
