"""A third arithmetic coder, for the tests: FBA-21..27 word by word, with a cumulative list, on strings of bits.

Nothing here is shared with the codec: neither models nor bit handling.
"""

from __future__ import annotations


class PlainModel:
    """n symbols; symbol s stands for the level s + lo. An adaptive model is a P model."""

    def __init__(self, lo: int, hi: int, adaptive: bool) -> None:
        self.lo = lo
        self.frequencies = [1] * (hi - lo + 1)
        self.adaptive = adaptive
        self.halvings = 0

    def cumulative(self) -> list[int]:
        cum = [0]
        for f in reversed(self.frequencies):
            cum.append(cum[-1] + f)
        return cum[::-1]  # cum[j] = sum of the frequencies of symbols j..n-1

    def count(self, s: int) -> None:
        if not self.adaptive:
            return
        if sum(self.frequencies) == 16383:
            self.frequencies = [(f + 1) // 2 for f in self.frequencies]
            self.halvings += 1
        self.frequencies[s] += 1


def _narrow(low: int, high: int, cum: list[int], s: int) -> tuple[int, int]:
    length = high - low + 1
    return low + length * cum[s + 1] // cum[0], low - 1 + length * cum[s] // cum[0]


def encode_data_bits(models: list[PlainModel], levels: list[int]) -> str:
    """The data bits of a segment, without guards (FBA-21..24, FBA-26)."""
    low, high, pending, out = 0, 65535, 0, ""
    for model, level in zip(models, levels, strict=True):
        s = level - model.lo
        low, high = _narrow(low, high, model.cumulative(), s)
        model.count(s)
        while True:
            if high < 32768:
                out += "0" + "1" * pending
                pending = 0
            elif low >= 32768:
                out += "1" + "0" * pending
                pending = 0
                low, high = low - 32768, high - 32768
            elif low >= 16384 and high < 49152:
                pending += 1
                low, high = low - 16384, high - 16384
            else:
                break
            low, high = 2 * low, 2 * high + 1
    pending += 1
    return out + ("0" + "1" * pending if low < 16384 else "1" + "0" * pending)


def guarded(bits: str, guard: str = "1") -> str:
    """A guard before the data bit that follows 22 zeros (FBA-25)."""
    out, zeros = "", 0
    for bit in bits:
        if zeros == 22:
            out += guard
            zeros = 0
        out += bit
        zeros = 0 if bit == "1" else zeros + 1
    return out


def encode(models: list[PlainModel], levels: list[int]) -> str:
    """A whole segment as it stands in the stream."""
    return guarded(encode_data_bits(models, levels))


def decode(bits: str, start: int, models: list[PlainModel]) -> tuple[list[int], int, list[int]]:
    """(levels, end, positions of guards of value 0 before the end); past the end of `bits` everything is 0."""
    at = start
    zeros = 0
    ends: list[int] = []  # position after each data bit
    guards: list[tuple[int, str]] = []

    def raw() -> str:
        nonlocal at
        bit = bits[at] if at < len(bits) else "0"
        at += 1
        return bit

    def data_bit() -> int:
        nonlocal zeros
        if zeros == 22:
            guards.append((at, raw()))
            zeros = 0
        bit = raw()
        zeros = zeros + 1 if bit == "0" else 0
        ends.append(at)
        return int(bit)

    low, high, code_value = 0, 65535, 0
    for _ in range(16):
        code_value = 2 * code_value + data_bit()
    levels = []
    for model in models:
        cum = model.cumulative()
        c = ((code_value - low + 1) * cum[0] - 1) // (high - low + 1)
        s = next(s for s in range(len(cum) - 1) if cum[s + 1] <= c)
        levels.append(s + model.lo)
        low, high = _narrow(low, high, cum, s)
        model.count(s)
        while True:
            if high < 32768:
                base = 0
            elif low >= 32768:
                base = 32768
            elif low >= 16384 and high < 49152:
                base = 16384
            else:
                break
            low, high = 2 * (low - base), 2 * (high - base) + 1
            code_value = 2 * (code_value - base) + data_bit()
    end = ends[-15]  # right after the 2nd of the last 16 data bits fetched
    return levels, end, [position for position, bit in guards if position < end and bit == "0"]
