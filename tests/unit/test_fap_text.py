"""`.fap` text: the plain form, every dialect, every fault with its place (FBA-50, FBA-51)."""

from __future__ import annotations

import io
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
    Truncated,
)
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face.fap_text import (
    FapFile,
    FapReader,
    FapTextFrame,
    fap_frame,
    fap_header,
    read_fap,
    write_fap,
)

HEADER = b"2.1 sequence 25 2\n"


def mask_of(*faps: int) -> tuple[int, ...]:
    return tuple(1 if fap in faps else 0 for fap in range(1, 69))


def mask_line(*faps: int) -> bytes:
    return b" ".join(b"%d" % digit for digit in mask_of(*faps)) + b"\n"


M3 = mask_line(3)
PLAIN = HEADER + M3 + b"0 100\n" + M3 + b"1 -7\n"


def text_of(fap: FapFile) -> bytes:
    return b"".join(write_fap(fap))


def refused(data: bytes, kind: type[SnhcError], line: int, column: int, **kwargs: Any) -> SnhcError:
    with pytest.raises(SnhcError) as caught:
        read_fap([data], **kwargs)
    error = caught.value
    assert (type(error), error.line, error.column) == (kind, line, column), str(error)
    return error


def test_plain_file() -> None:
    fap = read_fap(io.BytesIO(b"# made by hand\n" + PLAIN), strict=True)
    assert (fap.version, fap.name, fap.frame_rate, fap.nframes) == ("2.1", "sequence", Fraction(25), 2)
    assert fap.comments == [" made by hand"]
    assert fap.findings == []
    assert [frame.number for frame in fap.frames] == [0, 1]
    assert [frame.line for frame in fap.frames] == [3, 5]
    assert fap.frames[0].mask == mask_of(3)
    assert fap.frames[1].values == [None, None, -7] + [None] * 65
    assert fap.frames[0].viseme is None
    assert fap.frames[0].expression is None


def test_high_level_fields_and_ascending_values() -> None:
    data = b"2.1 n 30 1\n" + mask_line(1, 2, 5, 68) + b"0 1 2 63 1 3 40 6 20 0 1 -5 68\n"
    frame = read_fap([data], strict=True).frames[0]
    assert frame.viseme == (1, 2, 63, 1)
    assert frame.expression == (3, 40, 6, 20, 0, 1)
    assert (frame.values[4], frame.values[67]) == (-5, 68)
    assert frame.values[:2] == [None, None]


def test_header_is_known_before_any_frame_and_frames_come_one_by_one() -> None:
    seen: list[int] = []

    def source() -> Iterator[bytes]:
        yield PLAIN + b"#" + b" " * 5000 + b"\n"
        for number in range(2, 5):
            seen.append(number)
            yield M3 + b"%d 0\n" % number

    reader = FapReader(source())
    assert (reader.name, reader.nframes, reader.has_header, seen) == ("sequence", 2, True, [])
    frames = iter(reader)
    assert [next(frames).number, next(frames).number] == [0, 1]
    assert seen == []
    assert next(frames).number == 2
    assert seen == [2]


