"""The reader: runs the syntax functions over bits.

Rules: CNF-7, CNF-21, FBA-3, FBA-25..27, FBA-42, FBA-44.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from mypy_extensions import mypyc_attr

from ..bitstream.cursor import MASKS, BitCursor, OutOfBits
from ..bitstream.errors import MarkerBit, ReservedValue, Truncated
from ..bitstream.findings import Finding
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..bitstream.startcodes import DRAFT_PLANE, FBA_OBJECT_PLANE, PREFIX
from ..entropy.blocks import BlockCode, read_blocks
from ..entropy.kernel import decode_segment
from ..entropy.model import Model
from ..entropy.prefix import LENGTH_BITS, LENGTH_MASK, PrefixTable
from ..entropy.profile import EntropyProfile
from ..rules import finding as registered_finding
from .base import BARE_CODE, END, PLANE, STUFFED_CODE, STUFFED_END, ZERO_PADDING, SyntaxIO
from .element import DEFAULT_READINGS, Element, Fault, Readings

# The pure form reads words as the syntax functions say it: it is what can be patched and watched, and what the fast way
# of the compiled form is compared with. Interpreted functions have a code object.
COMPILED: Final = not hasattr(read_blocks, "__code__")


@mypyc_attr(allow_interpreted_subclasses=True)
class Reader(SyntaxIO):
    """Reads bits; the values passed in are ignored. Rules: CNF-7, CNF-21.

    `on_finding`: called with each finding; by default they gather in `findings`. `collect`: keep trailing bytes.
    """

    def __init__(
        self,
        cursor: BitCursor,
        *,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        draft: bool = False,
        strict: bool = False,
        on_finding: Callable[[Finding], None] | None = None,
        collect: bool = False,
        profile: EntropyProfile | None = None,
    ) -> None:
        super().__init__(limits=limits, readings=readings, profile=profile)
        self.cursor = cursor
        self.reading = True
        # Machines that extend this one want to see each word.
        self.by_blocks = COMPILED and type(self) is Reader
        self.draft = draft
        self.strict = strict
        self.collect = collect
        self._on_finding = on_finding if on_finding is not None else self.findings.append

    # -- elements ------------------------------------------------------------------------------------------------

    def u(self, el: Element, n: int, v: int) -> int:
        cursor = self.cursor
        left = cursor.left - n
        if left >= 0:
            cursor.left = left
            value = (cursor.acc >> left) & MASKS[n]
        else:
            try:
                value = cursor.read(n)
            except OutOfBits:
                raise self._truncated(el, cursor.tell()) from None
        if el.restricted and not el.allows(value):
            self._outside(el, value, n)
        return value

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        cursor = self.cursor
        found = table.lookup(cursor.look(table.max_length))
        length = found & LENGTH_MASK
        # Loaded bits are bits of the data; near its end nothing may be loaded.
        left = cursor.left - length
        if found and left >= 0:
            cursor.left = left
            return found >> LENGTH_BITS
        if not found or not cursor.has(length):
            raise self._no_word(el, table)
        cursor.read(length)
        return found >> LENGTH_BITS

    def _no_word(self, el: Element, table: PrefixTable) -> Truncated | ReservedValue:
        start = self.cursor.tell()
        left = self.bits_left(table.max_length)
        bits = self.cursor.peek(left)
        if left < table.max_length and table.is_beginning(bits, left):
            return self._truncated(el, start)
        return ReservedValue(
            el.rule, el.name, value=f"{bits:0{left}b}", allowed=f"a word of the {table.name} table",
            bits=(start, start + left), path=self.path(),
        )  # fmt: skip

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        start = self.cursor.tell()
        try:
            levels, bad_guard, self.tail = decode_segment(self.cursor, models)
        except OutOfBits:
            raise self._truncated(el, start, "FBA-27") from None
        if bad_guard >= 0:
            raise self._bad_guard(bad_guard)
        return levels

    def blocks(self, code: BlockCode, blocks: list[int], first: int) -> int:
        return read_blocks(self.cursor, code, blocks, first)

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        cursor = self.cursor
        start = cursor.tell()
        data = cursor.source.read_at(start >> 3, count)
        if len(data) < count:
            raise self._truncated(el, start)
        cursor.seek(start + 8 * count)
        return data

    def rest(self, el: Element, v: bytes) -> bytes:
        start = self.cursor.tell()
        end = self.cursor.end()
        data = self.cursor.source.read_at(start >> 3, (end - start) >> 3) if self.collect else b""
        self.cursor.seek(end)
        return data

    def zeros(self, el: Element, count: int) -> int:
        start = self.cursor.tell()
        end = self.cursor.end()
        self.cursor.seek(end)
        return end - start

    # -- look-ahead ----------------------------------------------------------------------------------------------

    def boundary(self, v: int, after_object_code: bool) -> int:
        cursor = self.cursor
        bit = cursor.tell()
        width = 8 - (bit & 7)
        if cursor.peek(width) == MASKS[width - 1] and cursor.has(width):
            if not cursor.has(width + 1):
                return STUFFED_END
            if cursor.peek(width + 24) & 0xFFFFFF == PREFIX and cursor.has(width + 24):
                if not cursor.has(width + 32):
                    raise Truncated(
                        "FBA-44", "start_code", allowed="a start code of 32 bits",
                        bits=(bit + width, cursor.end()), path=self.path(),
                    )  # fmt: skip
                return STUFFED_CODE
        if not cursor.has(1):
            return END
        if after_object_code and self.readings.unstuffed_plane != "plane-data" and self._bare_plane_code():
            return BARE_CODE
        if self.readings.trailing_zeros == "padding" and cursor.only_zeros_left():
            return ZERO_PADDING
        return PLANE

    def _bare_plane_code(self) -> bool:
        code = self.cursor.peek(32)
        return self.cursor.has(32) and (code == FBA_OBJECT_PLANE or (self.draft and code == DRAFT_PLANE))

    def at_end(self, v: bool) -> bool:
        return not self.cursor.has(1)

    def next_code(self, v: int) -> int:
        code = self.cursor.peek(32)
        return code if code >> 8 == PREFIX and self.cursor.has(32) else -1

    def follows(self, value: int, n: int, v: bool) -> bool:
        return self.cursor.peek(n) == value and self.cursor.has(n)

    def only_zeros_left(self, v: bool) -> bool:
        return self.cursor.only_zeros_left()

    def bits_left(self, most: int) -> int:
        left = most
        while left and not self.cursor.has(left):
            left -= 1
        return left

    def head(self, count: int) -> bytes:
        return self.cursor.source.read_at(self.cursor.tell() >> 3, count)

    def bytes_to_prefix(self, v: int) -> int:
        source = self.cursor.source
        first = self.cursor.tell() >> 3
        offset = first
        tail = b""
        while True:
            chunk = source.read_at(offset, 1 << 16)
            window = tail + chunk
            at = window.find(b"\0\0\1")
            if at >= 0:
                return offset - len(tail) + at - first
            offset += len(chunk)
            # One byte past the limit is enough to see that it is passed.
            if not chunk or offset - first > self.limits.user_data_bytes + (1 << 16):
                return offset - first
            tail = window[-2:]

    def tell(self) -> int:
        return self.cursor.tell()

    # -- faults --------------------------------------------------------------------------------------------------

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        if not ok:
            raise fault.error(
                fault.rule,
                fault.what,
                value=value,
                allowed=fault.allowed,
                bits=(start, end),
                path=self.path(),
            )

    def finding(self, id: str, message: str, start: int, end: int) -> None:
        kind = registered_finding(id)
        self._on_finding(Finding(id, kind.severity, kind.rule, message, (start, end), None, self.path()))

    def _outside(self, el: Element, value: int, n: int) -> None:
        end = self.cursor.tell()
        raise el.fault(el.domain_rule, el.name, value=value, allowed=el.allowed, bits=(end - n, end), path=self.path())

    def _truncated(self, el: Element, start: int, rule: str = "") -> Truncated:
        end = self.cursor.end()
        return Truncated(
            rule or el.rule, el.name, allowed="the whole element before the end of the data",
            bits=(start, end), path=self.path(),
        )  # fmt: skip

    def _bad_guard(self, bit: int) -> MarkerBit:
        return MarkerBit("FBA-25", "start_code_guard", value=0, allowed="1", bits=(bit, bit + 1), path=self.path())
