"""The laws that hold for every face stream (FBA-41, FBA-43, CNF-21).

read(write(x)) == x; write(read(bytes)) == bytes; the spans of a trace partition the stream; tracer and reader agree.
"""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest
from fba_helpers import check_partition, decoded, frames_of, plain, traced
from hypothesis import given, settings
from strategies import FAP_GROUPS, FAP_STEPS, Planes, Stream, streams, written

from snhc.reference_impl.bitstream.cursor import BitCursor
from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.records import FbaObject
from snhc.reference_impl.syntax.base import STUFFED_CODE
from snhc.reference_impl.syntax.tracer import Tracer
from snhc.reference_impl.systems.stream import read_stream, trace_stream
from snhc.reference_impl.systems.visual import StreamItem, fresh_items, visual_stream


@given(streams())
def test_read_of_written_is_the_record(stream: Stream) -> None:
    back = read_stream(stream.data, stream.options)
    # The writer's pass left its spans, frames and protecting start codes in the records.
    assert plain(back) == plain(stream.items)


@given(streams())
def test_written_again_identically(stream: Stream) -> None:
    back = read_stream(stream.data, stream.options)
    assert written(back, stream.options.draft) == stream.data


@given(streams())
def test_spans_partition_the_stream(stream: Stream) -> None:
    check_partition(stream.data, stream.options)


@given(streams())
def test_tracer_and_reader_agree(stream: Stream) -> None:
    findings: list[Finding] = []
    fast = read_stream(stream.data, stream.options, findings.append)
    gathered: list[Finding] = []
    io = Tracer(BitCursor.of(stream.data), draft=stream.options.draft, on_finding=gathered.append, collect=True)
    literal: list[StreamItem] = []
    for item, plane in visual_stream(io, fresh_items()):
        if plane is not None:
            assert item.fba is not None
            item.fba.planes.append(plane)
        elif item.fba is None or not item.end:
            literal.append(item)
    assert plain(literal) == plain(fast)
    assert gathered == findings


@given(streams())
def test_decoder_gives_the_frames_of_the_writers_pass(stream: Stream) -> None:
    frames, findings, error = decoded(stream.data, stream.options)
    assert error is None
    assert frames == frames_of(stream.items)
    frames_traced, findings_traced, error_traced = traced(stream.data, stream.options)
    assert error_traced is None
    assert frames_traced == frames
    # The tracer walks all objects; what the decoder reports of the first one, it reports too.
    if all(finding.id != "trailing-data" for finding in findings):
        assert findings_traced == findings


@given(streams())
def test_times_are_exact_fractions(stream: Stream) -> None:
    """FBA-37, FBA-38 with nothing but fractions: the running time, the rate in force, time codes, skipped frames."""
    for item in read_stream(stream.data, stream.options):
        running, rate = Fraction(0), Fraction(30)
        for plane in item.fba.planes if item.fba is not None else ():
            h = plane.header
            if h.is_frame_rate:
                rate = (h.frame_rate + Fraction(h.seconds, 16)) * (Fraction(1000, 1001) if h.frequency_offset else 1)
            if h.is_time_code:
                running = Fraction(3600 * h.time_code_hours + 60 * h.time_code_minutes + h.time_code_seconds)
            assert [frame.time for frame in plane.frames] == [running.as_integer_ratio()]
            running += (h.number_of_frames_to_skip + 1) / rate


@given(streams())
def test_values_and_states_follow_from_levels(stream: Stream) -> None:
    """FBA-31, FBA-32, FBA-34 by the letter, FAP by FAP: level, step, previous value; T, R, I, U."""
    for item in read_stream(stream.data, stream.options):
        values: dict[int, int] = {}
        state = dict.fromkeys(range(1, 69), "U")
        coded: list[int] = []
        quant = 0
        for plane in item.fba.planes if item.fba is not None else ():
            frame = plane.frames[0]
            data = plane.faps
            if data is None:
                state = {n: "R" if letter == "T" else letter for n, letter in state.items()}
            else:
                if plane.is_intra:
                    quant = data.quant
                    coded = []
                    for group, kind, mask in zip(FAP_GROUPS, data.mask_type, data.group_mask, strict=True):
                        for place, n in enumerate(group):
                            sent = kind == 3 or (kind in (1, 2) and mask >> (len(group) - 1 - place) & 1 == 1)
                            coded += [n] * sent
                            ever = state[n] in "TR" or n in values
                            state[n] = "T" if sent else "I" if kind == 2 else "R" if ever else "U"
                            if sent:
                                values.setdefault(n, 0)
                else:
                    state = {n: "T" if n in coded else letter for n, letter in state.items()}
                for n, level in zip([n for n in coded if n > 2], data.levels, strict=True):
                    step = FAP_STEPS[n] * quant if quant else 1
                    values[n] = level * step + (0 if plane.is_intra else values[n])
            assert frame.state == "".join(state.values())
            shown = [values.get(n) if state[n] in "TR" and n > 2 else None for n in range(1, 69)]
            assert list(frame.faps) == shown
            assert (frame.viseme is None) == (state[1] in "IU")
            assert (frame.expression is None) == (state[2] in "IU")


@given(streams(draft=True))
def test_draft_codes_are_refused_without_the_option(stream: Stream) -> None:
    first = next(item for item in stream.items if item.fba is not None)
    if first.fba is not None and first.fba.start_code == 0x101:
        _, _, error = decoded(stream.data)
        assert error is not None
    findings = traced(stream.data, stream.options)[1]
    draft_codes = sum(
        (item.code == 0x101) + sum(plane.start_code == 0x103 for plane in item.fba.planes)
        for item in stream.items
        if item.fba is not None
    )
    assert sum(finding.id == "draft-start-code" for finding in findings) == draft_codes


