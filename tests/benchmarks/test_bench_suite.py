"""Speed of the suite as a whole: made anew, run with the built-in decoder, exported.

On two cores the first takes less than 60 s and the second less than 30 s: that much is promised, and checked here.
"""

from __future__ import annotations

from typing import Any

from snhc.conformance.adapters import BuiltIn
from snhc.conformance.runner import run
from snhc.vectors.export import export_files
from snhc.vectors.generate import build_suite
from snhc.vectors.manifest import SUITE, load


def test_regenerate_the_whole_suite(benchmark: Any) -> None:
    files = benchmark.pedantic(build_suite, rounds=3)
    assert len(files) > 1000
    assert benchmark.stats["min"] < 60.0


def test_validate_the_whole_suite(benchmark: Any) -> None:
    manifest = load()
    report = benchmark.pedantic(lambda: run(manifest, [BuiltIn()], suite=SUITE, jobs=2), rounds=3)
    assert report.exit_code == 0 and len(report.results) == len(manifest.entries)
    assert benchmark.stats["min"] < 30.0


def test_export_the_whole_suite(benchmark: Any) -> None:
    files = benchmark.pedantic(export_files, rounds=3)
    assert "SHA256SUMS" in files
