"""The encoders: periods, masks, parts that come and go, what parameters override (FBA-20, FBA-43, FBA-52, DCT-13)."""

from __future__ import annotations

import io
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snhc.reference_impl.bitstream.errors import EncodeError, InconsistentSemantics
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.bap_text import BapFile, read_bap
from snhc.reference_impl.face.encode import EncoderOptions
from snhc.reference_impl.face.encode_part import quantise
from snhc.reference_impl.face.epf_text import EncoderParameters, read_epf
from snhc.reference_impl.face.fap_text import FapFile, read_fap
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.parameters import bap_set
from snhc.reference_impl.face.requests import requests_of, set_rate
from snhc.reference_impl.face.state import ParameterState
from snhc.reference_impl.syntax.base import STUFFED_CODE
from snhc.reference_impl.systems.encoding import encode_fap, encode_requests, stream_of
from snhc.reference_impl.systems.stream import decode_frames, decode_planes, write_stream

Values = list[tuple[int, dict[int, int]]]


def _text(frames: Values, columns: int) -> io.BytesIO:
    lines = [f"2.1 x 25 {len(frames)}"]
    for number, values in frames:
        lines.append(" ".join("1" if column + 1 in values else "0" for column in range(columns)))
        lines.append(" ".join(map(str, [number, *(values[key] for key in sorted(values))])))
    return io.BytesIO(("\n".join(lines) + "\n").encode())


def _faps(*frames: tuple[int, dict[int, int]]) -> FapFile:
    return read_fap(_text(list(frames), 68))


def _baps(*frames: tuple[int, dict[int, int]]) -> BapFile:
    return read_bap(_text(list(frames), 186))


def _epf(*lines: str) -> EncoderParameters:
    return read_epf(io.BytesIO(("\n".join(lines) + "\n").encode()))


def _decoded(data: bytes) -> list[FaceFrame]:
    return [frame for frame in decode_frames(data) if isinstance(frame, FaceFrame)]


def test_a_part_that_is_not_in_the_intra_plane_gets_one_of_its_own() -> None:
    faps = _faps((0, {3: 8}), (1, {4: 6}), (2, {4: 8}))
    frames = _decoded(write_stream(encode_fap(faps, baps=_baps((0, {1: 0}), (2, {1: 128})))))
    assert [frame.intra for frame in frames] == [True, True, True]
    assert [frame.baps for frame in frames] == [{1: 0}, None, {1: 128}]


def test_inter_planes_keep_to_the_limits_that_stand() -> None:
    """An explicit inter plane behind an intra plane without its part: old limits, and a finding where they clip."""
    faps = _faps((0, {3: 1000}), (1, {3: 1100}))
    epf = _epf("FBM 1", "FFR 0", "ISI 1", "FBM 0", "ISI 1", "FBM 1", "FFR 1", "ISI 0")
    findings: list[Finding] = []
    frames = _decoded(write_stream(encode_fap(faps, epf=epf, on_finding=findings.append)))
    assert [frame.faps[2] for frame in frames] == [1000, 1000, 1000]
    assert [(finding.id, finding.path) for finding in findings] == [("value-clipped", "frame[1]")]


@pytest.mark.parametrize("second", [{4: 6}, {3: 4, 4: 6}])
def test_masks_cannot_change_in_inter_planes(second: dict[int, int]) -> None:
    faps = _faps((0, {3: 8}), (1, second))
    epf = _epf("FBM 1", "FFR 0", "ISI 1", "FBM 1", "FFR 1", "ISI 0")
    with pytest.raises(InconsistentSemantics) as caught:
        encode_fap(faps, epf=epf)
    assert (caught.value.rule, caught.value.line) == ("FBA-52", 4)


def test_inter_first_is_refused() -> None:
    requests = list(requests_of(_faps((0, {3: 8}))))
    requests[0].is_intra = False
    with pytest.raises(EncodeError) as caught:
        list(encode_requests(requests))
    assert caught.value.rule == "FBA-35"


