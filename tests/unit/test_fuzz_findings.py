"""Every input that fuzzing ever found something with, replayed (tests/fuzz_findings/, one named file each).

A name begins with its target and two hyphens; without, the target is `face`.
"""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.systems.stream import read_stream, write_stream

TESTS = Path(__file__).parent.parent
FINDINGS = sorted((TESTS / "fuzz_findings").glob("*.bin"))


@pytest.fixture
def targets(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    monkeypatch.syspath_prepend(str(TESTS / "fuzz"))
    from targets import TARGETS

    return dict(TARGETS)


@pytest.mark.parametrize("path", FINDINGS, ids=lambda path: path.stem)
def test_finding(path: Path, targets: dict[str, object]) -> None:
    name, separator, _ = path.stem.partition("--")

    def stuck(*_: object) -> None:
        pytest.fail("this input was found because it did not come to an end, and does not again")

    before = signal.signal(signal.SIGALRM, stuck)
    signal.alarm(60)
    try:
        targets[name if separator else "face"].law(path.read_bytes())  # type: ignore[attr-defined]
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def test_there_are_findings_to_replay() -> None:
    assert len(FINDINGS) >= 10


def test_every_seed_fits_its_law(targets: dict[str, object]) -> None:
    """A law that refuses what is valid would find nothing but itself; each target has something to begin with."""
    for target in targets.values():
        seeds = list(target.seeds())  # type: ignore[attr-defined]
        assert seeds, target
        for seed in seeds[:: max(1, len(seeds) // 12)]:
            target.law(seed)  # type: ignore[attr-defined]


def test_structure_is_changed_and_most_of_it_decodes(
    targets: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(TESTS / "fuzz"))
    from random import Random

    from structure import mutated

    def decodes(data: bytes) -> bool:
        try:
            return bool(read_stream(data))
        except SnhcError:
            return False

    seeds = [seed for seed in targets["face"].seeds() if len(seed) > 40 and decodes(seed)]  # type: ignore[attr-defined]
    rng = Random(1)
    changed = {mutated(rng.choice(seeds), rng) for _ in range(200)} - set(seeds)
    assert len(changed) > 150, "mutations change something"
    assert sum(decodes(data) for data in changed) > 40, "and often get past the first refusals"


def test_last_bits_of_segments_are_kept() -> None:
    """Whatever was accepted writes back to the same bytes, also a segment that no encoder would end like that."""
    data = (FINDINGS[0].parent / "segment-ends-unlike-the-encoder.bin").read_bytes()
    assert write_stream(read_stream(data)) == data
