"""Bad input: always a decode or one located fault, in bounded memory and linear cost (CNF-7, CNF-21, CNF-22).

`check_input` holds the law: class of CNF-7, a registered rule, bits inside the input, and the same fault from the
decoder and the tracer. Emulated start codes (FBA-41) stand at the end.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from functools import cache, partial
from random import Random

import pytest
from fba_helpers import check_input, decoded, key, plain, traced
from hypothesis import given
from hypothesis import strategies as st
from plain_coder import guarded
from strategies import BAP_GROUPS, FAP_GROUPS, Planes, written

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.bitstream.source import BytesSource, Source
from snhc.reference_impl.entropy.kernel import segment_code
from snhc.reference_impl.entropy.model import Model
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaObject, FbaPlane
from snhc.reference_impl.syntax.base import STUFFED_CODE, ZERO_PADDING
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import (
    Options,
    decode_frames,
    decode_planes,
    read_stream,
    trace_stream,
    write_stream,
)
from snhc.reference_impl.systems.visual import StreamItem, VisualObjectHeader

EX2 = bytes.fromhex("000001bab1900192492e92000000049405172f000001b1")
EX3 = bytes.fromhex("000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1")
# Both planes of FBA-EX-3, up to bit 195, and 5 zero bits where the stuffing was.
EX3_PLANES = EX3[:24] + bytes([EX3[24] & 0xE0])
MIB = 1 << 20


def _object(planes: list[FbaPlane], *behind: StreamItem) -> list[StreamItem]:
    item = StreamItem(0x1BA)
    item.fba = FbaObject()
    item.fba.planes = planes
    return [item, *(behind or (StreamItem(0x1B1),))]


def _headers() -> list[StreamItem]:
    sequence, user, visual = StreamItem(0x1B0), StreamItem(0x1B2), StreamItem(0x1B5)
    sequence.profile = 0x63
    user.user_data = b"abc"
    visual.header = VisualObjectHeader()
    visual.header.type, visual.header.identifier, visual.header.verid = 4, 1, 2
    return [sequence, user, visual]


def _with_everything() -> bytes:
    """Headers, start codes, time code, skips, all range lists, FAP and BAP data."""
    make = Planes(Random(5))
    planes = [
        make.plane(intra=True, mask=3, boundary=STUFFED_CODE, quant=3, density=0.15, lists=15, style="uniform"),
        make.plane(intra=False, mask=0),
        make.plane(intra=False, mask=3, style="small"),
        make.plane(intra=True, mask=2, density=0.0, style="high"),
    ]
    first, second = planes[0].header, planes[1].header
    first.is_frame_rate, first.frame_rate, first.frequency_offset = 1, 30, 1
    first.is_time_code, first.time_code_hours, first.time_code_seconds = 1, 23, 59
    second.skip_frames, second.number_of_frames_to_skip = 1, 30
    return written([*_headers(), *_object(planes)], False)


SMALL = {"FBA-EX-2": EX2, "FBA-EX-3": EX3, "everything": _with_everything()}


@pytest.mark.parametrize("name", SMALL)
def test_cut_after_every_byte(name: str) -> None:
    data = SMALL[name]
    for count in range(len(data)):
        error = check_input(data[:count])
        # Behind the last plane only the end code is missing; a cut inside a plane never decodes to the end.
        assert count < 4 or error is None or error.error_class in ("Truncated", "InconsistentSemantics")


@pytest.mark.parametrize("name", SMALL)
@pytest.mark.parametrize("fill", [0, 1])
def test_cut_after_every_bit(name: str, fill: int) -> None:
    """Files have whole bytes: what is cut off in the last one reads as 0 or as 1 bits."""
    data = SMALL[name]
    number = int.from_bytes(data, "big")
    for bits in range(33, 8 * len(data)):
        size = (bits + 7) // 8
        cut = number >> (8 * len(data) - bits) << (8 * size - bits)
        cut |= ((1 << (8 * size - bits)) - 1) * fill
        check_input(cut.to_bytes(size, "big"))


@pytest.mark.parametrize("name", SMALL)
def test_every_single_bit_flip(name: str) -> None:
    data = bytearray(SMALL[name])
    classes = set()
    for bit in range(8 * len(data)):
        data[bit >> 3] ^= 0x80 >> (bit & 7)
        error = check_input(bytes(data))
        classes.add(error.error_class if error is not None else "")
        data[bit >> 3] ^= 0x80 >> (bit & 7)
    assert {"", "InputFormat", "MarkerBit", "InconsistentSemantics"} <= classes
    assert len(classes) >= 5


@given(st.binary(max_size=300))
def test_random_bytes(data: bytes) -> None:
    error = check_input(data)
    assert error is not None  # nothing begins with a start code by chance
    assert error.exit_code == (3 if error.error_class == "InputFormat" else 4)


@given(
    st.sampled_from(
        ("000001ba", "000001ba7f000001bb", "000001ba000001bb", "000001b061000001b523000001ba", "000001b59147000001b2",
         "000001bac0", "000001baa052492492492492", "000001bae0")
    ),
    st.binary(max_size=400),
    st.sampled_from((0xFF, 0xFF, 0x80, 0x11, 0x01)),
)  # fmt: skip
def test_random_bytes_behind_a_start(start: str, data: bytes, mask: int) -> None:
    """Sparse bytes bring runs of zero bits, guards and start codes."""
    check_input(bytes.fromhex(start) + bytes(byte & mask for byte in data))


@pytest.mark.parametrize(
    "data",
    [b"", b"\0", b"\0\0", b"\0\0\1", b"\xff\xff\xff", b"\0\0\1\xba"[:3], b"\0\0\0\1\xba", b"abcd", b"\0\0\1\x00"],
)
def test_no_known_start(data: bytes) -> None:
    """Fewer than 4 bytes, or no start code at their head: `InputFormat` over [0, min(32, bits)) (FBA-1, FBA-44)."""
    error = check_input(data)
    assert error is not None
    known_code = data == b"\0\0\1\x00"  # video_object: a visual stream, but not one that is built
    assert error.error_class == ("Unsupported" if known_code else "InputFormat")
    assert error.bits == (0, min(32, 8 * len(data)))
    assert error.exit_code == (4 if known_code else 3)


@pytest.mark.parametrize("text", ["2.1 name 25 10\n0 1 0\n", "# comment\n", "{}", "FBM 1\nFFR 0\n", "\ufeff2.1"])
def test_text_as_bitstream(text: str) -> None:
    error = check_input(text.encode())
    assert error is not None
    assert (error.error_class, error.rule) == ("InputFormat", "FBA-1")


@pytest.mark.parametrize("code", ["000001b1", "000001b2", "000001bb", "000001bd", "000001b6", "00000101"])
def test_streams_that_begin_with_something_else(code: str) -> None:
    error = check_input(bytes.fromhex(code) + bytes(8))
    assert error is not None
    assert error.bits == (0, 32)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        # What must come does not come before the end of the data: an empty span there, or what is left of it.
        ("000001b523", ("Truncated", "SYS-6", (40, 40))),
        ("000001b061000001b523", ("Truncated", "SYS-6", (80, 80))),
        ("000001b071", ("Truncated", "SYS-2", (40, 40))),
        ("000001b0710000", ("Truncated", "SYS-2", (40, 56))),
        ("000001b071000001b523000001", ("Truncated", "SYS-6", (80, 104))),
        ("000001b523000001b2616263", ("Truncated", "SYS-5", (40, 96))),
        ("000001b071000001b2112233", ("Truncated", "SYS-5", (40, 96))),
        # Something else comes instead.
        ("000001b061000001b1", ("InconsistentSemantics", "SYS-2", (40, 72))),
        ("000001b07112345678", ("InconsistentSemantics", "SYS-2", (40, 72))),
        ("000001b061000001ba7f000001b1", ("InconsistentSemantics", "SYS-2", (40, 72))),
        ("000001b061000001b061000001b523000001ba7f000001b1", ("InconsistentSemantics", "SYS-2", (40, 72))),
        ("000001b071000001b523000001b1", ("InconsistentSemantics", "SYS-6", (80, 112))),
        ("000001b071000001b523000001b0", ("InconsistentSemantics", "SYS-6", (80, 112))),
        ("000001b061000001b522000001ba7f000001b1", ("ForbiddenValue", "FBA-3", (77, 80))),
    ],
)
def test_headers_in_the_wrong_place(data: str, expected: tuple[str, str, tuple[int, int]]) -> None:
    """The grammar around the object, found by four independent decoders (SYS-2, SYS-3, SYS-5, SYS-6, CNF-21)."""
    error = check_input(bytes.fromhex(data))
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == expected


def test_a_sequence_may_begin_where_the_last_has_no_end() -> None:
    _, findings, error = traced(bytes.fromhex("000001b061000001b523000001ba7f" * 2 + "000001b1"))
    assert error is None
    assert [finding.id for finding in findings].count("no-end-code") == 1


def test_prefix_at_the_end_of_the_data() -> None:
    error = check_input(bytes.fromhex("000001ba07000001"))
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == ("Truncated", "FBA-44", (40, 64))


# -- much data in little memory ---------------------------------------------------------------------------------------


class Synthetic(Source):
    """`head`, then zero bytes up to `total`; counts what is asked for."""

    def __init__(self, head: bytes, total: int) -> None:
        self.head = head
        self.total = total
        self.calls = 0
        self.bytes = 0

    def read_at(self, offset: int, count: int) -> bytes:
        count = max(0, min(count, self.total - offset))
        self.calls += 1
        self.bytes += count
        return self.head[offset : offset + count].ljust(count, b"\0")

    def size(self) -> int:
        return self.total


class Counting(BytesSource):
    """Bytes that count what is asked for."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self.bytes = 0

    def read_at(self, offset: int, count: int) -> bytes:
        data = super().read_at(offset, count)
        self.bytes += len(data)
        return data


