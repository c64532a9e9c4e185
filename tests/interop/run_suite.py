"""Build the example decoders and run them against the suite, in every form that they have.

Rules: CNF-9, CNF-10, CNF-12, CNF-13. Run as a script, with the package installed; words are passed on to `snhc run`:

    python tests/interop/run_suite.py [--filter EXPR ...]

Prints a line of counts for each adapter; exit code 1 if one does not pass, 2 if none could be built.
"""

# ruff: noqa: T201 (a script whose output is the counts)
from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2] / "conformance"
# Folder: what it needs, how it is built there.
BUILDS: Final[dict[str, tuple[str, list[str]]]] = {
    "c": ("cc", ["make", "-s"]),
    "rust": ("cargo", ["cargo", "build", "-q", "--release", "--offline", "--locked"]),
    "go": ("go", ["go", "build", "-o", "fba-decoder", "."]),
    "javascript": ("node", ["node", "--version"]),
}


def built(folder: Path) -> list[Path]:
    """The adapter files of what could be built."""
    found: list[Path] = []
    for name, (needs, command) in BUILDS.items():
        if shutil.which(needs) is None:
            print(f"not run: {name}: {needs} is not installed")
            continue
        done = subprocess.run(command, cwd=folder / name, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"{name}: {' '.join(command)} failed\n{done.stdout}{done.stderr}")
        found += sorted((folder / name).glob("*.toml"))
    return [path for path in found if path.name != "Cargo.toml"]


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        # A copy, so that the sources stay as they are; the header lies beside the examples.
        folder = Path(name)
        for part in ("c", "examples"):
            shutil.copytree(ROOT / part, folder / part)
        adapters = built(folder / "examples")
        if not adapters:
            return 2
        command = [sys.executable, "-m", "snhc.conformance.cli", "run", "--format", "json", *map(str, adapters)]
        done = subprocess.run([*command, *sys.argv[1:]], stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode not in (0, 1, 5):
            return done.returncode
        report = json.loads(done.stdout)
    for adapter in report["adapters"]:
        counts = ", ".join(f"{count} {status}" for status, count in adapter["counts"].items() if count)
        print(f"{adapter['name']:34}{adapter['verdict']:6}{counts}")
    bad = [result for result in report["results"] if result["status"] not in ("pass", "not_applicable")]
    for result in bad[:20]:
        print(f"    {result['adapter']}: {result['vector']}: {result['status']}: {result['reason']}")
    return int(done.returncode != 0)


if __name__ == "__main__":
    sys.exit(main())
