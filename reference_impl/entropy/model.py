"""Adaptive models of the arithmetic coder.

Rules: FBA-22, FBA-24.

One model, three ways to search it, chosen by measurement: uniform (all frequencies 1: no search), outward from the
symbol of level 0 with one anchored cumulative sum (small residuals cluster there; an update is one addition), and a
Fenwick tree for large alphabets, where a hostile stream would make the outward walk long. `freq` and `total` are the
model; everything else only speeds up the search and can be rebuilt from them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    # Machine integers for locals of the compiled form; nothing of it is there at run time.
    from mypy_extensions import i64

MAX_FREQUENCY: Final = 16383
# Above this many symbols the tree wins on uniform input and loses little on clustered input.
FENWICK_FROM: Final = 513
# A node behind the last symbol: more than any sum, so that no search goes there, however often it is counted.
NO_NODE: Final = 1 << 20


def fresh_tree(n: int) -> list[int]:
    """The Fenwick tree of n frequencies of 1, with nodes up to a power of two above n. Rules: FBA-22.

    Node i sums as many frequencies as its lowest 1 bit says: each half of the tree repeats the one before it.
    """
    tree = [0]
    while len(tree) <= n:
        half = len(tree)
        tree += tree
        tree[half] = half
    tree[n + 1 :] = [NO_NODE] * (len(tree) - n - 1)
    return tree


def tree_of(freq: list[int]) -> list[int]:
    """The Fenwick tree of frequencies, of the size of `fresh_tree`. Rules: FBA-22."""
    n: i64 = len(freq)
    size: i64 = 1 << len(freq).bit_length()
    tree = [0, *freq]
    i: i64 = 1
    while i <= n:
        j = i + (i & -i)
        if j <= n:
            tree[j] += tree[i]
        i += 1
    tree += [NO_NODE] * (size - n - 1)
    return tree


@final
class Model:
    """Frequencies of `n` symbols; symbol s stands for the level s + lo.

    Rules: FBA-22, FBA-24.

    `freq` None: every frequency is 1 (state after a reset). `adaptive` False: used once, never updated (I models).
    `anchor`: the symbol the search starts from; `above`: sum of freq[anchor:] (0 beside a tree), -1 when it must be
    rebuilt; `tree`: Fenwick tree over freq, None for small alphabets.
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
        n = self.n
        freq = self.freq
        fresh = freq is None
        if freq is None:
            freq = [1] * n
            self.freq = freq
        if n >= FENWICK_FROM:
            self.above = 0
            self.tree = fresh_tree(n) if fresh else tree_of(freq)
        else:
            self.above = n - self.anchor if fresh else sum(freq[self.anchor :])
        return freq

    def halve(self) -> None:
        """Every frequency f becomes (f + 1) / 2. Rules: FBA-24."""
        freq = self.freq
        if freq is None:
            freq = [1] * self.n
        self.freq = [(f + 1) >> 1 for f in freq]
        self.total = sum(self.freq)
        self.rebuild()

    def take(self, c: int) -> tuple[int, int]:
        """The smallest symbol s with cum[s + 1] <= c, and cum[s]; s is counted in the tree, and only there.

        Rules: FBA-23. The nodes that the search turns away from are those that hold s.
        """
        tree = self.tree
        assert tree is not None
        rest: i64 = self.total - c - 1
        s: i64 = 0
        step: i64 = len(tree) >> 1
        while step:
            j = s + step
            below: i64 = tree[j]
            if below <= rest:
                s = j
                rest -= below
            else:
                tree[j] = below + 1
            step >>= 1
        return s, c + 1 + rest

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
