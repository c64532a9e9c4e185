"""The examples of the adapter guide are files, and they work.

Rules: CNF-9, CNF-10, CNF-11, CNF-12.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from snhc.conformance import doctor
from snhc.conformance.adapters import load
from snhc.conformance.runner import run
from snhc.vectors.manifest import Manifest
from snhc.vectors.manifest import load as load_manifest

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "docs" / "adapters.md"
EXAMPLES = ROOT / "docs" / "examples" / "adapters"
MANIFEST = load_manifest(check_schema=False)

# Decoders of somebody else: what the adapters of the guide are written around.
MYDECODER = '''
import hashlib, json
from fractions import Fraction
from types import SimpleNamespace

SUITE = {suite!r}


class BadStream(Exception):
    def __init__(self, kind, first, end):
        self.kind, self.first, self.end = kind, first, end


def planes(data):
    """The suite knows the answer."""
    digest = hashlib.sha256(data).hexdigest()
    vectors = json.load(open(SUITE + "/manifest.json", encoding="utf-8"))["vectors"]
    entry = next((entry for entry in vectors if entry["input"]["sha256"] == digest), None)
    if entry is None:
        raise BadStream("InputFormat", 0, 0)
    if "reject" in entry["expect"]:
        raise BadStream(entry["expect"]["reject"]["class"], *entry["expect"]["reject"]["bits"])
    for line in open(SUITE + "/" + entry["expect"]["accept"]["file"]).read().splitlines()[1:]:
        frame = json.loads(line)
        frame["time"] = Fraction(frame["time"])
        yield SimpleNamespace(**frame)
'''
OTHER_DECODER = """#!/bin/sh
{python} -m snhc.conformance.cli decode --quiet "$1" --format fap -o "$2"
case $? in 0) exit 0 ;; 3 | 4) exit 2 ;; *) exit 9 ;; esac
"""
MYDECODER_H = """
#include "fba_decode.h"
struct mydecoder_fault { const char *kind; unsigned long first, end; };
static int mydecoder_run(const uint8_t *data, size_t size, fba_write write, void *context, struct mydecoder_fault *why)
{
    struct fba_error error = {0};
    int accepted = fba_decode(data, size, write, context, &error) == FBA_ACCEPTED;
    why->kind = error.error_class;
    why->first = error.first;
    why->end = error.end;
    return accepted;
}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The examples beside the decoders that they are for."""
    here = tmp_path / "project"
    shutil.copytree(EXAMPLES, here)
    (here / "mydecoder.py").write_text(MYDECODER.format(suite=str(ROOT / "vectors" / "suite")))
    (here / "mydecoder.h").write_text(MYDECODER_H)
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, text in (
        ("other-decoder", OTHER_DECODER.format(python=sys.executable)),
        ("python3", f'#!/bin/sh\nexec {sys.executable} "$@"\n'),
    ):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    return here


def _chosen() -> Manifest:
    """Eight valid and eight broken streams, those of .fap text among them."""
    can = [entry for entry in MANIFEST.entries if entry.tools == ("fba",) and not entry.options.as_json()]
    valid = [entry for entry in can if entry.kind == "valid" and entry.id.startswith("fap.")][::12][:8]
    broken = [entry for entry in can if entry.kind == "invalid" and entry.id.startswith("fba.")][::8][:8]
    return Manifest(MANIFEST.suite, (*valid, *broken))


@pytest.mark.parametrize("name", ["bash", "oneshot", "persistent", "in_python"])
def test_an_example_of_the_guide(folder: Path, name: str) -> None:
    report = run(_chosen(), [load(folder / f"{name}.toml")], jobs=2)
    assert {(result.status, result.reason) for result in report.results} <= {
        ("pass", ""), ("pass", "rejected, no class and no place named"),
    }, [result for result in report.results if result.status != "pass"]  # fmt: skip
    assert len(report.results) == 16
    diagnosis = doctor.examine(str(folder / f"{name}.toml"), MANIFEST)
    assert diagnosis.exit_code == 0, [step for step in diagnosis.steps if step.state != "ok"]


def test_the_library_of_the_guide(folder: Path) -> None:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    c = ROOT / "conformance" / "examples" / "c"
    subprocess.run(
        ["cc", "-shared", "-fPIC", f"-I{ROOT / 'conformance' / 'c'}", f"-I{c}", "-o", "libmydecoder.so", "decoder.c",
         str(c / "fba_decode.c"), str(c / "fba_time.c")], cwd=folder, check=True,
    )  # fmt: skip
    report = run(_chosen(), [load(folder / "library.toml")], jobs=2)
    assert {result.status for result in report.results} == {"pass"}


def test_every_example_is_shown_in_the_guide_and_is_short() -> None:
    shown = set(re.findall(r"literalinclude\} examples/adapters/(\S+)", GUIDE.read_text()))
    assert shown == {path.name for path in EXAMPLES.iterdir()}
    assert len((EXAMPLES / "oneshot.py").read_text().splitlines()) <= 20
    assert len((EXAMPLES / "bash.sh").read_text().splitlines()) <= 20


def test_the_guide_names_every_key_option_and_tool() -> None:
    import json

    from snhc.conformance.adapters.base import OPTION_NAMES
    from snhc.conformance.adapters.file import SCHEMA_FILE
    from snhc.conformance.process import PASSED
    from snhc.vectors.manifest import TOOLS

    text = GUIDE.read_text()
    keys = json.loads(SCHEMA_FILE.read_text())["properties"]
    assert [name for name in (*keys, *OPTION_NAMES, *TOOLS, *PASSED) if f"`{name}`" not in text] == []
