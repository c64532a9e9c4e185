"""Real .fap files from elsewhere go through encode and decode (FBA-36, FBA-43, FBA-54, DCT-13).

Nothing derived from them is kept.
"""

from __future__ import annotations

import io
import re
from fractions import Fraction
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.encode import EncoderOptions
from snhc.reference_impl.face.fap_text import FapFile, read_fap
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.parameters import LARGEST_V, LIMIT_UNIT, fap_set
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.output import frame_writer
from snhc.reference_impl.systems.stream import decode_planes, read_stream, write_stream

FILES = ("xface-joy.fap", "xface-joy-crlf.fap", "xface-anger.fap", "crystal-7-basic-emotion.fap")
QUANTISERS = (0, 1, 2, 7, 16, 31)
pytestmark = pytest.mark.corpus


def _read(corpus: Path, name: str) -> FapFile:
    with (corpus / "fap" / name).open("rb") as file:
        return read_fap(file)


def _decoded(data: bytes) -> list[FaceFrame]:
    frames: list[FaceFrame] = []
    for plane in decode_planes(data, on_finding=lambda _: None):
        frames += [frame for frame in plane.frames if isinstance(frame, FaceFrame)]
    return frames


def _clipped(findings: list[Finding]) -> dict[tuple[int, int], int]:
    """(frame number, FAP) -> the level that was sent, of every finding that says so."""
    out = {}
    for finding in findings:
        if finding.id == "value-clipped":
            fap, sent = re.match(r"FAP (\d+) .*, (-?\d+) sent", finding.message).groups()  # type: ignore[union-attr]
            out[int(finding.path[6:-1]), int(fap)] = int(sent)
    return out


@pytest.mark.parametrize("quant", QUANTISERS)
@pytest.mark.parametrize("ranges", ["auto", "widen", "max"])
@pytest.mark.parametrize("name", FILES)
def test_values_come_back_within_half_a_step(corpus: Path, name: str, ranges: str, quant: int) -> None:
    source = _read(corpus, name)
    findings: list[Finding] = []
    data = write_stream(encode_fap(source, EncoderOptions(ranges=ranges), quant=quant, on_finding=findings.append))
    assert write_stream(read_stream(data)) == data
    clipped = _clipped(findings)
    frames = _decoded(data)
    assert len(frames) == len(source.frames)
    seen = set()
    for text, frame in zip(source.frames, frames, strict=True):
        assert frame.time == (Fraction(text.number) / source.frame_rate).as_integer_ratio()
        assert [letter == "T" for letter in frame.state] == [bit == 1 for bit in text.mask]
        for index, value in enumerate(text.values):
            if value is None:
                continue
            step = fap_set().base_steps[index + 1] * quant if quant else 1
            decoded = frame.faps[index]
            assert decoded is not None
            if abs(decoded - value) > (step // 2 if quant else 0):
                assert (text.number, index + 1) in clipped
                seen.add((text.number, index + 1))
    # Clipping is reported where it happened, and only where a value cannot be held (FBA-20).
    assert seen == set(clipped)
    for number, fap in clipped:
        value = next(frame for frame in source.frames if frame.number == number).values[fap - 1]
        assert value is not None
        step = fap_set().base_steps[fap] * quant if quant else 1
        assert abs(value) > LARGEST_V * LIMIT_UNIT // max(quant, 1) * step


@pytest.mark.parametrize("name", FILES)
def test_the_text_comes_back(corpus: Path, name: str) -> None:
    """Lossless at fap_quant 0 but for values no range holds; numbers, masks, rate as FBA-54 says."""
    source = _read(corpus, name)
    findings: list[Finding] = []
    data = write_stream(encode_fap(source, quant=0, on_finding=findings.append))
    pieces: list[bytes] = []
    writer = frame_writer("fap", pieces.append)
    writer.begin("fba")
    for plane in decode_planes(data, on_finding=lambda _: None):
        writer.plane(plane)
    writer.end()
    writer.close()
    again = read_fap(io.BytesIO(b"".join(pieces)), strict=True)
    assert (again.version, again.frame_rate, again.nframes) == ("2.1", source.frame_rate, len(source.frames))
    clipped = _clipped(findings)
    for before, after in zip(source.frames, again.frames, strict=True):
        assert (after.number, tuple(after.mask)) == (before.number, tuple(before.mask))
        for index, value in enumerate(before.values):
            if (before.number, index + 1) not in clipped:
                assert after.values[index] == value


@pytest.mark.parametrize("quant", [0, 8, 31])
@pytest.mark.parametrize("name", FILES)
def test_dct_mode_keeps_the_time_line(corpus: Path, name: str, quant: int) -> None:
    source = _read(corpus, name)
    findings: list[Finding] = []
    data = write_stream(encode_fap(source, quant=quant, mode="dct", on_finding=findings.append))
    assert write_stream(read_stream(data)) == data
    frames = _decoded(data)
    assert len(frames) % 16 == 0
    by_number = {Fraction(*frame.time) * source.frame_rate: frame for frame in frames}
    assert all(frame.number in by_number for frame in source.frames)
    assert sum(finding.id == "encode-extended" for finding in findings) == (len(source.frames) % 16 > 0)
