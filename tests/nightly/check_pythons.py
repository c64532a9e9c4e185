"""The suite on every Python that is found: `snhc generate --check` and `snhc run`, each in an environment of its own.

Rules: CNF-4. Run: `python tests/nightly/check_pythons.py [--python FILE ...]`, or `tox -e nightly`.

Looked at: `pythonX.Y` on the path, the versions of pyenv, and what `--python` adds. One interpreter per minor version
is taken, the newest. The package is built once, uncompiled, and installed as a stranger would, with its dependencies.
Three checks run with other hash seeds, locales and time zones, one of them with assertions off. Versions that are not
there are counted. Exit code 1 where a check fails, or where fewer than `--least` versions (2) could be run.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[2]
OLDEST: Final = 11
NEWEST: Final = 14
"""Minor versions of Python 3 that are looked for, and said to be missing."""
LEAST: Final = 2
ENVIRONMENTS: Final[tuple[Mapping[str, str], ...]] = (
    {"PYTHONHASHSEED": "0", "LC_ALL": "C", "TZ": "UTC"},
    {"PYTHONHASHSEED": "4242", "LC_ALL": "C.UTF-8", "TZ": "Pacific/Chatham", "PYTHONOPTIMIZE": "1"},
    {"PYTHONHASHSEED": "4294967295", "LC_ALL": "POSIX", "TZ": "America/St_Johns", "PYTHONUTF8": "0"},
)
_SECONDS: Final = 900


def candidates(given: list[str]) -> Iterator[Path]:
    """Interpreters that may be there."""
    yield from map(Path, given)
    for minor in range(OLDEST, NEWEST + 1):
        # A shim of pyenv answers for versions only that are switched on: its folders are looked at instead.
        found = shutil.which(f"python3.{minor}")
        if found is not None:
            yield Path(found)
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    yield from sorted((root / "versions").glob("*/bin/python3"))


def version_of(python: Path) -> tuple[int, int, int] | None:
    """(3, 12, 1); None for what does not answer, is no CPython-like 3, or cannot make environments."""
    code = "import ensurepip, sys, venv; print(*sys.version_info[:3])"
    try:
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    match = re.fullmatch(r"(\d+) (\d+) (\d+)\n", done.stdout)
    return (int(match[1]), int(match[2]), int(match[3])) if match and done.returncode == 0 else None


def pythons(given: list[str]) -> dict[tuple[int, int, int], Path]:
    """The newest interpreter of each minor version that is new enough."""
    best: dict[tuple[int, int], tuple[tuple[int, int, int], Path]] = {}
    for python in candidates(given):
        version = version_of(python)
        if version is None or version < (3, OLDEST):
            continue
        if version[:2] not in best or best[version[:2]][0] < version:
            best[version[:2]] = (version, python)
    return dict(sorted(best.values()))


def call(*command: str | Path, cwd: Path, **environment: str) -> str:
    """The output of a command that must succeed. Raises RuntimeError with what it said."""
    # Nothing of the environment that this runs in may help: not its packages, not its locale.
    own = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LC_", "LANG", "VIRTUAL"))
    }
    done = subprocess.run(
        command, cwd=cwd, env={**own, **environment}, capture_output=True, text=True, timeout=_SECONDS, check=False,
    )  # fmt: skip
    if done.returncode:
        tail = (done.stdout + done.stderr).strip().splitlines()[-5:]
        raise RuntimeError(
            f"{Path(command[0]).name} {' '.join(map(str, command[1:]))}: {done.returncode}\n" + "\n".join(tail)
        )
    return done.stdout


def check(python: Path, wheel: Path, folder: Path) -> str:
    """Install and check with one interpreter; what was found, in words. Raises RuntimeError."""
    call(python, "-m", "venv", folder, cwd=folder.parent)
    call(folder / "bin" / "python", "-m", "pip", "install", "--quiet", wheel, cwd=folder)
    said = []
    for environment in ENVIRONMENTS:
        began = time.monotonic()
        call(folder / "bin" / "snhc", "generate", "--check", cwd=folder, **environment)
        said.append(f"{time.monotonic() - began:.1f} s")
    lines = call(folder / "bin" / "snhc", "run", "--quiet", cwd=folder, **ENVIRONMENTS[0]).strip().splitlines()
    return f"generate --check {', '.join(said)}; {lines[-1] if lines else 'run: pass'}"


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> int:
    """Check all; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("--python", action="append", default=[], metavar="FILE", help="One more interpreter.")
    parser.add_argument("--least", type=int, default=LEAST, metavar="N", help="So many versions must be there.")
    arguments = parser.parse_args()
    found = pythons(arguments.python)
    good = bad = 0
    with tempfile.TemporaryDirectory(prefix="snhc-pythons-") as name:
        folder = Path(name)
        call(
            sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, ROOT, cwd=folder,
            SNHC_PURE="1",
        )  # fmt: skip
        (wheel,) = folder.glob("*.whl")
        for version, python in found.items():
            text = ".".join(map(str, version))
            try:
                _say(f"{text}: {check(python, wheel, folder / text)}")
                good += 1
            except (RuntimeError, subprocess.TimeoutExpired) as error:
                _say(f"{text}: FAILED: {error}")
                bad += 1
    have = {version[1] for version in found}
    missing = [f"3.{minor}" for minor in range(OLDEST, NEWEST + 1) if minor not in have]
    if missing:
        _say(f"not run: {len(missing)} versions of Python ({', '.join(missing)}: none found)")
    _say(f"{good} passed, {bad} failed")
    return 1 if bad or good < arguments.least else 0


if __name__ == "__main__":
    sys.exit(main())
