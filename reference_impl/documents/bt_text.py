"""The VRML/BT text form of nodes: tokens, and a reader that needs no node tables.

Rules: SYS-58 (lexis, the productions `node` and `value`), CNF-22 (document 256 MiB), CNF-25 (line, column).
Not implemented: descriptors, commands, time stamps, node and field names (their reader checks them).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isfinite
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat, ResourceLimit
from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES

MAX_DEPTH: Final = 100
# Possessive: otherwise a string is held as a hundred times its length, one way back per character.
_TOKEN: Final = re.compile(
    r"""[\s,]+|\#[^\n]*|(?P<mark>[{}\[\]])|(?P<string>"(?:[^"\\]++|\\.)*+")|(?P<word>[^\s,{}\[\]"\#]+)""",
    re.DOTALL,
)
_INT: Final = re.compile(r"[+-]?[0-9]{1,18}")
# Possessive: a long number that ends in a letter is not tried once per digit.
_FLOAT: Final = re.compile(r"[+-]?([0-9]++\.?[0-9]*+|\.[0-9]++)([eE][+-]?[0-9]++)?")


@dataclass(frozen=True, slots=True)
class Token:
    """One token.

    Rules: SYS-58. `kind`: "mark" (one of {}[]), "string" (text without its quotes) or "word". `line`,
    `column`: from 1.
    """

    kind: str
    text: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class BtNode:
    """One node as written.

    Rules: SYS-58. `type` is empty for USE. `name`: of DEF or USE, or empty. `fields`: the values by field
    name, MFs without their brackets; `places` holds the token of each field name, `end` the closing brace.
    """

    type: str
    name: str
    start: Token
    end: Token
    fields: dict[str, tuple[Token | BtNode, ...]] = field(default_factory=dict)
    places: dict[str, Token] = field(default_factory=dict)


def _fault(what: str, token: Token, allowed: str) -> InputFormat:
    return InputFormat("SYS-58", what, value=token.text[:40], allowed=allowed, line=token.line, column=token.column)


def tokens(data: bytes | str, *, limit: int = MAX_JSON_BYTES) -> Iterator[Token]:
    """The tokens of a text.

    Rules: SYS-58, CNF-22. `data`: UTF-8 bytes or text, a byte order mark is dropped. Raises `ResourceLimit`
    past `limit` bytes, `InputFormat` (line, column) where it is not UTF-8 or a string is not closed.
    """
    if len(data) > limit:
        raise ResourceLimit("CNF-22", "text", value=len(data), allowed=f"at most {limit} bytes", line=1, column=1)
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data.removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        head = bytes(data[: error.start]) if isinstance(data, bytes) else b""
        raise InputFormat(
            "SYS-58", "text", value=f"byte 0x{error.object[error.start]:02X}", allowed="UTF-8",
            line=head.count(b"\n") + 1, column=len(head) - head.rfind(b"\n"),
        ) from None  # fmt: skip
    line, start, at = 1, 0, 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise InputFormat(
                "SYS-58",
                "string",
                value="not closed",
                allowed='a closing "',
                line=line,
                column=at - start + 1,
            )
        if match.lastgroup is not None:
            body = match.group()
            if match.lastgroup == "string":
                body = re.sub(r"\\(.)", r"\1", body[1:-1], flags=re.DOTALL)
            yield Token(match.lastgroup, body, line, at - start + 1)
        breaks = text.count("\n", at, match.end())
        if breaks:
            line += breaks
            start = text.rfind("\n", at, match.end()) + 1
        at = match.end()