def _peak(work: Callable[[], object]) -> int:
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_100_mib_of_zeros_behind_an_object() -> None:
    """Padding, not 200 million planes (FBA-42)."""
    source = Synthetic(EX3_PLANES, 100 * MIB)
    frames: list[FaceFrame] = []
    findings: list[Finding] = []

    def work() -> None:
        nonlocal frames, findings
        frames, findings, error = decoded(source)
        assert error is None

    assert _peak(work) < 4 * MIB
    assert len(frames) == 2
    assert [finding.id for finding in findings] == ["no-sequence-header", "zero-padding", "no-end-code"]
    assert source.bytes < 102 * MIB
    assert traced(source) == (frames, findings, None)
    item = read_stream(source)[0]
    assert item.fba is not None
    assert item.fba.end == ZERO_PADDING
    assert item.fba.padding == 8 * 100 * MIB - item.fba.planes[-1].end


def test_100_mib_of_zeros() -> None:
    source = Synthetic(b"", 100 * MIB)
    _, _, error = decoded(source)
    assert error is not None
    assert (error.error_class, error.bits) == ("InputFormat", (0, 32))
    assert source.bytes < MIB
    assert key(traced(source)[2]) == key(error)


def test_padding_is_looked_for_once() -> None:
    """Each plane of a run of zeros asks whether only zeros are left: the answer may not cost a scan each time."""
    gap = 100 * MIB
    # 1,024 idle planes in zeros, and the limit before the end of the gap: no scan reaches over it twice.

    class Far(Synthetic):
        def read_at(self, offset: int, count: int) -> bytes:
            data = super().read_at(offset, count)
            last = self.total - 1 - offset
            return data[:last] + b"\1" if 0 <= last < len(data) else data

    source = Far(bytes.fromhex("000001ba"), gap)
    _, _, error = decoded(source)
    assert error is not None
    assert (error.error_class, error.rule) == ("ResourceLimit", "FBA-42")
    # The plane that passes the limit: the 1,025th of four bits each.
    assert error.bits == (32 + 4 * 1_024, 32 + 4 * 1_025)
    assert source.bytes < gap + MIB


