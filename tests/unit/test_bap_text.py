"""`.bap` text: widths and numbers of its own, the rest as `.fap` (FBA-53)."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    InputFormat,
    ResourceLimit,
    SnhcError,
    Truncated,
)
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face.bap_text import (
    BapFile,
    BapReader,
    BapTextFrame,
    bap_frame,
    bap_header,
    read_bap,
    write_bap,
)


def mask_line(width: int, *baps: int) -> bytes:
    return b" ".join(b"1" if bap in baps else b"0" for bap in range(1, width + 1)) + b"\n"


def file_of(width: int) -> bytes:
    return b"2.1 body 30 1\n" + mask_line(width, 1, 2, width) + b"0 5 -6 7\n"


def refused(data: bytes, kind: type[SnhcError], line: int, column: int, *, strict: bool = False) -> SnhcError:
    with pytest.raises(SnhcError) as caught:
        read_bap([data], strict=strict)
    assert (type(caught.value), caught.value.line, caught.value.column) == (kind, line, column)
    return caught.value


@pytest.mark.parametrize("width", [186, 296])
def test_two_widths_without_high_level_fields(width: int) -> None:
    bap = read_bap([file_of(width)], strict=True)
    assert (bap.version, bap.name, bap.frame_rate, bap.nframes) == ("2.1", "body", Fraction(30), 1)
    frame = bap.frames[0]
    assert len(frame.mask) == len(frame.values) == width
    # BAP 1 and 2 are plain values, unlike FAP 1 and 2.
    assert (frame.values[0], frame.values[1], frame.values[-1]) == (5, -6, 7)
    assert frame.values[2:-1] == [None] * (width - 3)
    assert (frame.number, frame.line) == (0, 2)


def test_295_columns() -> None:
    bap = read_bap([file_of(295)])
    assert [(f.id, f.line, f.rule) for f in bap.findings] == [("text-295-columns", 2, "FBA-53")]
    assert len(bap.frames[0].mask) == len(bap.frames[0].values) == 296
    assert bap.frames[0].values[294:] == [7, None]
    refused(file_of(295), InputFormat, 2, 590, strict=True)


@pytest.mark.parametrize(("width", "column"), [(185, 370), (187, 374), (294, 588), (297, 593), (68, 136), (69, 138)])
def test_other_widths_are_refused(width: int, column: int) -> None:
    error = refused(file_of(width), InputFormat, 2, column)
    assert (error.rule, error.value, error.expected) == ("FBA-53", str(width), "186 or 296")


def test_dialects_are_those_of_fap() -> None:
    data = b"3.1 a b 30 2\r\n" + mask_line(186, 4)[:-1] + b" \r\n1\t1.5"
    found = [(f.id, f.line) for f in read_bap([data]).findings]
    assert found == [
        ("text-crlf", 1), ("text-version", 1), ("text-blank-in-name", 1), ("text-nframes", 1),
        ("text-trailing-blanks", 2), ("text-no-final-newline", 3), ("text-tabs", 3),
        ("text-first-frame-one", 3), ("text-decimal", 3),
    ]  # fmt: skip
    bare = read_bap([mask_line(186, 4) + b"0 1\n"])
    assert [f.id for f in bare.findings] == ["text-no-header"]
    assert bare.nframes == 1


def test_faults() -> None:
    head = b"2.1 body 30 1\n" + mask_line(186, 1, 2)
    refused(head, Truncated, 2, 1)
    # Four integers are not taken for BAP 1: it has no high-level form.
    assert refused(head + b"0 1 2 3 4 5\n", InputFormat, 3, 7).expected == 2
    refused(head + b"0 1\n", InputFormat, 3, 4)
    refused(b"\x00\x00\x01\xba", InputFormat, 1, 1)
    with pytest.raises(ResourceLimit):
        read_bap([file_of(186)], limits=Limits(collected_planes=0))
    assert len(list(BapReader([file_of(186)], limits=Limits(collected_planes=0)))) == 1


def test_what_no_text_holds() -> None:
    for frame in (
        BapTextFrame(0, (0,) * 295, [None] * 295),
        BapTextFrame(0, (0,) * 186, [None] * 185),
        BapTextFrame(0, (0,) * 186, [1] + [None] * 185),
        BapTextFrame(-1, (0,) * 186, [None] * 186),
    ):
        with pytest.raises(EncodeError) as caught:
            bap_frame(frame)
        assert caught.value.rule == "FBA-53"
    assert bap_header("a b", Fraction(30000, 1001), 4) == b"2.1 a_b 29.97003 4\n"


@given(
    st.lists(
        st.tuples(
            st.sampled_from([186, 296]),
            st.integers(1, 99),
            st.dictionaries(st.integers(0, 185), st.integers(-(2**31), 2**31 - 1)),
        ),
        max_size=3,
    ),
    st.integers(1, 10**6),
)
@settings(deadline=None)
def test_reading_what_was_written_gives_the_same(drawn: list[tuple[int, int, dict[int, int]]], rate: int) -> None:
    frames: list[BapTextFrame] = []
    number = 0
    for width, gap, values in drawn:
        mask = tuple(1 if i in values else 0 for i in range(width))
        frames.append(BapTextFrame(number, mask, [values.get(i) for i in range(width)]))
        number += gap
    bap = BapFile("2.1", "body", Fraction(rate, 16), len(frames), frames, ["x"])
    assert read_bap([b"".join(write_bap(bap))], strict=True) == bap
