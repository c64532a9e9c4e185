"""The replayer: runs the syntax functions over written-down values and makes bits.

Rules: CNF-25, FBA-3, FBA-26, FBA-41, SYS-5.

It stands between reader and writer: control flow follows the values, as a reader's does, and the bits are written as
they come. So an edited value becomes what it says wherever the syntax can still hold what follows, and a located
fault elsewhere. What depends on the place (stuffing, padding) is made anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from ..bitstream.errors import EncodeError
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..entropy.model import Model
from ..entropy.prefix import PrefixTable
from ..entropy.profile import EntropyProfile
from .base import BARE_CODE, END, PLANE, STUFFED_CODE, STUFFED_END, ZERO_PADDING
from .element import DEFAULT_READINGS, Element, Fault, Readings
from .writer import Writer

_STUFFING: Final = "stuffing"
_PADDING: Final = "zero_padding"
_PLANE_CODE: Final = "fba_object_plane_start_code"
_CODE: Final = "_code"
_PREFIX: Final = b"\0\0\1"


@dataclass(frozen=True, slots=True)
class Written:
    """One element as it was written down.

    Rules: CNF-21, CNF-25.

    `width`: bits it had; of padding what counts. `value`: of a field. `levels`, `tail`: of an arithmetic segment.
    `data`: of bytes. `where`: its place in the document, for errors.
    """

    name: str
    width: int
    where: str
    value: int = 0
    levels: tuple[int, ...] | None = None
    tail: int = 0
    data: bytes | None = None


class ValuesEnd(Exception):
    """No more values, where the document says that a fault ended it. Rules: CNF-25."""


class Replayer(Writer):
    """A writer that follows written-down values instead of records.

    Rules: CNF-25. `open_end`: the values end at a fault of the stream; there `ValuesEnd` is raised. Raises EncodeError
    where an element that the syntax wants is not the next one, or cannot hold its value.
    """

    def __init__(
        self,
        values: Iterator[Written],
        *,
        open_end: bool = False,
        draft: bool = False,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        profile: EntropyProfile | None = None,
    ) -> None:
        super().__init__(limits=limits, readings=readings, profile=profile)
        self.reading = True
        self.draft = draft
        self._values = values
        self._open_end = open_end
        self._coming: list[Written] = []

    def _look(self, ahead: int = 0) -> Written | None:
        while len(self._coming) <= ahead:
            value = next(self._values, None)
            if value is None:
                if self._open_end and ahead == 0:
                    raise ValuesEnd
                return None
            self._coming.append(value)
        return self._coming[ahead]

    def _at_fault(self) -> bool:
        """Whether the values end here at a fault of the stream."""
        try:
            self._look()
        except ValuesEnd:
            return True
        return False

    def _take(self, el: Element) -> Written:
        value = self._look()
        if value is None or value.name != el.name:
            raise EncodeError(
                el.rule, el.name, value="nothing" if value is None else f"{value.name} ({value.where})",
                allowed="this element here, as the values before it say", path=self.path(),
            )  # fmt: skip
        return self._coming.pop(0)

    # -- elements ------------------------------------------------------------------------------------------------

    def u(self, el: Element, n: int, v: int) -> int:
        written = self._take(el)
        if el.name != _STUFFING:
            return super().u(el, n, written.value)
        # Its width is what is left of a byte: bits before it may have come or gone.
        if written.width == n and written.value != v:
            if self._at_fault():
                return super().u(el, n, written.value)
            raise EncodeError(el.rule, el.name, value=written.value, allowed=str(v), path=self.path())
        return super().u(el, n, v)

    def s(self, el: Element, n: int, v: int) -> int:
        value = self._take(el).value
        if not -(1 << (n - 1)) <= value < 1 << (n - 1):
            raise EncodeError(
                el.rule, el.name, value=value, allowed=f"{-(1 << (n - 1))}..{(1 << (n - 1)) - 1}", path=self.path()
            )
        self.sink.write(value & ((1 << n) - 1), n)
        return value

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        return super().vlc(el, table, self._take(el).value)

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        written = self._take(el)
        if written.levels is None:
            raise EncodeError(el.rule, el.name, value=written.where, allowed="levels", path=self.path())
        return super().segment(el, models, labels, list(written.levels), written.tail)

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        data = self._bytes(el)
        if (data + _PREFIX).find(_PREFIX) < len(data):
            raise EncodeError(
                el.rule, el.name, value=f"{len(data)} bytes", allowed="bytes that hold no start code prefix",
                path=self.path(),
            )  # fmt: skip
        return super().raw(el, count, data)

    def rest(self, el: Element, v: bytes) -> bytes:
        return Writer.raw(self, el, 0, self._bytes(el))

    def _bytes(self, el: Element) -> bytes:
        written = self._take(el)
        if written.data is None:
            raise EncodeError(el.rule, el.name, value=written.where, allowed="bytes", path=self.path())
        return written.data

    def zeros(self, el: Element, count: int) -> int:
        width = self._take(el).width
        return super().zeros(el, width + -(self.sink.tell() + width) % 8)

    # -- what follows --------------------------------------------------------------------------------------------

    def boundary(self, v: int, after_object_code: bool) -> int:
        return super().boundary(self._boundary(), after_object_code)

    def _boundary(self) -> int:
        following = self._look()
        if following is None:
            return END
        if following.name == _STUFFING:
            return STUFFED_CODE if self._look(1) is not None or self._open_end else STUFFED_END
        if following.name == _PADDING:
            return ZERO_PADDING
        return BARE_CODE if following.name == _PLANE_CODE else PLANE

    def at_end(self, v: bool) -> bool:
        return self._look() is None

    def next_code(self, v: int) -> int:
        following = self._look()
        if following is not None and following.data is not None and following.data.startswith(_PREFIX):
            # Bytes that no syntax takes may begin with a start code all the same.
            return int.from_bytes(following.data[:4], "big") if len(following.data) >= 4 else -1
        return following.value if following is not None and following.name.endswith(_CODE) else -1

    def follows(self, value: int, n: int, v: bool) -> bool:
        following = self._look()
        return following is not None and following.width == n and following.value == value

    def only_zeros_left(self, v: bool) -> bool:
        following = self._look()
        return following is not None and following.name == _PADDING

    def bytes_to_prefix(self, v: int) -> int:
        following = self._look()
        return len(following.data) if following is not None and following.data is not None else 0

    def bits_left(self, most: int) -> int:
        return most

    def head(self, count: int) -> bytes:
        return b""

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        if not ok and self._open_end:
            # The fault that ended the stream, or else one that an edited value made.
            self._look()
        super().require(ok, fault, value, start, end)
