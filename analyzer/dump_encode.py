"""From a dump in JSON back to the stream: unchanged to the same bytes, edited to what it says.

Rules: CNF-22, CNF-25. The document is the one of `dump_json`; what is read of it: `compat`, `readings`, and of each
element its name and `value`, `levels` with `tail`, `bytes`, or for padding `bits`. Everything else (spans, raw bits,
meanings, symbols) follows from these.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.documents.json_text import as_array, as_int, as_object, as_text, parse_json
from snhc.reference_impl.entropy.profile import EntropyProfile
from snhc.reference_impl.rules import ambiguities
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.replay import Replayer, ValuesEnd, Written
from snhc.reference_impl.systems.visual import fresh_items, visual_stream

_RULE: Final = "CNF-25"
_FORMAT: Final = re.compile(rb'"format"\s*:\s*"snhc-dump"')
_BITS: Final = re.compile(r"[01]{0,7}")
# Values are of 32 bits at most, but a document may hold any number.
_LARGEST: Final = (1 << 32) - 1


def is_dump(data: bytes) -> bool:
    """Whether a JSON text is a dump. Rules: CNF-25."""
    return _FORMAT.search(data) is not None


def encode_dump(data: bytes, *, limits: Limits = DEFAULT_LIMITS, profile: EntropyProfile | None = None) -> bytes:
    """The stream that a dump describes.

    Rules: CNF-25. `profile`: entropy tables of DCT segments, None: the shipped ones. A dump that a fault ended gives
    the bits up to the fault and what it left unread. Raises InputFormat (with the path in the document) for what is
    no dump of a whole stream, EncodeError where the syntax cannot hold what it says.
    """
    root = as_object(parse_json(data, rule=_RULE, what="dump", limit=limits.json_bytes), "", _RULE)
    if root.get("format") != "snhc-dump" or root.get("version") != 1:
        raise InputFormat(_RULE, "dump", value=str(root.get("version")), allowed="snhc-dump version 1", path="version")
    for key in ("planes", "query"):
        if root.get(key) is not None:
            raise InputFormat(_RULE, key, value="a part of a stream", allowed="a dump of a whole stream", path=key)
    gap = root.get("unclaimed")
    replayer = Replayer(
        _written(as_array(root.get("parts"), "parts", _RULE)),
        open_end=root.get("error") is not None,
        draft=root.get("compat") == "draft",
        limits=limits,
        readings=_readings(as_object(root.get("readings", {}), "readings", _RULE)),
        profile=profile,
    )
    try:
        for _ in visual_stream(replayer, fresh_items()):
            pass
    except ValuesEnd:
        if gap is not None:
            _append(replayer, as_object(gap, "unclaimed", _RULE))
    return replayer.sink.getvalue()


def _readings(given: Mapping[str, object]) -> Readings:
    for id, key in given.items():
        entry = ambiguities().get(id)
        if entry is None or key not in entry.readings:
            allowed = "an ambiguity of the register" if entry is None else ", ".join(entry.readings)
            raise InputFormat(_RULE, id, value=str(key)[:40], allowed=allowed, path=f"readings.{id}")
    return Readings({id: str(key) for id, key in given.items()})


def _written(parts: Sequence[object]) -> Iterator[Written]:
    for p, part in enumerate(parts):
        path = f"parts[{p}]"
        elements = as_array(as_object(part, path, _RULE).get("elements"), f"{path}.elements", _RULE)
        for e, element in enumerate(elements):
            where = f"{path}.elements[{e}]"
            yield _element(as_object(element, where, _RULE), where)


def _element(fields: Mapping[str, object], where: str) -> Written:
    name = as_text(fields.get("element"), f"{where}.element", _RULE)
    span = as_array(fields.get("bits"), f"{where}.bits", _RULE)
    if len(span) != 2:
        raise InputFormat(_RULE, "bits", value=f"{len(span)} numbers", allowed="two numbers", path=f"{where}.bits")
    start, end = (as_int(bit, f"{where}.bits[{i}]", _RULE, 0) for i, bit in enumerate(span))
    width = max(end - start, 0)
    if "levels" in fields:
        levels = as_array(fields["levels"], f"{where}.levels", _RULE)
        numbers = tuple(
            as_int(level, f"{where}.levels[{i}]", _RULE, -_LARGEST, _LARGEST) for i, level in enumerate(levels)
        )
        tail = as_int(fields.get("tail", 0), f"{where}.tail", _RULE, -3, 3)
        return Written(name, width, where, levels=numbers, tail=tail)
    if "bytes" in fields:
        return Written(name, width, where, data=_hex(fields["bytes"], f"{where}.bytes"))
    return Written(name, width, where, as_int(fields.get("value"), f"{where}.value", _RULE, -_LARGEST, _LARGEST))


def _hex(value: object, path: str) -> bytes:
    text = as_text(value, path, _RULE)
    try:
        return bytes.fromhex(text)
    except ValueError:
        raise InputFormat(_RULE, "bytes", value=text[:40], allowed="pairs of hexadecimal digits", path=path) from None


def _append(replayer: Replayer, gap: Mapping[str, object]) -> None:
    raw = as_text(gap.get("raw"), "unclaimed.raw", _RULE)
    data = _hex(gap.get("bytes"), "unclaimed.bytes")
    if _BITS.fullmatch(raw) is None:
        raise InputFormat(_RULE, "raw", value=raw[:40], allowed="up to 7 bits", path="unclaimed.raw")
    if raw:
        replayer.sink.write(int(raw, 2), len(raw))
    for byte in data:
        replayer.sink.write(byte, 8)
