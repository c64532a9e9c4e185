"""Minimising: broken decoders, whose failures have to become small and stay what they are.

Rules: CNF-17.
"""

from __future__ import annotations

import json
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Self

import pytest
from hypothesis import given
from hypothesis import strategies as st
from signals import hears_interrupts

from snhc.conformance.adapters import Outcome
from snhc.conformance.minimize import Budget, Minimized, Subject, Target, minimize, subject_of_file, subject_of_vector
from snhc.conformance.minimize.ddmin import ddmin, lower
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.systems.stream import read_stream
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import SUITE, DecodeOptions, Entry, load

ENTRIES = {entry.id: entry for entry in load(check_schema=False).entries}

# -- delta debugging ---------------------------------------------------------------------------------------------------


@given(st.sets(st.integers(0, 40), max_size=6), st.integers(0, 41))
def test_what_is_needed_is_what_is_kept(needed: set[int], count: int) -> None:
    needed = {n for n in needed if n < count}
    assert ddmin(range(count), lambda kept: needed.issubset(kept)) == sorted(needed)


@given(st.integers(1, 30), st.data())
def test_no_single_unit_can_be_left_out(count: int, data: st.DataObject) -> None:
    # A test that is not monotonic: an odd sum above a bound.
    bound = data.draw(st.integers(0, count))
    units = list(range(1, count + 1))

    def test(kept: list[int]) -> bool:
        return sum(kept) % 2 == sum(units) % 2 and sum(kept) >= bound

    kept = ddmin(units, test)
    assert test(kept)
    assert not any(test(kept[:i] + kept[i + 1 :]) for i in range(len(kept)))


@given(st.integers(-1000, 1000), st.integers(0, 1000))
def test_numbers_come_down_to_the_smallest(value: int, least: int) -> None:
    least = min(least, abs(value))
    assert abs(lower(value, lambda v: abs(v) >= least)) == least


# -- decoders with one fault -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Broken:
    """The reference decoder with a fault put into its output, or into how it ends. In this process: it is fast."""

    fault: Callable[[list[dict[str, Any]], bytes, str], Outcome | None]
    name: str = "broken"
    format: str = "ndjson"
    reproduce: str = ""

    def lacks(self, entry: Entry) -> str:
        return ""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        data = path.read_bytes()
        decoded = decode_input(entry.media, data, aux.read_bytes() if aux else None, entry.options.for_decoder())
        frames = [json.loads(line) for line in decoded.lines]
        error = decoded.error.error_class if decoded.error is not None else ""
        outcome = self.fault(frames, data, error)
        if outcome is not None:
            return outcome
        text = "".join(json.dumps(frame) + "\n" for frame in frames).encode()
        said = json.dumps(decoded.error.as_json()).encode() if decoded.error is not None else b""
        return Outcome(1 if said else 0, text, said)

    def timed(self, seconds: float) -> Self:
        return self

    def close(self) -> None:
        return None


