"""`.epf` text: tags, their domains, their order; writer and reader agree (FBA-52)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InconsistentSemantics,
    InputFormat,
    MarkerBit,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.face.epf_text import (
    _TAGS,
    CodedFrame,
    EncoderParameters,
    EpfReader,
    PartParameters,
    read_epf,
    write_epf,
)
from snhc.reference_impl.systems.stream import decode_frames
from snhc.reference_impl.tables import bap_groups, fap_groups

FACE_SIZES = [group.count for group in fap_groups()]
BODY_SIZES = [group.count for group in bap_groups()]
INTRA = b"FBM 3\nISI 1\n"


def refused(data: bytes, kind: type[SnhcError], line: int, column: int, **kwargs: Any) -> SnhcError:
    with pytest.raises(SnhcError) as caught:
        read_epf([data], **kwargs)
    error = caught.value
    assert (type(error), error.line, error.column) == (kind, line, column), str(error)
    return error


def test_a_whole_file() -> None:
    digits = "1000000000000000"
    text = f"""# an intra block, then an inter one
FBM 1
FFR 0
ISI 1
FRR 29 15 1
TC 23 59 1 58
SKN 3
FMT 0 1 {digits} 0 2 {" ".join("10000000")} 3 0 0 0 0 0
FQU 4
FIX {" ".join(["61"] * 66)}
FIN {" ".join(["-61"] * 66)}
FPX {" ".join(["1860"] * 66)}
FPN {" ".join(["0"] * 66)}
GDR 1
CDM 1

FBM 0
ISI 0
SKN 15
"""
    # Group 3 has type 0, group 4 type 2 with its 8 digits apart.
    read = read_epf([text.encode()])
    assert [f.id for f in read.findings] == ["text-trailing-blanks"]
    first, second = read.frames
    face = first.face
    assert (first.fba_object_mask, first.is_intra, first.line) == (1, True, 2)
    assert (face.frame, face.frame_rate, face.time_code, face.skip) == (0, (29, 15, 1), (23, 59, 58), 3)
    assert face.mask_types == (0, 1, 0, 2, 3, 0, 0, 0, 0, 0)
    assert face.masks is not None
    assert face.masks[1] == (1, *[0] * 15)
    assert face.masks[3] == (1, *[0] * 7)
    assert [len(mask) for mask in face.masks] == [0, 16, 0, 8, 0, 0, 0, 0, 0, 0]
    assert face.quant == 4
    assert (face.i_max, face.i_min) == ((120,) * 66, (-120,) * 66)
    assert (face.p_max, face.p_min) == ((1860,) * 66, (0,) * 66)
    assert (face.gender, face.coding_type) == (1, 1)
    assert first.body == PartParameters()
    assert (second.fba_object_mask, second.is_intra, second.face.skip) == (0, False, 15)


def test_body_tags() -> None:
    types = " ".join(["3"] * 22 + ["1 " + "10" * 11, "0"])
    text = f"""FBM 2
