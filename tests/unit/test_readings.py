"""Each reading of an AMB-FBA ambiguity changes what it is about, and nothing else (CNF-24)."""

from __future__ import annotations

from random import Random

import pytest
from fba_helpers import case_files, case_names, check_error, decoded, traced
from strategies import FAP_DEFAULTS, Planes, written

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaObject, FbaPlane
from snhc.reference_impl.rules import ambiguities
from snhc.reference_impl.syntax.base import BARE_CODE
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import Options, read_stream, write_stream
from snhc.reference_impl.systems.visual import StreamItem

FOLLOWED = {
    "AMB-FBA-1": "lowest-first", "AMB-FBA-2": "table", "AMB-FBA-3": "rederived", "AMB-FBA-4": "none",
    "AMB-FBA-5": "base_step", "AMB-FBA-6": "after", "AMB-FBA-7": "header", "AMB-FBA-8": "accept",
    "AMB-FBA-9": "padding",
}  # fmt: skip


def _object(planes: list[FbaPlane]) -> list[StreamItem]:
    item = StreamItem(0x1BA)
    item.fba = FbaObject()
    item.fba.planes = planes
    return [item, StreamItem(0x1B1)]


def _read(data: bytes, **chosen: str) -> tuple[list[FaceFrame], SnhcError | None]:
    options = Options(readings=Readings({f"AMB-FBA-{id[1:]}": key for id, key in chosen.items()}))
    frames, _, error = decoded(data, options)
    frames_traced, _, error_traced = traced(data, options)
    assert frames == frames_traced
    assert (error and error.as_json()) == (error_traced and error_traced.as_json())
    return frames, error


def _accepted(data: bytes, **chosen: str) -> list[FaceFrame]:
    frames, error = _read(data, **chosen)
    assert error is None
    return frames


def test_register_names_the_same_readings() -> None:
    register = ambiguities()
    for id, followed in FOLLOWED.items():
        assert next(iter(register[id].readings)) == followed
        assert len(register[id].readings) >= 2


@pytest.mark.parametrize("name", case_names("fba"))
def test_naming_the_reading_followed_changes_nothing(name: str) -> None:
    case, data, _ = case_files("fba", name)
    if case["profile"] == "long":
        data = data[:600]
    readings = Readings(FOLLOWED)
    assert readings.chosen == FOLLOWED
    wanted, given = decoded(data), decoded(data, Options(readings=readings))
    assert given[:2] == wanted[:2]
    assert str(given[2]) == str(wanted[2])


def _one_group(group: int, mask: int, levels: list[int], mask_type: int = 1) -> FbaPlane:
    plane = Planes(Random(1)).plane(intra=True, mask=1, density=0.0)
    assert plane.faps is not None
    plane.faps.mask_type[group], plane.faps.group_mask[group] = mask_type, mask
    plane.faps.levels = levels
    return plane


def test_1_mask_order() -> None:
    # Group 7 is FAPs 48, 49, 50, all with the same limits: mask 100 is FAP 48, or read as an integer FAP 50.
    data = written(_object([_one_group(6, 0b100, [7])]), False)
    (ours,) = _accepted(data)
    (other,) = _accepted(data, _1="highest-first")
    assert (ours.faps[47], ours.faps[49]) == (7 * 170, None)
    assert (other.faps[47], other.faps[49]) == (None, 7 * 170)
    assert [ours.state[i] for i in (47, 48, 49)] == ["T", "U", "U"]
    assert [other.state[i] for i in (47, 48, 49)] == ["U", "U", "T"]
    # A palindrome and a whole group read alike.
    for mask in (0b101, 0b111):
        data = written(_object([_one_group(6, mask, [1] * mask.bit_count())]), False)
        assert _accepted(data) == _accepted(data, _1="highest-first")


def test_1_mask_order_of_bodies() -> None:
    plane = Planes(Random(1)).plane(intra=True, mask=2, density=0.0)
    assert plane.baps is not None
    plane.baps.mask_type[0], plane.baps.group_mask[0], plane.baps.levels = 1, 0b100, [5]
    data = written(_object([plane]), False)
    assert list(_accepted(data)[0].baps or ()) == [1]
    assert list(_accepted(data, _1="highest-first")[0].baps or ()) == [3]


