"""Profiles and levels: every profile code with every tool, and streams at and just above the limits of Simple Face.

The decoded output is that of any other stream; what a checker of profiles must say stands in `check`. `profile` is the
least profile and level that holds the stream, as far as limits are known; what the stream claims is `check.profile`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Final

from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.systems.stream import read_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem

from ..builders import (
    all_lists,
    body,
    empty,
    end_code,
    face_object,
    inter,
    intra,
    sequence,
    timed,
    user_data,
    visual_object,
)
from ..checking import ProfileCheck
from ..mesh_builders import mesh_object, moved, uniform
from ..recipe import Accept, family, vector
from ..seeded import Seeded

SF1: Final = "Simple Face Animation@L1"
SF2: Final = "Simple Face Animation@L2"
_L1: Final = 0x61
_L2: Final = 0x62
# A sequence header and a visual object header are 5 bytes each: here the object's start code begins.
_OBJECT: Final = 80
_FEATURES: Final = ("sequence-header",)


def _objects(code: int, *objects: Sequence[FbaPlane], padding: bytes = b"") -> list[StreamItem]:
    """A sequence of face objects, each with its visual object; user data behind the sequence header."""
    items = [sequence(code)] + ([user_data(padding)] if padding else [])
    for planes in objects:
        items += [visual_object(), face_object(planes)]
    return [*items, end_code()]


def _talk(count: int, rate: tuple[int, int, int], seconds: int | None = None) -> list[FbaPlane]:
    """Planes of few bits, one FAP going up and down."""
    first = intra({3: 5}, rate=rate, time=None if seconds is None else (0, 0, seconds))
    return [first, *(inter(first, {3: (-1) ** n}) for n in range(count - 1))]


# -- profile codes and tools -------------------------------------------------------------------------------------------

_FACE_CODES: Final = {
    "51": 0x51, "61": 0x61, "62": 0x62, "63": 0x63, "64": 0x64, "71": 0x71, "72": 0x72, "81": 0x81, "82": 0x82,
    "fe": 0xFE, "ff": 0xFF,
}  # fmt: skip


@family(
    _FACE_CODES,
    id="sys.profile.face.code-{case}",
    title="A face under profile code 0x{case}",
    tier="profile",
    rules=["SYS-2", "SYS-8", "SYS-9", "SYS-10"],
    features=_FEATURES,
    profile=SF1,
)
def face_codes(code: int) -> Accept:
    """FAP data under profile_and_level_indication 0x{case}.

    All profiles but Scalable Texture hold it. Limits are known for Simple Face Animation only.
    """
    measured = {"faces": 1, "frame_rate": 15}
    check = ProfileCheck("pass" if code in (_L1, _L2) else "not_checked", measured=measured)
    if code == 0x51:
        check = ProfileCheck("fail", ("profile-tool",), {"profile-tool": (_OBJECT, _OBJECT + 1)}, measured)
    return Accept(_objects(code, _talk(3, (15, 0, 0))), lines=3, findings=check.findings, check=check)


_BODY_CODES: Final = {"61": 0x61, "62": 0x62, "63": 0x63, "64": 0x64, "71": 0x71, "81": 0x81}


@family(
    _BODY_CODES,
    id="sys.profile.body.code-{case}",
    title="BAP data under profile code 0x{case}",
    tier="profile",
    rules=["SYS-8", "SYS-9", "FBA-5", "FBA-40"],
    features=[*_FEATURES, "bap"],
    profile="Simple FBA@L1",
)
def body_codes(code: int) -> Accept:
    """A plane of FAP data, then one of FAP and BAP data, under 0x{case}: only Simple FBA holds bodies.

    Elsewhere `profile-tool` stands at the first bit of the BAP data, not at the plane.
    """
    first = intra({3: 5}, rate=(15, 0, 0))
    both = body({8: 100}, face=intra({3: 6}))
    items = _objects(code, [first, both])
    held = code in (0x63, 0x64)
    where: dict[str, tuple[int, int]] = {}
    if not held:
        # The same plane without bodies ends where the BAP data begins.
        alone = [item for item in read_stream(write_stream(_objects(code, [first, intra({3: 6})]))) if item.fba]
        assert alone[0].fba is not None
        at = alone[0].fba.planes[1].end
        where = {"profile-tool": (at, at + 1)}
    ids = () if held else ("profile-tool",)
    return Accept(
        items, values={(1, 3): 24}, findings=ids, check=ProfileCheck("not_checked" if held else "fail", ids, where)
    )


_MESH_CODES: Final = {"51": 0x51, "61": 0x61, "62": 0x62, "63": 0x63, "71": 0x71, "72": 0x72, "81": 0x81, "82": 0x82}


@family(
    _MESH_CODES,
    id="sys.profile.mesh.code-{case}",
    title="A 2D mesh under profile code 0x{case}",
    tier="profile",
    rules=["SYS-3", "SYS-4", "SYS-8", "SYS-9", "MSH-1"],
    features=[*_FEATURES, "mesh-uniform"],
    tools=("mesh",),
    profile="Basic Animated Texture@L1",
    notes="The limits of Basic Animated Texture are not known to this suite: its level 1 is not checked.",
)
def mesh_codes(code: int) -> Accept:
    """A mesh object under 0x{case}. No profile is named after meshes: Hybrid and Basic Animated Texture do."""
    first = uniform(3, 2, 20, 16)
    items = [sequence(code), visual_object(type=3), mesh_object([first, moved(first, {1: (2, 1)})]), end_code()]
    held = code in (0x71, 0x72, 0x81, 0x82)
    ids = () if held else ("profile-tool",)
    where = {} if held else {"profile-tool": (_OBJECT, _OBJECT + 1)}
    return Accept(
        items, lines=2, findings=ids,
        check=ProfileCheck("not_checked" if held else "fail", ids, where, {"faces": 0}),
    )  # fmt: skip


# -- bit rate ----------------------------------------------------------------------------------------------------------


def _dense(seed: int, count: int, rate: tuple[int, int, int] | None, ranges: int = 1) -> list[FbaPlane]:
    """Intra planes of random levels of all FAPs: about 800 bits, 2,200 where limits are sent, as in the first ones."""
    numbers = Seeded(seed)
    planes = []
    for n in range(count):
        levels = {fap: numbers.between(0, 1860) for fap in range(3, 69)}
        planes.append(intra(levels, ranges=all_lists(31) if n < ranges else None, rate=rate if n == 0 else None))
    return planes


def _of_size(code: int, bits: int, count: int, rate: tuple[int, int, int]) -> list[StreamItem]:
    """A second of `count` planes with exactly so many bits, headers included, then a plane of the second after it.

    User data fills up whole bytes; the seed of the levels is the first whose last bit falls right.
    """
    for seed in range(1, 200):
        planes = _dense(seed, count, rate)
        data = write_stream(_objects(code, planes, padding=b"\xff"))
        (item,) = [item for item in read_stream(data) if item.fba is not None]
        assert item.fba is not None
        missing = bits - item.fba.planes[-1].end
        if missing % 8 == 0:
            if missing < 0:
                raise TypeError(f"{count} planes have more than {bits} bits")
            return _objects(code, [*planes, empty()], padding=b"\xff" * (1 + missing // 8))
    raise TypeError("no seed gives the last bit its place")


@family(
    {
        "level 1 at the limit": (_L1, 16_000, 15, "pass"), "level 1 one bit above": (_L1, 16_001, 15, "fail"),
        "level 2 at the limit": (_L2, 32_000, 30, "pass"), "level 2 one bit above": (_L2, 32_001, 30, "fail"),
    },
    id="sys.level.bit-rate.{case}",
    title="Bit rate: {case}",
    tier="profile",
    rules=["SYS-2", "SYS-10", "SYS-11"],
    features=_FEATURES,
    value_classes=["max"],
    profile={
        "level 1 at the limit": SF1, "level 1 one bit above": SF2, "level 2 at the limit": SF2,
        "level 2 one bit above": None,
    },
    seed=1,
    notes="Level 2 one bit above is held by no known level; as a stream it is still to be decoded.",
)  # fmt: skip
def bit_rate(case: tuple[int, int, int, str]) -> Accept:
    """The planes of one second hold 16,000 or 32,000 bits, or one more ({case}).

    Bits count from the first of the sequence header to the last of the plane. A kbit is 1,000 bits.
    """
    code, bits, rate, verdict = case
    measured = {"bit_rate": bits, "faces": 1}
    ids = () if verdict == "pass" else ("level-bit-rate",)
    return Accept(
        _of_size(code, bits, rate, (rate, 0, 0)), lines=rate + 1, findings=(),
        check=ProfileCheck(verdict, ids, measured=measured),
    )  # fmt: skip


@vector(
    id="sys.level.bit-rate.burst",
    title="A burst in a quiet stream",
    tier="profile",
    rules=["SYS-10", "SYS-11"],
    features=_FEATURES,
    profile=SF2,
    seed=2,
    notes="By the mean of the whole stream (the other reading of AMB-SYS-1) it would keep to level 1.",
)
def burst() -> Accept:
    """Three quiet seconds at 15 Hz, then a second of dense planes: the fullest window counts, not the mean."""
    items = _objects(_L1, [*_talk(45, (15, 0, 0)), *_dense(2, 8, None, ranges=8)])
    return Accept(items, lines=53, findings=(), check=ProfileCheck("fail", ("level-bit-rate",)))


@vector(
    id="sys.level.bit-rate.half-open-window",
    title="Two large planes exactly one second apart",
    tier="profile",
    rules=["SYS-10", "SYS-11"],
    features=[*_FEATURES, "frame-rate"],
    profile=SF1,
    seed=3,
)
def half_open_window() -> Accept:
    """At 1 Hz a window [t, t + 1 s) holds one plane: the user data of the first does not add to the second's bits."""
    planes = _dense(3, 2, (1, 0, 0))
    items = _objects(_L1, planes, padding=b"\xff" * 1_650)
    # The first plane has 13,200 bits of user data and 2,447 of its own; with the second there would be 16,544.
    return Accept(items, lines=2, findings=(), check=ProfileCheck("pass", measured={"planes_per_second": 1}))


