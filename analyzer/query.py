"""Expressions over the elements of a trace: `snhc dump --query EXPR`, and the policies of `snhc check`.

Rules: CNF-19, CNF-21, CNF-25.

The language is CEL, the Common Expression Language, made for rules that strangers write: no side effects, no access
to anything but the names below, regular expressions in linear time. An expression is asked once for every element,
plane and, where symbols are traced, arithmetic symbol. docs/query.md is its page.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.mesh.records import MeshPlane

from .elements import kind_of_row, meaning, settled_bits
from .parts import Part, raw_bits

if TYPE_CHECKING:
    import cel

MOST_CHARACTERS: Final = 2000
# Bits that `raw` gives at most: it is for looking at fields, not at files.
MOST_RAW: Final = 16384
_STRING: Final = re.compile(r"""r?'(?:\\.|[^'\\])*'|r?"(?:\\.|[^"\\])*\"""", re.DOTALL)
# What goes over a list: one of them is linear in the list, several inside each other are not.
_MACRO: Final = re.compile(r"\.\s*(all|exists|exists_one|existsOne|map|filter)\s*\(")
_BOUND: Final = re.compile(_MACRO.pattern.replace("(all", "(?:all") + r"\s*(\w+)\s*,")
_OPERATORS: Final = re.compile(r"[_@!-]")
_FUNCTIONS: Final = frozenset({"size", "contains", "startsWith", "endsWith", "matches", "int", "double", "string"})
_PLACE: Final = re.compile(r"<input>:1:(\d+): (.*)")

PLANE: Final = "plane"
SYMBOL: Final = "symbol"


@dataclass(frozen=True, slots=True)
class Subject:
    """What an expression is asked about: a row, a plane (row -1), or a symbol of a row.

    Rules: CNF-21. `span`: the bits that a symbol settles.
    """

    part: Part
    row: int
    source: Source
    symbol: int = -1
    span: tuple[int, int] = (0, 0)

    @property
    def bits(self) -> tuple[int, int]:
        """First bit and the one behind the last. Rules: CNF-21."""
        if self.symbol >= 0:
            return self.span
        if self.row < 0:
            assert self.part.plane is not None
            return self.part.plane.start, self.part.plane.end
        return self.part.trace.start[self.row], self.part.trace.end[self.row]


def _name(of: Subject) -> str:
    if of.row < 0:
        return "plane"
    return of.part.trace.segments[of.row][1][of.symbol] if of.symbol >= 0 else of.part.trace.el(of.row).name


def _value(of: Subject) -> int:
    plane = of.part.plane
    if of.row < 0:
        return plane.mesh_mask if isinstance(plane, MeshPlane) else plane.fba_object_mask if plane is not None else 0
    if of.symbol >= 0:
        return of.part.trace.segments[of.row][0].levels[of.symbol]
    return of.part.trace.value[of.row]


def _rule(of: Subject) -> str:
    if of.row < 0:
        return "MSH-2" if isinstance(of.part.plane, MeshPlane) else "FBA-5"
    return "FBA-23" if of.symbol >= 0 else of.part.trace.el(of.row).rule


def _kind(of: Subject) -> str:
    if of.row < 0:
        return PLANE
    return SYMBOL if of.symbol >= 0 else kind_of_row(of.part.trace, of.row)


def _path(of: Subject) -> str:
    return f"plane[{of.part.plane_number}]" if of.row < 0 else of.part.trace.path_text(of.row)


def _raw(of: Subject) -> str:
    start, end = of.bits
    return raw_bits(of.source, start, min(end, start + MOST_RAW))


def _meaning(of: Subject) -> str:
    if of.row < 0 or of.symbol >= 0:
        return ""
    return meaning(of.part.trace.el(of.row), of.part.trace.value[of.row])


def _levels(of: Subject) -> list[int]:
    segment = of.part.trace.segments.get(of.row)
    return list(segment[0].levels) if segment is not None else []


def _time(of: Subject) -> float:
    frames = of.part.plane.frames if of.part.plane is not None else []
    return frames[0].time[0] / frames[0].time[1] if frames else -1.0


@dataclass(frozen=True, slots=True)
class Field:
    """A name of the language. Rules: CNF-25. `type`: as CEL calls it; `text`: what it is."""

    type: str
    text: str
    get: Callable[[Subject], object]


FIELDS: Final[dict[str, Field]] = {
    "name": Field("string", "name of the element, `plane` for a plane, the label of a symbol", _name),
    "value": Field(
        "int",
        "its value; number of symbols of a segment, of bytes of user data; mask of a plane; level of a symbol",
        _value,
    ),
    "rule": Field("string", "its rule, `FBA-16`", _rule),
    "path": Field("string", "where it stands, `plane[0].fap.group[7]`; `` outside planes", _path),
    "kind": Field("string", "`field`, `segment`, `bytes`, `plane` or `symbol`", _kind),
    "bits": Field("int", "how many bits it has", lambda of: of.bits[1] - of.bits[0]),
    "start": Field("int", "its first bit", lambda of: of.bits[0]),
    "end": Field("int", "the bit behind its last", lambda of: of.bits[1]),
    "raw": Field("string", "its bits, `0110`; the first 16384 of longer ones", _raw),
    "meaning": Field("string", "what the value means, `FAP data`; `` for plain numbers", _meaning),
    "levels": Field("list of int", "the levels of an arithmetic segment, else empty", _levels),
    "plane": Field("int", "number of the plane in its object, -1 outside planes", lambda of: of.part.plane_number),
    "intra": Field("bool", "whether the plane is intra", lambda of: bool(of.part.plane and of.part.plane.is_intra)),
    "time": Field("double", "seconds of the plane's first frame, -1 outside planes", _time),
    "item": Field("int", "number of the item of the stream, from 0", lambda of: of.part.item_number),
    "object": Field(
        "string", "kind of the item: `fba_object`, `mesh_object`, `user_data`, ...", lambda of: of.part.kind
    ),
}


