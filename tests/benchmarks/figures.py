"""All figures of the docs page `benchmarks`: measured, compared with the committed ones, written as tables and plots.

    python tests/benchmarks/figures.py [--long] [--no-write]

`--long`: 100 MB also for the commands that need minutes for them. `--no-write`: compare only. Exit code 1
where a figure is less than half of the committed one, calibrated; nothing else is judged: a shared machine is no
judge of small differences.
"""

from __future__ import annotations

import argparse
import datetime
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
OUT = ROOT / "docs" / "benchmarks"
COMMITTED = OUT / "figures.json"
MEGABYTE = 1_000_000
SLOWER = 0.5
PEAK = ROOT / "tests" / "peak.py"
SNHC = [sys.executable, "-m", "snhc.conformance.cli"]

# Compiled form: what was to be reached (rates per second, seconds of an hour of speech).
TARGETS = {
    "decode, 361 symbols, small residuals": 5e6,
    "decode, 3,721 symbols, uniform": 1e6,
    "DCT: bits to frames": 3e6,
    "trace of headers": 1e6,
    "hour of speech to npz": 2.0,
    "hour of speech from text": 4.0,
}
# Megabytes of input per command; with --long the last column too. `encode` is measured by its .fap text alone.
SIZES = {
    "decode": ((1, 10, 100), ()),
    "check": ((1, 10, 100), ()),
    "stats": ((1, 10), (100,)),
    "dump": ((1, 10), (100,)),
    "encode": ((1, 10, 100), ()),
    "encode --epf --bap": ((1, 10), (100,)),
}

Figures = dict[str, Any]


def run_command(arguments: list[str], pure: bool = False) -> tuple[float, int]:
    """(processor seconds, peak KiB) of one run of the command; its output goes nowhere."""
    environment = {**os.environ, "SNHC_PURE": "1" if pure else "0"}
    process = subprocess.Popen(
        [sys.executable, str(PEAK), *arguments], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    assert process.stderr is not None
    with process.stderr as stream:
        said = stream.read().decode().split()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"snhc {' '.join(arguments)}: exit status {process.returncode}: {' '.join(said)}")
    return usage.ru_utime + usage.ru_stime, int(said[-1])


def form(pure: bool) -> str:
    """The form that a child runs in."""
    environment = {**os.environ, "SNHC_PURE": "1" if pure else "0"}
    said = subprocess.run([*SNHC, "--version"], env=environment, capture_output=True, text=True, check=True).stdout
    return said.rstrip().rpartition("(")[2].rstrip(")")


def rates(pure: bool) -> dict[str, Figures]:
    """The rates of `measures.py` in one form, by name."""
    environment = {**os.environ, "SNHC_PURE": "1" if pure else "0"}
    command = [sys.executable, str(HERE / "measures.py")]
    out = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    return {figure.pop("name"): figure for figure in map(json.loads, out.splitlines())}


def hour(folder: Path, pure: bool) -> dict[str, float]:
    """Processor seconds of the commands on an hour of speech."""
    from workloads import HOUR, write_speech

    text, stream = folder / "hour.fap", folder / "hour.fba"
    if not text.exists():
        write_speech(text, HOUR)
    encode = ["encode", "--quiet", str(text), "-o", str(stream)]
    decode = ["decode", "--quiet", str(stream), "-o", str(folder / "hour.npz")]
    return {
        "hour of speech from text": min(run_command(encode, pure)[0] for _ in range(2)),
        "hour of speech to npz": min(run_command(decode, pure)[0] for _ in range(2)),
        "start (--version)": min(run_command(["--version"], pure)[0] for _ in range(2)),
    }


def growth(folder: Path, long: bool) -> dict[str, list[Figures]]:
    """Processor time and peak memory of the streaming commands against the size of their input."""
    from workloads import write_companions, write_speech, write_wide

    found: dict[str, list[Figures]] = {}
    for command, (sizes, more) in SIZES.items():
        verb, *options = command.split()
        for megabytes in (*sizes, *(more if long else ())):
            file = folder / f"{megabytes}.{'fap' if verb == 'encode' else 'fba'}"
            frames = int(megabytes * MEGABYTE / 288)
            if not file.exists():
                if verb == "encode":
                    write_speech(file, frames)
                else:
                    write_wide(file, int(megabytes * MEGABYTE))
            companions = []
            if options:
                write_companions(file, frames)
                companions = [part for name in options for part in (name, str(file.with_suffix(f".{name[2:]}")))]
            seconds, peak = run_command([verb, "--quiet", *companions, str(file), "-o", os.devnull])
            found.setdefault(command, []).append(
                {"bytes": file.stat().st_size, "seconds": round(seconds, 3), "peak_kib": peak}
            )
    return found


def exponent(rows: list[Figures]) -> float:
    """The power of the size with which the time grows, between the two largest."""
    (a, b) = rows[-2:]
    return math.log(b["seconds"] / a["seconds"]) / math.log(b["bytes"] / a["bytes"])