def test_2_default_range_of_fap_47() -> None:
    assert FAP_DEFAULTS[47] == [300, -300, 60, -60]
    # FAP 47 is the last of group 6 (43..47).
    data = written(_object([_one_group(5, 0b00001, [300])]), False)
    assert _accepted(data)[0].faps[46] == 300 * 512
    _, error = _read(data, _2="wide")
    wide_data = _written_with(Readings({"AMB-FBA-2": "wide"}), [_one_group(5, 1, [1080])])
    wide = _accepted(wide_data, _2="wide")
    assert wide[0].faps[46] == 1080 * 512
    assert wide_data != data
    # The 2,161 symbols of the wide range make another segment of the same bits.
    assert error is not None or _accepted(data, _2="wide")[0].faps[46] != 300 * 512
    # Every other FAP, and FAP 47 with sent limits, read alike.
    data = written(_object([_one_group(5, 0b11110, [3, -3, 0, 1])]), False)
    assert _accepted(data) == _accepted(data, _2="wide")
    sent = _one_group(5, 1, [60])
    assert sent.faps is not None
    sent.faps.new = [1, 1, 1, 1]
    sent.faps.limits = [[0] * 69 for _ in range(4)]
    for limits in sent.faps.limits:
        limits[47] = 1
    data = written(_object([sent]), False)
    assert _accepted(data) == _accepted(data, _2="wide")


def _written_with(readings: Readings, planes: list[FbaPlane]) -> bytes:
    return write_stream(_object(planes), Writer(readings=readings))


def _quantised(quant: int, levels: list[int], lists: bool) -> FbaPlane:
    plane = _one_group(6, 0b111, levels)
    assert plane.faps is not None
    plane.faps.quant = quant
    if lists:
        plane.faps.new = [1, 1, 1, 1]
        plane.faps.limits = [[0] * 69 for _ in range(4)]
        for limits in plane.faps.limits:
            limits[48:51] = [2, 2, 2]
    return plane


def test_3_limits_after_a_change_of_fap_quant() -> None:
    # 120 / 4 = 30; not sent again with fap_quant 1: 120, or kept as the 30 that they were.
    planes = [_quantised(4, [30, 0, -30], True), _quantised(1, [30, -30, 29], False)]
    ours = written(_object(planes), False)
    kept = _written_with(Readings({"AMB-FBA-3": "kept"}), planes)
    assert ours != kept
    values = [frame.faps[47:50] for frame in _accepted(ours)]
    assert values == [(30 * 680, 0, -30 * 680), (30 * 170, -30 * 170, 29 * 170)]
    assert [frame.faps[47:50] for frame in _accepted(kept, _3="kept")] == values
    # All four lists in every intra plane: both readings agree, as they do while fap_quant stays.
    for second in (_quantised(1, [30, -30, 29], True), _quantised(4, [30, -30, 29], False)):
        data = written(_object([planes[0], second]), False)
        assert _accepted(data) == _accepted(data, _3="kept")


def test_4_clipping() -> None:
    make = Planes(Random(1))
    intra = _one_group(6, 0b100, [1860])
    inter = make.plane(intra=False, mask=1)
    assert inter.faps is not None
    inter.faps.levels = [600]
    back = make.plane(intra=False, mask=1)
    assert back.faps is not None
    back.faps.levels = [-600]
    data = written(_object([intra, inter, back]), False)
    assert [frame.faps[47] for frame in _accepted(data)] == [1860 * 170, 2460 * 170, 1860 * 170]
    # Clipped before it predicts the next one.
    assert [frame.faps[47] for frame in _accepted(data, _4="clip")] == [1860 * 170, 1860 * 170, 1260 * 170]
    inter.faps.levels = [0]
    data = written(_object([intra, inter, back]), False)
    assert _accepted(data) == _accepted(data, _4="clip")


def test_4_clipping_of_blend_and_intensities() -> None:
    intra = _one_group(0, 0, [], mask_type=3)
    assert intra.faps is not None
    intra.faps.quant = 2
    intra.faps.viseme = [3, 4, 32]  # M = 32; 32 * 2 = 64
    intra.faps.expression = [1, 30, 2, 0]
    inter = Planes(Random(1)).plane(intra=False, mask=1)
    assert inter.faps is not None
    inter.faps.viseme, inter.faps.expression = [0, 0, -1], [0, 10, 0, -5]
    data = written(_object([intra, inter]), False)
    ours, clipped = _accepted(data), _accepted(data, _4="clip")
    assert [frame.viseme and frame.viseme[:3] for frame in ours] == [(3, 4, 64), (3, 4, 62)]
    assert [frame.viseme and frame.viseme[:3] for frame in clipped] == [(3, 4, 63), (3, 4, 61)]
    assert [frame.expression and frame.expression[:4] for frame in ours] == [(1, 60, 2, 0), (1, 80, 2, -10)]
    assert [frame.expression and frame.expression[:4] for frame in clipped] == [(1, 60, 2, 0), (1, 63, 2, 0)]