def test_parameters_override_only_what_they_say() -> None:
    epf = _epf("FBM 1", "FFR 0", "ISI 1")
    frames = _decoded(write_stream(encode_fap(_faps((0, {3: 8})), epf=epf, mode="dct", gender=1, quant=4)))
    assert len(frames) == 16
    assert (frames[0].coding_type, frames[0].gender, frames[0].fap_quant) == (1, 1, 4)
    said = _epf("FBM 1", "FFR 0", "ISI 1", "FQU 2", "GDR 0", "CDM 0")
    frames = _decoded(write_stream(encode_fap(_faps((0, {3: 8})), epf=said, mode="dct", gender=1, quant=4)))
    assert [(frame.coding_type, frame.gender, frame.fap_quant) for frame in frames] == [(0, 0, 2)]


def test_a_new_rate_travels_in_an_intra_plane() -> None:
    requests = list(requests_of(_faps((0, {3: 8}), (1, {3: 9}), (2, {3: 9}))))
    set_rate(requests[1].header, Fraction(50))
    frames = _decoded(write_stream(stream_of(encode_requests(requests))))
    assert [(frame.intra, frame.time) for frame in frames] == [(True, (0, 1)), (True, (1, 25)), (False, (3, 50))]


def test_requests_can_be_encoded_twice() -> None:
    frames = [(number, {3: 8}) for number in (0, 1, 40)]
    requests = list(requests_of(_faps(*frames), coding_type=1))
    first = write_stream(stream_of(encode_requests(requests)))
    assert write_stream(stream_of(encode_requests(requests))) == first


def test_a_time_code_that_goes_back_into_a_segment_is_a_finding() -> None:
    faps = _faps(*[(number, {3: 8}) for number in range(17)])
    requests = list(requests_of(faps, coding_type=1))
    requests[16].header.is_time_code = 1
    findings: list[Finding] = []
    planes = list(decode_planes(write_stream(stream_of(encode_requests(requests))), on_finding=findings.append))
    assert planes[1].frames[0].time == (0, 1)
    assert "time-code-back" in [finding.id for finding in findings]


def test_idle_planes_get_a_start_code_in_time() -> None:
    """Before the 5th consecutive plane without data (FBA-41)."""
    requests = list(requests_of(_faps(*[(number, {3: 8}) for number in range(12)])))
    for request in requests[1:]:
        request.face = None
    planes = list(encode_requests(requests, EncoderOptions(intra_period=100)))
    assert [i for i, plane in enumerate(planes) if plane.start_code] == [5, 9]


def test_only_a_plane_start_code_can_stand_before_a_plane() -> None:
    items = encode_fap(_faps((0, {3: 8})))
    obj = items[0].fba
    assert obj is not None
    obj.planes[0].boundary = STUFFED_CODE
    obj.planes[0].start_code = 0x000001B5
    with pytest.raises(EncodeError) as caught:
        write_stream(items)
    assert caught.value.rule == "FBA-2"


@pytest.mark.parametrize("period", [1, 2, 3, 7])
def test_intra_period(period: int) -> None:
    faps = _faps(*[(number, {3: 4 * number}) for number in range(8)])
    frames = _decoded(write_stream(encode_fap(faps, EncoderOptions(intra_period=period))))
    assert [frame.intra for frame in frames] == [number % period == 0 for number in range(8)]
    assert [frame.faps[2] for frame in frames] == [4 * number for number in range(8)]


# -- bodies beside DCT segments ----------------------------------------------------------------------------------------


def test_a_dct_segment_carries_the_baps_of_its_first_instant() -> None:
    faps = _faps(*[(number, {3: number}) for number in range(40)])
    baps = _baps(*[(number, {2: 10 * number, 5: -number}) for number in (0, 3, 16, 20, 25)])
    findings: list[Finding] = []
    data = write_stream(encode_fap(faps, mode="dct", baps=baps, bap_quant=0, on_finding=findings.append))
    frames = _decoded(data)
    # The third segment has none of its own: the last ones of the second go with it.
    assert {frame.index: frame.baps for frame in frames if frame.baps is not None} == {
        0: {2: 0, 5: 0}, 16: {2: 160, 5: -16}, 32: {2: 250, 5: -25},
    }  # fmt: skip
    assert [frame.intra for frame in frames[::16]] == [True, False, False]
    thinned = [finding for finding in findings if finding.id == "baps-thinned"]
    assert [(finding.path, ": 1 " in finding.message) for finding in thinned] == [
        ("frame[0]", True), ("frame[16]", False),
    ]  # fmt: skip
    alone = _decoded(write_stream(encode_fap(faps, mode="dct")))
    assert [frame.faps for frame in frames] == [frame.faps for frame in alone]


