"""Inputs that the reference rejects: there are no records to edit, only the parts of the trace and the bytes.

Rules: CNF-17, CNF-21.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import trace_stream

from .ddmin import ddmin

if TYPE_CHECKING:
    from .shrink import Shrinker


def shrink(shrinker: Shrinker) -> None:
    """Cut off the end, leave out whole planes and items, then bytes, then set bits to 0. Rules: CNF-17."""
    data = shrinker.data
    # The shortest beginning that still fails.
    low, high = 0, len(data)
    while high - low > 1:
        middle = (low + high) // 2
        if shrinker.takes(data[:middle]):
            high = middle
        else:
            low = middle
    _parts(shrinker)
    data = shrinker.data
    ddmin(range(len(data)), lambda kept: shrinker.takes(bytes(data[i] for i in kept)))
    data = shrinker.data
    ones = [i for i in range(len(data) * 8) if data[i >> 3] >> (7 - (i & 7)) & 1]
    ddmin(ones, lambda kept: shrinker.takes(_with_ones(kept, len(data))))


def _with_ones(ones: list[int], length: int) -> bytes:
    out = bytearray(length)
    for i in ones:
        out[i >> 3] |= 1 << (7 - (i & 7))
    return bytes(out)


def _parts(shrinker: Shrinker) -> None:
    """Planes and items, as runs of bits."""
    data = shrinker.data
    bits = "".join(f"{byte:08b}" for byte in data)
    options = shrinker.entry.options.for_decoder()
    ends = [0]
    for part in trace_stream(BytesSource(data), options):
        if part.error is None and len(part.trace):
            ends.append(part.trace.end[-1])
    ends.append(len(bits))
    units = [bits[a:b] for a, b in pairwise(ends) if b > a]

    def joined(kept: list[str]) -> bytes:
        text = "".join(kept)
        text += "0" * (-len(text) % 8)
        return int(text or "0", 2).to_bytes(len(text) // 8, "big")

    ddmin(units, lambda kept: shrinker.takes(joined(kept)))
