"""The tier `real`: its sequences are plausible, pinned, and come back from streams as near as their quantiser says."""

from __future__ import annotations

import json
from hashlib import sha256
from itertools import pairwise

import pytest

from snhc.reference_impl.face.bap_text import write_bap
from snhc.reference_impl.face.fap_text import FapFile, write_fap
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.stream import decode_frames, write_stream
from snhc.reference_impl.tables import fap_table
from snhc.vectors.manifest import SUITE, Accepted, load
from snhc.vectors.performances import GESTURES, gestures, talk
from snhc.vectors.sequences import expressions, speech
from snhc.vectors.tracked import HEAD_BOUNDARY, flag, head

ENTRIES = {entry.id: entry for entry in load().entries if entry.tier == "real"}


def test_there_are_enough_over_both_modes_bodies_and_meshes() -> None:
    tools = {tool for entry in ENTRIES.values() for tool in entry.tools}
    assert len(ENTRIES) >= 25
    assert tools >= {"fba", "dct-p1", "mesh"}
    assert {feature for entry in ENTRIES.values() for feature in entry.features} >= {"bap", "mask-type-2", "viseme"}
    assert all(entry.kind == "valid" and entry.provenance["seed"] is not None for entry in ENTRIES.values())


def _digest(value: object) -> str:
    return sha256(value if isinstance(value, bytes) else json.dumps(value).encode()).hexdigest()[:16]


@pytest.mark.parametrize(
    ("made", "digest"),
    [
        (lambda: b"".join(write_fap(talk(100, 7, noise=2))), "5c4465b442c74bf9"),
        (lambda: b"".join(write_bap(gestures(100, 7))), "e08b6283e1e67e04"),
        (lambda: flag(60, 7), "d9e3e75007e5b0d4"),
        (lambda: head(60, 7), "c5c77204319ecc4f"),
    ],
)
def test_the_same_on_every_platform(made: object, digest: str) -> None:
    """CNF-4: pinned for ever; vectors are made of these."""
    assert callable(made)
    assert _digest(made()) == digest


@pytest.mark.parametrize("quant", [1, 4, 12, 31])
@pytest.mark.parametrize("file", [speech(40, 5, rate=20), expressions(40, 5), talk(40, 5)])
def test_what_is_decoded_is_as_near_as_the_quantiser_says(file: FapFile, quant: int) -> None:
    """FBA-31: an encoder that closes its loop never drifts: half a step at most."""
    frames = [f for f in decode_frames(write_stream(encode_fap(file, quant=quant))) if isinstance(f, FaceFrame)]
    assert len(frames) == len(file.frames)
    for frame, source in zip(frames, file.frames, strict=True):
        for row, got, wanted in zip(fap_table(), frame.faps, source.values, strict=True):
            if wanted is not None:
                assert got is not None and abs(got - wanted) * 2 <= row.QP * quant, (frame.index, row.number)


def test_a_talk_moves_from_viseme_to_viseme_without_jumps() -> None:
    frames = talk(400, 3).frames
    visemes = [frame.viseme for frame in frames]
    assert len({one[0] for one in visemes if one is not None}) > 8
    for before, after in pairwise(visemes):
        assert before is not None and after is not None
        if before[:2] == after[:2]:
            # The first of the two fades: it never comes back.
            assert 63 >= before[2] >= after[2] >= 0
        elif before[2]:
            assert after[0] == before[1] or before[2] < 63
    intensities = [frame.expression[i] for frame in frames if frame.expression is not None for i in (1, 3)]
    assert min(intensities) >= 0 and 40 < max(intensities) <= 63


def test_gestures_move_only_joints_whose_step_is_not_in_dispute() -> None:
    from snhc.reference_impl.tables import bap_table

    rows = {row.number: row for row in bap_table()}
    assert all(rows[bap].base_step == rows[bap].base_step_variant_b for bap in GESTURES)
    values = [value for frame in gestures(200, 3).frames for value in frame.values if value is not None]
    # Half a radian, and a little more where a spring is still under way.
    assert 10_000 < max(values) < 60_000 and -60_000 < min(values) < -10_000


@pytest.mark.parametrize("seed", range(1, 9))
def test_a_flag_waves_more_the_farther_from_its_pole(seed: int) -> None:
    frames = flag(60, seed)
    assert frames[0] == [(20 * column, 20 * row) for row in range(5) for column in range(8)]

    def reach(column: int) -> int:
        ys = [nodes[16 + column][1] for nodes in frames]
        return max(ys) - min(ys)

    assert reach(0) == 0 and reach(7) > reach(2) > 0 and reach(7) > 12


@pytest.mark.parametrize("seed", range(1, 9))
def test_a_head_moves_as_one_and_speaks(seed: int) -> None:
    frames = head(90, seed)
    middle = [sum(x for x, _ in nodes[: len(HEAD_BOUNDARY)]) / len(HEAD_BOUNDARY) for nodes in frames]
    assert 3 < max(middle) - min(middle) < 60
    # The mouth: from the middle of the upper lip to that of the lower.
    opened = [nodes[-2][1] - nodes[-3][1] for nodes in frames]
    assert 8 < max(opened) - min(opened) < 30
    steps = [abs(a[0] - b[0]) + abs(a[1] - b[1]) for f, g in pairwise(frames) for a, b in zip(f, g, strict=True)]
    assert max(steps) < 40


def test_streams_are_small() -> None:
    for entry in ENTRIES.values():
        assert isinstance(entry.expect, Accepted)
        size = len((SUITE / entry.file).read_bytes())
        # The two long DCT sequences are older than this tier.
        assert size < (4096 if entry.id in ("fap.dct.real.speech", "fap.dct.real.expressions") else 2304), entry.id
