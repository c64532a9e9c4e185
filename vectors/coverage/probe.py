"""The coverage probe: one more machine over the one syntax. It reads, and writes down which cells it met.

Rules: CNF-8, CNF-21, FBA-21..27. Segments are decoded by the literal coder, whose steps show the states of the models.

What is met is kept as short tuples, in which the first word is the kind of cell; `cells` turns them into names.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.cursor import BitCursor, OutOfBits
from snhc.reference_impl.bitstream.errors import ReservedValue, SnhcError, Truncated
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.entropy.literal import SegmentTrace, SymbolStep, decode_literally
from snhc.reference_impl.entropy.model import FENWICK_FROM, Model
from snhc.reference_impl.entropy.prefix import PrefixTable
from snhc.reference_impl.face.dct_syntax import AT_FAP_NUMBER
from snhc.reference_impl.face.syntax import AT_GROUP, IS_INTRA
from snhc.reference_impl.mesh.records import DELAUNAY, MeshPlane
from snhc.reference_impl.syntax import base
from snhc.reference_impl.syntax.element import Element, Fault, Step
from snhc.reference_impl.syntax.reader import Reader
from snhc.reference_impl.systems.stream import Options, is_object
from snhc.reference_impl.systems.visual import AnyPlane, fresh_items, visual_stream

from .values import classes_of, refused

Met = tuple[str | int, ...]

BOUNDARIES: Final = {
    getattr(base, name): name.lower().replace("_", " ")
    for name in ("PLANE", "STUFFED_CODE", "BARE_CODE", "STUFFED_END", "END", "ZERO_PADDING")
}
"""What can stand at a plane boundary, by the numbers of `syntax.base`."""


class Probe(Reader):
    """A reader that notes the cells it meets.

    Rules: CNF-8. `met`: all of them; `elements`, `tables`: those met, by key and name; `error`: what ended the stream.
    """

    def __init__(self, cursor: BitCursor, options: Options) -> None:
        super().__init__(
            cursor, limits=options.limits, readings=options.readings, draft=options.draft, strict=options.strict,
            profile=options.profile, on_finding=lambda finding: None,
        )  # fmt: skip
        self.met: set[Met] = set()
        self.elements: dict[str, Element] = {}
        self.tables: dict[str, PrefixTable] = {}
        self.error: SnhcError | None = None
        self._intra = 1

    # -- elements --------------------------------------------------------------------------------------------------

    def _note(self, el: Element, n: int, signed: bool, value: int) -> None:
        key = key_of(el)
        self.elements[key] = el
        if el.fixed:
            self.met.add(("fixed", key, n))
            return
        for name in classes_of(el, n, signed, value):
            self.met.add(("value", key, n, signed, name))
        if self._steps and self._steps[-1] == AT_GROUP.index and n > 1:
            group = self._indices[-1]
            name = _mask_class(n, value) if el.name.endswith("group_mask") else _type_class(el, value)
            self.met.add(("group", key, group, name))

    def u(self, el: Element, n: int, v: int) -> int:
        value = super().u(el, n, v)
        if el.name == IS_INTRA.name:
            self._intra = value
        self._note(el, n, False, value)
        return value

    def s(self, el: Element, n: int, v: int) -> int:
        # Not through `u`, which would note the bits and not the number.
        raw = super().u(el, n, v)
        value = raw - (1 << n) if raw >> (n - 1) else raw
        self._note(el, n, True, value)
        return value

    def vlc(self, el: Element, table: PrefixTable, v: int) -> int:
        self.tables[table.name] = table
        self.elements[key_of(el)] = el
        symbol = super().vlc(el, table, v)
        self.met.add(("word", table.name, symbol))
        self.met.add(("used", key_of(el), table.name, symbol))
        return symbol

    def raw(self, el: Element, count: int, v: bytes) -> bytes:
        data = super().raw(el, count, v)
        self.elements[key_of(el)] = el
        self.met.add(("bytes", key_of(el), "empty" if not data else "some"))
        return data

    def rest(self, el: Element, v: bytes) -> bytes:
        self.elements[key_of(el)] = el
        self.met.add(("read", key_of(el)))
        return super().rest(el, v)

    def zeros(self, el: Element, count: int) -> int:
        self.elements[key_of(el)] = el
        self.met.add(("read", key_of(el)))
        return super().zeros(el, count)

    def enter(self, step: Step, i: int) -> None:
        super().enter(step, i)
        if step.index == AT_FAP_NUMBER.index and i > 0:
            self.met.add(("dct", i, self._intra))

    def boundary(self, v: int, after_object_code: bool) -> int:
        kind = super().boundary(v, after_object_code)
        self.met.add(("boundary", kind, after_object_code))
        return kind

    # -- segments --------------------------------------------------------------------------------------------------

    def segment(self, el: Element, models: list[Model], labels: list[str], v: list[int], tail: int) -> list[int]:
        start = self.cursor.tell()
        self.elements[key_of(el)] = el
        # Before decoding: a model that was never updated has no frequencies, or only ones.
        fresh = [model.total == model.n for model in models]
        bounds = [(model.lo, model.lo + model.n - 1) for model in models]
        try:
            segment = decode_literally(self.cursor, models)
        except OutOfBits:
            raise self._truncated(el, start, "FBA-27") from None
        self._note_segment(el, segment, models)
        for position, value in segment.guards:
            if not value:
                raise self._bad_guard(position)
        for step, label, first, (lo, hi) in zip(segment.steps, labels, fresh, bounds, strict=True):
            self._note_symbol(el, step, first)
            for name in _level_classes(step.level, lo, hi):
                self.met.add(("level", label, self._intra, name))
        self.tail = segment.tail
        return [step.level for step in segment.steps]

    def _note_segment(self, el: Element, segment: SegmentTrace, models: list[Model]) -> None:
        key = key_of(el)
        kinds = ["empty" if not models else "one symbol" if len(models) == 1 else "several symbols"]
        kinds.append("ends as an encoder ends it" if segment.tail == 0 else "ends otherwise")
        if segment.past_end:
            kinds.append("look-ahead past the end of the data")
        kinds += ["guard" if value else "guard 0" for _, value in segment.guards]
        if len(segment.guards) > 1:
            kinds.append("several guards")
        kinds += [f"guard in the look-ahead, {value}" for _, value in segment.ahead]
        for kind in kinds:
            self.met.add(("segment", key, self._intra, kind))

    def _note_symbol(self, el: Element, step: SymbolStep, first: bool) -> None:
        kinds: list[str] = []
        if step.symbols == 1:
            kinds.append("single-symbol model")
        elif not step.adaptive:
            kinds.append("uniform")
        else:
            kinds.append("first symbol" if first else "adapted")
            if step.rescaled:
                kinds.append("rescale")
            if step.symbols >= FENWICK_FROM:
                kinds.append(f"{FENWICK_FROM} symbols or more")
        if step.shifts == 0:
            kinds.append("no bits fetched")
        for kind in kinds:
            self.met.add(("model", key_of(el), self._intra, kind))

    # -- faults ----------------------------------------------------------------------------------------------------

    def require(self, ok: bool, fault: Fault, value: int | str | None, start: int, end: int) -> None:
        if not ok:
            self.met.add(("fault", *fault_key(fault)))
        super().require(ok, fault, value, start, end)

    def _outside(self, el: Element, value: int, n: int) -> None:
        self._note(el, n, False, value)
        self.met.add(("outside", key_of(el)))
        super()._outside(el, value, n)

    def _truncated(self, el: Element, start: int, rule: str = "") -> Truncated:
        self.elements[key_of(el)] = el
        self.met.add(("cut", key_of(el)))
        return super()._truncated(el, start, rule)

    def _no_word(self, el: Element, table: PrefixTable) -> Truncated | ReservedValue:
        error = super()._no_word(el, table)
        if isinstance(error, ReservedValue):
            self.met.add(("noword", key_of(el), table.name))
        return error


def _level_classes(level: int, lo: int, hi: int) -> list[str]:
    out = ["coded"]
    if lo < hi and level == lo:
        out.append("lowest")
    if lo < hi and level == hi:
        out.append("highest")
    return out


def _mask_class(n: int, value: int) -> str:
    if value == 0:
        return "none"
    if value == (1 << n) - 1:
        return "all"
    return {1: "last only", 1 << (n - 1): "first only"}.get(value, "some")


def _type_class(el: Element, value: int) -> str:
    return str(value) if el.allows(value) else refused(value)


def key_of(el: Element) -> str:
    """An element by rule and name: one of several declarations of it is as good as another. Rules: CNF-8."""
    return f"{el.rule}/{el.name}"


def fault_key(fault: Fault) -> tuple[str, str, str]:
    """A declared fault by class, rule and what it is about. Rules: CNF-7."""
    declared = fault.declared
    return declared.error.__name__, declared.rule, declared.what


def probe(data: bytes, options: Options) -> Probe:
    """Read a stream up to its first fault or the end of the object to decode, and hand back the probe.

    Rules: CNF-8, FBA-44. Objects before it are read too, as a decoder must; those behind it are not.
    """
    io = Probe(BitCursor(BytesSource(data)), options)
    number = -1
    try:
        for item, plane in visual_stream(io, fresh_items()):
            if plane is not None:
                io.met |= _plane(plane)
                if item.mesh is not None:
                    io.met.add(("stuffing", item.mesh.stuffing))
            elif is_object(item) and not item.end:
                number += 1
                if number > options.object_number:
                    break
    except SnhcError as error:
        io.error = error
    return io


def _plane(plane: AnyPlane) -> set[Met]:
    kind = "intra" if plane.is_intra else "inter"
    if isinstance(plane, MeshPlane):
        out: set[Met] = {("plane", "mesh", kind, "data" if plane.mesh_mask else "no data")}
        if plane.geometry is not None:
            out.add(("plane", "mesh", kind, "Delaunay" if plane.geometry.type == DELAUNAY else "uniform"))
        return out
    code = "with a start code" if plane.start_code else "without a start code"
    mask = {0: "no data", 1: "FAP", 2: "BAP", 3: "FAP and BAP"}[plane.fba_object_mask]
    out = {("plane", "FBA", kind, f"{mask}, {code}")}
    if plane.faps is not None:
        mode = "DCT" if plane.faps.segment is not None else "arithmetic"
        out.add(("plane", "FBA", kind, mode))
    return out
