"""Adaptive models of the arithmetic coder.

Rules: FBA-22, FBA-24.

One model, three ways to search it, chosen by measurement: uniform (all frequencies 1: no search), outward from the
symbol of level 0 with one anchored cumulative sum (small residuals cluster there; an update is one addition), and a
Fenwick tree for large alphabets, where a hostile stream would make the outward walk long. `freq` and `total` are the
model; everything else only speeds up the search and can be rebuilt from them.
"""

from __future__ import annotations

from typing import Final, final

MAX_FREQUENCY: Final = 16383
# Above this many symbols the tree wins on uniform input and loses little on clustered input.
FENWICK_FROM: Final = 513


@final
class Model:
    """Frequencies of `n` symbols; symbol s stands for the level s + lo.

    Rules: FBA-22, FBA-24.

    `freq` None: every frequency is 1 (state after a reset). `adaptive` False: used once, never updated (I models).
    `anchor`: the symbol the search starts from; `above`: sum of freq[anchor:], -1 when it must be rebuilt;
    `tree`: Fenwick tree over freq, None for small alphabets.
    """

    __slots__ = ("above", "adaptive", "anchor", "freq", "lo", "n", "total", "tree")

    def __init__(self, lo: int, hi: int, adaptive: bool) -> None:
        self.lo = lo
        self.n = hi - lo + 1
        self.adaptive = adaptive
        self.freq: list[int] | None = None
        self.tree: list[int] | None = None
        self.total = self.n
        self.anchor = -lo if lo < 0 else 0
        self.above = -1

    def rebuild(self) -> list[int]:
        """Make the search structures anew from the frequencies, which are returned. Rules: FBA-22."""
        freq = self.freq
        if freq is None:
            freq = [1] * self.n
            self.freq = freq
        self.above = sum(freq[self.anchor :])
        if self.n >= FENWICK_FROM:
            tree = [0, *freq]
            for i in range(1, self.n + 1):
                j = i + (i & -i)
                if j <= self.n:
                    tree[j] += tree[i]
            self.tree = tree
        return freq

    def halve(self) -> None:
        """Every frequency f becomes (f + 1) / 2. Rules: FBA-24."""
        freq = self.freq
        if freq is None:
            freq = [1] * self.n
        self.freq = [(f + 1) >> 1 for f in freq]
        self.total = sum(self.freq)
        self.rebuild()

    def find(self, c: int) -> int:
        """The smallest symbol s with cum[s + 1] <= c, in the tree. Rules: FBA-23."""
        tree = self.tree
        assert tree is not None
        n = self.n
        rest = self.total - c - 1
        s = 0
        step = 1 << (n.bit_length() - 1)
        while step:
            j = s + step
            if j <= n and tree[j] <= rest:
                s = j
                rest -= tree[j]
            step >>= 1
        return s

    def cum_from(self, s: int) -> int:
        """cum[s]: the sum of the frequencies of symbols s..n-1. Rules: FBA-22."""
        freq = self.freq
        if freq is None or self.above < 0:
            freq = self.rebuild()
        tree = self.tree
        if tree is not None:
            below = 0
            while s:
                below += tree[s]
                s &= s - 1
            return self.total - below
        anchor = self.anchor
        if s >= anchor:
            return self.above - sum(freq[anchor:s])
        return self.above + sum(freq[s:anchor])

    def update(self, s: int) -> None:
        """Count symbol s; halve first where the total is Max_frequency. Rules: FBA-24."""
        freq = self.freq
        if freq is None or self.above < 0:
            freq = self.rebuild()
        if self.total == MAX_FREQUENCY:
            self.halve()
            freq = self.freq
            assert freq is not None
        freq[s] += 1
        self.total += 1
        if s >= self.anchor:
            self.above += 1
        tree = self.tree
        if tree is not None:
            s += 1
            while s <= self.n:
                tree[s] += 1
                s += s & -s