def large_fap_48(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[1:]:
        if frame["faps"][47] is not None and abs(frame["faps"][47]) > 3000:
            frame["faps"][47] = 3000


def wrong_state_of_later_frames(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[2:]:
        frame["state"] = frame["state"].replace("T", "R", 1)


def crash_on_two_visemes(frames: list[dict[str, Any]], data: bytes, error: str) -> Outcome | None:
    both = any(frame.get("viseme") and frame["viseme"]["select2"] for frame in frames)
    return Outcome(-11, stderr=b"") if both else None


def rejects_motion(frames: list[dict[str, Any]], data: bytes, error: str) -> Outcome | None:
    return Outcome(1, stderr=b'{"class": "RangeViolation"}') if any("triangles" not in f for f in frames[1:]) else None


def node_4_in_motion(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for before, frame in pairwise(frames[1:]):
        if len(frame["nodes"]) > 4 and frame["nodes"][4] != before["nodes"][4]:
            frame["nodes"][4][0] += 1


def four_nodes_at_least(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[1:]:
        if len(frame["nodes"]) > 3:
            frame["nodes"][3][1] += 2


def accepts_everything(frames: list[dict[str, Any]], data: bytes, error: str) -> Outcome | None:
    return Outcome(0, "".join(json.dumps(f) + "\n" for f in frames).encode()) if error == "MarkerBit" else None


def dct_off(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[1:]:
        frame["faps"] = [v + 40 if v is not None and v > 20 else v for v in frame["faps"]]


def values_of_tables(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[1:]:
        frame["faps"] = [
            v + (s == "F" and v != 0) if v else v for v, s in zip(frame["faps"], frame["state"], strict=True)
        ]


def first_vertex(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
    for frame in frames[1:]:
        for points in frame["meshes"].values():
            if points:
                points[0][0] += 100.0


# Vector, fault, most bytes of what is left of it.
CASES: dict[str, tuple[str, Any, int]] = {
    "fap": ("fap.arith.model.adapts", large_fap_48, 14),
    "real": ("fap.arith.real.speech.quant-1-at-25-hz", wrong_state_of_later_frames, 18),
    "viseme": ("fap.arith.example.3", crash_on_two_visemes, 15),
    "motion": ("mesh.motion.range.7", rejects_motion, 20),
    "node": ("mesh.motion.range.7", node_4_in_motion, 24),
    "delaunay": ("mesh.delaunay.concave", four_nodes_at_least, 30),
    "marker": ("fba.error.marker.group-1", accepts_everything, 8),
    "dct": ("fap.dct.real.short.speech-quant-6", dct_off, 20),
    "coefficients": ("dct.coefficients.example.1", dct_off, 110),
    "fit": ("fit.case.c-eyebrow", values_of_tables, 800),
    "fat": ("fat.interval.single.zero-first", first_vertex, 800),
}


def _subject(name: str) -> tuple[Subject, Broken]:
    id, fault, _ = CASES[name]
    return subject_of_vector(ENTRIES[id], SUITE), Broken(fault)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Subject, Broken, Minimized, Path]]:
    kept: dict[str, tuple[Subject, Broken, Minimized, Path]] = {}

    def of(name: str) -> tuple[Subject, Broken, Minimized, Path]:
        if name not in kept:
            subject, decoder = _subject(name)
            folder = tmp_path_factory.mktemp(name)
            kept[name] = subject, decoder, minimize(decoder, subject, folder, Budget(3000, None)), folder
        return kept[name]

    return of


@pytest.mark.parametrize("name", CASES)
def test_what_is_left_is_small_and_fails_in_the_same_way(name: str, found: Any, tmp_path: Path) -> None:
    subject, decoder, result, _ = found(name)
    before = Target(decoder, subject, tmp_path).signature(subject.data, subject.aux)
    after = Target(decoder, subject, tmp_path).signature(result.data, result.aux)
    assert before == after == result.signature is not None
    size = len(result.data) + len(result.aux or b"")
    assert result.complete and size <= CASES[name][2], (size, result.data, result.aux)
    assert size <= len(subject.data) + len(subject.aux or b"")


@pytest.mark.parametrize("name", ["fap", "node", "marker"])
def test_minimising_again_changes_nothing_and_is_deterministic(name: str, found: Any, tmp_path: Path) -> None:
    subject, decoder, result, _ = found(name)
    assert minimize(decoder, subject, tmp_path, Budget(3000, None)).data == result.data
    again = minimize(decoder, replace(subject, data=result.data, aux=result.aux), tmp_path, Budget(3000, None))
    assert again.data == result.data


def test_one_plane_one_fap_and_the_least_level_are_left(found: Any) -> None:
    _, _, result, _ = found("fap")
    (item,) = read_stream(result.data)
    assert item.fba is not None
    (plane,) = item.fba.planes
    assert plane.faps is not None and len(plane.faps.levels) == 1
    # 170 per level: 17 * 170 = 2890, 18 * 170 = 3060.
    assert abs(plane.faps.levels[0]) == 18


def test_the_budget_ends_it(tmp_path: Path) -> None:
    subject, decoder = _subject("real")
    result = minimize(decoder, subject, tmp_path, Budget(3, None))
    assert not result.complete and result.runs <= 4
    assert Target(decoder, subject, tmp_path).signature(result.data, None) == result.signature


def test_an_interrupt_leaves_the_smallest_so_far(tmp_path: Path) -> None:
    subject, decoder = _subject("real")

    def progress(runs: int, size: int) -> None:
        if size < len(subject.data) // 2:
            raise KeyboardInterrupt

    result = minimize(decoder, subject, tmp_path, progress=progress)
    assert result.interrupt is not None and not result.complete
    assert len(result.data) < len(subject.data) // 2
    assert Target(decoder, subject, tmp_path).signature(result.data, None) == result.signature

    def at_once(frames: list[dict[str, Any]], data: bytes, error: str) -> Outcome | None:
        if len(data) < len(subject.data):
            raise KeyboardInterrupt
        return decoder.fault(frames, data, error)

    # Nothing has been found yet: there is nothing to keep.
    with pytest.raises(KeyboardInterrupt):
        minimize(replace(decoder, fault=at_once), subject, tmp_path)


def test_a_decoder_that_does_not_fail_is_said(tmp_path: Path) -> None:
    subject = subject_of_vector(ENTRIES["fap.arith.example.1"], SUITE)
    with pytest.raises(InputFormat, match="on which broken fails"):
        minimize(Broken(lambda *_: None), subject, tmp_path)


def test_ambiguous_vectors_stay_ambiguous(tmp_path: Path) -> None:
    entry = ENTRIES["fba.ambiguous.skipped-frames"]

    def third(frames: list[dict[str, Any]], data: bytes, error: str) -> None:
        for frame in frames[2:]:
            frame["time"] = "7/1"

    result = minimize(Broken(third), subject_of_vector(entry, SUITE), tmp_path, Budget(500, None))
    assert result.entry.kind == "ambiguous" and result.signature.kind == "time"
    assert len(result.data) < len((SUITE / entry.file).read_bytes())


def test_progress_tells_ever_smaller_sizes(tmp_path: Path) -> None:
    subject, decoder = _subject("fap")
    seen: list[tuple[int, int]] = []
    minimize(decoder, subject, tmp_path, progress=lambda runs, size: seen.append((runs, size)))
    assert len(seen) > 3 and [runs for runs, _ in seen] == sorted(runs for runs, _ in seen)


# -- files -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("id", "media", "tools"),
    [
        ("fap.arith.example.1", "fba", ("fba",)),
        ("fap.dct.viseme", "fba", ("fba", "dct-p1")),
        ("mesh.motion.range.7", "m2d", ("mesh",)),
        ("dct.coefficients.example.1", "dctcoef", ("dctcoef",)),
        ("fba.error.input.text", "fba", ("fba",)),
    ],
)
def test_a_file_says_what_it_is(id: str, media: str, tools: tuple[str, ...]) -> None:
    entry = ENTRIES[id]
    subject = subject_of_file(SUITE / entry.file, None, DecodeOptions())
    assert (subject.entry.media, subject.entry.tools) == (media, tools)


def test_a_table_needs_its_frames() -> None:
    entry = next(entry for entry in ENTRIES.values() if "fit" in entry.tools and entry.kind == "valid")
    with pytest.raises(InputFormat, match="--aux"):
        subject_of_file(SUITE / entry.file, None, DecodeOptions())


# -- the command -------------------------------------------------------------------------------------------------------

SCRIPT = """
import json, sys
from pathlib import Path
from snhc.reference_impl.systems.stream import Options
from snhc.vectors.decoding import decode

decoded = decode(Path(sys.argv[1]).read_bytes(), Options())
for line in decoded.lines:
    frame = json.loads(line)
    if "faps" in frame and frame["faps"][47] is not None and abs(frame["faps"][47]) > 300:
        frame["faps"][47] = 300
    print(json.dumps(frame))
sys.exit(decoded.error is not None)
"""


def _snhc(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "snhc.conformance.cli", *words]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False, timeout=120)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_command_writes_the_smallest_so_far(tmp_path: Path, how: signal.Signals) -> None:
    log = tmp_path / "log"
    log.mkdir()
    began = f"open({str(log / 'runs')!r}, 'a').write('x')\nimport time\ntime.sleep(0.1)\n"
    (tmp_path / "clips.py").write_text(began + SCRIPT)
    (tmp_path / "clips.toml").write_text(
        f'command = ["{sys.executable}", "clips.py", "{{input}}"]\nwritable = ["{log}"]\n'
    )
    id = "fap.arith.real.parts-in-turn"
    process = subprocess.Popen(
        [sys.executable, "-m", "snhc.conformance.cli", "minimize", "clips.toml", id], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=hears_interrupts,
    )  # fmt: skip
    # By then it is much smaller, and there is more to do.
    for _ in range(1000):
        if (log / "runs").exists() and (log / "runs").stat().st_size >= 20:
            break
        time.sleep(0.1)
    process.send_signal(how)
    said, errors = process.communicate(timeout=60)
    assert process.returncode == 128 + how, errors
    assert b"interrupted, it may shrink further" in said and b"again: snhc minimize" in said
    small = tmp_path / f"{id}.min.fba"
    assert 0 < small.stat().st_size < (SUITE / ENTRIES[id].file).stat().st_size


def test_the_command_leaves_a_stream_and_a_command_that_shows_the_failure_again(tmp_path: Path) -> None:
    (tmp_path / "clips.py").write_text(SCRIPT)
    (tmp_path / "clips.toml").write_text(f'command = ["{sys.executable}", "clips.py", "{{input}}"]\n')
    done = _snhc(tmp_path, "minimize", "clips.toml", "fap.arith.example.2")
    assert done.returncode == 0, done.stderr
    small = tmp_path / "fap.arith.example.2.min.fba"
    assert small.stat().st_size <= 14 and "fap_segment" in done.stdout
    again = next(line for line in done.stdout.splitlines() if "again:" in line).partition("again: snhc ")[2]
    failing = _snhc(tmp_path, *shlex.split(again))
    assert failing.returncode == 1 and failing.stdout.startswith("fail: frame 0, FAP 48")

    file = _snhc(tmp_path, "minimize", "clips.toml", str(small), "-o", "again.fba")
    assert file.returncode == 0 and "12 bytes -> 12 bytes" in file.stdout
    assert (tmp_path / "again.fba").read_bytes() == small.read_bytes()
    passing = _snhc(tmp_path, "minimize", "snhc", str(small), "--check")
    assert (passing.returncode, passing.stdout) == (0, "pass\n")
    nothing = _snhc(tmp_path, "minimize", "snhc", str(small))
    assert nothing.returncode == 3 and "pass: allowed an input on which snhc fails" in nothing.stderr
    unknown = _snhc(tmp_path, "minimize", "snhc", "no.such.vector")
    assert unknown.returncode == 2 and "neither a file nor a vector" in unknown.stderr