@pytest.mark.parametrize(
    ("finding", "line", "column", "data"),
    [
        ("text-crlf", 1, 18, PLAIN.replace(b"\n", b"\r\n")),
        ("text-tabs", 3, 2, PLAIN.replace(b"0 100", b"0\t100")),
        ("text-trailing-blanks", 2, 136, PLAIN.replace(M3, M3[:-1] + b" \n")),
        ("text-trailing-blanks", 6, 1, PLAIN + b"\n"),
        ("text-blank-in-name", 1, 5, PLAIN.replace(b"sequence", b"a sequence")),
        ("text-backslash-in-name", 1, 6, PLAIN.replace(b"sequence", b"a\\sequence")),
        ("text-no-header", 1, 1, PLAIN[len(HEADER) :]),
        ("text-comment-between", 4, 1, HEADER + M3 + b"0 100\n# x\n" + M3 + b"1 -7\n"),
        ("text-decimal", 3, 3, PLAIN.replace(b"0 100", b"0 100.4")),
        ("text-69-columns", 2, 138, PLAIN.replace(M3, M3[:-1] + b" 0\n")),
        ("text-single-viseme", 3, 3, HEADER.replace(b" 2\n", b" 1\n") + mask_line(1) + b"0 5\n"),
        ("text-first-frame-one", 3, 1, PLAIN.replace(b"1 -7", b"2 -7").replace(b"0 100", b"1 100")),
        ("text-version", 1, 1, PLAIN.replace(b"2.1", b"2.0")),
        ("text-version", 1, 1, PLAIN.replace(b"2.1", b"2.2")),
        ("text-nframes", 1, 17, PLAIN.replace(b"25 2", b"25 3")),
        ("text-no-final-newline", 5, 5, PLAIN[:-1]),
        (
            "text-intensity-minus-one",
            3,
            5,
            HEADER.replace(b" 2\n", b" 1\n") + mask_line(2) + b"0 1 -1 2 -1 0 0\n",
        ),
    ],
)
def test_dialects_are_read_reported_once_and_refused_when_strict(
    finding: str, line: int, column: int, data: bytes
) -> None:
    fap = read_fap([data])
    assert [(f.id, f.line, f.rule) for f in fap.findings] == [(finding, line, "FBA-51")]
    refused(data, InputFormat, line, column, strict=True)


def test_what_the_dialects_mean() -> None:
    assert read_fap([PLAIN.replace(b"sequence", b"a  b\\c")]).name == "a  b\\c"
    bare = read_fap([PLAIN[len(HEADER) :]])
    assert (bare.version, bare.name, bare.frame_rate, bare.nframes) == ("2.1", "", Fraction(30), 2)
    extra = PLAIN.replace(M3, M3[:-1] + b" 0\n")
    assert read_fap([extra]).frames == read_fap([PLAIN]).frames
    single = read_fap([b"2.1 n 25 1\n" + mask_line(1, 2, 3) + b"0 5 1 2 3 4 0 1 9\n"]).frames[0]
    assert single.viseme == (5, 0, 63, 0)
    assert single.expression == (1, 2, 3, 4, 0, 1)
    assert single.values[2] == 9
    minus = read_fap([b"2.1 n 25 1\n" + mask_line(2) + b"0 1 -1 2 -1 0 0\n"])
    assert minus.frames[0].expression == (1, -1, 2, -1, 0, 0)
    assert "2 times" in minus.findings[0].message


def test_a_finding_is_counted_not_repeated() -> None:
    data = b"2.1 n 25 500\r\n" + b"".join(M3[:-1] + b"\t \r\n%d 1.5\r\n" % i for i in range(500))
    found = {f.id: f for f in read_fap([data]).findings}
    assert sorted(found) == ["text-crlf", "text-decimal", "text-tabs", "text-trailing-blanks"]
    assert "1001 times" in found["text-crlf"].message
    assert "500 times" in found["text-decimal"].message
    assert found["text-decimal"].line == 3


@pytest.mark.parametrize(
    ("token", "value"),
    [
        (b"0.5", 1), (b"-0.5", -1), (b"0.49999999999999999999", 0), (b"-1.5", -2), (b"2.5", 3), (b".5", 1),
        (b"7.", 7), (b"-154.8", -155), (b"1.5e1", 15), (b"1e3", 1000), (b"125E-2", 1), (b"1e-308", 0),
        (b"0e308", 0), (b"5e-1", 1), (b"4.9e-1", 0), (b"+3.2", 3), (b"2147483647.4", 2147483647),
        (b"-2147483648.4", -2147483648), (b"0.00000000000000000001e20", 1), (b"+12", 12), (b"-0", 0),
        (b"007", 7), (b"0" * 3000 + b"9", 9), (b"0." + b"4" * 9000, 0),
    ],
)  # fmt: skip
def test_numbers_are_exact(token: bytes, value: int) -> None:
    assert read_fap([b"2.1 n 25 1\n" + M3 + b"0 " + token + b"\n"]).frames[0].values[2] == value