# -- faces and frame rates ---------------------------------------------------------------------------------------------


@family(
    {
        "level 1 one after the other": (_L1, 2, True, "pass"), "level 1 two at once": (_L1, 2, False, "fail"),
        "level 2 four at once": (_L2, 4, False, "pass"), "level 2 five at once": (_L2, 5, False, "fail"),
    },
    id="sys.level.faces.{case}",
    title="Faces: {case}",
    tier="profile",
    rules=["SYS-2", "SYS-10", "SYS-12"],
    features=[*_FEATURES, "several-objects"],
    value_classes=["max"],
    profile={
        "level 1 one after the other": SF1, "level 1 two at once": SF2, "level 2 four at once": SF2,
        "level 2 five at once": None,
    },
    notes="A decoder of one object gives the first.",
)  # fmt: skip
def faces(case: tuple[int, int, bool, str]) -> Accept:
    """{case}: level 1 allows one face at a time, level 2 four. Every face is a visual object of its own.

    What counts is whether the times of their FAP data overlap, not how many objects there are.
    """
    code, count, apart, verdict = case
    objects = [_talk(3, (12, 0, 0), seconds=10 * n if apart else 0) for n in range(count)]
    items = _objects(code, *objects)
    ids = () if verdict == "pass" else ("level-faces",)
    measured: dict[str, int | Fraction] = {"faces": 1 if apart else count, "frame_rate": 12 * count}
    if code == _L1:
        ids = (*ids, "rate-above-15")
    return Accept(items, lines=3, findings=("trailing-data",), check=ProfileCheck(verdict, ids, measured=measured))


