"""The laws of streams with DCT segments (DCT rules, FBA-41, FBA-43, CNF-21), on generated records."""

from __future__ import annotations

from fractions import Fraction

from fba_helpers import check_partition, decoded, frames_of, traced
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies_dct import DCT_ELEMENTS, DctStream, check_plainly, dct_streams, plain

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.dct_transform import ac_step, dc_step
from snhc.reference_impl.face.fap_text import FapFile, FapTextFrame
from snhc.reference_impl.syntax.temporal import Clock, TemporalHeader
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.stream import decode_frames, read_stream, trace_stream, write_stream


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
    check_plainly(write_stream(stream.items))


@given(
    st.integers(0, 255),
    st.integers(0, 15),
    st.booleans(),
    st.integers(0, 86_399),
    st.integers(0, 40),
    st.integers(0, 15),
)
def test_times_of_instants_are_exact_sums(
    rate: int, sixteenths: int, by_1001: bool, code: int, skipped: int, instant: int
) -> None:
    header = TemporalHeader()
    header.is_frame_rate, header.frame_rate, header.seconds, header.frequency_offset = 1, rate, sixteenths, int(by_1001)
    header.is_time_code, header.time_code_hours = 1, code // 3600
    header.time_code_minutes, header.time_code_seconds = code // 60 % 60, code % 60
    clock = Clock()
    clock.tick(header, True)
    later = TemporalHeader()
    later.number_of_frames_to_skip = skipped
    time = clock.tick(later, True)
    wanted = Fraction(*time) + instant / clock.rate
    assert clock.after(time, instant) == (wanted.numerator, wanted.denominator)


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


SELECTS = st.tuples(st.integers(0, 14), st.integers(0, 14), st.integers(0, 63), st.integers(0, 1))
SHOWN = st.tuples(
    st.integers(0, 6), st.integers(0, 63), st.integers(0, 6), st.integers(0, 63), st.integers(0, 1), st.integers(0, 1)
)


@given(st.lists(st.tuples(SELECTS, SHOWN), min_size=1, max_size=36), st.integers(0, 31))
def test_visemes_and_expressions_are_coded_without_loss(
    instants: list[tuple[tuple[int, int, int, int], tuple[int, int, int, int, int, int]]], quant: int
) -> None:
    """Blend and intensities are not scaled in this mode (DCT-11); the last segment repeats its last instant."""
    text = FapFile(nframes=len(instants), frame_rate=Fraction(30))
    mask = (1, 1) + (0,) * 66
    for number, (viseme, expression) in enumerate(instants):
        text.frames.append(FapTextFrame(number, mask, [None] * 68, viseme, expression))
    frames = decoded(write_stream(encode_fap(text, quant=quant, mode="dct")))[0]
    assert len(frames) % 16 == 0
    padded = instants + [instants[-1]] * (len(frames) - len(instants))
    assert [(frame.viseme, frame.expression) for frame in frames] == padded
