"""The base of all machines that run the syntax functions.

Rules: CNF-7, CNF-21, FBA-3.

A syntax function calls these methods with the value that the record holds and stores what it gets back. The reader
ignores the value and returns what the bits say; the writers write it and return it.
"""

from __future__ import annotations

from mypy_extensions import mypyc_attr

from ..bitstream.findings import Finding
from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..entropy.blocks import BlockCode
from ..entropy.model import Model
from ..entropy.prefix import PrefixTable
from ..entropy.profile import EntropyProfile, load_profile
from .element import DEFAULT_READINGS, STEPS, Element, Fault, Readings, Step

# What stands at a plane boundary (FBA-3, 42, 44).
PLANE = 0  # a plane begins at once
STUFFED_CODE = 1  # stuffing, then a start code
BARE_CODE = 2  # a start code without stuffing, directly behind another
STUFFED_END = 3  # stuffing, then the end of the data
END = 4  # the end of the data
ZERO_PADDING = 5  # zero bits up to the end of the data


@mypyc_attr(allow_interpreted_subclasses=True)
class SyntaxIO:
    """One syntax, many machines. Rules: CNF-7, CNF-21."""

    def __init__(
        self,
        *,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        profile: EntropyProfile | None = None,
    ) -> None:
        self._profile = profile
        self.limits = limits
        self.readings = readings
        self.findings: list[Finding] = []
        self._steps: list[int] = []
        self._indices: list[int] = []
        # Whether values come from bits (reader, tracer) or from records (writers).
        self.reading = False
        # Whether this machine reads blocks of coefficients at once where it can.
        self.by_blocks = False
        self.tail = 0
        self.draft = False
        self.strict = False
        # The tools that the signalled profile does not contain and that have not been met yet.
        self.outside: frozenset[str] = frozenset()

    @property
    def profile(self) -> EntropyProfile:
        """The entropy profile of DCT segments; the shipped one where none was given. Rules: DCT-1."""
        if self._profile is None:
            self._profile = load_profile()
        return self._profile

    # -- elements ------------------------------------------------------------------------------------------------

    def u(self, el: Element, n: int, v: int) -> int:
        """An unsigned number of n bits (1..32). Rules: CNF-21."""
        raise NotImplementedError

    def s(self, el: Element, n: int, v: int) -> int:
        """A two's complement number of n bits (1..32). Rules: CNF-21."""
        w = self.u(el, n, v & ((1 << n) - 1))
        return w - (1 << n) if w >> (n - 1) else w

    def marker(self, el: Element) -> None:
        """A bit that must be 1. Rules: CNF-7."""
        self.u(el, 1, 1)

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        """A symbol of a prefix code. Rules: DCT-1, MSH-5, CNF-26."""
        raise NotImplementedError

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        """A whole arithmetic segment: a level per model. Rules: FBA-26, FBA-28. `labels`: what each symbol is.

        `tail`: how the last two data bits differ from an encoder's; what was read or written is then in `self.tail`.
        """
        raise NotImplementedError

    def blocks(self, code: BlockCode, blocks: list[int], first: int) -> int:
        """Read blocks of DCT coefficients from block `first` on, as far as they are ordinary ones.

        Rules: DCT-2, DCT-3, DCT-4. Returns the number of the first one that is left to be read word by word. Only for
        machines with `by_blocks`.
        """
        return first

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        """`count` whole bytes from an aligned position. Rules: SYS-5."""
        raise NotImplementedError

    def rest(self, el: Element, v: bytes) -> bytes:
        """All bytes up to the end of the data; a streaming reader passes over them and returns none. Rules: FBA-3."""
        raise NotImplementedError

    def zeros(self, el: Element, count: int) -> int:
        """Zero bits up to the end of the data; the reader counts them. Rules: FBA-42."""
        raise NotImplementedError

    # -- what the writer is told and the reader finds out ---------------------------------------------------------

    def boundary(self, v: int, after_object_code: bool) -> int:
        """What stands at a plane boundary, one of PLANE .. ZERO_PADDING. Rules: FBA-3, FBA-42, FBA-44."""
        raise NotImplementedError

    def at_end(self, v: bool) -> bool:
        """Whether the data ends here. Rules: FBA-1."""
        raise NotImplementedError

    def next_code(self, v: int) -> int:
        """The coming 32 bits without taking them, where they are a start code; else -1. Rules: FBA-1, FBA-3."""
        raise NotImplementedError

    def follows(self, value: int, n: int, v: bool) -> bool:
        """Whether the coming n bits (1..32) are `value`, without taking them. Rules: MSH-2."""
        raise NotImplementedError

    def only_zeros_left(self, v: bool) -> bool:
        """Whether every remaining bit is 0. Rules: FBA-42, MSH-25."""
        raise NotImplementedError

    def bits_left(self, most: int) -> int:
        """How many bits are left, at most `most` (up to 256). Rules: CNF-21. Readers only."""
        raise NotImplementedError

    def head(self, count: int) -> bytes:
        """The coming bytes, fewer where the data ends, without taking them. Rules: CNF-21. Readers only."""
        raise NotImplementedError

    def bytes_to_prefix(self, v: int) -> int:
        """Whole bytes up to the next start code prefix or the end of the data. Rules: SYS-5."""
        raise NotImplementedError

    def tell(self) -> int:
        """The current bit position. Rules: CNF-21."""
        raise NotImplementedError

    def protect(self, start: int) -> bool:
        """Whether the plane at bit `start` now has a start code before it, because its own bits would read as one.

        Rules: FBA-41. Only writers do this.
        """
        return False

    # -- relations -----------------------------------------------------------------------------------------------

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        """A relation must hold over bits [start, end). Rules: CNF-7, CNF-21.

        The reader raises, the writer refuses, the faulty writer passes.
        """
        raise NotImplementedError

    def finding(self, id: str, message: str, start: int, end: int) -> None:
        """Something accepted but wrong or odd. Rules: CNF-23. Only readers report."""

    def tool(self, name: str) -> None:
        """Data of a tool (`face`, `body`, `mesh`) begins here; outside the signalled profile that is a finding, once.

        Rules: SYS-9.
        """
        if name in self.outside:
            self.outside -= {name}
            start = self.tell()
            self.finding("profile-tool", f"{name} data, which the signalled profile does not contain", start, start + 1)

    # -- the path ------------------------------------------------------------------------------------------------

    def enter(self, step: Step, i: int) -> None:
        """Go down one level of the path; i < 0: no index. Rules: CNF-21."""
        self._steps.append(step.index)
        self._indices.append(i)

    def leave(self) -> None:
        """Go up one level. Rules: CNF-21."""
        self._steps.pop()
        self._indices.pop()

    def path(self, leaf: str = "") -> str:
        """The path in words: `plane[0].fap.group[7]`. Rules: CNF-21."""
        parts = [
            STEPS[step].name + (f"[{i}]" if i >= 0 else "") for step, i in zip(self._steps, self._indices, strict=True)
        ]
        if leaf:
            parts.append(leaf)
        return ".".join(parts)