# One value of each type: what does not fit together is found before any stream is read.
_EXAMPLES: Final[dict[str, object]] = {"string": "", "int": 1, "list of int": [1], "bool": True, "double": 1.0}


class QueryError(InputFormat):
    """No expression of the language, or one that has no truth value. Rules: CNF-19, CNF-25."""

    exit_code = 2


class Query:
    """A compiled expression.

    Rules: CNF-19, CNF-25. Raises QueryError, with the column, for what is no expression of the language, for names
    that there are not, and for types that do not fit together.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > MOST_CHARACTERS:
            raise _fault(text[:40] + "...", MOST_CHARACTERS + 1, f"at most {MOST_CHARACTERS} characters")
        self._program = _compiled(text)
        code = _STRING.sub(lambda match: " " * len(match[0]), text)
        macros = list(_MACRO.finditer(code))
        if len(macros) > 1:
            raise _fault(text, macros[1].start() + 1, "at most one of all, exists, exists_one, map and filter")
        bound = set(_BOUND.findall(code))
        self._fields: list[tuple[str, Callable[[Subject], object]]] = []
        for name in self._program.variables():
            if name in FIELDS:
                self._fields.append((name, FIELDS[name].get))
            elif name not in bound:
                raise _unknown(text, code, name, "name", FIELDS)
        for name in self._program.functions():
            if not _OPERATORS.search(name) and name not in _FUNCTIONS:
                raise _unknown(text, code, name, "function", _FUNCTIONS)
        # Values are made up, so a division by one of them says nothing yet.
        with suppress(ZeroDivisionError):
            self._ask({name: _EXAMPLES[FIELDS[name].type] for name, _ in self._fields})

    def __call__(self, subject: Subject) -> bool:
        """Whether the expression holds. Rules: CNF-25. Raises QueryError where it has no truth value."""
        try:
            return self._ask({name: get(subject) for name, get in self._fields})
        except ZeroDivisionError:
            raise _fault(self.text, 1, f"no division by zero, as at bits {list(subject.bits)}") from None

    def _ask(self, values: dict[str, object]) -> bool:
        try:
            result = self._program.execute(values)
        except ZeroDivisionError:
            raise
        except (TypeError, ValueError, RuntimeError, ArithmeticError) as error:
            raise _fault(self.text, 1, f"an expression that can be computed: {_first_sentence(error)}") from None
        if not isinstance(result, bool):
            raise _fault(self.text, 1, f"true or false, not {type(result).__name__}")
        return result

    def takes_row(self, part: Part, row: int, source: Source) -> bool:
        """Whether it holds of a row. Rules: CNF-21."""
        return self(Subject(part, row, source))

    def takes_plane(self, part: Part, source: Source) -> bool:
        """Whether the part is a plane and it holds of it. Rules: CNF-21."""
        return part.plane is not None and self(Subject(part, -1, source))


def subjects(part: Part, source: Source, symbols: bool = False) -> Iterator[Subject]:
    """What of a part an expression is asked about, in stream order: its plane, then its rows, each with its symbols.

    Rules: CNF-21. `symbols`: the trace has them, and they are asked about.
    """
    if part.plane is not None:
        yield Subject(part, -1, source)
    for row in range(len(part.trace)):
        yield Subject(part, row, source)
        segment = part.trace.segments.get(row)
        if symbols and segment is not None:
            for number, span in enumerate(settled_bits(segment[0])):
                yield Subject(part, row, source, number, span)


def _compiled(text: str) -> cel.Program:
    import cel

    try:
        return cel.compile(text)
    except ValueError as error:
        place = _PLACE.search(str(error))
        column = int(place[1]) if place is not None else 1
        said = place[2].removeprefix("Syntax error: ") if place is not None else "no expression"
        if "Recursion" in said:
            said = "nested too deeply"
        raise _fault(text, column, f"an expression ({said[:120]})") from None


def _unknown(text: str, code: str, name: str, what: str, known: Iterable[str]) -> QueryError:
    names = sorted(known)
    near = difflib.get_close_matches(name, names, 1)
    at = re.search(rf"\b{re.escape(name)}\b", code)
    allowed = f"a {what} of the language ({', '.join(names)})" if not near else f"a {what}; did you mean {near[0]}?"
    return _fault(name, at.start() + 1 if at is not None else 1, allowed)


def _first_sentence(error: Exception) -> str:
    return str(error).partition(". ")[0].strip().rstrip(".")


def _fault(value: str, column: int, allowed: str) -> QueryError:
    return QueryError("CNF-25", "query", value=value, allowed=allowed, line=1, column=column)
