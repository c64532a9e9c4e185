"""Rate against distortion of both coding modes of FAPs: the experiment of figure 11 of the paper, on our own sequences.

Rules: FBA-17, FBA-31, DCT-5, DCT-8, CNF-4. Run: `python -m snhc.vectors.rate_distortion [FOLDER] [--fap FILE ...]`.

Rate: bits of the whole stream, headers and end code included, over its duration. Distortion: mean squared error of
each coded FAP, divided by the square of that FAP's own range (maximum - minimum over the original sequence); the mean
of that over all FAPs whose range is not 0; PSNR = -10 log10 of the mean. So every FAP counts alike, whatever its unit.
Both modes send an intra plane every 128 frames (8 segments), and nothing in between. The arithmetic mode's fap_quant 0
stands in the CSV only: its levels are the values, and range lists hold 1860 at most, so that large angles are clipped.

The code words of four of the DCT mode's six tables are our own (profile P1, provisional): so are its bit counts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import log10
from pathlib import Path
from typing import Final

from snhc.reference_impl.entropy.profile import load_profile
from snhc.reference_impl.face.encode import EncoderOptions
from snhc.reference_impl.face.fap_text import FapFile, read_fap
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.stream import decode_frames, write_stream

from .sequences import expressions, speech

MODES: Final = ("arithmetic", "dct")
QUANTISERS: Final = range(32)
INTRA_FRAMES: Final = 128
SEGMENTS: Final = INTRA_FRAMES // 16
HEADER: Final = "sequence,mode,entropy_profile,fap_quant,bits,seconds,kbit_per_s,psnr_db\n"
FRAMES: Final = 1_920
LABEL: Final = "provisional entropy tables (P1)"


@dataclass(frozen=True, slots=True)
class Point:
    """One encoding. Rules: CNF-4. `psnr`: dB, None without any error. `seconds`: of the sequence."""

    sequence: str
    mode: str
    quant: int
    bits: int
    seconds: float
    psnr: float | None

    @property
    def rate(self) -> float:
        """kbit/s."""
        return self.bits / self.seconds / 1000.0

    def row(self) -> str:
        """The line of the CSV."""
        profile = load_profile().name if self.mode == "dct" else ""
        psnr = "inf" if self.psnr is None else f"{self.psnr:.2f}"
        return (
            f"{self.sequence},{self.mode},{profile},{self.quant},"
            f"{self.bits},{self.seconds:.3f},{self.rate:.3f},{psnr}\n"
        )


def psnr(original: Sequence[Sequence[int | None]], decoded: Sequence[Sequence[int | None]]) -> float | None:
    """PSNR over FAPs as this experiment defines it; None where nothing differs. Rules: DCT-8.

    `original`, `decoded`: 68 values per frame, None where not coded; frames of `decoded` behind the last of
    `original` do not count.
    """
    errors: list[float] = []
    for fap in range(2, 68):
        wanted = [values[fap] for values in original]
        pairs = [(a, values[fap]) for a, values in zip(wanted, decoded, strict=False) if a is not None]
        if not pairs:
            continue
        spread = max(a for a, _ in pairs) - min(a for a, _ in pairs)
        if spread:
            squares = sum((a - (b or 0)) ** 2 for a, b in pairs)
            errors.append(squares / len(pairs) / (spread * spread))
    mean = sum(errors) / len(errors) if errors else 0.0
    return -10.0 * log10(mean) if mean else None


def measure(sequence: FapFile, mode: str, quant: int) -> Point:
    """Encode, decode and compare. Rules: FBA-31, DCT-5. `mode`: `arithmetic` or `dct`; `quant`: 0..31."""
    options = EncoderOptions(intra_period=SEGMENTS if mode == "dct" else INTRA_FRAMES)
    data = write_stream(encode_fap(sequence, options, quant=quant, mode=mode))
    decoded = [frame.faps for frame in decode_frames(data) if isinstance(frame, FaceFrame)]
    seconds = float(len(sequence.frames) / sequence.frame_rate)
    original = [frame.values for frame in sequence.frames]
    return Point(sequence.name, mode, quant, 8 * len(data), seconds, psnr(original, decoded))


def points(sequences: Iterable[FapFile]) -> Iterator[Point]:
    """All encodings of all sequences. Rules: CNF-4."""
    for sequence in sequences:
        for mode in MODES:
            for quant in QUANTISERS:
                yield measure(sequence, mode, quant)


def own_sequences(frames: int = FRAMES) -> list[FapFile]:
    """What takes the place of the paper's Marco30 and Expressions. Rules: CNF-4."""
    return [speech(frames, 1, rate=30), expressions(frames, 1, rate=25)]