BFR 7
ISI 1
BRR 25 0 0
BTC 1 2 1 3
BSK 0
BMT {types}
BQU 31
BIX {" ".join(["60"] * 296)}
BIN {" ".join(["-1"] * 186)}
BPX {" ".join(["0"] * 296)}
BPN {" ".join(["-1860"] * 296)}
"""
    body = read_epf([text.encode()], strict=True).frames[0].body
    assert (body.frame, body.frame_rate, body.time_code, body.skip, body.quant) == (
        7, (25, 0, 0), (1, 2, 3), 0, 31
    )  # fmt: skip
    assert body.masks is not None
    assert body.masks[22] == (1, 0) * 11
    assert (body.i_max, body.i_min) == ((60,) * 296, (-60,) * 186)


@pytest.mark.parametrize(
    ("given_text", "limit"),
    [("0", 0), ("1", 60), ("59", 60), ("60", 60), ("61", 120), ("1801", 1860), ("1860", 1860)],
)
def test_limits_are_rounded_outward(given_text: str, limit: int) -> None:
    other = " 0" * 65
    face = read_epf([INTRA + f"FQU 1\nFIX {given_text}{other}\nFIN -{given_text}{other}\n".encode()]).frames[0].face
    assert face.i_max is not None
    assert face.i_min is not None
    assert (face.i_max[0], face.i_min[0]) == (limit, -limit)


def test_masks_may_be_run_together_or_apart() -> None:
    rest = " 0" * 8
    want = (1, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1)
    for form in ("1011000000000001", "1 0 1 1 0 0 0 0 0 0 0 0 0 0 0 1", "1011 00000000 000 1"):
        masks = read_epf([INTRA + f"FMT 0 1 {form}{rest}\n".encode()]).frames[0].face.masks
        assert masks is not None
        assert masks[1] == want


@pytest.mark.parametrize(
    ("kind", "line", "column", "data"),
    [
        (InputFormat, 1, 1, b""),
        (InputFormat, 2, 1, b"# x\n# y\n"),
        (InputFormat, 1, 1, b"\x00\x00\x01\xba"),
        (InconsistentSemantics, 1, 1, b"ISI 1\nFBM 1\n"),
        (InconsistentSemantics, 1, 1, b"FQU 1\n"),
        (InputFormat, 2, 2, b"FBM 1\n XYZ 1\n"),
        (InputFormat, 1, 1, b"fbm 1\n"),
        (InputFormat, 1, 1, b"\xff\n"),
        (InputFormat, 1, 6, b"FBM 1\x0b\n"),
        (InputFormat, 1, 4, b"FBM\n"),
        (InputFormat, 1, 7, b"FBM 1 2\n"),
        (InputFormat, 1, 5, b"FBM x\n"),
        (InputFormat, 1, 5, b"FBM 1.0\n"),
        (RangeViolation, 1, 5, b"FBM 4\n"),
        (RangeViolation, 1, 5, b"FBM " + b"9" * 9999 + b"\n"),
        (RangeViolation, 2, 5, b"FBM 1\nISI 2\n"),
        (RangeViolation, 2, 5, b"FBM 1\nFFR -1\n"),
        (RangeViolation, 3, 5, INTRA + b"FRR 256 0 0\n"),
        (RangeViolation, 3, 8, INTRA + b"FRR 25 16 0\n"),
        (RangeViolation, 3, 10, INTRA + b"FRR 25 0 2\n"),
        (ForbiddenValue, 3, 5, INTRA + b"FRR 0 0 1\n"),
        (ForbiddenValue, 3, 4, INTRA + b"TC 24 0 1 0\n"),
        (ForbiddenValue, 3, 6, INTRA + b"TC 0 60 1 0\n"),
        (MarkerBit, 3, 8, INTRA + b"TC 0 0 0 0\n"),
        (ForbiddenValue, 3, 11, INTRA + b"BTC 0 0 1 60\n"),
        (ResourceLimit, 3, 5, INTRA + b"SKN 1000001\n"),
        (RangeViolation, 3, 5, INTRA + b"FQU 32\n"),
        (RangeViolation, 3, 5, INTRA + b"GDR 2\n"),
        (RangeViolation, 3, 5, INTRA + b"CDM -1\n"),
        (RangeViolation, 3, 7, INTRA + b"FMT 0 4 0 0 0 0 0 0 0 0\n"),
        (InputFormat, 3, 22, INTRA + b"FMT 0 0 0 0 0 0 0 0 0\n"),
        (InputFormat, 3, 25, INTRA + b"FMT 0 0 0 0 0 0 0 0 0 0 0\n"),
        (InputFormat, 3, 7, INTRA + b"FMT 1 012\n"),
        (InputFormat, 3, 7, INTRA + b"FMT 1 111\n"),
        (InputFormat, 3, 8, INTRA + b"FMT 1 1\n"),
        (ForbiddenValue, 3, 5, INTRA + b"BMT 2\n"),
        (InconsistentSemantics, 3, 1, INTRA + b"FIX" + b" 0" * 66 + b"\n"),
        (InconsistentSemantics, 3, 1, INTRA + b"BIX" + b" 0" * 186 + b"\n"),
        (InconsistentSemantics, 5, 1, INTRA + b"BQU 0\nFRR 1 1 1\nFIX" + b" 0" * 66 + b"\n"),
        (InputFormat, 4, 134, INTRA + b"FQU 1\nFIX" + b" 0" * 65 + b"\n"),
        (InputFormat, 4, 137, INTRA + b"FQU 1\nFIX" + b" 0" * 67 + b"\n"),
        (InputFormat, 4, 578, INTRA + b"BQU 1\nBIX" + b" 0" * 287 + b"\n"),
        (RangeViolation, 4, 5, INTRA + b"FQU 1\nFIX 1861" + b" 0" * 65 + b"\n"),
        (RangeViolation, 4, 5, INTRA + b"FQU 1\nFIX -1" + b" 0" * 65 + b"\n"),
        (RangeViolation, 4, 5, INTRA + b"FQU 1\nFPN 1" + b" 0" * 65 + b"\n"),
        (InputFormat, 4, 5, INTRA + b"FQU 1\nFPN 0.5" + b" 0" * 65 + b"\n"),
        (InconsistentSemantics, 3, 1, INTRA + b"ISI 1\n"),
        (InconsistentSemantics, 4, 1, INTRA + b"FQU 1\nFQU 2\n"),
        (InconsistentSemantics, 2, 1, b"FBM 1\nFQU 1\n"),
        (InconsistentSemantics, 3, 1, b"FBM 1\nISI 0\nGDR 1\n"),
        (InconsistentSemantics, 2, 1, b"FBM 2\nFFR 1\n"),
        (InconsistentSemantics, 2, 1, b"FBM 1\nBFR 1\n"),
        (InconsistentSemantics, 4, 5, b"FBM 1\nFFR 1\nFBM 1\nFFR 1\n"),
    ],
)
def test_faults_have_class_line_and_column(kind: type[SnhcError], line: int, column: int, data: bytes) -> None:
    refused(data, kind, line, column)


def test_fqu_behind_limits_and_from_an_earlier_block() -> None:
    limits = b"FIX" + b" 0" * 66 + b"\n"
    assert len(read_epf([INTRA + b"FQU 1\n" + INTRA + limits]).frames) == 2
    refused(INTRA + b"FQU 1\n" + INTRA + limits + b"FQU 1\n", InconsistentSemantics, 7, 1)


def test_limits_and_dialects() -> None:
    refused(b"FBM 0\nFBM 0\n", ResourceLimit, 2, 1, limits=Limits(collected_planes=1))
    refused(b"FBM 00000\n", ResourceLimit, 1, 9, limits=Limits(text_line_bytes=8))
    assert len(list(EpfReader([b"FBM 0\nFBM 0\n"], limits=Limits(collected_planes=1)))) == 2
    data = b"FBM\t0 \r\nSKN 1"
    found = [(f.id, f.line) for f in read_epf([data]).findings]
    assert found == [
        ("text-crlf", 1), ("text-trailing-blanks", 1), ("text-tabs", 1), ("text-no-final-newline", 2)
    ]  # fmt: skip
    refused(data, InputFormat, 1, 7, strict=True)


@pytest.mark.parametrize(
    ("index", "parameters"),
    [
        (0, []),
        (0, [CodedFrame(4)]),
        (1, [CodedFrame(0), CodedFrame(0, None, PartParameters(quant=1))]),
        (0, [CodedFrame(1, True, PartParameters(quant=1, i_max=(1,) * 66))]),
        (0, [CodedFrame(1, True, PartParameters(i_max=(60,) * 66))]),
        (0, [CodedFrame(1, True, PartParameters(masks=((),) * 10))]),
        (0, [CodedFrame(1, True, PartParameters(mask_types=(0,) * 10, masks=((1, 1), *((),) * 9)))]),
        (0, [CodedFrame(2, True, PartParameters(), PartParameters(gender=1))]),
        (0, [CodedFrame(1, True, PartParameters(time_code=(24, 0, 0)))]),
    ],
)
def test_what_no_text_holds(index: int, parameters: list[CodedFrame]) -> None:
    with pytest.raises(EncodeError) as caught:
        list(write_epf(EncoderParameters(parameters)))
    assert caught.value.path == (f"frames[{index}]" if parameters else "frames")


def maybe(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(st.none(), strategy)


@st.composite
def part(draw: st.DrawFn, body: bool, coded: bool, intra: bool) -> PartParameters:
    out = PartParameters(skip=draw(maybe(st.integers(0, 10**6))))
    if intra:
        out.frame_rate = draw(maybe(st.tuples(st.integers(1, 255), st.integers(0, 15), st.integers(0, 1))))
        out.time_code = draw(maybe(st.tuples(st.integers(0, 23), st.integers(0, 59), st.integers(0, 59))))
    if intra and coded:
        out.quant = draw(maybe(st.integers(0, 31)))
        if draw(st.booleans()):
            sizes = BODY_SIZES if body else FACE_SIZES
            out.mask_types = tuple(draw(st.sampled_from([0, 1, 3] if body else [0, 1, 2, 3])) for _ in sizes)
            bits = draw(st.integers(0, 2**22 - 1))
            out.masks = tuple(
                tuple(bits >> i & 1 for i in range(size)) if kind in (1, 2) else ()
                for kind, size in zip(out.mask_types, sizes, strict=True)
            )
        if out.quant is not None:
            count = draw(st.sampled_from([186, 296])) if body else 66
            first = draw(st.integers(0, 31))
            values = tuple((first + i) % 32 * 60 for i in range(count))
            out.i_max = draw(st.sampled_from([None, values]))
            out.p_max = draw(st.sampled_from([None, values]))
            out.i_min = draw(st.sampled_from([None, tuple(-v for v in values)]))
            out.p_min = draw(st.sampled_from([None, tuple(-v for v in values)]))
        if not body:
            out.gender = draw(maybe(st.integers(0, 1)))
            out.coding_type = draw(maybe(st.integers(0, 1)))
    return out


@st.composite
def encoder_parameters(draw: st.DrawFn) -> EncoderParameters:
    frames: list[CodedFrame] = []
    for number in range(draw(st.integers(1, 4))):
        mask = draw(st.integers(0, 3))
        intra = draw(st.sampled_from([None, False, True]))
        face = draw(part(False, bool(mask & 1), intra is True))
        body = draw(part(True, bool(mask & 2), intra is True))
        if mask & 1:
            face.frame = draw(st.sampled_from([None, number * 3]))
        if mask & 2:
            body.frame = draw(st.sampled_from([None, number * 5]))
        frames.append(CodedFrame(mask, intra, face, body))
    return EncoderParameters(frames)


@given(encoder_parameters())
@settings(max_examples=80, deadline=None)
def test_reading_what_was_written_gives_the_same(parameters: EncoderParameters) -> None:
    assert read_epf([b"".join(write_epf(parameters))], strict=True) == parameters


VALID = (
    b"FBM 1\nFFR 0\nISI 1\nFRR 25 0 0\nTC 0 0 1 0\nSKN 3\n"
    b"FMT 1 11 2 1011000000000001 3 0 0 0 0 0 0 0\nFQU 4\nFIX" + b" 60" * 66 + b"\nGDR 1\nCDM 1\n"
    b"FBM 2\nBFR 0\nISI 1\nBMT" + b" 0" * 24 + b"\nBQU 1\nFBM 0\nISI 0\n"
)


@given(
    st.lists(
        st.tuples(
            st.integers(0, len(VALID)),
            st.integers(0, 4),
            st.one_of(st.binary(max_size=4), st.sampled_from([b"\n", b" ", b"-1", b"#", b"FBM", b"1", b"\r\n"])),
        ),
        min_size=1,
        max_size=4,
    )
)
@settings(max_examples=400, deadline=None)
def test_a_broken_file_gives_blocks_or_one_located_fault(edits: list[tuple[int, int, bytes]]) -> None:
    data = VALID
    for at, cut, put in edits:
        data = data[:at] + put + data[at + cut :]
    try:
        read = read_epf([data])
    except SnhcError as error:
        assert error.line is not None
        assert error.column is not None
        assert 1 <= error.line <= data.count(b"\n") + 1
        assert error.column >= 1
    else:
        assert read_epf([b"".join(write_epf(read))], strict=True) == read


def test_the_example_of_the_page_encodes(tmp_path: Path) -> None:
    page = Path(__file__).parents[2] / "docs" / "formats-epf.md"
    example = page.read_text().split("```")[1]
    mask = " ".join("1" if fap in (3, 17, 18, 48, 49, 50) else "0" for fap in range(1, 69))
    (tmp_path / "e.fap").write_text("2.1 e 25 3\n" + "".join(f"{mask}\n{n} 100 0 0 9 9 {n}\n" for n in range(3)))
    (tmp_path / "e.epf").write_text(example)
    args = ["encode", str(tmp_path / "e.fap"), "--epf", str(tmp_path / "e.epf"), "-o", str(tmp_path / "e.fba")]
    assert CliRunner().invoke(snhc, args).exit_code == 0
    frames = list(decode_frames((tmp_path / "e.fba").read_bytes()))
    assert [frame.time for frame in frames] == [(0, 1), (2, 25)]
    assert frames[0].fap_quant == 4


def test_the_page_names_every_tag() -> None:
    page = (Path(__file__).parents[2] / "docs" / "formats-epf.md").read_text()
    assert {*_TAGS, "FBM", "ISI"} == set(re.findall(r"`([A-Z]{2,3})`", page.split("## Tags")[1].split("## What")[0]))
