"""The recipe API as somebody else's CI uses it: the example of docs/recipes.md, run as a script of its own."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner

from snhc.conformance.cli import snhc
from snhc.vectors.builders import intra, stream
from snhc.vectors.generate import build_suite
from snhc.vectors.manifest import SCHEMA_FILE, load
from snhc.vectors.recipe import RECIPES, Accept, all_recipes, recipes_of, vector

PAGE = Path(__file__).parents[2] / "docs" / "recipes.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the script of the page was run."""
    folder = tmp_path_factory.mktemp("own")
    (script,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (folder / "own_vectors.py").write_text(script, encoding="utf-8")
    subprocess.run([sys.executable, "own_vectors.py"], cwd=folder, check=True)
    return folder


def test_it_makes_a_suite(folder: Path) -> None:
    document = json.loads((folder / "own-suite" / "manifest.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, json.loads(SCHEMA_FILE.read_text(encoding="utf-8")))
    assert (document["suite"], document["tombstones"]) == ("1.0.0", [])
    assert [entry["id"] for entry in document["vectors"]] == [
        "own.error.marker", "own.rate.12-5-hz", "own.rate.50-hz", "own.rate.8-hz", "own.speech.quant-9",
    ]  # fmt: skip


def test_the_runner_takes_it(folder: Path) -> None:
    done = CliRunner().invoke(snhc, ["run", "--suite", str(folder / "own-suite"), "--quiet"])
    assert done.exit_code == 0 and "5 pass" in done.output


def test_it_is_exported_and_compared_like_the_shipped_one(folder: Path) -> None:
    out = folder / "own-export"
    done = CliRunner().invoke(snhc, ["generate", "--suite", str(folder / "own-suite"), "--export", str(out)])
    assert done.exit_code == 0, done.output
    assert subprocess.run(["sha256sum", "-c", "--quiet", "SHA256SUMS"], cwd=out, check=False).returncode == 0
    done = CliRunner().invoke(snhc, ["generate", "--suite", str(folder / "own-suite"), "--changes", str(out)])
    assert (done.exit_code, done.stdout) == (0, "suite 1.0.0 -> 1.0.0: no changes\n")


def test_made_twice_it_is_the_same(folder: Path) -> None:
    def contents() -> dict[str, bytes]:
        root = folder / "own-suite"
        return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file()}

    before = contents()
    subprocess.run([sys.executable, "own_vectors.py"], cwd=folder, check=True)
    assert contents() == before and len(before) == 10
    assert len(load(folder / "own-suite").entries) == 5


def test_recipes_of_others_do_not_get_into_the_shipped_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    # Modules register their recipes once: all of them before the register is exchanged.
    before = all_recipes()
    monkeypatch.setattr("snhc.vectors.recipe.RECIPES", dict(RECIPES))

    @vector(id="own.test.one", title="T", tier="syntax", rules=["FBA-1"])
    def function() -> Accept:
        """A docstring."""
        return Accept(stream(intra({3: 5})))

    assert all_recipes() == before
    assert [recipe.id for recipe in recipes_of(__name__)] == ["own.test.one"]
    assert set(build_suite(recipes_of(__name__), version="3.0.0")) == {
        "manifest.json", "own/own.test.one.fba", "own/own.test.one.ndjson",
    }  # fmt: skip