@family(
    {
        "level 1 at 15 Hz": (_L1, (15, 0, 0), Fraction(15), ()),
        "level 1 above 15 Hz": (_L1, (15, 1, 0), Fraction(241, 16), ("rate-above-15",)),
        "level 1 below 15 Hz": (_L1, (15, 0, 1), Fraction(15_000, 1_001), ()),
        "level 2 at 60 Hz": (_L2, (60, 0, 0), Fraction(60), ()),
        "level 2 above 60 Hz": (_L2, (60, 1, 0), Fraction(961, 16), ("rate-sum-above-60",)),
    },
    id="sys.level.rate.{case}",
    title="Frame rate: {case}",
    tier="profile",
    rules=["SYS-10", "SYS-12", "FBA-6"],
    features=[*_FEATURES, "frame-rate"],
    value_classes=["max"],
    profile=SF1,
    notes="15 and 60 Hz are what a decoder must render (AMB-SYS-2): a finding, and no failure.",
)
def frame_rates(case: tuple[int, tuple[int, int, int], Fraction, tuple[str, ...]]) -> Accept:
    """{case}: the declared rate is an exact fraction, sixteenths of a Hz, with 1000/1001 or without."""
    code, rate, exact, ids = case
    return Accept(
        _objects(code, _talk(4, rate)), lines=4, findings=(),
        check=ProfileCheck("pass", ids, measured={"frame_rate": exact}),
    )  # fmt: skip


@vector(
    id="sys.level.rate.level-2-shared",
    title="Four faces share 60 Hz",
    tier="profile",
    rules=["SYS-10", "SYS-12"],
    features=[*_FEATURES, "several-objects", "frame-rate"],
    profile=SF2,
    notes="A decoder of one object gives the first.",
)
def shared_rate() -> Accept:
    """Faces at 25, 15, 12 and 8 Hz: together 60 Hz, which level 2 still renders."""
    objects = [_talk(2 + n, (rate, 0, 0)) for n, rate in enumerate((25, 15, 12, 8))]
    check = ProfileCheck("pass", measured={"faces": 4, "frame_rate": 60})
    return Accept(_objects(_L2, *objects), lines=2, findings=("trailing-data",), check=check)


@vector(
    id="sys.level.rate.changes",
    title="The frame rate changes on the way",
    tier="profile",
    rules=["SYS-12", "FBA-6"],
    features=[*_FEATURES, "frame-rate"],
    profile=SF1,
    notes="15 and 60 Hz are what a decoder must render (AMB-SYS-2): a finding, and no failure.",
)
def rate_changes() -> Accept:
    """10 Hz, then 20 Hz from an intra plane on: the highest rate in force is the one that level 1 looks at."""
    planes = [*_talk(3, (10, 0, 0)), timed(intra({3: 6}), rate=(20, 0, 0)), timed(intra({3: 7}))]
    check = ProfileCheck("pass", ("rate-above-15",), measured={"frame_rate": 20})
    return Accept(_objects(_L1, planes), lines=5, check=check)
