"""The build backend: compiled where it can be, else pure with one line that says why.

Wheels are built from a copy of the sources without the suite; a fake compiler stands for a broken one.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
BACKEND = ROOT / "packaging" / "snhc_build.py"
BUILD = "import snhc_build, sys; print('wheel:', snhc_build.build_wheel(sys.argv[1]))"


@pytest.fixture
def backend(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    for name in ("SNHC_PURE", "SNHC_COMPILE", "CC"):
        monkeypatch.delenv(name, raising=False)
    spec = importlib.util.spec_from_file_location("snhc_build", BACKEND)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _compiler(folder: Path, script: str) -> str:
    """A C compiler that is a shell script."""
    path = folder / "cc"
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return str(path)


def test_every_hot_module_is_a_file(backend: ModuleType) -> None:
    assert sorted(backend.HOT) == list(backend.HOT)
    assert all((ROOT / "reference_impl" / f"{module}.py").is_file() for module in backend.HOT)


def test_the_environment_decides(backend: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    assert backend.wanted(editable=False) and not backend.wanted(editable=True)
    monkeypatch.setenv("SNHC_COMPILE", "1")
    assert backend.wanted(editable=True)
    monkeypatch.setenv("SNHC_PURE", "1")
    assert not backend.wanted(editable=False) and not backend.wanted(editable=True)
    assert backend.get_requires_for_build_wheel() == backend._setuptools.get_requires_for_build_wheel()


@pytest.mark.parametrize("command", ["/nowhere/cc", "no-such-compiler -O2"])
def test_no_compiler(backend: ModuleType, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    monkeypatch.setenv("CC", command)
    with pytest.raises(backend.CannotCompile, match="no C compiler"):
        backend.check_compiler()
    assert not any("mypy" in requirement for requirement in backend.get_requires_for_build_wheel())


def test_a_compiler_without_python_headers(
    backend: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # A compiler of our own, so that the test says the same where there is none: it only looks for the header.
    script = 'for a in "$@"; do case "$a" in -I*) [ -e "${a#-I}/Python.h" ] && touch "$out"; esac; done\n'
    script = 'for a; do [ "$p" = -o ] && out=$a; p=$a; done\n' + script
    script += '[ -e "$out" ] || { echo "fatal error: Python.h: No such file or directory" >&2; exit 1; }'
    monkeypatch.setenv("CC", _compiler(tmp_path, script))
    (tmp_path / "Python.h").touch()
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    backend.check_compiler()
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path / "empty"))
    with pytest.raises(backend.CannotCompile, match=r"no Python headers \(Python\.h\)"):
        backend.check_compiler()


def test_a_compiler_that_does_nothing(backend: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CC", _compiler(tmp_path, "exit 0"))
    with pytest.raises(backend.CannotCompile, match="compiles nothing"):
        backend.check_compiler()
    monkeypatch.setenv("CC", str(tmp_path))
    with pytest.raises(backend.CannotCompile, match="no C compiler"):
        backend.check_compiler()


def _built(tmp_path: Path, **environment: str) -> tuple[str, str, int]:
    """(standard output, standard error, exit code) of a build in a copy of the sources."""
    tree = tmp_path / "tree"
    for name in ("reference_impl", "analyzer", "vectors", "conformance", "packaging"):
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("suite", "__pycache__", "examples"))
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "MANIFEST.in"):
        shutil.copy(ROOT / name, tree)
    done = subprocess.run(
        [sys.executable, "-c", BUILD, str(tmp_path)],
        cwd=tree,
        env={**os.environ, "SNHC_PURE": "0", "SNHC_COMPILE": "0", **environment, "PYTHONPATH": str(tree / "packaging")},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout, done.stderr, done.returncode


def test_a_compilation_that_fails_ends_in_the_pure_form(tmp_path: Path) -> None:
    # Takes the probe, and nothing else.
    passing = 'for a; do [ "$p" = -o ] && out=$a; p=$a; done\ncase "$*" in *probe.c*) touch "$out";; *) exit 1;; esac'
    command = _compiler(tmp_path, passing)
    out, err, code = _built(tmp_path, CC=command)
    assert not code, err
    assert "-py3-none-any.whl" in out
    said = [line for line in err.splitlines() if line.startswith("snhc: ")]
    assert len(said) == 1 and said[0].startswith("snhc: built in the pure form: ")


def test_a_form_that_must_be_compiled_is_an_error(tmp_path: Path) -> None:
    out, err, code = _built(tmp_path, CC=_compiler(tmp_path, "exit 1"), SNHC_COMPILE="1")
    assert code and "CannotCompile" in err
    assert "wheel:" not in out


def test_pure_asks_for_no_compiler(tmp_path: Path) -> None:
    out, err, code = _built(tmp_path, CC=_compiler(tmp_path, "touch called; exit 1"), SNHC_PURE="1")
    assert not code, err
    assert "-py3-none-any.whl" in out
    assert "snhc: " not in err
    assert not (tmp_path / "tree" / "called").exists()
