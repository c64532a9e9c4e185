"""The laws of streams with DCT segments (DCT rules, FBA-41, FBA-43, CNF-21), on generated records."""

from __future__ import annotations

from fractions import Fraction

from fba_helpers import check_partition, decoded, frames_of, traced
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_dct import PlainPayload, values
from strategies_dct import DctStream, dct_streams, plain

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.dct_transform import ac_step, dc_step
from snhc.reference_impl.face.fap_text import FapFile, FapTextFrame
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.stream import decode_frames, read_stream, trace_stream, write_stream

DCT_ELEMENTS = {
    "dc", "dc_escape", "dc_difference", "dc_difference_escape", "dc_difference_escape_wide", "run", "ac", "ac_escape",
    "ac_escape_wide", "viseme_select1", "viseme_select1_difference", "expression_select1",
    "expression_select1_difference",
}  # fmt: skip


@given(dct_streams())
def test_read_of_written_is_the_record(stream: DctStream) -> None:
    data = write_stream(stream.items)
    back = read_stream(data)
    assert plain(back) == plain(stream.items)
    assert write_stream(back) == data


@given(dct_streams())
def test_trace_partitions_and_tracer_agrees(stream: DctStream) -> None:
    data = write_stream(stream.items)
    check_partition(data)
    frames, findings, error = decoded(data)
    assert error is None
    assert frames == frames_of(stream.items)
    assert traced(data) == (frames, findings, None)


@given(dct_streams(odd=False))
def test_a_writer_never_escapes_without_need(stream: DctStream) -> None:
    findings: list[Finding] = []
    read_stream(write_stream(stream.items), on_finding=findings.append)
    assert [finding for finding in findings if finding.id == "non-canonical"] == []


@given(dct_streams())
def test_a_plain_decoder_agrees(stream: DctStream) -> None:
    data = write_stream(stream.items)
    second = PlainPayload(f"{int.from_bytes(data, 'big'):0{8 * len(data)}b}")
    coded: list[int] = []
    quant = 0
    for part in trace_stream(data):
        plane = part.plane
        if plane is None or plane.faps is None:
            continue
        rows = list(part.trace.rows())
        if plane.is_intra:
            quant = plane.faps.quant
            state = plane.frames[0].state
            coded = [i for i, letter in enumerate(state, 1) if letter == "T"]
        segment = plane.faps.segment
        if segment is None:
            continue
        first = [start for el, start, _, _, _ in rows if el.name in DCT_ELEMENTS][:1]
        viseme, expression, runs = second.payload(first[0] if first else rows[-1][2], coded, bool(plane.is_intra))
        assert [row[:3] for row in viseme] == segment.viseme
        assert [row[3] for row in viseme] == segment.viseme_def
        assert [row[:4] for row in expression] == segment.expression
        assert [row[4] for row in expression] == segment.init_face
        assert [row[5] for row in expression] == segment.expression_def
        # Of an inter DC the record holds the difference.
        assert [c[1:] for c in runs.values()] == [run.coefficients()[1:] for run in segment.runs]
        body = [start for _, start, _, _, path in rows if ".bap" in path]
        if first:
            assert second.at == (body[0] if body else plane.end)
        for fap, c in runs.items():
            for t, (wanted, frame) in enumerate(zip(values(fap, quant, c), plane.frames, strict=True)):
                got = frame.faps[fap - 1]
                assert got is not None
                assert abs(got - wanted) <= 0.5 + 1e-9 * (1 + sum(map(abs, c)) * float(ac_step(fap, quant))), (fap, t)


def test_the_strategy_reaches_what_it_should() -> None:
    seen: set[str] = set()

    @settings(max_examples=120, derandomize=True, database=None)
    @given(dct_streams())
    def look(stream: DctStream) -> None:
        for part in trace_stream(write_stream(stream.items)):
            seen.update(finding.id for finding in part.findings)
            seen.update(el.name for el, *_ in part.trace.rows())
            if part.plane is not None:
                seen.update(f"state {frame.state[i]}" for frame in part.plane.frames[:1] for i in range(2, 68))

    look()
    assert seen >= DCT_ELEMENTS | {
        "non-canonical", "bap_segment", "fap_segment", "state T", "state I", "state R", "state U", "viseme_def",
        "init_face", "number_of_frames_to_skip", "frame_rate",
    }  # fmt: skip


@settings(max_examples=60)
@given(
    st.lists(st.integers(-400, 400), min_size=1, max_size=40),
    st.integers(0, 20),
    st.sampled_from((3, 5, 19, 48, 61)),
)
def test_the_encoders_error_is_bounded_by_the_steps(curve: list[int], quant: int, fap: int) -> None:
    """Each coefficient is off by half a step: sqrt(2/16) of it for AC, 1/4 for DC, and 1/2 for the rounding.

    Sixteen times the largest of each is a bound for every value (the cosines are at most 1).
    """
    text = FapFile(nframes=len(curve), frame_rate=Fraction(25))
    mask = tuple(int(i == fap) for i in range(1, 69))
    for number, value in enumerate(curve):
        text.frames.append(FapTextFrame(number, mask, [value if i == fap else None for i in range(1, 69)]))
    findings: list[Finding] = []
    data = write_stream(encode_fap(text, quant=quant, mode="dct", on_finding=findings.append))
    frames = list(decode_frames(data))
    assert len(frames) == (len(curve) + 15) // 16 * 16
    assert [f.id for f in findings] == (["encode-extended"] if len(curve) % 16 else [])
    bound = 15 * 0.3535533906 * float(ac_step(fap, quant)) / 2 + 0.25 * float(dc_step(fap, quant)) / 2 + 0.5 + 1e-6
    for frame, value in zip(frames, curve + [curve[-1]] * 16, strict=False):
        got = frame.faps[fap - 1]
        assert got is not None
        assert abs(got - value) <= bound
