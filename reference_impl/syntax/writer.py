"""The writer: runs the syntax functions over records and makes bits.

Rules: FBA-3, FBA-25, FBA-26, FBA-41.
"""

from __future__ import annotations

from mypy_extensions import mypyc_attr

from ..bitstream.errors import EncodeError
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..bitstream.sink import BitSink
from ..bitstream.startcodes import FBA_OBJECT_PLANE, PREFIX
from ..entropy.kernel import encode_segment
from ..entropy.model import Model
from ..entropy.prefix import PrefixTable
from ..entropy.profile import EntropyProfile
from .base import END, PLANE, STUFFED_END, ZERO_PADDING, SyntaxIO
from .element import DEFAULT_READINGS, Element, Fault, Readings

# Padding may be as long as a file: not bit by bit, and not as one number.
_ZEROS_AT_ONCE = 1 << 16


@mypyc_attr(allow_interpreted_subclasses=True)
class Writer(SyntaxIO):
    """Writes what the records say, and refuses what the syntax cannot hold. Rules: FBA-3, FBA-41.

    Raises EncodeError, with rule, element, path and value.
    """

    def __init__(
        self,
        sink: BitSink | None = None,
        *,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        profile: EntropyProfile | None = None,
    ) -> None:
        super().__init__(limits=limits, readings=readings, profile=profile)
        self.sink = sink if sink is not None else BitSink()
        self._plane_start = -1
        # Planes without a start code whose first bits could still be read as one, with what they would be read as.
        self._suspects: list[tuple[int, int, int]] = []

    # -- elements ------------------------------------------------------------------------------------------------

    def u(self, el: Element, n: int, v: int) -> int:
        if v < 0 or v >> n or (el.restricted and not el.allows(v)):
            raise EncodeError(
                el.domain_rule, el.name, value=v, allowed=el.allowed if el.restricted else f"0..{(1 << n) - 1}",
                path=self.path(),
            )  # fmt: skip
        self.sink.write(v, n)
        return v

    def s(self, el: Element, n: int, v: int) -> int:
        if not -(1 << (n - 1)) <= v < 1 << (n - 1):
            raise EncodeError(
                el.rule, el.name, value=v, allowed=f"{-(1 << (n - 1))}..{(1 << (n - 1)) - 1}", path=self.path()
            )
        return super().s(el, n, v)

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        if v not in table:
            raise EncodeError(
                el.rule, el.name, value=v, allowed=f"a symbol of the {table.name} table", path=self.path()
            )
        code, length = table.encode(v)
        self.sink.write(code, length)
        return v

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        self._check_levels(el, models, labels, v)
        encode_segment(self.sink, models, v, tail)
        self.tail = tail
        return v

    def _check_levels(self, el: Element, models: list[Model], labels: list[str], v: list[int]) -> None:
        if len(v) != len(models):
            raise EncodeError(
                el.rule,
                f"{el.name}: number of levels",
                value=len(v),
                allowed=f"{len(models)}",
                path=self.path(),
            )
        for model, label, level in zip(models, labels, v):
            if not 0 <= level - model.lo < model.n:
                raise EncodeError(
                    el.rule, f"level of {label}", value=level, allowed=f"{model.lo}..{model.lo + model.n - 1}",
                    path=self.path(),
                )  # fmt: skip

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        for byte in v:
            self.sink.write(byte, 8)
        return v

    def zeros(self, el: Element, count: int) -> int:
        # One zero bit before the end of the data is stuffing, none is no padding (FBA-3).
        if count < 2 or (self.sink.tell() + count) & 7:
            raise EncodeError(
                el.rule, el.name, value=count, allowed="2 or more zero bits, up to a byte boundary", path=self.path()
            )
        for written in range(0, count, _ZEROS_AT_ONCE):
            self.sink.write(0, min(_ZEROS_AT_ONCE, count - written))
        return count

    # -- told, not found out -------------------------------------------------------------------------------------

    def boundary(self, v: int, after_object_code: bool) -> int:
        at = self.sink.tell()
        if v in (END, STUFFED_END, ZERO_PADDING):
            self._check_end(v, at)
        if v == PLANE:
            self._plane_start = at
            width = 8 - (at & 7)
            self._suspects.append((at, width + 24, (((1 << (width - 1)) - 1) << 24) | PREFIX))
            if after_object_code:
                self._suspects.append((at, 32, FBA_OBJECT_PLANE))
        else:
            self._plane_start = -1
            self._suspects.clear()
        return v

    def _check_end(self, v: int, at: int) -> None:
        if v == END and at & 7:
            raise EncodeError("FBA-3", "end of the data", value=f"bit {at}", allowed="a byte boundary, or stuffing")
        if self._plane_start < 0:
            return
        # The zero bits of a last plane without data, and a one-bit stuffing, would read as padding (FBA-42).
        width = at - self._plane_start
        if (v != STUFFED_END or at & 7 == 7) and not self.sink.bits_from(self._plane_start, width):
            raise EncodeError("FBA-42", "last plane", value="zero bits only", allowed="an end code after it")

    def protect(self, start: int) -> bool:
        sink = self.sink
        here = sink.tell()
        # A start code can be emulated by one plane, or by a run of planes without data and what follows it; a code
        # before the plane that completes it breaks both.
        emulated = False
        left: list[tuple[int, int, int]] = []
        for suspect in self._suspects:
            at, width, pattern = suspect
            if here < at + width:
                left.append(suspect)
            elif sink.bits_from(at, width) == pattern:
                emulated = True
        self._suspects = left
        if not emulated:
            return False
        width = 8 - (start & 7)
        bits = sink.bits_from(start, here - start)
        sink.cut(start)
        sink.write((1 << (width - 1)) - 1, width)
        sink.write(FBA_OBJECT_PLANE, 32)
        sink.write(bits, here - start)
        self._plane_start = -1
        self._suspects.clear()
        return True

    def take(self) -> bytes:
        """The bytes that are final: nothing that is still to come changes them or looks back at them. Rules: CNF-22.

        The last plane stays: a start code may have to be put before it (FBA-41).
        """
        before = self._plane_start if self._plane_start >= 0 else self.sink.tell()
        for at, _, _ in self._suspects:
            before = min(before, at)
        return self.sink.take(before)

    def rest(self, el: Element, v: bytes) -> bytes:
        return self.raw(el, len(v), v)

    def at_end(self, v: bool) -> bool:
        return v

    def follows(self, value: int, n: int, v: bool) -> bool:
        return v

    def only_zeros_left(self, v: bool) -> bool:
        return v

    def next_code(self, v: int) -> int:
        return v

    def bytes_to_prefix(self, v: int) -> int:
        return v

    def tell(self) -> int:
        return self.sink.tell()

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        if not ok:
            raise EncodeError(fault.rule, fault.what, value=value, allowed=fault.allowed, path=self.path())