def processor() -> str:
    """The model of the processor, as the system names it."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def measure(long: bool) -> Figures:
    """Everything."""
    forms = ["pure"]
    if form(pure=False) == "compiled":
        forms.append("compiled")
    else:
        sys.stdout.write("not run: the compiled form (the package was built without one)\n")
    figures: Figures = {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "rates": {name: rates(name == "pure") for name in forms},
    }
    with tempfile.TemporaryDirectory() as folder:
        figures["seconds"] = {name: hour(Path(folder), name == "pure") for name in forms}
        figures["growth"] = growth(Path(folder), long)
    return figures


def compared(now: Figures, before: Figures) -> list[tuple[str, float]]:
    """(form and name, how many times as fast as before), both divided by their calibration loops."""
    out = []
    for name, figures in now["rates"].items():
        for key, figure in figures.items():
            old = before.get("rates", {}).get(name, {}).get(key)
            if old is not None:
                ratio = figure["rate"] * figure["calibration"] / (old["rate"] * old["calibration"])
                out.append((f"{name}: {key}", ratio))
    return out


def shown(value: float) -> str:
    """Three digits, with M or k."""
    for limit, unit in ((1e6, " M"), (1e3, " k")):
        if value >= limit:
            return f"{value / limit:.3g}{unit}"
    return f"{value:.3g}"


def _target(name: str, value: float | None, rate: bool) -> str:
    target = TARGETS.get(name)
    if target is None or value is None:
        return ""
    met = value >= target if rate else value <= target
    return f"{'at least' if rate else 'at most'} {shown(target)}: {'met' if met else '**missed**'}"


def tables(figures: Figures) -> str:
    """The tables of the page, as Markdown."""
    lines = [
        f"Measured on {figures['date']}: {figures['processor']}, {figures['cores']} cores, Python {figures['python']}.",
        "",
        "| per second of processor time | pure | compiled | times | target (compiled) |",
        "|---|---|---|---|---|",
    ]
    pure, compiled = (figures["rates"].get(name, {}) for name in ("pure", "compiled"))
    for name, figure in pure.items():
        fast = compiled[name]["rate"] if name in compiled else None
        rate = figure["rate"]
        cells = [f"{name} ({figure['unit']})", shown(rate), "", "", _target(name, fast, True)]
        if fast is not None:
            cells[2:4] = shown(fast), f"{fast / rate:.1f}"
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "| processor seconds of a command | pure | compiled | target (compiled) |", "|---|---|---|---|"]
    for name, seconds in figures["seconds"]["pure"].items():
        fast = figures["seconds"].get("compiled", {}).get(name)
        shown_fast = f"{fast:.2f}" if fast is not None else ""
        lines.append(f"| {name} | {seconds:.2f} | {shown_fast} | {_target(name, fast, False)} |")
    lines += [
        "",
        "| command | input, MB | processor seconds | peak memory, MB | time grows with size to the power of |",
        "|---|---|---|---|---|",
    ]
    for command, rows in figures["growth"].items():
        for i, row in enumerate(rows):
            power = f"{exponent(rows):.2f}" if i == len(rows) - 1 else ""
            lines.append(
                f"| {command} | {row['bytes'] / MEGABYTE:.3g} | {row['seconds']:.2f} "
                f"| {row['peak_kib'] * 1024 / MEGABYTE:.1f} | {power} |"
            )
    return "\n".join(lines) + "\n"


def plots(figures: Figures, folder: Path) -> None:
    """`rates.svg`, `memory.svg`, `time.svg`."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "snhc"
    from matplotlib import pyplot as plt

    names = list(figures["rates"]["pure"])
    figure, axes = plt.subplots(figsize=(9, 6), layout="constrained")
    colours = {"pure": "#8da0cb", "compiled": "#1f4e9c"}
    height = 0.8 / len(figures["rates"])
    for i, (form_name, found) in enumerate(figures["rates"].items()):
        places = [row + (i - (len(figures["rates"]) - 1) / 2) * height for row in range(len(names))]
        axes.barh(places, [found[n]["rate"] for n in names], height, label=form_name, color=colours[form_name])
    marks = [(row, TARGETS[name]) for row, name in enumerate(names) if name in TARGETS]
    axes.plot([x for _, x in marks], [y for y, _ in marks], "|", color="#c0392b", ms=22, mew=2.5, label="target")
    axes.set_yticks(range(len(names)), [f"{n} ({figures['rates']['pure'][n]['unit']})" for n in names])
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("per second of processor time")
    axes.grid(axis="x", alpha=0.3)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False)
    figure.savefig(folder / "rates.svg", metadata={"Date": None})
    for key, label, scale in (("peak_kib", "peak memory, MB", 1024 / MEGABYTE), ("seconds", "processor seconds", 1.0)):
        figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
        for command, rows in figures["growth"].items():
            name = command if key == "peak_kib" else f"{command} (power {exponent(rows):.2f})"
            axes.plot([r["bytes"] / MEGABYTE for r in rows], [r[key] * scale for r in rows], "o-", label=name)
        axes.set_xscale("log")
        if key == "seconds":
            axes.set_yscale("log")
        else:
            axes.set_ylim(0, 1.25 * scale * max(r[key] for rows in figures["growth"].values() for r in rows))
        axes.set_xlabel("input, MB")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        axes.legend(loc="lower right" if key == "seconds" else "lower left")
        figure.savefig(folder / ("memory.svg" if key == "peak_kib" else "time.svg"), metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--long", action="store_true", help="100 MB for all commands")
    parser.add_argument("--no-write", action="store_true", help="compare with the committed figures only")
    options = parser.parse_args()
    sys.path.insert(0, str(HERE))
    before = json.loads(COMMITTED.read_text()) if COMMITTED.exists() else {}
    figures = measure(options.long)
    sys.stdout.write(tables(figures))
    slower = 0
    for name, ratio in compared(figures, before):
        slow = ratio < SLOWER
        slower += slow
        sys.stdout.write(f"{ratio:6.2f} x the committed figure: {name}{'  <-- slower' if slow else ''}\n")
    if not options.no_write:
        OUT.mkdir(exist_ok=True)
        COMMITTED.write_text(json.dumps(figures, indent=1) + "\n")
        (OUT / "tables.inc").write_text(tables(figures))
        plots(figures, OUT)
    sys.exit(1 if slower else 0)


if __name__ == "__main__":
    main()
