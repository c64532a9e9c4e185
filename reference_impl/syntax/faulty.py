"""The faulty writer: makes negative vectors by named mutations of valid streams.

Rules: CNF-6, FBA-25, FBA-26.

A mutation changes one element at one place. Mode *wire*: other bits go out while control flow follows the true value.
Mode *value*: control flow follows the changed value too. Segments can get bad guards or another tail; the whole
stream can be cut inside an element. The span that each mutation touched is recorded: it is the expected location.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mypy_extensions import mypyc_attr

from ..bitstream.limits import DEFAULT_LIMITS, Limits
from ..bitstream.sink import BitSink
from ..entropy.kernel import GUARD_AFTER, segment_code, write_guarded
from ..entropy.model import Model
from ..entropy.prefix import PrefixTable
from ..entropy.profile import EntropyProfile
from .element import DEFAULT_READINGS, Element, Fault, Readings
from .writer import Writer


@dataclass(slots=True)
class Mutation:
    """One change at one place.

    Rules: CNF-6.

    `element`: the element's name; `path`: a prefix of the path it must stand under (`plane[2]`), "" for any;
    `occurrence`: which of the matching ones, from 0. `mode`: `wire` or `value` (the new number is `to`), `guard` (the
    guards of this segment become 0), `tail` (the last two bits of this segment are inverted), `cut` (the data ends
    `to` bits after the element's first bit), `flip` (bit `to` of the element is inverted, wire only), `word` (a code
    word is replaced by the `width` bits `to`).
    `spans`: filled in by the writer: the half-open spans of what was changed.
    """

    element: str
    mode: str
    to: int = 0
    path: str = ""
    occurrence: int = 0
    width: int = 0
    spans: list[tuple[int, int]] = field(default_factory=list)
    seen: int = 0


class _Cut(Exception):
    """The stream ends here."""


@mypyc_attr(allow_interpreted_subclasses=True)
class FaultyWriter(Writer):
    """A writer that passes what it should refuse, and breaks what it is told to break. Rules: CNF-6."""

    def __init__(
        self,
        mutations: list[Mutation],
        sink: BitSink | None = None,
        *,
        limits: Limits = DEFAULT_LIMITS,
        readings: Readings = DEFAULT_READINGS,
        profile: EntropyProfile | None = None,
    ) -> None:
        super().__init__(sink, limits=limits, readings=readings, profile=profile)
        self.mutations = mutations

    def _hit(self, el: Element) -> Mutation | None:
        for mutation in self.mutations:
            if mutation.element != el.name or not self.path().startswith(mutation.path):
                continue
            mutation.seen += 1
            if mutation.seen - 1 == mutation.occurrence:
                return mutation
        return None

    def u(self, el: Element, n: int, v: int) -> int:
        mutation = self._hit(el)
        start = self.sink.tell()
        wire = v
        if mutation is not None:
            if mutation.mode in ("wire", "value"):
                wire = mutation.to
            elif mutation.mode == "flip":
                wire = v ^ (1 << (n - 1 - mutation.to))
            mutation.spans.append((start, start + n))
        self.sink.write(wire, n)
        if mutation is not None and mutation.mode == "cut":
            self._cut(start, mutation)
        return wire & ((1 << n) - 1) if mutation is not None and mutation.mode == "value" else v

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        mutation = self._hit(el)
        start = self.sink.tell()
        symbol = mutation.to if mutation is not None and mutation.mode in ("wire", "value") else v
        code, length = table.encode(symbol)
        if mutation is not None and mutation.mode == "flip":
            code ^= 1 << (length - 1 - mutation.to)
        self.sink.write(code, length)
        if mutation is not None:
            mutation.spans.append((start, start + length))
            if mutation.mode == "word":
                # Other bits, which need not be a word: `to` as `width` bits.
                self.sink.cut(start)
                self.sink.write(mutation.to, mutation.width)
                mutation.spans[-1] = (start, start + mutation.width)
            if mutation.mode == "cut":
                self._cut(start, mutation)
        return symbol if mutation is not None and mutation.mode == "value" else v

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        mutation = self._hit(el)
        start = self.sink.tell()
        # Levels outside their model cannot be coded at all, whatever is to be broken.
        self._check_levels(el, models, labels, v)
        code, count = segment_code(models, v, tail)
        self.tail = tail
        if mutation is not None and mutation.mode == "tail":
            code ^= 3
        if mutation is not None and mutation.mode == "guard":
            write_guarded(self.sink, code, count, guard=0)
            mutation.spans += [(bit, bit + 1) for bit in _guard_bits(start, code, count)]
        else:
            write_guarded(self.sink, code, count)
            if mutation is not None:
                mutation.spans.append((start, self.sink.tell()))
        if mutation is not None and mutation.mode == "cut":
            self._cut(start, mutation)
        return v

    def _cut(self, start: int, mutation: Mutation) -> None:
        mutation.spans[-1] = (start, start + mutation.to)
        self.sink.cut(start + mutation.to)
        raise _Cut

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        return


def was_cut(error: Exception) -> bool:
    """Whether an exception is the faulty writer's own end of the stream. Rules: CNF-6."""
    return isinstance(error, _Cut)


def _guard_bits(start: int, code: int, count: int) -> list[int]:
    zeros = "0" * GUARD_AFTER
    bits = format(code, f"0{count}b")
    out: list[int] = []
    position = 0
    while (run := bits.find(zeros, position)) >= 0 and run + GUARD_AFTER < count:
        position = run + GUARD_AFTER
        out.append(start + position + len(out))
    return out