@given(st.integers(-(2**30), 2**30), st.integers(0, 999), st.integers(-12, 12))
def test_rounding_is_half_away_from_zero(whole: int, thousandths: int, exponent: int) -> None:
    token = f"{whole}.{thousandths:03d}e{exponent}"
    exact = Fraction(abs(whole) * 1000 + thousandths, 1000) * Fraction(10) ** exponent
    magnitude = (2 * exact.numerator + exact.denominator) // (2 * exact.denominator)
    expected = -magnitude if token.startswith("-") else magnitude
    data = b"2.1 n 25 1\n" + M3 + b"0 " + token.encode() + b"\n"
    if -(2**31) <= expected < 2**31:
        assert read_fap([data]).frames[0].values[2] == expected
    else:
        refused(data, RangeViolation, 3, 3)


@pytest.mark.parametrize(
    ("token", "kind"),
    [
        (b"1e999999999", InputFormat), (b"1e-999999999", InputFormat), (b"1e309", InputFormat),
        (b"1e300", RangeViolation), (b"2147483648", RangeViolation), (b"-2147483649", RangeViolation),
        (b"2147483647.5", RangeViolation), (b"9" * 100_000, RangeViolation), (b"9" * 3000, RangeViolation),
        (b"1_0", InputFormat), (b"--5", InputFormat), (b".", InputFormat), (b"e5", InputFormat),
        (b"1-2", InputFormat), (b"nan", InputFormat), (b"0x1", InputFormat),
        ("\u0663".encode(), InputFormat), (b"-", InputFormat),
    ],
)  # fmt: skip
def test_numbers_that_are_refused(token: bytes, kind: type[SnhcError]) -> None:
    refused(b"2.1 n 25 1\n" + mask_line(3, 4) + b"0  7 " + token + b"\n", kind, 3, 6)


@pytest.mark.parametrize(
    ("kind", "line", "column", "data"),
    [
        (InputFormat, 1, 1, b""),
        (InputFormat, 1, 1, b"# only\n\n# comments\n"),
        (InputFormat, 1, 1, b"\x00\x00\x01\xba"),
        (InputFormat, 1, 1, PLAIN + b"\x00"),
        (InputFormat, 205, 2, PLAIN + b"# 20 characters.....\n" * 199 + b"#\x00\n"),
        (InputFormat, 1, 1, b"hello 25 2\n"),
        (InputFormat, 1, 1, b"3.0 n 25 2\n"),
        (InputFormat, 1, 1, b"2.1 25 2\n"),
        (InputFormat, 1, 7, b"2.1 n x 2\n"),
        (InputFormat, 1, 7, b"2.1 n 1/2 2\n"),
        (InputFormat, 1, 7, b"2.1 n 1e2 2\n"),
        (InputFormat, 1, 7, b"2.1 n 0.123456789012345678901 2\n"),
        (ForbiddenValue, 1, 7, b"2.1 n 0.0 2\n"),
        (RangeViolation, 1, 7, b"2.1 n -25 2\n"),
        (RangeViolation, 1, 7, b"2.1 n 2147483647.1 2\n"),
        (RangeViolation, 1, 7, b"2.1 n " + b"9" * 9999 + b" 2\n"),
        (RangeViolation, 1, 10, b"2.1 n 25 -1\n"),
        (InputFormat, 1, 10, b"2.1 n 25 2.0\n"),
        (InputFormat, 1, 10, "2.1 \u00e9 25 \u00e9\n".encode()),
        (InputFormat, 1, 6, b"2.1 a\x1bb 25 2\n"),
        (InputFormat, 1, 6, b"2.1 a\rb 25 2\n"),
        (InputFormat, 2, 3, HEADER + M3.replace(b"0 0 1", b"0 2 1")),
        (InputFormat, 2, 1, HEADER + b"00" + M3[3:]),
        (InputFormat, 2, 134, HEADER + M3[2:]),
        (InputFormat, 2, 137, HEADER + M3[:-1] + b" 0 0\n"),
        (InputFormat, 2, 137, HEADER + M3[:-1] + b" 1\n"),
        (InputFormat, 1, 134, M3[2:]),
        (InputFormat, 3, 2, HEADER + M3 + b"0\n"),
        (InputFormat, 3, 5, HEADER + M3 + b"0 1 2\n"),
        (InputFormat, 3, 6, HEADER + mask_line(1) + b"0 1 2\n"),
        (InputFormat, 3, 1, HEADER + M3 + b"0.0 1\n"),
        (InputFormat, 3, 4, HEADER + M3 + b"0 1\x0b\n"),
        (RangeViolation, 3, 1, HEADER + M3 + b"-1 1\n"),
        (RangeViolation, 3, 3, HEADER + mask_line(1) + b"0 15 0 0 0\n"),
        (RangeViolation, 3, 3, HEADER + mask_line(1) + b"0 15\n"),
        (RangeViolation, 3, 9, HEADER + mask_line(1) + b"0 1 0 0 2\n"),
        (RangeViolation, 3, 7, HEADER + mask_line(2) + b"0 1 0 7 0 0 0\n"),
        (RangeViolation, 3, 11, HEADER + mask_line(2) + b"0 1 0 6 0 2 0\n"),
        (InconsistentSemantics, 5, 1, HEADER + M3 + b"4 1\n" + M3 + b"4 1\n"),
        (InconsistentSemantics, 5, 1, HEADER + M3 + b"4 1\n" + M3 + b"3 1\n"),
        (Truncated, 4, 1, HEADER + M3 + b"4 1\n" + M3),
        (Truncated, 4, 1, HEADER + M3 + b"4 1\n" + M3 + b"\n# end\n"),
    ],
)
def test_faults_have_class_line_and_column(kind: type[SnhcError], line: int, column: int, data: bytes) -> None:
    refused(data, kind, line, column)


