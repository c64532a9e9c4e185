"""What the symbols of a segment cost, at the speed of the fast kernel.

Rules: FBA-22, FBA-24.

A symbol costs log2(total / width): the width of its bin is its frequency. Both are what the model says before it is
updated, so that they can be told from the model afterwards; nothing is decoded twice.
"""

from __future__ import annotations

from ..bitstream.cursor import BitCursor
from .kernel import decode_segment
from .model import MAX_FREQUENCY, Model


def decode_with_shares(cursor: BitCursor, models: list[Model]) -> tuple[list[int], int, int, list[int], list[int]]:
    """As `decode_segment`, and per symbol the width of its bin and the total of its model at its coding.

    Rules: FBA-22, FBA-24. `models`: each stands once in a segment. Raises OutOfBits like the kernel.
    """
    totals: list[int] = []
    halved: dict[int, list[int]] = {}
    for i, model in enumerate(models):
        total = model.total
        totals.append(total)
        if total == MAX_FREQUENCY and model.adaptive and model.freq is not None:
            # The halving rounds: what the frequencies were cannot be told afterwards.
            halved[i] = list(model.freq)
    levels, bad_guard, tail = decode_segment(cursor, models)
    widths: list[int] = []
    for i, model in enumerate(models):
        s = levels[i] - model.lo
        freq = model.freq
        if not model.adaptive:
            widths.append(1)
        elif model.n == 1:
            widths.append(totals[i])
        elif i in halved:
            widths.append(halved[i][s])
        else:
            assert freq is not None
            widths.append(freq[s] - 1)
    return levels, bad_guard, tail, widths, totals
