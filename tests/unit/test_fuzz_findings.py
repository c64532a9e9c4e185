"""Every input that fuzzing ever found something with, replayed (tests/fuzz_findings/, one named file each)."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz_law import check_bytes

from snhc.reference_impl.systems.stream import read_stream, write_stream

FINDINGS = sorted((Path(__file__).parent.parent / "fuzz_findings").glob("*.bin"))


@pytest.mark.parametrize("path", FINDINGS, ids=lambda path: path.stem)
def test_finding(path: Path) -> None:
    check_bytes(path.read_bytes())


def test_there_are_findings_to_replay() -> None:
    assert FINDINGS


def test_last_bits_of_segments_are_kept() -> None:
    """Whatever was accepted writes back to the same bytes, also a segment that no encoder would end like that."""
    data = (FINDINGS[0].parent / "segment-ends-unlike-the-encoder.bin").read_bytes()
    assert write_stream(read_stream(data)) == data
