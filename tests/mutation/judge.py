# ruff: noqa: T201
"""Is this copy of the decoder still right? Exit 0: nobody noticed anything; 1: the suite or a test did.

Run by the mutation tester once per mutation, in the copy. The suite first, vector by vector: it notices most. Then unit
tests and laws of the parts that are mutated. Without arguments.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TESTS = (
    "test_entropy.py", "test_prefix.py", "test_mesh_motion.py", "test_fit.py", "test_fit_table.py", "test_readings.py",
    "test_encode.py",
)  # fmt: skip
LAWS = ("test_mesh_motion_laws.py",)


def suite_notices() -> bool:
    from snhc.conformance.adapters import BuiltIn
    from snhc.conformance.compare import judge
    from snhc.vectors.manifest import SUITE, load

    decoder = BuiltIn()
    # Small ones first: most mutations fall at once.
    entries = sorted(load(SUITE, check_schema=False).entries, key=lambda entry: (SUITE / entry.file).stat().st_size)
    for entry in entries:
        outcome = decoder.decode(entry, SUITE / entry.file, SUITE / entry.aux if entry.aux else None)
        verdict = judge(entry, outcome, SUITE, "ndjson")
        if verdict.status not in ("pass", "not_applicable"):
            print(f"{entry.id}: {verdict.reason}")
            return True
    return False


def tests_notice(root: Path) -> bool:
    files = [f"tests/unit/{name}" for name in TESTS] + [f"tests/properties/{name}" for name in LAWS]
    command = [
        sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--hypothesis-seed=0",
        *files,
    ]  # fmt: skip
    done = subprocess.run(command, cwd=root, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}, check=False)
    return done.returncode != 0


if __name__ == "__main__":
    sys.exit(1 if suite_notices() or tests_notice(Path(__file__).resolve().parents[2]) else 0)