def test_a_wrong_count_names_both_numbers() -> None:
    error = refused(HEADER + mask_line(1, 3) + b"0 1 2 3\n", InputFormat, 3, 8)
    assert (error.value, error.expected) == ("3", 5)
    error = refused(HEADER + M3[:-1] + b" 1 1\n", InputFormat, 2, 137)
    assert (error.value, error.expected) == ("70", "68")


def test_names_keep_any_character() -> None:
    assert read_fap(["2.1 gr\u00fc\u00dfe\u2003x 25 0\n".encode()], strict=True).name == "gr\u00fc\u00dfe\u2003x"
    assert read_fap([b"2.1 gr\xfcn 25 0\n"], strict=True).name == "gr\u00fcn"
    assert read_fap([b"# \xfc\n2.1 n 25 0\n"], strict=True).comments == [" \u00fc"]
    # A CR before a CR LF is no part of the comment: it could not be written back.
    assert read_fap([b"# a\r\r\n2.1 n 25 0\r\n"]).comments == [" a"]


def test_a_line_has_a_limit_and_is_not_read_to_its_end() -> None:
    limits = Limits(text_line_bytes=10)
    assert read_fap([b"2.1 n 25 0\r\n"], limits=limits).nframes == 0
    assert read_fap([b"2.1 n 25 0\r", b"\n"], limits=limits).nframes == 0
    for data in ([b"2.1 nn 25 0\n"], [b"2.1 nn 25 0"], [b"2.1 nn", b" 25 0\n"]):
        with pytest.raises(ResourceLimit) as caught:
            read_fap(data, limits=limits)
        assert (caught.value.line, caught.value.column, caught.value.rule) == (1, 11, "CNF-22")
    taken = 0

    def endless() -> Iterator[bytes]:
        nonlocal taken
        yield PLAIN
        while True:
            taken += 1 << 16
            yield b"1" * (1 << 16)

    with pytest.raises(ResourceLimit) as caught:
        read_fap(endless())
    assert (caught.value.line, caught.value.column) == (6, (1 << 20) + 1)
    assert taken <= (1 << 20) + (1 << 17)


def test_a_binary_file_is_refused_at_once() -> None:
    taken = 0

    def source() -> Iterator[bytes]:
        nonlocal taken
        while True:
            taken += 1
            yield b"\x00\x00\x01\xba" * 16

    with pytest.raises(InputFormat) as caught:
        FapReader(source())
    assert (caught.value.line, caught.value.column, taken) == (1, 1, 1)


