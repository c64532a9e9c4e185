"""Peak memory of the commands that stream does not grow with their input (CNF-22); docs/benchmarks.md says which do.

Fifteen times the frames, the same peak: of a process of its own, by what the system says of it. Nothing is timed.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

PEAK = Path(__file__).parents[1] / "peak.py"
TABLE = Path(__file__).parents[1] / "fixtures" / "samples" / "fit" / "fit-11-00000" / "table.json"
FEW, MANY = 200, 3_000
# KiB. Frames left behind, with 68 places each, would be 1,600 and more.
SLACK = 1_000

# Arguments; those that begin with a dot are files of the length in question.
STREAMING = {
    "decode to NDJSON": ("decode", ".fba"),
    "decode to text": ("decode", "--format", "fap", ".fba"),
    "decode to CSV": ("decode", "--format", "csv", ".fba"),
    "check": ("check", ".fba"),
    "check of a profile": ("check", "--profile", "simple-face@L2", ".fba"),
    "check of text": ("check", ".fap"),
    "dump": ("dump", ".fba"),
    "dump to JSON": ("dump", "--format", "json", ".fba"),
    "dump to CSV": ("dump", "--format", "csv", ".fba"),
    "stats": ("stats", ".fba"),
    "encode": ("encode", ".fap"),
    "encode to DCT": ("encode", "--mode", "dct", ".fap"),
    "encode with parameters and bodies": ("encode", "--epf", ".epf", "--bap", ".bap", ".fap"),
    "diff of streams": ("diff", ".fba", ".other.fba"),
    "diff of values": ("diff", ".ndjson", ".fba"),
    "decode with a table": ("decode", "--fit", str(TABLE), ".fba"),
}
COLLECTING = {
    "decode to an archive": ("decode", "--format", "npz", ".fba"),
    "encode of a dump": ("encode", ".json"),
}


def snhc(*arguments: object) -> int:
    """Peak KiB of a command that must end well (a difference is no bad end)."""
    command = [sys.executable, str(PEAK), *map(str, arguments)]
    out = subprocess.run(command, capture_output=True, text=True, check=False)
    assert out.returncode in (0, 1), out.stderr
    return int(out.stderr.split()[-1])


def write_texts(folder: Path, frames: int) -> None:
    """`.fap`, `.epf` and `.bap` texts: one intra plane, then 20 FAPs and two BAPs that change."""
    mask = " ".join("1" if 18 < fap < 39 else "0" for fap in range(1, 69))
    body = " ".join("1" if bap in (1, 50) else "0" for bap in range(1, 187))
    with (
        (folder / f"{frames}.fap").open("w") as faps,
        (folder / f"{frames}.epf").open("w") as blocks,
        (folder / f"{frames}.bap").open("w") as baps,
    ):
        faps.write(f"2.1 long 25 {frames}\n")
        baps.write(f"2.1 long 25 {frames}\n")
        for i in range(frames):
            faps.write(f"{mask}\n{i} {' '.join(str(i * n % 90) for n in range(20))}\n")
            baps.write(f"{body}\n{i} {i % 90} {i % 50}\n")
            blocks.write(f"FBM 3\nFFR {i}\nBFR {i}\n" + "ISI 1\n" * (i == 0))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lengths")
    for frames in (FEW, MANY):
        write_texts(folder, frames)
        text, stream = folder / f"{frames}.fap", folder / f"{frames}.fba"
        snhc("encode", "--quiet", text, "-o", stream)
        snhc("encode", "--quiet", "--quant", 3, text, "-o", folder / f"{frames}.other.fba")
        snhc("decode", "--quiet", stream, "-o", folder / f"{frames}.ndjson")
        snhc("dump", "--quiet", stream, "-o", folder / f"{frames}.json")
    return folder


def growth(arguments: Sequence[str], folder: Path) -> int:
    """How much higher the peak is with fifteen times the frames, KiB."""
    peaks = []
    for frames in (FEW, MANY):
        given = [folder / f"{frames}{name}" if name.startswith(".") else name for name in arguments]
        peaks.append(snhc(given[0], "--quiet", *given[1:], "-o", folder / "out"))
    return peaks[1] - peaks[0]


@pytest.mark.parametrize("arguments", STREAMING.values(), ids=STREAMING)
def test_what_streams_holds_no_frames(arguments: tuple[str, ...], files: Path) -> None:
    assert growth(arguments, files) < SLACK


@pytest.mark.parametrize("arguments", COLLECTING.values(), ids=COLLECTING)
def test_what_collects_is_seen_to(arguments: tuple[str, ...], files: Path) -> None:
    """The measure is no blind one."""
    assert growth(arguments, files) > SLACK


def test_the_documentation_names_what_streams() -> None:
    """Each command measured here stands in the table of what is held."""
    text = (Path(__file__).parents[2] / "docs" / "benchmarks.md").read_text()
    table = text[text.index("## What a command holds") :]
    for arguments in (*STREAMING.values(), *COLLECTING.values()):
        assert f"`{arguments[0]}" in table, arguments[0]
