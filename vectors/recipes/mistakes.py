"""Face streams for mistakes that the other vectors let pass: found by the kill matrix, one each.

Rules: CNF-8. What a vector is about stands in its rules, as everywhere; the mistakes are in `vectors/mutants`.
"""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import InconsistentSemantics
from snhc.reference_impl.bitstream.startcodes import DRAFT_PLANE
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import decode_planes, write_stream

from ..builders import body, empty, inter, intra, stream, timed, with_code
from ..manifest import DecodeOptions
from ..recipe import Accept, Reject, vector


@vector(
    id="fba.framing.idle.ended-by-data",
    title="A plane with data ends a run of planes without",
    tier="semantic",
    rules=["FBA-42", "CNF-22"],
    features=["plane-without-data", "limits"],
    options=DecodeOptions(limits={"idle_planes": 2}),
)
def idle_ended_by_data() -> Accept:
    """Under a limit of two: two planes without data, one with, two without. Runs are limited, not their sum."""
    first = intra({3: 5})
    idle = [empty(is_intra=1), empty(is_intra=1)]
    return Accept(stream(first, *idle, inter(first, {3: 1}), empty(is_intra=1), empty(is_intra=1)), lines=6)


@vector(
    id="fba.framing.idle.ended-by-code",
    title="A start code ends a run of planes without data",
    tier="semantic",
    rules=["FBA-42", "FBA-44", "CNF-22"],
    features=["plane-without-data", "plane-start-code", "limits"],
    options=DecodeOptions(limits={"idle_planes": 2}),
)
def idle_ended_by_code() -> Accept:
    """Under a limit of two: two planes without data, then two more, the first of them behind a start code."""
    planes = [empty(is_intra=1), empty(is_intra=1), with_code(empty(is_intra=1)), empty(is_intra=1)]
    return Accept(stream(intra({3: 5}), *planes), lines=5)


@vector(
    id="fba.framing.draft-plane-code-unasked",
    title="A plane start code of the drafts that nobody asked for",
    tier="semantic",
    rules=["FBA-4", "FBA-3"],
    features=["draft", "start-codes"],
)
def draft_plane_code_unasked() -> Accept:
    """Without `--compat draft` 00000103 is a start code of something else: the object ends before it."""
    writer = Writer()
    writer.draft = True
    first = intra({3: 5})
    data = write_stream(stream(first, with_code(inter(first, {3: 1}), DRAFT_PLANE)), writer)
    return Accept(data, lines=1, values={(0, 3): 20}, findings=("trailing-data",))


@vector(
    id="fba.error.inter-first.body-behind-face",
    title="Inter BAP data behind an intra plane with FAP data only",
    tier="error",
    rules=["FBA-35", "FBA-40"],
    features=["bap"],
)
def inter_body_behind_face() -> Reject:
    """Each kind of data needs an intra plane of its own."""
    first = intra({3: 5})
    end = next(decode_planes(write_stream(stream(first)))).end
    return Reject(stream(first, inter(body({}))), InconsistentSemantics, "FBA-35", bits=(end, end + 1))


@vector(
    id="fba.header.skip.at-the-limit",
    title="As many skipped frames as the limit allows",
    tier="semantic",
    rules=["FBA-8", "CNF-22", "CNF-26"],
    features=["skip", "limits"],
    value_classes=["limit"],
    options=DecodeOptions(limits={"skipped_frames": 31}),
)
def skip_at_the_limit() -> Accept:
    """31 frames skipped under a limit of 31: a limit is the largest number that is still good."""
    first = intra({3: 5}, rate=(25, 0, 0), skip=31)
    return Accept(stream(first, inter(first, {3: 1})), times={1: "32/25"})


@vector(
    id="fba.header.time-code.standing-still",
    title="A time code equal to the time before",
    tier="semantic",
    rules=["FBA-38"],
    features=["time-code"],
)
def time_code_standing_still() -> Accept:
    """Two planes with the time code 0:00:07. Time does not go back: no finding."""
    planes = [intra({3: 5}, time=(0, 0, 7)), intra({3: 6}, time=(0, 0, 7))]
    return Accept(stream(*planes), times={0: "7/1", 1: "7/1"}, findings=())


@vector(
    id="fap.mask.group-1.interpolated-later",
    title="FAP 1 and 2 decoded, then to be interpolated, then back",
    tier="semantic",
    rules=["FBA-14", "FBA-34"],
    features=["viseme", "expression", "mask-type-2"],
)
def group_1_interpolated_later() -> Accept:
    """While they are I, `viseme` and `expression` are null; with mask type 0 they come back with their last values."""
    coded = intra(viseme=(3, 4, 5, 0), expression=(1, 20, 2, 30, 0, 1))
    return Accept(
        stream(coded, intra({3: 1}, types={1: 2}), intra({3: 2})),
        states={(1, 1): "I", (1, 2): "I", (2, 1): "R", (2, 2): "R"},
        text={
            0: '"viseme":{"select1":3,"select2":4,"blend":5,"def":0}',
            1: '"viseme":null,"expression":null',
            2: '"viseme":{"select1":3,"select2":4,"blend":5,"def":0}',
        },
    )


@vector(
    id="fap.arith.segment.code-value-on-the-border",
    title="A code value that is the last one of its symbol",
    tier="stress",
    rules=["FBA-23"],
    features=["ranges"],
)
def code_value_on_the_border() -> Accept:
    """FAP 3 has two symbols of one half each and is 1; then twenty FAPs are 0, which sends nothing but 1 bits.

    The code value at FAP 3 is 32767, the last one of the lower half: (32767 + 1) * 2 / 65536 is exactly 1, and only the
    - 1 of the formula keeps it below.
    """
    numbers = [*range(3, 17), *range(19, 26)]
    levels = {number: int(number == 3) for number in numbers}
    one = dict.fromkeys(numbers, 1)
    none = dict.fromkeys(numbers, 0)
    first = intra(levels, quant=31, ranges={"i_max": one, "i_min": none, "p_max": one, "p_min": none})
    return Accept(stream(first), values={(0, 3): 124, (0, 4): 0, (0, 25): 0})


@vector(
    id="fap.arith.segment.unusual-end",
    title="A segment that ends in its own way",
    tier="semantic",
    rules=["FBA-26"],
    features=["segment-end"],
)
def unusual_end() -> Accept:
    """The last two data bits are 00 where encoders send 01: the same value, other bits. Accepted, with a finding."""
    first = intra({3: 0}, ranges={"i_max": 1, "i_min": 1, "p_max": 1, "p_min": 1})
    second = inter(first, {3: 60})
    assert second.faps is not None
    second.faps.tails[2] = -1
    return Accept(stream(first, second), values={(1, 3): 240}, findings=("segment-end",))


@vector(
    id="fba.body.two-genders",
    title="Face and body with two suggested genders",
    tier="semantic",
    rules=["FBA-40", "FBA-11"],
    features=["bap", "gender"],
)
def two_genders() -> Accept:
    """The face is female, the body male: the line's `gender` is the face's."""
    return Accept(stream(timed(body({8: 1}, quant=0, gender=1, face=intra({3: 5}, gender=0)))), text={0: '"gender":0'})
