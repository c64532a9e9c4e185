"""Speed of running decoders: 1,000 vectors one-shot and persistent. Figures are printed by pytest-benchmark.

Issue 7 asks for less than 15 s one-shot (decoders in stdlib Python) and less than 10 s persistent, on 2 cores. Nothing
is asserted about time: a busy machine is no bug.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from itertools import cycle, islice
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from snhc.conformance.adapters import Adapter, OneShot, Persistent
from snhc.conformance.runner import run
from snhc.vectors.manifest import Manifest, load

VECTORS = 1000
PYTHON = os.path.realpath(sys.executable)
# The least that a decoder does: read its input, and print an answer that is found by the input's name.
ONE_SHOT = """
import os, sys
suite, path = sys.argv[1:3]
data = open(path, "rb").read()
stem = os.path.basename(path).rpartition(".")[0]
answer = os.path.join(suite, stem.partition(".")[0], stem + ".ndjson")
if not os.path.exists(answer):
    sys.exit(1)
sys.stdout.write(open(answer).read())
"""
PERSISTENT = """
import json, os, sys
suite = sys.argv[1]
for line in sys.stdin:
    question = json.loads(line)
    answer = {"seq": question["seq"], "type": question["type"]}
    if question["type"] == "hello":
        answer |= {"protocol": "snhc-adapter", "version": 1, "tools": ["fba"]}
    elif question["type"] == "decode":
        data = open(question["input"], "rb").read()
        stem = os.path.basename(question["input"]).rpartition(".")[0]
        path = os.path.join(suite, stem.partition(".")[0], stem + ".ndjson")
        if os.path.exists(path):
            answer |= {"status": "accepted", "output": open(path).read()}
        else:
            answer |= {"status": "rejected", "error": {}}
    print(json.dumps(answer), flush=True)
    if question["type"] == "bye":
        break
"""


@pytest.fixture(scope="module")
def manifest() -> Manifest:
    """Face streams of the suite, again and again, each time under another id."""
    whole = load(check_schema=False)
    can = [
        entry
        for entry in whole.entries
        if entry.tools == ("fba",) and not entry.options.as_json() and entry.kind != "ambiguous"
    ]
    entries = [replace(entry, id=f"{entry.id}.{i}") for i, entry in enumerate(islice(cycle(can), VECTORS))]
    return Manifest(whole.suite, tuple(entries))


def _adapter(kind: str, folder: Path) -> Adapter:
    from snhc.vectors.manifest import SUITE

    script = folder / f"{kind}.py"
    script.write_text(ONE_SHOT if kind == "one-shot" else PERSISTENT)
    command = (PYTHON, "-I", "-S", str(script), str(SUITE))
    return OneShot(kind, (*command, "{input}")) if kind == "one-shot" else Persistent(kind, command)


@pytest.mark.parametrize("kind", ["one-shot", "persistent"])
def test_a_thousand_vectors(benchmark: BenchmarkFixture, manifest: Manifest, tmp_path: Path, kind: str) -> None:
    adapter = _adapter(kind, tmp_path)
    report = benchmark.pedantic(lambda: run(manifest, [adapter], jobs=2), rounds=3, iterations=1, warmup_rounds=0)
    assert {result.status for result in report.results} == {"pass"}
    assert len(report.results) == VECTORS