def test_5_base_steps_of_bodies() -> None:
    plane = Planes(Random(1)).plane(intra=True, mask=2, density=0.0, quant=1)
    assert plane.baps is not None
    plane.baps.mask_type[0], plane.baps.levels = 3, [5, 0, -1]
    data = written(_object([plane]), False)
    ours, other = _accepted(data), _accepted(data, _5="variant_b")
    # bap_table.csv: base_step 64, base_step_variant_b 170.
    assert ours[0].baps == {1: 5 * 64, 2: 0, 3: -64}
    assert other[0].baps == {1: 5 * 170, 2: 0, 3: -170}
    assert ours[0].faps == other[0].faps
    plane.baps.quant = 0
    data = written(_object([plane]), False)
    assert _accepted(data)[0].baps == _accepted(data, _5="variant_b")[0].baps == {1: 5, 2: 0, 3: -1}


def test_6_skipped_frames() -> None:
    make = Planes(Random(1))
    planes = [make.plane(intra=True, mask=0), make.plane(intra=False, mask=0), make.plane(intra=False, mask=0)]
    planes[1].header.skip_frames, planes[1].header.number_of_frames_to_skip = 1, 4
    data = written(_object(planes), False)
    # Periods of 1/30: 0, 1, then 1 + 4 + 1; or 0, 1 + 4, then 6.
    assert [frame.time for frame in _accepted(data)] == [(0, 1), (1, 30), (1, 5)]
    assert [frame.time for frame in _accepted(data, _6="before")] == [(0, 1), (1, 6), (1, 5)]
    planes[1].header.number_of_frames_to_skip = 0
    data = written(_object(planes), False)
    assert _accepted(data) == _accepted(data, _6="before")


def test_6_a_time_code_wins_over_frames_skipped_before_it() -> None:
    plane = Planes(Random(1)).plane(intra=True, mask=0)
    h = plane.header
    h.is_time_code, h.time_code_seconds, h.skip_frames, h.number_of_frames_to_skip = 1, 7, 1, 3
    data = written(_object([plane, Planes(Random(1)).plane(intra=False, mask=0)]), False)
    assert [frame.time for frame in _accepted(data)] == [(7, 1), (107, 15)]  # 7 + 4/30
    assert _accepted(data, _6="before")[0].time == (7, 1)


def test_7_header_of_planes_without_data() -> None:
    planes = [Planes(Random(1)).plane(intra=intra, mask=0) for intra in (True, False, True)]
    bare = _written_with(Readings({"AMB-FBA-7": "bare"}), planes)
    # 100 000 100: three bits each, then stuffing 0111111.
    assert bare == bytes.fromhex("000001ba") + bytes([0b10000010, 0b00111111]) + bytes.fromhex("000001b1")
    assert [frame.time for frame in _accepted(bare, _7="bare")] == [(0, 1), (1, 30), (1, 15)]
    with_data = written(_object([_one_group(6, 0b111, [1, 2, 3])]), False)
    assert _accepted(with_data) == _accepted(with_data, _7="bare")


def test_8_plane_code_directly_behind_the_object_code() -> None:
    plane = Planes(Random(1)).plane(intra=True, mask=0, boundary=BARE_CODE)
    data = written(_object([plane]), False)
    assert data[:8] == bytes.fromhex("000001ba000001bb")
    assert len(_accepted(data)) == 1
    _, error = _read(data, _8="error")
    assert error is not None
    check_error(error, 8 * len(data))
    assert (error.rule, error.bits) == ("FBA-3", (32, 64))
    # As plane data the code is zero bits first: planes without data.
    frames, error = _read(data, _8="plane-data")
    assert len(frames) > 1 or error is not None
    plane.boundary, plane.start_code = 1, 0x1BB
    data = written(_object([plane]), False)
    assert _accepted(data) == _accepted(data, _8="error") == _accepted(data, _8="plane-data")


def test_9_zeros_at_the_end() -> None:
    data = bytes.fromhex("000001ba80") + b"\0"
    # 1 00 0 0 0 is an intra plane; 10 zero bits: padding, or two planes and two bits too few for a third.
    assert len(_accepted(data)) == 1
    frames, error = _read(data, _9="planes")
    assert len(frames) == 3
    assert error is not None
    assert (error.error_class, error.bits) == ("Truncated", (47, 48))
    whole = written(_object([Planes(Random(1)).plane(intra=True, mask=0)]), False)
    assert _accepted(whole) == _accepted(whole, _9="planes")


@pytest.mark.parametrize("id", FOLLOWED)
def test_readings_keep_the_writing_back(id: str) -> None:
    """Under every reading: what is accepted writes back to the same bytes under the same reading."""
    for key in ambiguities()[id].readings:
        readings = Readings({id: key})
        accepted = 0
        for name in case_names("fba"):
            case, data, _ = case_files("fba", name)
            if case["profile"] == "long":
                continue
            try:
                items = read_stream(data, Options(readings=readings))
            except SnhcError as error:
                check_error(error, 8 * len(data))
                continue
            accepted += 1
            assert write_stream(items, Writer(readings=readings)) == data
        assert accepted >= 4