def test_padding_writes_back_in_pieces() -> None:
    data = EX3_PLANES + bytes(MIB)
    assert write_stream(read_stream(data)) == data


def _long_stream(count: int) -> bytes:
    make = Planes(Random(3))
    planes = [make.plane(intra=True, mask=1, density=0.2, lists=15)]
    planes += [make.plane(intra=False, mask=1, style="small") for _ in range(count)]
    return written(_object(planes), False)


def test_memory_does_not_grow_with_the_stream() -> None:
    """Ten times the planes, the same peak, decoding and tracing (CNF-22)."""
    few, many = _long_stream(60), _long_stream(600)

    def walk(data: bytes) -> None:
        for _ in decode_frames(data):
            pass

    def trace(data: bytes) -> None:
        for _ in trace_stream(data):
            pass

    walk(few)  # tables and caches are loaded before the measurement
    trace(few)
    for work in (walk, trace):
        small, large = _peak(partial(work, few)), _peak(partial(work, many))
        # The window over the data may be larger by the data itself.
        assert large < small + 4 * (len(many) - len(few)) + 64 * 1024


def test_memory_of_20000_idle_planes() -> None:
    """Nothing but planes that are not kept: the peak of 20,000 is that of 2,000."""
    # Start code, then twice the four zero bits of an inter plane without data.
    planes = bytes.fromhex("7f000001bb00")
    peaks: list[int] = []
    for count in (2_000, 20_000):
        data = bytes.fromhex("000001ba") + planes * count + bytes.fromhex("7f000001b1")
        source = BytesSource(data)

        def work(source: Source = source, count: int = count) -> None:
            assert sum(1 for _ in decode_planes(source)) == 2 * count

        if not peaks:
            work()
        peaks.append(_peak(work))
    assert peaks[1] < peaks[0] + 256 * 1024