def test_strategy_reaches_what_it_should() -> None:
    """Guards in segments, rescales and the rest are of no use if they never come up."""
    seen: set[str] = set()

    @settings(max_examples=150, derandomize=True, database=None)
    @given(streams())
    def look(stream: Stream) -> None:
        for part in trace_stream(stream.data, stream.options):
            seen.update(finding.id for finding in part.findings)
            for segment, _ in part.trace.segments.values():
                if segment.guards:
                    seen.add("guard")
                if any(step.symbols == 1 for step in segment.steps):
                    seen.add("range 0..0")
                if not segment.steps:
                    seen.add("empty segment")
            for element, _, _, value, _ in part.trace.rows():
                seen.add(f"{element.name}={value}" if element.name == "fap_mask_type" else element.name)
                if element.name == "number_of_frames_to_skip" and value == 15:
                    seen.add("skip escape")

    look()
    assert seen >= {
        "guard", "range 0..0", "empty segment", "skip escape", "fap_mask_type=0", "fap_mask_type=1",
        "fap_mask_type=2", "fap_mask_type=3", "time_code_seconds", "frame_rate", "viseme_def", "init_face",
        "bap_segment", "fap_new_i_max", "fap_new_p_min", "bap_new_i_min", "user_data", "visual_object_priority",
        "trailing_data", "zero_padding", "no-end-code", "no-stuffing", "zero-padding", "trailing-data",
        "empty-object", "time-code-back", "draft-start-code", "no-sequence-header", "profile-unknown",
        "intensity-range",
    }  # fmt: skip


def _object(planes: list, end: bool = True) -> list[StreamItem]:
    item = StreamItem(0x1BA)
    item.fba = FbaObject()
    item.fba.planes = planes
    return [item, StreamItem(0x1B1)] if end else [item]


def test_20000_planes_with_rescales() -> None:
    """Few FAPs over 20,000 inter planes: every P model passes Max_frequency and halves (FBA-24)."""
    make = Planes(Random(5))
    planes = [make.plane(intra=True, mask=1, density=0.0, lists=15)]
    # FAP 3 and FAP 48: small and large alphabet would both rescale after 16383 - n planes.
    make.faps.limits = {3: [60, -60, 60, -60], 48: [60, -60, 600, -600]}
    make.faps.selected = [3, 48]
    data = planes[0].faps
    assert data is not None
    data.mask_type[1] = data.mask_type[6] = 1
    data.group_mask[1] = 1 << 15
    data.group_mask[6] = 1 << 2
    data.new = [1, 1, 1, 1]
    for which, (v3, v48) in enumerate(((1, 1), (1, 1), (1, 10), (1, 10))):
        data.limits[which][3], data.limits[which][48] = v3, v48
    data.levels = [0, 0]
    planes += [make.plane(intra=False, mask=1, style="small") for _ in range(20_000)]
    items = _object(planes)
    stream = written(items, False)
    back = read_stream(stream)
    assert plain(back) == plain(items)
    assert written(back, False) == stream
    rescaled = {3: 0, 48: 0}
    last = None
    for part in trace_stream(stream):
        for segment, _ in part.trace.segments.values():
            for number, step in zip((3, 48), segment.steps, strict=True):
                rescaled[number] += step.rescaled
        if part.plane is not None:
            last = part.plane.frames
    assert rescaled == {3: 1, 48: 1}
    assert last == planes[-1].frames


@pytest.mark.parametrize("count", [4, 5, 6, 7, 60, 1_023])
@pytest.mark.parametrize("seed", range(12))
def test_runs_of_planes_without_data(count: int, seed: int) -> None:
    """A run of zero bits and the plane behind it may emulate a start code at any alignment (FBA-41)."""
    make = Planes(Random(seed))
    planes = [make.plane(intra=True, mask=1, density=0.3)]
    planes += [make.plane(intra=False, mask=0) for _ in range(count)]
    # Planes whose first 1 bit comes after 3, 1 and 0 more zero bits.
    skipping = make.plane(intra=False, mask=0)
    skipping.header.skip_frames = 1
    planes += [skipping, make.plane(intra=False, mask=1), make.plane(intra=True, mask=0)]
    items = _object(planes)
    stream = written(items, False)
    back = read_stream(stream)
    assert plain(back) == plain(items)
    assert len(frames_of(back)) == count + 4
    assert written(back, False) == stream


def test_idle_planes_are_counted_from_a_start_code() -> None:
    """The plane with the start code is the first of the 1,024 (FBA-42, FBA-44); the writer refuses like a reader."""
    make = Planes(Random(1))
    planes = [make.plane(intra=True, mask=0)]
    planes += [make.plane(intra=False, mask=0) for _ in range(1_024)]
    with pytest.raises(EncodeError) as caught:
        written(_object(planes), False)
    assert caught.value.rule == "FBA-42"
    planes[1].boundary, planes[1].start_code = STUFFED_CODE, 0x1BB
    items = _object(planes)
    assert plain(read_stream(written(items, False))) == plain(items)
    planes.insert(2, make.plane(intra=False, mask=0))
    with pytest.raises(EncodeError):
        written(_object(planes), False)


def test_an_end_that_reads_as_padding_is_refused() -> None:
    make = Planes(Random(1))
    items = _object([make.plane(intra=True, mask=0), make.plane(intra=False, mask=0)], end=False)
    for kind in (3, 4, 5):  # STUFFED_END, END, ZERO_PADDING
        assert items[0].fba is not None
        items[0].fba.end = kind
        items[0].fba.padding = 14 if kind == 5 else 0
        try:
            stream = written(items, False)
        except EncodeError as error:
            assert error.rule in ("FBA-3", "FBA-42")
        else:
            assert plain(read_stream(stream)) == plain(items)