def test_collecting_and_leading_comments_have_limits() -> None:
    refused(PLAIN, ResourceLimit, 4, 1, limits=Limits(collected_planes=1))
    refused(b"# 10 bytes\n" * 11 + PLAIN, ResourceLimit, 11, 1, limits=Limits(text_line_bytes=100))


@pytest.mark.parametrize("size", [1, 2, 7, 64, 100_000])
def test_pieces_do_not_matter(size: int) -> None:
    data = (PLAIN + b"# \xc3\xa9\n" + M3 + b"2 5.5").replace(b"\n", b"\r\n")
    pieces = [data[i : i + size] for i in range(0, len(data), size)]
    whole, cut = read_fap(io.BytesIO(data)), read_fap(pieces)
    assert cut == whole
    assert cut.findings == whole.findings
    assert len(cut.frames) == 3


@pytest.mark.parametrize(
    ("rate", "text"),
    [
        (Fraction(25), b"25"),
        (Fraction(2997, 100), b"29.97"),
        (Fraction(30000, 1001), b"29.97003"),
        (Fraction(401, 16), b"25.0625"),
        (Fraction(1, 3), b"0.333333"),
        (Fraction(1, 10**20), b"0.00000000000000000001"),
        (Fraction(3, 1_000_001), b"0.000003"),
    ],
)
def test_rate_as_printed(rate: Fraction, text: bytes) -> None:
    assert fap_header("n", rate, 0) == b"2.1 n " + text + b" 0\n"
    assert abs(read_fap([fap_header("n", rate, 0)], strict=True).frame_rate - rate) < Fraction(1, 10**6)


def test_header_written_is_plain() -> None:
    assert fap_header("a b\tc\\d", Fraction(25), 3, [" x"]) == b"# x\n2.1 a_b_c/d 25 3\n"
    assert fap_header("", Fraction(25), 0) == b"2.1 _ 25 0\n"


@pytest.mark.parametrize(
    ("path", "frame"),
    [
        ("f.number", FapTextFrame(-1, mask_of(), [None] * 68)),
        ("f.number", FapTextFrame(2**31, mask_of(), [None] * 68)),
        ("f.mask", FapTextFrame(0, mask_of()[1:], [None] * 68)),
        ("f.mask", FapTextFrame(0, (2, *mask_of()[1:]), [None] * 68)),
        ("f.values", FapTextFrame(0, mask_of(), [])),
        ("f.values[2]", FapTextFrame(0, mask_of(3), [None] * 68)),
        ("f.values[2]", FapTextFrame(0, mask_of(3), [None, None, 2**31] + [None] * 65)),
        ("f.values[0]", FapTextFrame(0, mask_of(1), [1] + [None] * 67, (1, 0, 0, 0))),
        ("f.viseme", FapTextFrame(0, mask_of(1), [None] * 68)),
        ("f.viseme", FapTextFrame(0, mask_of(), [None] * 68, (1, 0, 0, 0))),
        ("f.viseme", FapTextFrame(0, mask_of(1), [None] * 68, (15, 0, 0, 0))),
        ("f.expression", FapTextFrame(0, mask_of(2), [None] * 68, None, (1, 0, 0, 0, 0, 2))),
    ],
)
def test_frames_that_no_text_holds(path: str, frame: FapTextFrame) -> None:
    with pytest.raises(EncodeError) as caught:
        fap_frame(frame, -1, "f")
    assert caught.value.path == path


@pytest.mark.parametrize(
    ("name", "rate", "nframes", "comments"),
    [
        ("n", Fraction(0), 0, []),
        ("n", Fraction(2**31), 0, []),
        ("n", Fraction(1, 3_000_000), 0, []),
        ("n", Fraction(25), -1, []),
        ("n", Fraction(25), 0, ["a\nb"]),
        ("\ud800", Fraction(25), 0, []),
    ],
)
def test_headers_that_no_text_holds(name: str, rate: Fraction, nframes: int, comments: list[str]) -> None:
    with pytest.raises(EncodeError):
        fap_header(name, rate, nframes, comments)