def test_cost_is_linear() -> None:
    """Ten times the planes read ten times the bytes: no part of the data is read over and over."""
    asked = []
    for count in (1_000, 10_000):
        data = _long_stream(count)
        source = Counting(data)
        assert sum(1 for _ in decode_planes(source)) == count + 1
        asked.append(source.bytes / len(data))
        # Once for the window, little more for its overlap and the look behind the end.
        assert source.bytes < 1.1 * len(data) + 4096
    assert asked[1] < 1.2 * asked[0]


# -- limits -----------------------------------------------------------------------------------------------------------


def test_idle_limit_can_be_lowered() -> None:
    make = Planes(Random(1))
    data = written(_object([make.plane(intra=False, mask=0) for _ in range(5)]), False)
    assert check_input(data, Options(limits=DEFAULT_LIMITS.with_values({"idle_planes": 5}))) is None
    frames, _, error = decoded(data, Options(limits=DEFAULT_LIMITS.with_values({"idle_planes": 4})))
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == ("ResourceLimit", "FBA-42", (48, 52))
    assert len(frames) == 4  # the plane that passes the limit is not given out


def test_skip_limit() -> None:
    """From the first group of 4 bits to the one that passes the limit (FBA-44)."""
    make = Planes(Random(1))
    plane = make.plane(intra=False, mask=0)
    plane.header.skip_frames = 1
    plane.header.number_of_frames_to_skip = 1_000_000
    data = written(_object([plane]), False)
    assert check_input(data) is None
    groups = 1_000_000 // 15 + 1
    number = int.from_bytes(data, "big")
    # The last group says 10: 15 * 66,666 + 10 = 1,000,000; made 11 it passes the limit.
    last = 36 + 4 * groups
    number += 1 << (8 * len(data) - last)
    error = check_input(number.to_bytes(len(data), "big"))
    assert error is not None
    assert (error.error_class, error.rule, error.bits) == ("ResourceLimit", "FBA-8", (36, last))
    error = check_input(data, Options(limits=DEFAULT_LIMITS.with_values({"skipped_frames": 29})))
    assert error is not None
    assert error.bits == (36, 44)  # 15 + 15


def test_user_data_limit() -> None:
    limits = DEFAULT_LIMITS.with_values({"user_data_bytes": 10})
    for count, accepted in ((10, True), (11, False)):
        item = StreamItem(0x1B2)
        item.user_data = b"x" * count
        make = Planes(Random(1))
        header = StreamItem(0x1B5)
        header.header = VisualObjectHeader()
        data = written([StreamItem(0x1B0), item, header, *_object([make.plane(intra=True, mask=0)])], False)
        error = check_input(data, Options(limits=limits))
        assert (error is None) == accepted
    assert error is not None
    assert (error.error_class, error.rule) == ("ResourceLimit", "CNF-22")
    assert error.bits == (40, 40 + 32 + 88)


def test_user_data_without_an_end_takes_no_memory() -> None:
    source = Synthetic(bytes.fromhex("000001b061000001b2") + b"\xff", 200 * MIB)
    peak = _peak(lambda: decoded(source))
    assert peak < 4 * MIB
    _, _, error = decoded(source)
    assert error is not None
    assert (error.error_class, error.rule) == ("ResourceLimit", "CNF-22")
    assert error.bits is not None and error.bits[1] <= 8 * source.total
    assert key(traced(source)[2]) == key(error)


# -- start codes that nobody wrote (FBA-41) ---------------------------------------------------------------------------


class Unprotected(Writer):
    """A writer that does not know FBA-41."""

    def protect(self, start: int) -> bool:
        return False


NARROW = 60  # v = 1: 121 symbols, about 7 zero bits for each highest one


@cache
def _levels_with_zeros(zeros: int, count: int) -> tuple[int, ...]:
    """`count` levels whose first inter segment opens with exactly so many zeros, guard or data bit 1 behind them."""
    for third in range(NARROW, NARROW - 40, -1):
        for fourth in range(NARROW, -NARROW - 1, -1):
            levels = [NARROW, NARROW, third, fourth, *[0] * (count - 4)]
            code, length = segment_code([Model(-NARROW, NARROW, True) for _ in levels], levels)
            if guarded(f"{code:0{length}b}").startswith("0" * zeros + "1"):
                return tuple(levels)
    raise AssertionError(f"no segment opens with {zeros} zeros")


