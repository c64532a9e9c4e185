"""The temporal header: rates, time codes, skipped frames."""

from __future__ import annotations

from ..builders import empty, inter, intra, stream
from ..recipe import Accept, family, vector


@family(
    {
        "25": ((25, 0, 0), "1/25"),
        "12 and 8 sixteenths": ((12, 8, 0), "2/25"),
        "30 by 1001": ((30, 0, 1), "1001/30000"),
        "29 and 15 sixteenths by 1001": ((29, 15, 1), "2002/59875"),
        "7 sixteenths": ((0, 7, 0), "16/7"),
        "1": ((1, 0, 0), "1/1"),
        "255 and 15 sixteenths": ((255, 15, 0), "16/4095"),
    },
    id="fba.header.rate.{case}",
    title="Frame rate {case}",
    tier="syntax",
    rules=["FBA-6", "FBA-37", "FBA-38"],
    features=["frame-rate"],
    value_classes=["frame-rate"],
)
def rate(case: tuple[tuple[int, int, int], str]) -> Accept:
    """Frame rate {case}: whole frames plus sixteenths, times 1000/1001 where frequency_offset is set.

    Times are exact fractions. Decoders compute 1000/1001 in integers, or leave the sixteenths out.
    """
    value, period = case
    first = intra({3: 1}, rate=value)
    return Accept(stream(first, inter(first)), times={0: "0/1", 1: period})


@vector(
    id="fba.header.rate.default",
    title="No frame rate is ever sent",
    tier="syntax",
    rules=["FBA-37", "FBA-38"],
    features=["frame-rate"],
)
def default_rate() -> Accept:
    """Before any rate is sent it is 30."""
    first = intra({3: 1})
    return Accept(stream(first, inter(first), inter(first)), times={1: "1/30", 2: "1/15"})


@vector(
    id="fba.header.rate.changed",
    title="The frame rate changes in the stream",
    tier="semantic",
    rules=["FBA-37", "FBA-38"],
    features=["frame-rate"],
)
def changed_rate() -> Accept:
    """Frames before the change keep their time; periods after it are those of the new rate. An intra plane without
    a rate keeps the one in force.
    """
    first = intra({3: 1}, rate=(10, 0, 0))
    second = intra({3: 1}, rate=(24, 0, 1))
    third = intra({3: 1})
    planes = [first, inter(first), second, inter(second), third, inter(third)]
    return Accept(
        stream(*planes),
        times={1: "1/10", 2: "1/5", 3: "5801/24000", 5: "2601/8000"},
    )


@vector(
    id="fba.header.rate.plane-without-data",
    title="The rate comes with a plane without data",
    tier="syntax",
    rules=["FBA-5", "FBA-6", "FBA-37"],
    features=["frame-rate", "plane-without-data"],
)
def rate_in_empty_plane() -> Accept:
    """A plane without data has the whole temporal header; its rate holds from there on."""
    first = intra({3: 1})
    return Accept(stream(empty(is_intra=1, rate=(5, 0, 0)), first, inter(first)), times={1: "1/5", 2: "2/5"})


@family(
    {
        "zero": ((0, 0, 0), "0/1"),
        "highest": ((23, 59, 59), "86399/1"),
        "mixed": ((1, 2, 3), "3723/1"),
    },
    id="fba.header.time-code.{case}",
    title="Time code, {case}",
    tier="syntax",
    rules=["FBA-7", "FBA-38"],
    features=["time-code"],
    value_classes=["time-code"],
)
def time_code(case: tuple[tuple[int, int, int], str]) -> Accept:
    """A time code ({case}) in the first plane sets the running time."""
    value, time = case
    return Accept(stream(intra({3: 1}, rate=(25, 0, 0), time=value)), times={0: time})


@vector(
    id="fba.header.time-code.running-on",
    title="Time runs on after a time code",
    tier="semantic",
    rules=["FBA-7", "FBA-38"],
    features=["time-code"],
)
def time_code_runs_on() -> Accept:
    """A time code is the time of its plane alone. Decoders repeat it for every later plane until the next one."""
    first = intra({3: 1}, rate=(4, 0, 0), time=(0, 1, 0))
    later = intra({3: 2}, time=(0, 2, 0))
    planes = [first, inter(first), inter(first), later, inter(later)]
    return Accept(stream(*planes), times={0: "60/1", 1: "241/4", 2: "121/2", 3: "120/1", 4: "481/4"}, findings=())


@vector(
    id="fba.header.time-code.back",
    title="A time code that goes back",
    tier="semantic",
    rules=["FBA-38"],
    features=["time-code"],
)
def time_code_back() -> Accept:
    """The second time code is earlier than the first. That is odd, and no error: the time goes back."""
    planes = [intra({3: 1}, time=(2, 0, 0)), intra({3: 2}, time=(1, 0, 0))]
    return Accept(stream(*planes), times={0: "7200/1", 1: "3600/1"}, findings=("time-code-back",))


@family(
    {str(count): count for count in (0, 1, 14, 15, 16, 29, 30, 31, 1000)},
    id="fba.header.skip.{case}",
    title="{case} frames skipped",
    tier="syntax",
    rules=["FBA-8", "FBA-38"],
    features=["skip"],
    value_classes=["skip-groups"],
)
def skip(count: int) -> Accept:
    """The plane in the middle says that {case} frames are skipped: groups of four bits, repeated while they are 15.

    15 is coded as 15, 0 and 30 as 15, 15, 0. A decoder that stops after the first group loses its place.
    """
    first = intra({3: 1}, rate=(1, 0, 0))
    return Accept(
        stream(first, inter(first, {3: 1}, skip=count), inter(first, {3: 1})), times={1: "1/1", 2: f"{count + 2}/1"}
    )


@vector(
    id="fba.header.skip.everywhere",
    title="Skips in intra planes, inter planes and planes without data",
    tier="semantic",
    rules=["FBA-5", "FBA-8", "FBA-38"],
    features=["skip", "plane-without-data"],
)
def skip_everywhere() -> Accept:
    """Skipped frames lie behind the plane that says so, whatever data it has."""
    first = intra({3: 1}, rate=(1, 0, 0), skip=2)
    planes = [first, empty(skip=3), inter(first, skip=1), inter(first)]
    return Accept(stream(*planes), times={0: "0/1", 1: "3/1", 2: "7/1", 3: "9/1"})


@vector(
    id="fba.header.all-fields",
    title="Every field of the temporal header",
    tier="syntax",
    rules=["FBA-6", "FBA-7", "FBA-8", "FBA-37", "FBA-38"],
    features=["frame-rate", "time-code", "skip"],
)
def all_fields() -> Accept:
    """Rate, time code and skip in one intra plane."""
    first = intra({3: 1}, rate=(50, 0, 1), time=(0, 0, 10), skip=16)
    return Accept(stream(first, inter(first)), times={0: "10/1", 1: "517017/50000"})
