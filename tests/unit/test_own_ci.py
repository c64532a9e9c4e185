"""The suite in the tests and the CI of another project: pytest plugin and GitHub Action, in a little project.

Rules: CNF-13, CNF-15, CNF-17, CNF-19.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from snhc.conformance.reports.json import SCHEMA_FILE as REPORT_SCHEMA

ROOT = Path(__file__).parents[2]
HARNESS = ROOT / "tests" / "harness"
PYTHON = os.path.realpath(sys.executable)
FILTER = "fap.arith.example.1|fap.arith.example.2|fba.error.time-code.hours-24"


def _adapter(project: Path, script: str, name: str = "decoder.toml", more: str = "") -> Path:
    path = project / name
    command = json.dumps([PYTHON, "-S", str(HARNESS / f"{script}.py"), "{input}"])
    path.write_text(f'name = "{script}"\ncommand = {command}\n{more}')
    return path


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with a test of its own, strict about everything."""
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_own.py").write_text("def test_own() -> None:\n    assert 1 + 1 == 2\n")
    (tmp_path / "pyproject.toml").write_text(
        '[tool.pytest.ini_options]\naddopts = ["--strict-markers", "--strict-config", "-p", "no:cacheprovider"]\n'
        'testpaths = ["tests"]\nfilterwarnings = ["error"]\n'
    )
    return tmp_path


