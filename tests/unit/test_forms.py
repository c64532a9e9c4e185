"""The two forms of the codec: which one runs, and that it does not matter.

`tox -e compiled` builds with SNHC_COMPILE=1 and sets SNHC_STREAMS=10000 for the comparison on generated streams.
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

from snhc.conformance.cli.version import form
from snhc.reference_impl._forms import _PureFinder

ROOT = Path(__file__).parents[2]
DIGESTS = ROOT / "tests" / "form_digests.py"
STREAMS = int(os.environ.get("SNHC_STREAMS", "300"))


def _python(*arguments: str, pure: bool) -> str:
    environment = {**os.environ, "SNHC_PURE": "1" if pure else "0", "PYTHONPATH": str(ROOT / "tests")}
    done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    return done.stdout


def test_pure_is_forced_at_run_time() -> None:
    assert _python("-m", "snhc.conformance.cli", "--version", pure=True).strip().endswith("(pure)")


def test_the_finder_prefers_sources(tmp_path: Path) -> None:
    extension = tmp_path / f"kernel{EXTENSION_SUFFIXES[0]}"
    source = tmp_path / "kernel.py"
    extension.write_bytes(b"")
    source.write_text("")
    spec = _PureFinder.find_spec("snhc.reference_impl.kernel", [str(tmp_path)])
    assert spec is not None and spec.origin == str(source)
    # Other packages' extensions are none of our business.
    assert _PureFinder.find_spec("elsewhere.kernel", [str(tmp_path)]) is None
    # A module that is only there compiled has no pure form: that is said, not passed over.
    source.unlink()
    with pytest.raises(ImportError, match="kernel"):
        _PureFinder.find_spec("snhc.reference_impl.kernel", [str(tmp_path)])


def test_both_forms_say_the_same_of_generated_streams() -> None:
    """Each stream's digest; the first that differs is named. Trivial where only the pure form was built."""
    if form() != "compiled":
        pytest.skip("compares with the compiled form, which does not run here")
    pure, compiled = (_python(str(DIGESTS), "0", str(STREAMS), pure=which) for which in (True, False))
    differing = [a for a, b in zip(pure.splitlines(), compiled.splitlines(), strict=True) if a != b]
    assert not differing, f"stream {differing[0].split()[0]}: python tests/form_digests.py {differing[0].split()[0]} 1"
    assert len(pure.splitlines()) == STREAMS
