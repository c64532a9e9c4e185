"""Headers around the face object."""

from __future__ import annotations

from snhc.reference_impl.systems.visual import StreamItem

from ..builders import end_code, face_object, inter, intra, sequence, user_data, visual_object
from ..recipe import Accept, family, vector


def _face() -> StreamItem:
    first = intra({3: 5})
    return face_object([first, inter(first, {3: 1})])


@vector(
    id="sys.sequence.plain",
    title="Visual object sequence, visual object, face object",
    tier="syntax",
    rules=["SYS-1", "SYS-2", "SYS-3", "SYS-4"],
    features=["sequence-header"],
    profile="Simple Face Animation@L1",
)
def plain() -> Accept:
    """All headers of a stand-alone file; visual_object_type is 4."""
    return Accept([sequence(0x61), visual_object(), _face(), end_code()], values={(1, 3): 24}, findings=())


@vector(
    id="sys.sequence.identifier",
    title="Visual object with identifier",
    tier="syntax",
    rules=["SYS-3"],
    features=["sequence-header"],
    value_classes=["max"],
)
def identifier() -> Accept:
    """visual_object_verid 15 and visual_object_priority 7 are sent."""
    items = [sequence(0x61), visual_object(verid=15, priority=7), _face(), end_code()]
    return Accept(items, values={(1, 3): 24}, findings=())


@vector(
    id="sys.user-data.both-places",
    title="User data behind both headers",
    tier="syntax",
    rules=["SYS-5"],
    features=["user-data"],
)
def user_data_twice() -> Accept:
    """User data after the sequence header and after the visual object; the second holds FF, 00 and 00 02."""
    items = [
        sequence(0x61), user_data(b"first"), visual_object(), user_data(b"\xff\x00\x00\x02\x7f"), _face(), end_code()
    ]  # fmt: skip
    return Accept(items, lines=2, findings=())


@vector(
    id="sys.user-data.empty",
    title="User data without bytes",
    tier="syntax",
    rules=["SYS-5"],
    features=["user-data"],
    value_classes=["zero"],
)
def user_data_empty() -> Accept:
    """The next start code stands directly behind user_data_start_code."""
    return Accept([sequence(0x61), user_data(b""), visual_object(), _face(), end_code()], lines=2, findings=())


@family(
    {"0": 0x00, "255": 0xFF, "254": 0xFE},
    id="sys.sequence.profile-{case}",
    title="profile_and_level_indication {case}",
    tier="syntax",
    rules=["SYS-2", "SYS-8"],
    features=["sequence-header"],
    value_classes=["min", "max"],
)
def profile(code: int) -> Accept:
    """The value {case} names no face profile; the stream decodes all the same."""
    items = [sequence(code), visual_object(), _face(), end_code()]
    return Accept(items, lines=2, findings=("profile-unknown",) if code == 0 else ())