def test_a_body_that_comes_or_changes_makes_a_dct_plane_intra() -> None:
    faps = _faps(*[(number, {3: 8}) for number in range(80)])
    baps = _baps((16, {2: 10}), (32, {2: 12}), (48, {2: 12, 3: 4}))
    frames = _decoded(write_stream(encode_fap(faps, mode="dct", baps=baps, bap_quant=0)))
    assert [frame.intra for frame in frames[::16]] == [True, True, False, True, False]
    assert [frame.baps for frame in frames[::16]] == [None, {2: 10}, {2: 12}, {2: 12, 3: 4}, None]


def test_a_body_goes_on_from_mode_to_mode() -> None:
    faps = _faps(*[(number, {3: 8}) for number in range(20)])
    baps = _baps((0, {2: 10}), (1, {2: 1800}), (17, {2: 1790}), (18, {2: -7}))
    blocks = [f"FBM {3 if number in (0, 1, 17, 18) else 1}\nFFR {number}" for number in range(20)]
    for number, mode in ((0, 0), (1, 1), (17, 0)):
        blocks[number] += f"\nISI 1\nCDM {mode}"
    for number in (0, 1, 17, 18):
        blocks[number] = blocks[number].replace(f"FFR {number}", f"FFR {number}\nBFR {number}")
    frames = _decoded(write_stream(encode_fap(faps, epf=_epf(*blocks), baps=baps, bap_quant=0)))
    assert [(frame.coding_type, frame.baps) for frame in frames if frame.baps is not None] == [
        (0, {2: 10}), (1, {2: 1800}), (0, {2: 1790}), (None, {2: -7}),
    ]  # fmt: skip


_BODIES = st.lists(
    st.tuples(st.integers(0, 70), st.dictionaries(st.integers(1, 186), st.integers(-900, 900), max_size=3)),
    max_size=8,
    unique_by=lambda pair: pair[0],
)


@settings(max_examples=40)
@given(bodies=_BODIES, quant=st.integers(0, 6), period=st.integers(1, 4), ranges=st.sampled_from(["auto", "widen"]))
def test_baps_beside_segments_are_those_of_the_encoder(bodies: Values, quant: int, period: int, ranges: str) -> None:
    """All that is decoded was asked for, no farther off than half a step where nothing was clipped."""
    given_bodies = {number: values for number, values in sorted(bodies) if values}
    faps = _faps(*[(number, {3: number % 9, 4: -number}) for number in range(71)])
    findings: list[Finding] = []
    options = EncoderOptions(intra_period=period, ranges=ranges)
    baps = _baps(*given_bodies.items()) if given_bodies else None
    data = write_stream(encode_fap(faps, options, mode="dct", baps=baps, bap_quant=quant, on_finding=findings.append))
    frames = _decoded(data)
    assert len(frames) == 80
    assert not [frame for frame in frames if frame.baps is not None and frame.index % 16]
    clipped = any(finding.id == "value-clipped" for finding in findings)
    for first in range(0, 80, 16):
        decoded = frames[first].baps
        earlier = [number for number in given_bodies if first - 16 < number < first]
        source = first if first in given_bodies else max(earlier, default=None)
        assert (decoded is None) == (source is None)
        if decoded is None or source is None or clipped:
            continue
        assert decoded.keys() == given_bodies[source].keys()
        for number, value in decoded.items():
            assert abs(value - given_bodies[source][number]) <= step_of(number, quant) / 2


def step_of(number: int, quant: int) -> int:
    state = ParameterState(bap_set())
    state.selected = [number]
    state.quant, state.scale = quant, bap_set().quant_scale[quant]
    state.set_steps()
    return state.steps[0] or 1


@given(st.integers(-3, 3) | st.integers(), st.integers(0, 5000), st.integers(-2, 2))
def test_levels_are_the_nearest_multiples(multiple: int, step: int, off: int) -> None:
    """FBA-36: half a step and less is 0, else the nearest; the sign is that of the value."""
    x = multiple * step + step // 2 + off
    if step == 0:
        assert quantise(x, step) == x
    else:
        nearest = (abs(x) + step // 2) // step if abs(x) > step // 2 else 0
        assert quantise(x, step) == (nearest if x > 0 else -nearest)
