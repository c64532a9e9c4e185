"""Other masks for a `.fap` text than its own.

Rules: FBA-10, FBA-50.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from ..tables import fap_groups
from .fap_text import FapFile, FapTextFrame


def with_masks(fap: FapFile, numbers: Collection[int]) -> FapFile:
    """A copy in which every frame codes exactly the FAPs `numbers` (1..68), as `masked`. Rules: FBA-10, FBA-50."""
    frames = list(masked(fap.frames, numbers))
    return FapFile(fap.version, fap.name, fap.frame_rate, fap.nframes, frames, list(fap.comments), list(fap.findings))


def masked(frames: Iterable[FapTextFrame], numbers: Collection[int]) -> Iterator[FapTextFrame]:
    """Frames that code exactly the FAPs `numbers` (1..68).

    Rules: FBA-10, FBA-50. A FAP that a frame does not give holds its last value, 0 before any; others are dropped.
    A constant mask spares intra planes.
    """
    last = max(group.last_fap for group in fap_groups())
    mask = tuple(1 if number in numbers else 0 for number in range(1, last + 1))
    held: list[int | None] = [0 if digit and i > 1 else None for i, digit in enumerate(mask)]
    viseme = (0, 0, 0, 0) if mask[0] else None
    expression = (0, 0, 0, 0, 0, 0) if mask[1] else None
    for frame in frames:
        for i, value in enumerate(frame.values):
            if mask[i] and value is not None:
                held[i] = value
        if viseme is not None and frame.viseme is not None:
            viseme = frame.viseme
        if expression is not None and frame.expression is not None:
            expression = frame.expression
        yield FapTextFrame(frame.number, mask, list(held), viseme, expression, frame.line)
