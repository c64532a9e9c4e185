"""The arithmetic coder, fast: whole segments, several bits at a time.

Rules: FBA-21..27. `literal.py` says the same thing bit by bit; the tests hold the two together.

Renormalisation shifts by k + m bits at once: k leading bits that low and high share (each was output), then m bits
where low is 01.. and high is 10.. (each counted as pending). After the second kind the leading bits differ for good,
so k then m is the whole loop of FBA-23.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from ..bitstream.cursor import MASKS, SEGMENT_BYTES, BitCursor, OutOfBits
from ..bitstream.errors import EncodeError
from ..bitstream.sink import BitSink
from .model import MAX_FREQUENCY, Model

if TYPE_CHECKING:
    # Machine integers for locals of the compiled form; nothing of it is there at run time.
    from mypy_extensions import i64

GUARD_AFTER: Final = 22
ZEROS: Final = "0" * GUARD_AFTER
LOOK_AHEAD: Final = 14
# Up to so many frequencies are summed one by one, more by `sum`.
NEAR: Final = 6
# With a symbol's bits behind it, a word stays a machine number in both forms.
WORD: Final = 32


def segment_end(start: int, data_bits: int, guards: list[int]) -> int:
    """Where raw parsing resumes after a segment.

    Rules: FBA-26. `data_bits`: all data bits fetched, the 16 preloaded ones included; `guards`: for each guard met,
    the number of data bits before it. Returns the absolute bit position behind the 2nd of the last 16 data bits.
    """
    used = data_bits - LOOK_AHEAD
    end = start + used
    for before in guards:
        if before < used:
            end += 1
    return end


def first_bad_guard(start: int, end: int, guards: list[int], values: list[int]) -> int:
    """Bit position of the first guard of value 0 before the end of its segment, or -1. Rules: FBA-25, FBA-27."""
    for i, before in enumerate(guards):
        position = start + before + i
        if position >= end:
            break
        if not values[i]:
            return position
    return -1


def segment_tail(low: int, value: int) -> int:
    """How the last two data bits of a segment differ from those that an encoder sends (01 or 10), as numbers.

    Rules: FBA-26, FBA-43. `low`, `value`: the coder's registers at the end of the segment.
    """
    return (value >> 14) - (1 if low < 0x4000 else 2)


def decode_segment(cursor: BitCursor, models: list[Model]) -> tuple[list[int], int, int]:
    """Decode one segment: a level per model; P models adapt.

    Rules: FBA-21..27. Leaves the cursor at the end of the segment. Returns the levels, the position of the first
    bad guard (-1: none) and the tail (`segment_tail`). Raises OutOfBits where the segment ends past the data.
    """
    cursor.ensure(SEGMENT_BYTES)
    start = cursor.tell()
    window = cursor.window
    base = cursor.base << 3
    acc: i64 = cursor.acc & MASKS[cursor.left]
    left: i64 = cursor.left
    nxt: i64 = cursor.next
    data_bits: i64 = 16
    guards: list[int] = []
    guard_values: list[int] = []
    levels: list[int] = []

    while left < 16:
        acc = (acc << 32) | int.from_bytes(window[nxt : nxt + 4], "big")
        nxt += 4
        left += 32
    left -= 16
    value: i64 = acc >> left
    acc -= value << left
    lowest: int = value & -value
    zeros: i64 = lowest.bit_length() - 1 if lowest else 16
    low: i64 = 0
    high: i64 = 0xFFFF
    s: i64
    top: i64
    below: i64
    k: i64
    m: i64
    w: i64
    # Bit lengths are asked of Python's integers.
    differ: int
    open_: int

    for model in models:
        n: i64 = model.n
        if n == 1:
            levels.append(model.lo)
            continue
        length = high - low + 1
        total: i64 = model.total
        c = ((value - low + 1) * total - 1) // length
        if not model.adaptive:
            s = n - 1 - c
            high = low - 1 + length * (c + 1) // total
            low += length * c // total
        else:
            freq = model.freq
            if freq is None or model.above < 0:
                freq = model.rebuild()
            if model.tree is not None:
                s, top = model.take(c)
                below = top - freq[s]
            else:
                above: i64 = model.above
                s = model.anchor
                if above <= c:
                    below = above
                    s -= 1
                    top = below + freq[s]
                    while top <= c:
                        below = top
                        s -= 1
                        top += freq[s]
                else:
                    top = above
                    below = top - freq[s]
                    while below > c:
                        top = below
                        s += 1
                        below -= freq[s]
                    model.above = above + 1
            high = low - 1 + length * top // total
            low += length * below // total
            if total == MAX_FREQUENCY:
                model.update(s)
            else:
                freq[s] = top - below + 1
                model.total = total + 1
        levels.append(s + model.lo)

        differ = low ^ high
        k = 16 - differ.bit_length()
        low = (low << k) & 0xFFFF
        high = ((high << k) & 0xFFFF) | ((1 << k) - 1)
        open_ = ~(low & ~high) & 0x7FFF
        m = 15 - open_.bit_length() if k < 16 else 0
        if m:
            low = (low << m) & 0x7FFF
            high = 0x8000 | ((high << m) & 0x7FFF) | ((1 << m) - 1)
        t = k + m
        if not t:
            continue
        data_bits += t
        if zeros + t <= GUARD_AFTER:
            while left < t:
                # Interpreted, a third slower than int.from_bytes; compiled, no call at all.
                word = window[nxt] << 24 | window[nxt + 1] << 16 | window[nxt + 2] << 8 | window[nxt + 3]
                acc = (acc << 32) | word
                nxt += 4
                left += 32
            left -= t
            w = acc >> left
            acc -= w << left
            if w:
                lowest = w & -w
                zeros = lowest.bit_length() - 1
            else:
                zeros += t
        else:
            w = 0
            for i in range(t):
                if zeros == GUARD_AFTER:
                    if left == 0:
                        acc = int.from_bytes(window[nxt : nxt + 4], "big")
                        nxt += 4
                        left = 32
                    left -= 1
                    guards.append(data_bits - t + i)
                    bit = acc >> left
                    guard_values.append(bit)
                    acc -= bit << left
                    zeros = 0
                if left == 0:
                    acc = int.from_bytes(window[nxt : nxt + 4], "big")
                    nxt += 4
                    left = 32
                left -= 1
                bit = acc >> left
                acc -= bit << left
                w = (w << 1) | bit
                zeros += 1
                if bit:
                    zeros = 0
        value = ((value << k) & 0xFFFF) | (w >> m)
        if m:
            value = (value & 0x8000) | ((value << m) & 0x7FFF) | (w & ((1 << m) - 1))

    end = segment_end(start, data_bits, guards)
    if end - base > cursor.limit << 3:
        raise OutOfBits
    cursor.seek(end)
    bad_guard = first_bad_guard(start, end, guards, guard_values) if guards else -1
    return levels, bad_guard, segment_tail(low, value)


def encode_segment(sink: BitSink, models: list[Model], levels: list[int], tail: int = 0) -> None:
    """Encode one segment; P models adapt. Each level must lie in its model. Rules: FBA-21..26."""
    code, count = segment_code(models, levels, tail)
    write_guarded(sink, code, count)


def segment_code(models: list[Model], levels: list[int], tail: int = 0) -> tuple[int, int]:
    """The data bits of a segment, without guards, as (number, count of bits).

    Rules: FBA-21..24, FBA-26. `tail`: what is added to the last two bits, to write an odd segment back as it was;
    raises EncodeError where no bits behind such an end could decode to these levels.
    """
    low: i64 = 0
    high: i64 = 0xFFFF
    below: i64
    top: i64
    # What is written is no machine integer: pending bits have no bound.
    pending = 0
    # Whole words, and the bits behind them: one number that grows would be copied with every symbol.
    words: list[int] = []
    acc = 0
    held = 0
    differ: int
    open_: int
    out: int
    assert len(models) == len(levels)
    for model, level in zip(models, levels):
        if model.n == 1:
            continue
        s: i64 = level - model.lo
        length = high - low + 1
        total: i64 = model.total
        if not model.adaptive:
            below = model.n - 1 - s
            top = below + 1
        else:
            freq = model.freq
            if freq is None or model.above < 0:
                freq = model.rebuild()
            f: i64 = freq[s]
            if model.tree is not None or total == MAX_FREQUENCY:
                below = model.cum_from(s + 1)
                top = below + f
                model.update(s)
            else:
                top = model.above
                at: i64 = model.anchor
                if s >= at:
                    model.above = top + 1
                    if s - at > NEAR:
                        top -= sum(freq[at:s])
                    else:
                        while at < s:
                            top -= freq[at]
                            at += 1
                elif at - s > NEAR:
                    top += sum(freq[s:at])
                else:
                    while at > s:
                        at -= 1
                        top += freq[at]
                below = top - f
                freq[s] = f + 1
                model.total = total + 1
        high = low - 1 + length * top // total
        low += length * below // total
        differ = low ^ high
        k = 16 - differ.bit_length()
        if k:
            out = low >> (16 - k)
            if pending:
                # The first shared bit resolves the pending ones, which are its opposite.
                first = out >> (k - 1)
                acc = (((acc << 1) | first) << pending) | (0 if first else (1 << pending) - 1)
                acc = (acc << (k - 1)) | (out & MASKS[k - 1])
                held += pending
                pending = 0
            else:
                acc = (acc << k) | out
            held += k
            while held >= WORD:
                held -= WORD
                words.append(acc >> held)
                acc &= (1 << held) - 1
        low = (low << k) & 0xFFFF
        high = ((high << k) & 0xFFFF) | ((1 << k) - 1)
        open_ = ~(low & ~high) & 0x7FFF
        m = 15 - open_.bit_length() if k < 16 else 0
        if m:
            low = (low << m) & 0x7FFF
            high = 0x8000 | ((high << m) & 0x7FFF) | ((1 << m) - 1)
            pending += m
    pending += 1
    quarter = (1 if low < 0x4000 else 2) + tail
    if quarter < low >> 14 or quarter > high >> 14:
        raise EncodeError("FBA-26", "tail of the segment", value=tail, allowed="0, or what was read with these levels")
    last = (1 << pending) - 1 if low < 0x4000 else 1 << pending
    code = 0
    for word in words:
        code = (code << WORD) | word
    code = (((code << held) | acc) << (pending + 1)) | last
    return code + tail, len(words) * WORD + held + pending + 1


def write_guarded(sink: BitSink, code: int, count: int, guard: int = 1) -> None:
    """Write data bits with the start-code guards between them.

    Rules: FBA-25. `guard` 0 makes bad guards, for negative vectors.
    """
    bits = f"{code:0{count}b}"
    run = bits.find(ZEROS)
    if run < 0 or run + GUARD_AFTER >= count:
        sink.write(code, count)
        return
    position = 0
    while True:
        run = bits.find(ZEROS, position)
        if run < 0 or run + GUARD_AFTER >= count:
            break
        run += GUARD_AFTER
        sink.write(int(bits[position:run], 2), run - position)
        sink.write(guard, 1)
        position = run
    sink.write(int(bits[position:], 2), count - position)