def _align(plane: FbaPlane, alignment: int) -> None:
    """Header fields of 13, 18 and 4 bits: each `alignment` 0..7 makes the plane end at another bit of a byte."""
    h = plane.header
    h.is_frame_rate, h.frame_rate = alignment & 1, 25 * (alignment & 1)
    h.is_time_code = (alignment >> 1) & 1
    h.skip_frames = alignment >> 2


def _emulating(at: int) -> list[FbaPlane]:
    """An intra plane, and an inter plane that begins at bit `at` of a byte and reads as stuffing and 000001 there."""
    # S is 0 and 7 - at ones; the header takes its first bits, the rest of the 23 zeros and the 1 are the segment's.
    mask, skipped, zeros = {
        1: (2, None, 21),  # 01|0 0: mask 2, no skip
        2: (3, None, 22),  # 011|0
        3: (3, 0, 19),  # 0111|0000
        4: (3, 8, 20),  # 01111|000
        5: (3, 12, 21),  # 011111|00
        6: (3, 14, 22),  # 0111111|0
        7: (3, 15, 19),  # 01111111|0000: 15, 0
    }[7 - at]
    for alignment in range(8):
        make = Planes(Random(at))
        intra = make.plane(intra=True, mask=3, density=0.0, lists=15, style="zero")
        _align(intra, alignment)
        assert intra.faps is not None and intra.baps is not None
        for data, group, numbers in ((intra.faps, 3, FAP_GROUPS[3]), (intra.baps, 3, BAP_GROUPS[3])):
            data.mask_type[group] = 3
            for limits in data.limits:
                for number in numbers:
                    limits[number] = NARROW // 60
            data.levels = [make.rng.randint(-30, 30) for _ in numbers]
        written(_object([intra]), False)
        if intra.end % 8 == at:
            break
    else:
        raise AssertionError(f"no plane ends at bit {at}")
    inter = make.plane(intra=False, mask=mask)
    if skipped is not None:
        inter.header.skip_frames = 1
        inter.header.number_of_frames_to_skip = skipped
    if inter.faps is not None and inter.baps is not None:
        inter.faps.levels = list(_levels_with_zeros(zeros, len(FAP_GROUPS[3])))
        inter.baps.levels = [0, 1, -1, 0, 2, 0]
    elif inter.baps is not None:
        inter.baps.levels = list(_levels_with_zeros(zeros, len(BAP_GROUPS[3])))
    return [intra, inter]


@pytest.mark.parametrize("at", range(7))
def test_an_inter_plane_that_reads_as_a_start_code(at: int) -> None:
    planes = _emulating(at)
    bare = write_stream(_object(planes), Unprotected())
    first = planes[0]
    assert first.end % 8 == at
    prefix = (first.end + 8) // 8
    assert bare[prefix : prefix + 3] == b"\0\0\1"
    # Written without protection the stream is another one.
    assert len(decoded(bare)[0]) == 1
    items = _object(planes)
    data = written(items, False)
    assert (planes[1].boundary, planes[1].start_code) == (STUFFED_CODE, 0x1BB)
    back = read_stream(data)
    assert plain(back) == plain(items)
    assert written(back, False) == data
    assert check_input(data) is None


@pytest.mark.parametrize("count", range(4, 40))
def test_zero_planes_that_read_as_a_start_code(count: int) -> None:
    """Planes without data are zero bits; the 1 of the prefix comes from the plane behind the run (FBA-41)."""
    emulated = []
    for alignment in range(8):
        make = Planes(Random(count))
        planes = [make.plane(intra=True, mask=1, density=0.2)]
        _align(planes[0], alignment)
        planes += [make.plane(intra=False, mask=0) for _ in range(count)]
        planes.append(make.plane(intra=True, mask=count & 1))
        bare = write_stream(_object(planes), Unprotected())
        items = _object(planes)
        data = written(items, False)
        assert plain(read_stream(data)) == plain(items)
        assert written(read_stream(data), False) == data
        if data != bare:
            emulated.append(planes[0].end % 8)
            frames, _, error = decoded(bare)
            assert error is not None or len(frames) != count + 2
    # S is the single 0 at bit 7: a run whose planes begin there, 24 zero bits before its end. It may also begin at
    # bit 3, every second plane then begins at bit 7.
    assert set(emulated) == ({7} if count % 2 == 0 else {3}) if count >= 6 else not emulated
