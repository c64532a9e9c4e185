"""The arithmetic coder, literally: one bit, one comparison, one cumulative list at a time.

Rules: FBA-21..27. The tracer runs this one, and reports every symbol; it shares nothing with the fast kernel but the
frequencies of the models.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from typing import Final

from ..bitstream.cursor import BitCursor, OutOfBits
from .model import MAX_FREQUENCY, Model

Q1: Final = 16384
Q2: Final = 32768
Q3: Final = 49152
TOP: Final = 65535


@dataclass(frozen=True, slots=True)
class SymbolStep:
    """One decoded symbol, as the coder saw it.

    Rules: FBA-22, FBA-23.

    `low`, `high`, `code_value`: before the symbol. `total`: cum[0]; `c`: the scaled code value; `cum_low`, `cum_high`:
    the cumulative bin [cum[s + 1], cum[s]). `level`: s + lo. `bits_before`: data bits fetched before the symbol was
    decoded; `shifts`: renormalisation shifts after it. `adaptive`: a P model (updated) or an I model. `rescaled`: the
    frequencies were halved before the update (FBA-24).
    """

    low: int
    high: int
    code_value: int
    total: int
    c: int
    cum_low: int
    cum_high: int
    symbols: int
    level: int
    bits_before: int
    shifts: int
    adaptive: bool
    rescaled: bool


@dataclass(frozen=True, slots=True)
class SegmentTrace:
    """A decoded segment: its levels, steps, guards and end.

    Rules: FBA-25, FBA-26. `steps`: one per level, or none where nobody asked for them. `guards`: (absolute bit
    position, value) of the guards before the end position. `tail`: how the last two data bits differ from an
    encoder's, 0 normally. `ahead`, `past_end`, only with steps: the guards met behind the end position, among the
    bits that the coder looks ahead at, whose values do not count; and whether the look-ahead met the end of the data,
    where zeros are read (FBA-27). `widths`, `totals`: one per level where they were asked for instead of steps: the
    width of its bin and cum[0], the quotient of which is what it costs.
    """

    start: int
    end: int
    steps: tuple[SymbolStep, ...]
    guards: tuple[tuple[int, int], ...]
    levels: tuple[int, ...]
    tail: int = 0
    ahead: tuple[tuple[int, int], ...] = ()
    past_end: bool = False
    widths: tuple[int, ...] = ()
    totals: tuple[int, ...] = ()


class LiteralDecoder:
    """FBA-21..27 as written. Rules: FBA-21, FBA-22, FBA-23, FBA-24, FBA-25, FBA-26, FBA-27."""

    def __init__(self, cursor: BitCursor) -> None:
        self._cursor = cursor
        self._start = cursor.tell()
        self._size: int = -1
        self._zeros = 0
        self._positions: list[int] = []  # after each data bit
        self._guards: list[tuple[int, int]] = []
        self._low = 0
        self._high = TOP
        self._code_value = 0
        for _ in range(16):
            self._code_value = 2 * self._code_value + self._data_bit()

    def _raw_bit(self) -> int:
        try:
            return self._cursor.read(1)
        except OutOfBits:
            if self._size < 0:
                self._size = self._cursor.tell()
            return 0

    @property
    def _position(self) -> int:
        # Past the end of the data the position goes on counting, bit by bit (FBA-27).
        return self._start + len(self._positions) + len(self._guards)

    def _data_bit(self) -> int:
        if self._zeros == 22:
            position = self._position
            self._guards.append((position, self._raw_bit()))
            self._zeros = 0
        bit = self._raw_bit()
        self._zeros = 0 if bit else self._zeros + 1
        self._positions.append(0)
        self._positions[-1] = self._position
        return bit

    def symbol(self, model: Model) -> SymbolStep:
        """Decode one symbol and update its model. Rules: FBA-23, FBA-24."""
        freq = model.freq
        if freq is None:
            freq = [1] * model.n
            model.freq = freq
        # cum[j] = sum of freq[j:], cum[n] = 0
        cum = [*accumulate(reversed(freq), initial=0)]
        cum.reverse()
        low, high, code_value = self._low, self._high, self._code_value
        bits_before = len(self._positions)
        length = high - low + 1
        c = ((code_value - low + 1) * cum[0] - 1) // length
        s = _smallest(cum, c)
        self._high = low - 1 + length * cum[s] // cum[0]
        self._low = low + length * cum[s + 1] // cum[0]
        shifts = 0
        while True:
            if self._high < Q2:
                pass
            elif self._low >= Q2:
                self._code_value -= Q2
                self._low -= Q2
                self._high -= Q2
            elif self._low >= Q1 and self._high < Q3:
                self._code_value -= Q1
                self._low -= Q1
                self._high -= Q1
            else:
                break
            self._low = 2 * self._low
            self._high = 2 * self._high + 1
            self._code_value = 2 * self._code_value + self._data_bit()
            shifts += 1
        rescaled = False
        if model.adaptive:
            if cum[0] == MAX_FREQUENCY:
                freq = [(f + 1) // 2 for f in freq]
                model.freq = freq
                rescaled = True
            freq[s] += 1
            model.total = sum(freq) if rescaled else cum[0] + 1
            model.above = -1  # the fast structures no longer fit
        return SymbolStep(
            low, high, code_value, cum[0], c, cum[s + 1], cum[s], model.n, s + model.lo, bits_before, shifts,
            model.adaptive, rescaled,
        )  # fmt: skip

    def finish(self, steps: list[SymbolStep]) -> SegmentTrace:
        """The end of the segment; leaves the cursor there.

        Rules: FBA-26, FBA-27. Raises OutOfBits where it lies past the data.
        """
        end = self._positions[len(self._positions) - 15]  # after the 2nd of the last 16 data bits
        if 0 <= self._size < end:
            raise OutOfBits
        self._cursor.seek(end)
        guards = tuple((position, value) for position, value in self._guards if position < end)
        # An encoder ends on 01 where low lies below the first quarter, else on 10 (FBA-26).
        wanted = 0b01 if self._low < Q1 else 0b10
        levels = tuple([step.level for step in steps])
        return SegmentTrace(
            self._start, end, tuple(steps), guards, levels, self._code_value // Q1 - wanted,
            tuple(self._guards[len(guards) :]), self._size >= 0,
        )  # fmt: skip


def _smallest(cum: list[int], c: int) -> int:
    # cum falls, so the first hit from below is found by halving.
    lo, hi = 0, len(cum) - 2
    while lo < hi:
        mid = (lo + hi) // 2
        if cum[mid + 1] <= c:
            hi = mid
        else:
            lo = mid + 1
    return lo


def decode_literally(cursor: BitCursor, models: list[Model]) -> SegmentTrace:
    """Decode one segment symbol by symbol. Rules: FBA-21..27. Raises OutOfBits like the kernel."""
    decoder = LiteralDecoder(cursor)
    return decoder.finish([decoder.symbol(model) for model in models])
