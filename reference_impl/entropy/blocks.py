"""Blocks of coefficients, fast: the ordinary ones of a DCT segment in one go.

Rules: DCT-2, DCT-3, DCT-4. `face/dct_syntax.py` says the same thing word by word; the tests hold the two together.

This reads what nearly all blocks are made of, and leaves everything else to the syntax functions, which alone say what
an escape is and what is wrong with a word: at an escape, where no word fits, at a run past the end, and where the data
or what is loaded of it ends, it stops before the block.
"""

from __future__ import annotations

from typing import Final, final

from mypy_extensions import i64

from ..bitstream.cursor import MASKS, BitCursor
from .prefix import LENGTH_BITS, LENGTH_MASK, PrefixTable

BLOCK: Final = 16
_DC_BITS: Final = 16
_DC_MASK: Final = 0xFFFF
# Bits are loaded where fewer than 32 are left; the loaded ones stay a machine number with its sign. (`1 << n` is no way
# to make such a mask: compiled, that 1 has 32 bits.)
_KEPT: Final = 0x7FFFFFFF


@final
class BlockCode:
    """How the blocks of a segment are coded.

    Rules: DCT-2, DCT-3, DCT-4.

    `dc`: the table of DC differences, None where the DC itself is sent in 16 bits. `runs`, `levels`: the tables of the
    AC coefficients. `offset`: what is taken from the symbols of differences and levels. `dc_escape`, `level_escape`,
    `wide`: the symbols, and the DC of 16 bits, behind which further fields stand. `end`: the run that ends a block.
    """

    __slots__ = ("dc", "dc_escape", "end", "level_escape", "levels", "offset", "runs", "wide")

    def __init__(
        self, dc: PrefixTable | None, runs: PrefixTable, levels: PrefixTable, *, offset: int, dc_escape: int,
        level_escape: int, wide: int, end: int,
    ) -> None:  # fmt: skip
        self.dc = dc
        self.runs = runs
        self.levels = levels
        self.offset = offset
        self.dc_escape = dc_escape
        self.level_escape = level_escape
        self.wide = wide
        self.end = end


def read_blocks(cursor: BitCursor, code: BlockCode, blocks: list[int], first: int) -> int:
    """Read ordinary blocks into their places, from block `first` on; what stands there must be 0.

    Rules: DCT-2, DCT-3, DCT-4. Returns the number of the first block that was not read, and leaves the cursor before
    it; in its place then stands anything.
    """
    # Of what is loaded, and of that only data: a slow pipe is not waited for, and what was read is there.
    window = cursor.window
    limit: i64 = cursor.limit
    nxt: i64 = cursor.next
    left: i64 = cursor.left
    acc: i64 = cursor.acc
    dc = code.dc
    runs = code.runs
    levels = code.levels
    run_words = runs.direct
    level_words = levels.direct
    run_bits: i64 = runs.direct_bits
    level_bits: i64 = levels.direct_bits
    run_mask: i64 = len(run_words) - 1
    level_mask: i64 = len(level_words) - 1
    offset: i64 = code.offset
    dc_escape: i64 = code.dc_escape
    level_escape: i64 = code.level_escape
    wide: i64 = code.wide
    end: i64 = code.end
    if runs.max_length + levels.max_length > 32:
        # One loading would not do for both words of a coefficient.
        return first
    block: i64 = first
    count: i64 = len(blocks) // BLOCK
    done: i64 = (nxt << 3) - left
    while block < count:
        if left < 32:
            if nxt + 4 > limit:
                break
            acc = (
                ((acc & _KEPT) << 32)
                | (i64(window[nxt]) << 24)
                | (i64(window[nxt + 1]) << 16)
                | (i64(window[nxt + 2]) << 8)
                | i64(window[nxt + 3])
            )
            nxt += 4
            left += 32
        level: i64 = 0
        found: i64 = 0
        if dc is None:
            left -= _DC_BITS
            level = (acc >> left) & _DC_MASK
            if level >> (_DC_BITS - 1):
                level -= 1 << _DC_BITS
            if level == wide:
                break
        else:
            found = dc.lookup((acc >> (left - dc.max_length)) & MASKS[dc.max_length])
            left -= found & LENGTH_MASK
            level = found >> LENGTH_BITS
            if found == 0 or level == dc_escape:
                break
            level -= offset
        at: i64 = block * BLOCK
        last: i64 = at + BLOCK - 1
        blocks[at] = level
        while at < last:
            if left < 32:
                if nxt + 4 > limit:
                    break
                acc = (
                    ((acc & _KEPT) << 32)
                    | (i64(window[nxt]) << 24)
                    | (i64(window[nxt + 1]) << 16)
                    | (i64(window[nxt + 2]) << 8)
                    | i64(window[nxt + 3])
                )
                nxt += 4
                left += 32
            found = run_words[(acc >> (left - run_bits)) & run_mask]
            if found == 0:
                found = runs.lookup((acc >> (left - runs.max_length)) & MASKS[runs.max_length])
                if found == 0:
                    break
            left -= found & LENGTH_MASK
            run: i64 = found >> LENGTH_BITS
            if run == end:
                at = last
                break
            to: i64 = at + run + 1
            if to > last:
                break
            found = level_words[(acc >> (left - level_bits)) & level_mask]
            if found == 0:
                found = levels.lookup((acc >> (left - levels.max_length)) & MASKS[levels.max_length])
            left -= found & LENGTH_MASK
            level = found >> LENGTH_BITS
            if found == 0 or level == level_escape:
                break
            blocks[to] = level - offset
            at = to
        if at != last:
            break
        block += 1
        done = (nxt << 3) - left
    cursor.seek((cursor.base << 3) + done)
    return block