class _Reader:
    def __init__(self, data: bytes | str, limit: int) -> None:
        self._source = tokens(data, limit=limit)
        self._last = Token("end", "", 1, 1)
        self.next = self._read()

    def _read(self) -> Token:
        token = next(self._source, None)
        if token is None:
            return Token("end", "the end of the text", self._last.line, self._last.column + len(self._last.text))
        self._last = token
        return token

    def take(self) -> Token:
        token = self.next
        self.next = self._read()
        return token

    def mark(self, text: str) -> Token:
        if self.next.kind != "mark" or self.next.text != text:
            raise _fault("text", self.next, text)
        return self.take()

    def name(self, what: str) -> Token:
        if self.next.kind != "word" or _FLOAT.fullmatch(self.next.text):
            raise _fault(what, self.next, "a name")
        return self.take()

    def node(self, depth: int) -> BtNode:
        if depth > MAX_DEPTH:
            raise ResourceLimit(
                "CNF-22", "node", value=depth, allowed=f"at most {MAX_DEPTH} levels",
                line=self.next.line, column=self.next.column,
            )  # fmt: skip
        start = self.name("node")
        if start.text == "USE":
            name = self.name("USE")
            return BtNode("", name.text, start, name)
        label = ""
        kind = start
        if start.text == "DEF":
            label = self.name("DEF").text
            kind = self.name("node")
        self.mark("{")
        fields: dict[str, tuple[Token | BtNode, ...]] = {}
        places: dict[str, Token] = {}
        while not (self.next.kind == "mark" and self.next.text == "}"):
            place = self.name("field")
            if place.text in fields:
                raise _fault("field", place, "each field once")
            places[place.text] = place
            fields[place.text] = tuple(self._value(depth))
        return BtNode(kind.text, label, start, self.mark("}"), fields, places)

    def _value(self, depth: int) -> Iterator[Token | BtNode]:
        if self.next.kind == "mark" and self.next.text == "[":
            self.take()
            while not (self.next.kind == "mark" and self.next.text == "]"):
                yield self._item(depth)
            self.take()
            return
        token = self.next
        yield self._item(depth)
        if token.kind == "word" and _FLOAT.fullmatch(token.text):
            while self.next.kind == "word" and _FLOAT.fullmatch(self.next.text):
                yield self.take()

    def _item(self, depth: int) -> Token | BtNode:
        token = self.next
        if token.kind == "string":
            return self.take()
        if token.kind != "word":
            raise _fault("value", token, "a value")
        if _FLOAT.fullmatch(token.text) or token.text.upper() in ("TRUE", "FALSE", "NULL"):
            return self.take()
        return self.node(depth + 1)


def parse_nodes(data: bytes | str, *, limit: int = MAX_JSON_BYTES) -> list[BtNode]:
    """All nodes of a text, at most 100 levels deep.

    Rules: SYS-58, CNF-22, CNF-25. Raises `InputFormat` or `ResourceLimit` with line and column.
    """
    reader = _Reader(data, limit)
    out: list[BtNode] = []
    while reader.next.kind != "end":
        out.append(reader.node(0))
    return out


def ints(values: tuple[Token | BtNode, ...], what: str) -> tuple[int, ...]:
    """The values of an SFInt32 or MFInt32. Rules: SYS-58. Raises `InputFormat` with line and column."""
    out: list[int] = []
    for value in values:
        if isinstance(value, BtNode):
            raise _fault(what, value.start, "an integer")
        if value.kind != "word" or not _INT.fullmatch(value.text):
            raise _fault(what, value, "an integer")
        out.append(int(value.text))
    return tuple(out)


def floats(values: tuple[Token | BtNode, ...], what: str) -> tuple[float, ...]:
    """The values of a field of floats, flat. Rules: SYS-58. Raises `InputFormat` with line and column."""
    out: list[float] = []
    for value in values:
        if isinstance(value, BtNode):
            raise _fault(what, value.start, "a number")
        if value.kind != "word" or not _FLOAT.fullmatch(value.text) or not isfinite(float(value.text)):
            raise _fault(what, value, "a finite number")
        out.append(float(value.text))
    return tuple(out)


def nodes(values: tuple[Token | BtNode, ...], what: str) -> tuple[BtNode, ...]:
    """The nodes of an SFNode or MFNode, NULL left out.

    Rules: SYS-58. Raises `InputFormat` with line and column.
    """
    out: list[BtNode] = []
    for value in values:
        if isinstance(value, BtNode):
            out.append(value)
        elif value.text != "NULL" or value.kind != "word":
            raise _fault(what, value, "a node")
    return tuple(out)


def unknown_field(node: BtNode, known: frozenset[str]) -> None:
    """Raise `InputFormat` at the first field that is not in `known`. Rules: SYS-59, CNF-25."""
    for name, place in node.places.items():
        if name not in known:
            raise InputFormat(
                "SYS-59",
                "field",
                value=name[:40],
                allowed=f"a field of {node.type}",
                line=place.line,
                column=place.column,
            )
