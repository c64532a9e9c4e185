"""The bit sink: what the writers write to.

Rules: CNF-21 (positions are absolute, from bit 0).
"""

from __future__ import annotations

from typing import final


@final
class BitSink:
    """Bits appended one field after the other, most significant first. Rules: CNF-21."""

    __slots__ = ("_acc", "_base", "_count", "_done")

    def __init__(self) -> None:
        self._done = bytearray()
        self._base = 0
        self._acc = 0
        self._count = 0

    def tell(self) -> int:
        """Bits written so far. Rules: CNF-21."""
        return ((self._base + len(self._done)) << 3) + self._count

    def write(self, value: int, n: int) -> None:
        """Append the n low bits of value. Rules: CNF-21."""
        acc = (self._acc << n) | (value & ((1 << n) - 1))
        count = self._count + n
        if count >= 8:
            rest = count & 7
            self._done += (acc >> rest).to_bytes(count >> 3, "big")
            acc &= (1 << rest) - 1
            count = rest
        self._acc = acc
        self._count = count

    def bits_from(self, start: int, n: int) -> int:
        """n bits already written, from bit `start`, zeros past the end. Rules: FBA-41."""
        first = (start >> 3) - self._base
        data = bytes(self._done[first : first + ((n + 15) >> 3)])
        if self._count:
            data += bytes([(self._acc << (8 - self._count)) & 0xFF])
        data = data[: (n + 15) >> 3].ljust((n + 15) >> 3, b"\0")
        return (int.from_bytes(data, "big") >> (len(data) * 8 - (start & 7) - n)) & ((1 << n) - 1)

    def cut(self, bit: int) -> None:
        """Drop everything from a bit position on. Rules: CNF-6."""
        acc = self._acc
        count = self._count
        byte = (bit >> 3) - self._base
        if byte < len(self._done):
            acc = self._done[byte] >> (8 - (bit & 7)) if bit & 7 else 0
            del self._done[byte:]
        else:
            acc >>= count - (bit & 7)
        self._acc = acc
        self._count = bit & 7

    def take(self, before: int) -> bytes:
        """The whole bytes before bit `before` that were not taken yet; positions go on counting.

        Rules: CNF-22. `cut` and `bits_from` then reach back only to them.
        """
        out = bytes(self._done[: max(0, (before >> 3) - self._base)])
        self._base += len(out)
        del self._done[: len(out)]
        return out

    def getvalue(self) -> bytes:
        """All bytes, the last one filled up with zero bits. Rules: CNF-21."""
        out = bytes(self._done)
        if self._count:
            out += bytes([(self._acc << (8 - self._count)) & 0xFF])
        return out
