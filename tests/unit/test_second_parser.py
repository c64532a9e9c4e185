"""A second parser of all headers, declared with `construct` from the tables of the specification.

It knows nothing of the codec but the bit at which a plane or an item begins, and agrees with the tracer on every
element: name, span, value (FBA-5..13, FBA-16, FBA-40, SYS-2, SYS-3, SYS-5).
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from typing import Any

import pytest
from construct import BitsInteger, Computed, Construct, If, RawCopy, RepeatUntil, Sequence, Struct
from fba_helpers import case_files, case_names
from hypothesis import given
from strategies import BAP_GROUPS, FAP_GROUPS, Stream, streams

from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, trace_stream

Row = tuple[str, int, int, int]
LISTS = ("i_max", "i_min", "p_max", "p_min")


def el(name: str, width: int) -> Construct:
    """One element; the stream has one byte per bit, so offsets are bits."""
    return Struct("name" / Computed(name), "raw" / RawCopy(BitsInteger(width)))


def _value(context: Any, field: str) -> int:
    return int(context[field].raw.value)


TEMPORAL_HEADER = Struct(
    "is_frame_rate" / If(lambda c: c._params.is_intra, el("is_frame_rate", 1)),
    "rate" / If(
        lambda c: c.is_frame_rate and _value(c, "is_frame_rate"),
        Sequence(el("frame_rate", 8), el("seconds", 4), el("frequency_offset", 1)),
    ),
    "is_time_code" / If(lambda c: c._params.is_intra, el("is_time_code", 1)),
    "time_code" / If(
        lambda c: c.is_time_code and _value(c, "is_time_code"),
        Sequence(
            el("time_code_hours", 5), el("time_code_minutes", 6), el("marker_bit", 1), el("time_code_seconds", 6)
        ),
    ),
    "skip_frames" / el("skip_frames", 1),
    "skipped" / If(
        lambda c: _value(c, "skip_frames"),
        RepeatUntil(lambda last, _list, _c: last.raw.value != 15, el("number_of_frames_to_skip", 4)),
    ),
)  # fmt: skip
PLANE_START = Struct("is_intra" / el("is_intra", 1), "fba_object_mask" / el("fba_object_mask", 2))


def _group(kind: str, size: int) -> Construct:
    return Struct(
        "marker" / el("marker_bit", 1),
        "type" / el(f"{kind}_mask_type", 2),
        "mask" / If(lambda c: _value(c, "type") in (1, 2), el(f"{kind}_group_mask", size)),
    )


def _masks(kind: str, groups: list[list[int]]) -> Construct:
    names = ("fba_suggested_gender", "fba_object_coding_type")
    if kind == "bap":
        names = ("bap_suggested_gender", "bap_object_coding_type")
    return Struct(
        "quant" / el(f"{kind}_quant", 5),
        "groups" / Sequence(*[_group(kind, len(group)) for group in groups]),
        "gender" / el(names[0], 1),
        "coding_type" / el(names[1], 1),
        "flags" / Sequence(*[el(f"is_{name[0]}_new_{name[2:]}", 1) for name in LISTS]),
    )


FAP_MASKS = _masks("fap", FAP_GROUPS)
BAP_MASKS = _masks("bap", BAP_GROUPS)
SEQUENCE = Sequence(el("visual_object_sequence_start_code", 32), el("profile_and_level_indication", 8))
USER_DATA = Sequence(el("user_data_start_code", 32))
VISUAL_OBJECT = Struct(
    "code" / el("visual_object_start_code", 32),
    "identifier" / el("is_visual_object_identifier", 1),
    "id" / If(
        lambda c: _value(c, "identifier"), Sequence(el("visual_object_verid", 4), el("visual_object_priority", 3))
    ),
    "type" / el("visual_object_type", 4),
)  # fmt: skip


class Bits:
    """A stream as one byte per bit, parsed from any bit on."""

    def __init__(self, data: bytes) -> None:
        self.bits = bytes(int(bit) for byte in data for bit in f"{byte:08b}")

    def parse(self, part: Construct, at: int, **params: object) -> tuple[Any, int]:
        stream = BytesIO(self.bits)
        stream.seek(at)
        return part.parse_stream(stream, **params), stream.tell()


def rows(parsed: Any) -> Iterator[Row]:
    """The elements in a parsed structure, in order."""
    if isinstance(parsed, dict) and "raw" in parsed:
        raw = parsed["raw"]
        yield parsed["name"], raw.offset1, raw.offset2, raw.value
    elif isinstance(parsed, dict):
        for name, value in parsed.items():
            if not name.startswith("_"):
                yield from rows(value)
    elif isinstance(parsed, list):
        for value in parsed:
            yield from rows(value)


def parameter_header(bits: Bits, kind: str, at: int) -> tuple[list[Row], int]:
    """`fap` or `bap` data of an intra plane up to its first segment."""
    groups = FAP_GROUPS if kind == "fap" else BAP_GROUPS
    parsed, at = bits.parse(FAP_MASKS if kind == "fap" else BAP_MASKS, at)
    out = list(rows(parsed))
    if _value(parsed, "coding_type"):
        return out[:-4], out[-4][1]
    selected: set[int] = set()
    for group, entry in zip(groups, parsed.groups, strict=True):
        chosen = f"{_value(entry, 'mask'):0{len(group)}b}" if entry.mask else str(_value(entry, "type") // 3) * 99
        selected |= {number for number, bit in zip(group, chosen, strict=False) if bit == "1"}
    for name, flag in zip(LISTS, parsed.flags, strict=True):
        if not flag.raw.value:
            continue
        fields = []
        for group in groups[1:] if kind == "fap" else groups:
            for place, number in enumerate(group):
                if place % 4 == 0:
                    fields.append(el("marker_bit", 1))
                if number in selected:
                    fields.append(el(f"{kind}_new_{name}", 5))
        parsed_list, at = bits.parse(Sequence(*fields), at)
        out += rows(parsed_list)
        if kind == "fap":
            assert sum(field_row[0] == "marker_bit" for field_row in rows(parsed_list)) == 18
    return out, at


def check(data: bytes, options: Options = DEFAULT_OPTIONS) -> int:
    """Compare every header of a stream; returns how many planes there were."""
    bits = Bits(data)
    planes = 0
    for part in trace_stream(data, options):
        traced = [(el.name, start, end, value, path) for el, start, end, value, path in part.trace.rows()]
        if part.plane is None:
            _check_item(bits, traced, data)
            continue
        planes += 1
        first = next(i for i, row in enumerate(traced) if row[0] == "is_intra")
        own = traced[first:]
        start, at = bits.parse(PLANE_START, own[0][1])
        intra = _value(start, "is_intra")
        mask = _value(start, "fba_object_mask")
        header, at = bits.parse(TEMPORAL_HEADER, at, is_intra=intra)
        found = [*rows(start), *rows(header)]
        if intra and mask & 1:
            found += parameter_header(bits, "fap", at)[0]
        elif intra and mask & 2:
            found += parameter_header(bits, "bap", at)[0]
        assert [row[:4] for row in own[: len(found)]] == found
        if intra and mask == 3:
            bodies = [row for row in own if row[4].endswith(".bap") or ".bap." in row[4]]
            found = parameter_header(bits, "bap", bodies[0][1])[0]
            assert [row[:4] for row in bodies[: len(found)]] == found
        # What follows the headers is data: the tracer has no header element that this parser did not see.
        if not mask:
            assert own[-1][2] == found[-1][2]
    return planes


def _check_item(bits: Bits, traced: list[tuple[str, int, int, int, str]], data: bytes) -> None:
    parts = {
        "visual_object_sequence_start_code": SEQUENCE,
        "user_data_start_code": USER_DATA,
        "visual_object_start_code": VISUAL_OBJECT,
    }
    own = [row for row in traced if row[0] in parts]
    for name, start, *_ in own:
        at = traced.index(next(row for row in traced if row[:2] == (name, start)))
        parsed, end = bits.parse(parts[name], start)
        found = list(rows(parsed))
        assert [row[:4] for row in traced[at : at + len(found)]] == found
        if name == "user_data_start_code":
            behind = data.find(b"\0\0\1", end // 8)
            assert traced[at + 1][:4] == ("user_data", end, 8 * behind, behind - end // 8)


@given(streams())
def test_agrees_on_generated_streams(stream: Stream) -> None:
    planes = sum(len(item.fba.planes) for item in stream.items if item.fba is not None)
    assert check(stream.data, stream.options) == planes


@pytest.mark.parametrize("name", case_names("fba"))
def test_agrees_on_samples(name: str) -> None:
    case, data, _ = case_files("fba", name)
    if case["profile"] == "long":
        # 13,175 planes without a header beyond the first are enough as a tenth.
        data = data[: len(data) // 10]
        assert check(data) > 1_000
    else:
        assert check(data) == case["lines"]


def test_headers_to_check_a_reader_with() -> None:
    """The examples below SYS-7: face, Simple Face L1, no identifier; with verid 2, priority 1: 91 47."""
    assert check(bytes.fromhex("000001B061 000001B523 000001BA07000001B1")) == 1
    bits = Bits(bytes.fromhex("000001B59147"))
    assert [(name, value) for name, _, _, value in rows(bits.parse(VISUAL_OBJECT, 0)[0])] == [
        ("visual_object_start_code", 0x1B5), ("is_visual_object_identifier", 1), ("visual_object_verid", 2),
        ("visual_object_priority", 1), ("visual_object_type", 4),
    ]  # fmt: skip