INT32 = st.integers(-(2**31), 2**31 - 1)
LETTERS = st.characters(codec="utf-8", exclude_characters="\\", min_codepoint=33)
COMMENTS = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=20)


@st.composite
def fap_files(draw: st.DrawFn) -> FapFile:
    frames: list[FapTextFrame] = []
    number = 0
    for _ in range(draw(st.integers(0, 3))):
        bits = draw(st.integers(0, 2**68 - 1))
        mask = tuple(bits >> i & 1 for i in range(68))
        drawn = draw(st.lists(INT32, min_size=66, max_size=66))
        values = [None, None, *[v if digit else None for v, digit in zip(drawn, mask[2:], strict=True)]]
        select, flag = st.integers(0, 14), st.integers(0, 1)
        kind, level = st.integers(0, 6), INT32.filter(lambda v: v != -1)
        viseme = draw(st.tuples(select, select, INT32, flag)) if mask[0] else None
        expression = draw(st.tuples(kind, level, kind, level, flag, flag)) if mask[1] else None
        frames.append(FapTextFrame(number, mask, values, viseme, expression))
        number += draw(st.integers(1, 1000))
    rate = Fraction(draw(st.integers(1, 2**31 - 1)), 10 ** draw(st.integers(0, 20)))
    comments = draw(st.lists(COMMENTS, max_size=2))
    return FapFile("2.1", draw(st.text(LETTERS, min_size=1)), rate, len(frames), frames, comments)


@given(fap_files())
@settings(max_examples=60, deadline=None)
def test_reading_what_was_written_gives_the_same(fap: FapFile) -> None:
    assert read_fap([text_of(fap)], strict=True) == fap


VALID = (
    b"# comment\n2.1 name 29.97 3\n"
    + mask_line(1, 2, 3, 30)
    + b"0 1 2 63 0 1 2 3 4 0 0 100 -3\n"
    + mask_line()
    + b"1\n"
    + mask_line(3, 4, 5)
    + b"5 1.5 -2e1 3\n"
)


@given(
    st.lists(
        st.tuples(
            st.integers(0, len(VALID)),
            st.integers(0, 4),
            st.one_of(
                st.binary(max_size=4),
                st.sampled_from([b"\n", b"\r\n", b" ", b"\t", b"-1", b"1e9", b"#", b"."]),
            ),
        ),
        min_size=1,
        max_size=4,
    )
)
@settings(max_examples=400, deadline=None)
def test_a_broken_file_gives_frames_or_one_located_fault(edits: list[tuple[int, int, bytes]]) -> None:
    data = VALID
    for at, cut, put in edits:
        data = data[:at] + put + data[at + cut :]
    last = data.count(b"\n") + 1
    try:
        fap = read_fap([data])
    except SnhcError as error:
        assert error.line is not None
        assert error.column is not None
        assert 1 <= error.line <= last
        assert error.column >= 1
        assert "FBA" in error.rule
    else:
        assert all(1 <= (finding.line or 0) <= last for finding in fap.findings)
        assert len({finding.id for finding in fap.findings}) == len(fap.findings)
        # What was read can be written, and is the same file in plain form.
        again = read_fap([text_of(fap)])
        assert again.frames == fap.frames
        assert again.frame_rate == fap.frame_rate
        assert {f.id for f in again.findings} <= {"text-first-frame-one", "text-intensity-minus-one"}


class Counted(io.BytesIO):
    """Counts the bytes asked for."""

    taken = 0

    def read1(self, size: int | None = -1, /) -> bytes:
        out = super().read1(size)
        self.taken += len(out)
        return out


def test_every_byte_is_read_once() -> None:
    stream = Counted(PLAIN + b"\n" * 200_000 + b"# x\n" * 50_000)
    fap = read_fap(stream)
    assert stream.taken == len(stream.getvalue())
    assert [(f.id, f.line) for f in fap.findings] == [
        ("text-trailing-blanks", 6),
        ("text-comment-between", 200_006),
    ]
