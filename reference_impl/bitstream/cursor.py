"""The bit cursor: unsigned fields, most significant bit first, over a window of the source.

Rules: FBA-27 (bits past the end of the data read as 0 in look-ahead), CNF-21 (positions are absolute, from bit 0).

The accumulator never holds more than 63 bits, so that the same source compiles to machine words.
"""

from __future__ import annotations

from typing import Final, final

from .source import BytesSource, Source

WINDOW: Final = 1 << 16
# Zero bytes kept behind the end of the data: a segment's look-ahead may run over it (FBA-27). The longest segment,
# 296 parameters of at most 16 bits each, with its guards stays below 700 bytes.
PADDING: Final = 4096
SEGMENT_BYTES: Final = 2048
MASKS: Final = tuple((1 << n) - 1 for n in range(65))


class OutOfBits(Exception):
    """Fewer bits left than asked for. The machines turn it into a located `Truncated`. Rules: CNF-21."""


@final
class BitCursor:
    """Position in a source, to the bit.

    Rules: CNF-21, FBA-27.

    Public to the machines of this package: `window` (bytes from `base`, zero padded where the data ends), `limit`
    (bytes of `window` that are data), `next` (index of the byte to load next), `acc` and `left` (loaded bits).
    """

    __slots__ = ("_first_one", "acc", "base", "ended", "left", "limit", "next", "source", "window")

    def __init__(self, source: Source) -> None:
        self.source = source
        self.base = 0
        self.next = 0
        self.acc = 0
        self.left = 0
        self.limit = 0
        self.ended = False
        self.window = b""
        self._first_one = -1
        self._load(0)

    @classmethod
    def of(cls, data: bytes) -> BitCursor:
        """A cursor over bytes in memory. Rules: CNF-21."""
        return cls(BytesSource(data))

    def _load(self, byte: int, least: int = 8) -> None:
        data, self.ended = self.source.read_some(byte, least, WINDOW)
        self.base = byte
        self.next = 0
        self.acc = 0
        self.left = 0
        self.limit = len(data)
        self.window = data + bytes(PADDING) if self.ended else data

    def tell(self) -> int:
        """The current bit position. Rules: CNF-21."""
        return ((self.base + self.next) << 3) - self.left

    def seek(self, bit: int) -> None:
        """Go to a bit position inside the data or at its end. Rules: CNF-21."""
        byte = bit >> 3
        if byte < self.base or byte > self.base + self.limit:
            self._load(byte)
        self.next = byte - self.base
        self.left = 0
        self.acc = 0
        if bit & 7:
            self.acc = self.window[self.next]
            self.next += 1
            self.left = 8 - (bit & 7)

    def ensure(self, count: int) -> None:
        """Make at least `count` bytes from here visible in the window, or all up to the padded end. Rules: FBA-27."""
        if not self.ended and self.limit - self.next < count:
            bit = self.tell()
            self._load(bit >> 3, count + 1)
            self.seek(bit)

    def read(self, n: int) -> int:
        """The next n bits (0..32) as an unsigned number. Rules: CNF-21. Raises OutOfBits, without moving."""
        left = self.left
        while left < n:
            if self.next + 4 <= self.limit:
                i = self.next
                self.acc = ((self.acc & MASKS[left]) << 32) | int.from_bytes(self.window[i : i + 4], "big")
                self.next = i + 4
                left += 32
            elif self.next < self.limit:
                self.acc = ((self.acc & MASKS[left]) << 8) | self.window[self.next]
                self.next += 1
                left += 8
            elif self.ended:
                self.left = left
                raise OutOfBits
            else:
                self.left = left
                bit = self.tell()
                self._load(bit >> 3)
                self.seek(bit)
                left = self.left
        left -= n
        self.left = left
        return (self.acc >> left) & MASKS[n]

    def peek(self, n: int) -> int:
        """The next n bits (0..48) without moving; past the end of the data zeros. Rules: FBA-3, FBA-27."""
        self.ensure(8)
        bit = self.tell()
        first = (bit >> 3) - self.base
        word = int.from_bytes(self.window[first : first + 7].ljust(7, b"\0"), "big")
        return (word >> (56 - (bit & 7) - n)) & MASKS[n]

    def look(self, n: int) -> int:
        """As `peek`, for n up to 32, loading the bits so that taking them is cheap. Rules: FBA-27."""
        left = self.left
        if left < n:
            if self.next + 4 > self.limit:
                return self.peek(n)
            i = self.next
            self.acc = ((self.acc & MASKS[left]) << 32) | int.from_bytes(self.window[i : i + 4], "big")
            self.next = i + 4
            left += 32
            self.left = left
        return (self.acc >> (left - n)) & MASKS[n]

    def has(self, n: int) -> bool:
        """Whether at least n bits (0..256) are left. Rules: CNF-21."""
        self.ensure((n >> 3) + 2)
        return self.tell() + n <= (self.base + self.limit) << 3

    def end(self) -> int:
        """Bits in all; reads a pipe to its end. Rules: CNF-21."""
        return self.source.size() << 3

    def only_zeros_left(self) -> bool:
        """Whether every remaining bit is 0 (true at the end of the data).

        Rules: FBA-42. The place of the next 1 bit is remembered, so that asking again costs nothing: the whole
        stream is scanned at most once.
        """
        if self.peek(48):
            return False
        bit = self.tell()
        if self._first_one > bit:
            return False
        if self._first_one == -2:
            return True
        tail = self.source.read_at(bit >> 3, 1)
        if not tail:
            return True
        if tail[0] & MASKS[8 - (bit & 7)]:
            return False
        offset = (bit >> 3) + 1
        while True:
            chunk = self.source.read_at(offset, WINDOW)
            if not chunk:
                self._first_one = -2
                return True
            rest = chunk.lstrip(b"\0")
            if rest:
                self._first_one = (offset + len(chunk) - len(rest)) * 8 + 8 - rest[0].bit_length()
                return False
            offset += len(chunk)