def savings(found: Sequence[Point], sequence: str, levels: Iterable[float]) -> Iterator[tuple[float, float, float]]:
    """(PSNR, kbit/s arithmetic, kbit/s DCT) where both modes reach a PSNR; rates are interpolated linearly."""
    curves = []
    for mode in MODES:
        curves.append(sorted({(p.psnr, p.rate) for p in _curve(found, sequence, mode) if p.psnr is not None}))
    for level in levels:
        rates = [_at(curve, level) for curve in curves]
        if rates[0] is not None and rates[1] is not None:
            yield level, rates[0], rates[1]


def _curve(found: Sequence[Point], sequence: str, mode: str) -> list[Point]:
    """The points of a curve: all but the arithmetic mode's fap_quant 0, whose levels clip the large angles."""
    return [p for p in found if p.sequence == sequence and p.mode == mode and (p.quant or mode == "dct")]


def _at(curve: list[tuple[float, float]], level: float) -> float | None:
    for (x0, y0), (x1, y1) in pairwise(curve):
        if x0 <= level <= x1:
            return y0 if x1 == x0 else y0 + (y1 - y0) * (level - x0) / (x1 - x0)
    return None


def draw(found: Sequence[Point], target: Path) -> None:
    """The plot, as SVG or whatever the name says."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "snhc"
    from matplotlib import pyplot

    names = list(dict.fromkeys(point.sequence for point in found))
    figure, axes = pyplot.subplots(1, len(names), figsize=(6.2 * len(names), 4.8), squeeze=False)
    for axis, name in zip(axes[0], names, strict=True):
        for mode, mark in zip(MODES, ("o", "s"), strict=True):
            curve = [p for p in _curve(found, name, mode) if p.psnr is not None]
            label = "arithmetic mode" if mode == "arithmetic" else f"DCT mode, {LABEL}"
            axis.plot([p.rate for p in curve], [p.psnr for p in curve], marker=mark, markersize=3.5, label=label)
        axis.set_title(name)
        axis.set_xlabel("kbit/s")
        axis.set_ylabel("PSNR over FAPs / dB")
        axis.set_xlim(left=0)
        axis.grid(True, which="both", alpha=0.3)
        axis.legend(fontsize=8, loc="lower right")
    figure.tight_layout()
    figure.savefig(target, metadata={"Date": None} if target.suffix == ".svg" else None)
    pyplot.close(figure)


def table(found: Sequence[Point]) -> str:
    """Rates at equal PSNR, as text."""
    lines = []
    for name in dict.fromkeys(point.sequence for point in found):
        lines.append(f"{name} ({LABEL})\n")
        lines.append("  PSNR   arithmetic        DCT   DCT needs\n")
        for level, arithmetic, dct in savings(found, name, [2.5 * n for n in range(4, 32)]):
            change = 100.0 * (dct / arithmetic - 1.0)
            lines.append(f"{level:6.1f}{arithmetic:13.2f}{dct:11.2f}{change:+11.0f} %\n")
        for mode in MODES:
            best = max(p.psnr for p in _curve(found, name, mode) if p.psnr is not None)
            lines.append(f"  {mode}: best {best:.1f} dB\n")
    return "".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the experiment: CSV and SVG into a folder, the comparison to stdout."""
    parser = argparse.ArgumentParser(
        prog="python -m snhc.vectors.rate_distortion", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs/experiments"))
    parser.add_argument("--fap", type=Path, action="append", default=[], help="a .fap text instead of our sequences")
    parser.add_argument("--frames", type=int, default=FRAMES)
    given = parser.parse_args(arguments)
    sequences = []
    for path in given.fap:
        with path.open("rb") as stream:
            sequences.append(read_fap(stream))
        sequences[-1].name = path.stem
    found = list(points(sequences or own_sequences(given.frames)))
    given.folder.mkdir(parents=True, exist_ok=True)
    (given.folder / "rate_distortion.csv").write_text(HEADER + "".join(p.row() for p in found), encoding="utf-8")
    draw(found, given.folder / "rate_distortion.svg")
    sys.stdout.write(table(found))


if __name__ == "__main__":
    main()