def _pytest(project: Path, *words: str, installed: bool = False) -> tuple[int, str]:
    """`installed`: all plugins of the environment are loaded, which takes its time; else this one alone."""
    plugin = [] if installed else ["-p", "snhc.conformance.pytest_plugin"]
    alone = {} if installed else {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-rA", "--color=no", *plugin, *words], cwd=project, text=True,
        capture_output=True, env={**os.environ, **alone}, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


# -- pytest ------------------------------------------------------------------------------------------------------------


def test_a_pytest_that_does_not_ask_for_it_gets_nothing(project: Path) -> None:
    (project / "conftest.py").write_text(
        "import sys\n\n\ndef pytest_unconfigure(config):\n"
        "    loaded = [name for name in sys.modules if name.startswith('snhc.')]\n"
        "    print('loaded:', sorted(loaded))\n"
    )
    code, output = _pytest(project, "-s", installed=True)
    assert code == 0 and "1 passed" in output
    loaded = re.search(r"loaded: (.*)", output)
    assert loaded is not None and loaded[1] == "['snhc.conformance', 'snhc.conformance.pytest_plugin']"


def test_every_vector_is_a_test(project: Path) -> None:
    _adapter(project, "correct")
    code, output = _pytest(project, "--snhc-adapter", "decoder.toml", "--snhc-filter", FILTER)
    assert code == 0 and "4 passed" in output
    for id in FILTER.split("|"):
        assert f"PASSED decoder.toml::{id}" in output
    code, output = _pytest(project, "--snhc-adapter", "decoder.toml", "tests/test_own.py", "-m", "snhc_stress",
                           "--snhc-filter", "fap.*")  # fmt: skip
    assert code == 0 and "passed" in output and "test_own" not in output


def test_a_failure_says_what_and_where(project: Path) -> None:
    _adapter(project, "wrong_value")
    code, output = _pytest(project, "--snhc-adapter", "decoder.toml", "--snhc-filter", FILTER)
    assert code == 1 and "2 failed, 2 passed" in output
    assert "fail: frame 2, FAP 3 (faps): reference 140, candidate 141" in output
    assert "where: plane[2]" in output and "rules: FBA-1" in output and "again: snhc run" in output
    assert "Traceback" not in output and "pytest_vectors.py" not in output


def test_configured_adapters_run_where_no_path_is_named(project: Path) -> None:
    _adapter(project, "correct")
    with (project / "pyproject.toml").open("a") as file:
        file.write(f'snhc_adapters = ["decoder.toml"]\nsnhc_filter = "{FILTER}"\n')
    assert "4 passed" in _pytest(project)[1]
    assert "1 passed" in _pytest(project, "tests/test_own.py")[1]
    assert "1 passed" in _pytest(project, "decoder.toml::fap.arith.example.2")[1]
    # Rules are keywords; the workers of pytest-xdist find the same tests.
    assert "2 passed" in _pytest(project, "-k", "FBA-1", "-p", "xdist", "-n", "2")[1]


def test_what_is_not_claimed_is_skipped_and_nothing_but_that_is_a_failure(project: Path) -> None:
    _adapter(project, "correct", more='kinds = ["valid"]\n')
    words = ("--snhc-adapter", "decoder.toml", "--snhc-filter")
    code, output = _pytest(project, *words, FILTER)
    assert code == 0 and "3 passed, 1 skipped" in output and "not claimed: invalid vectors" in output
    code, output = _pytest(project, *words, "fba.error.time-code.hours-24")
    assert code == 1 and "snhc: no vector passed" in output
    code, output = _pytest(project, *words, "no.such.vector")
    assert code == 2 and "selects no vector" in output


def test_known_failures_of_a_ledger_are_expected(project: Path) -> None:
    _adapter(project, "wrong_value")
    (project / "known.toml").write_text(
        '[[known]]\nadapter = "wrong_value"\nvectors = "fap.arith.example.1"\nreason = "one off"\n'
        'link = "urn:issue:1"\nexpires = 2999-01-01\n'
    )
    words = ("--snhc-adapter", "decoder.toml", "--snhc-filter", FILTER, "--snhc-ledger", "known.toml")
    code, output = _pytest(project, *words)
    assert code == 1 and "1 failed, 2 passed, 1 xfailed" in output, output


def test_wrong_words_are_usage_errors(project: Path) -> None:
    code, output = _pytest(project, "--snhc-adapter", "none.toml")
    assert code == 4 and "there is no file" in output
    (project / "bad.toml").write_text("comand = ['x']\n")
    code, output = _pytest(project, "--snhc-adapter", "bad.toml")
    assert code == 2 and "did you mean command?" in output and "Traceback" not in output


# -- the action --------------------------------------------------------------------------------------------------------

ACTION = yaml.safe_load((ROOT / "action.yml").read_text())


def test_the_action_is_a_composite_one_and_names_no_host() -> None:
    assert ACTION["runs"]["using"] == "composite"
    assert {"name", "description", "inputs", "outputs", "runs"} <= set(ACTION)
    for step in ACTION["runs"]["steps"]:
        assert set(step) <= {"name", "id", "shell", "env", "run"} and step["shell"] == "bash"
        # What users give comes in through the environment: pasted into a script it would be code.
        assert "${{" not in step["run"]
    text = (ROOT / "action.yml").read_text()
    assert "://" not in text and not re.search(r"\b[\w-]+\.(org|com|io|net)\b", text)
    for name in re.findall(r"inputs\.(\w+)", text):
        assert name in ACTION["inputs"]
    for name, entry in ACTION["inputs"].items():
        assert entry["description"] and (entry.get("required") or "default" in entry), name


def _values(env: dict[str, str], inputs: dict[str, str], temporary: Path) -> dict[str, str]:
    def filled(match: re.Match[str]) -> str:
        name = match[1].strip()
        if name == "github.action_path":
            return str(ROOT)
        return inputs.get(name.removeprefix("inputs."), ACTION["inputs"][name.removeprefix("inputs.")].get("default"))

    return {name: re.sub(r"\$\{\{(.*?)\}\}", filled, value) for name, value in env.items()}


def _act(project: Path, steps: list[dict[str, Any]], **inputs: str) -> tuple[int, str, dict[str, str]]:
    """Run steps as a runner would: exit code of the first that fails, output, and what was set."""
    temporary = project / "runner"
    (temporary / "snhc" / "bin").mkdir(parents=True, exist_ok=True)
    # The package of this very environment stands in for the first step, which needs a package index.
    program = temporary / "snhc" / "bin" / "snhc"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m snhc.conformance.cli "$@"\n')
    program.chmod(0o755)
    files = {name: project / name.lower() for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    for path in files.values():
        path.write_text("")
    output, code = "", 0
    for step in steps:
        done = subprocess.run(
            ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", "-c", step["run"]], cwd=project, text=True,
            env={**os.environ, "RUNNER_TEMP": str(temporary), **{name: str(path) for name, path in files.items()},
                 **_values(step.get("env", {}), inputs, temporary)},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        output += done.stdout
        code = done.returncode
        if code:
            break
    return code, output, {name: path.read_text() for name, path in files.items()}


def test_the_steps_of_the_action_pass_and_leave_reports(project: Path) -> None:
    _adapter(project, "correct")
    code, output, said = _act(project, ACTION["runs"]["steps"][1:], adapter="decoder.toml\n", filter=FILTER)
    assert code == 0, output
    assert said["GITHUB_OUTPUT"] == "verdict=pass\n" and "correct" in said["GITHUB_STEP_SUMMARY"]
    assert "the adapter is in order" in output and "3 pass" in output
    folder = project / "snhc-report"
    assert {path.name for path in folder.iterdir()} == {"report.json", "junit.xml", "report.sarif", "report.html"}
    jsonschema.validate(json.loads((folder / "report.json").read_text()), json.loads(REPORT_SCHEMA.read_text()))


def test_the_action_fails_with_a_decoder_that_is_wrong_and_says_why(project: Path) -> None:
    _adapter(project, "wrong_value")
    _adapter(project, "correct", "second $(touch hit).toml")
    code, _, said = _act(
        project, ACTION["runs"]["steps"][1:], adapter="decoder.toml\nsecond $(touch hit).toml\n", filter=FILTER,
        report="out", shard="1/1",
    )  # fmt: skip
    assert code == 1 and said["GITHUB_OUTPUT"] == "verdict=fail\n"
    assert "fap.arith.example.1" in said["GITHUB_STEP_SUMMARY"] and (project / "out" / "report.html").is_file()
    assert not (project / "hit").exists()


def test_the_action_stops_at_an_adapter_that_is_wrong(project: Path) -> None:
    (project / "decoder.toml").write_text("comand = ['x']\n")
    code, output, _ = _act(project, ACTION["runs"]["steps"][1:], adapter="decoder.toml")
    assert code == 5 and "did you mean command?" in output and not (project / "snhc-report").exists()


def test_the_first_step_of_the_action_makes_an_environment(project: Path) -> None:
    # Without a package index its script can at least be read.
    done = subprocess.run(["bash", "-n", "-c", ACTION["runs"]["steps"][0]["run"]], check=False)
    assert done.returncode == 0 and "$SNHC_SOURCE" in ACTION["runs"]["steps"][0]["run"]
