"""What the rows of a trace are called and mean, in one place for all that show them.

Rules: CNF-17, CNF-21, FBA-23, FBA-25, FBA-26, SYS-8.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Final

from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.syntax.element import Element
from snhc.reference_impl.syntax.tracer import Trace
from snhc.reference_impl.systems.visual import PROFILE_AND_LEVEL, profile_name

# What a row holds.
FIELD: Final = "field"
SEGMENT: Final = "segment"
BYTES: Final = "bytes"


def kind_of_row(trace: Trace, row: int) -> str:
    """FIELD, SEGMENT or BYTES. Rules: CNF-21."""
    if row in trace.segments:
        return SEGMENT
    return BYTES if row in trace.blobs else FIELD


def meaning(element: Element, value: int) -> str:
    """What a value means, in words; "" where it is a plain number. Rules: SYS-8."""
    return profile_name(value) if element is PROFILE_AND_LEVEL else element.meaning.get(value, "")


def number_text(element: Element, value: int, bits: int) -> str:
    """A value as it is shown: start codes as eight hexadecimal digits. Rules: CNF-21."""
    return f"0x{value:08x}" if bits == 32 and element.name.endswith("_code") else str(value)


def settled_bits(segment: SegmentTrace) -> Iterator[tuple[int, int]]:
    """For each symbol the bits that it settles: those that the coder shifts out behind it.

    Rules: FBA-23, FBA-25, FBA-26. Half open, absolute; guards between count in, and a symbol may settle none. An
    arithmetic code does not give each symbol bits of its own; but once it is known, so are these, whatever follows.
    The two bits behind the last span end the segment. Needs the steps of the segment.
    """
    # guard number i stands behind (guard - start - i) data bits
    before = [position - segment.start - i for i, (position, _) in enumerate(segment.guards)]

    def place(data_bit: int) -> int:
        return segment.start + data_bit + bisect_right(before, data_bit)

    done = 0
    at = segment.start
    for step in segment.steps:
        done += step.shifts
        end = place(done - 1) + 1 if step.shifts else at
        yield at, end
        at = end
