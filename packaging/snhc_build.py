"""The build backend: setuptools, which first compiles the codec's hot modules where the machine can.

One source, two forms: the modules of `HOT` are compiled by mypyc from the same files that run uncompiled. Where there
is no C compiler, no Python headers, or the compilation fails, the package is built pure and one line says why.

Environment: `SNHC_PURE=1` builds the pure form and asks for no compiler; `SNHC_COMPILE=1` makes a form that could not
be compiled an error, and compiles editable installs too (which are pure otherwise: a compiled module does not follow
its source).
"""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from setuptools import Extension
from setuptools import build_meta as _setuptools
from setuptools.build_meta import (
    build_sdist,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable", "build_sdist", "build_wheel", "get_requires_for_build_editable", "get_requires_for_build_sdist",
    "get_requires_for_build_wheel", "prepare_metadata_for_build_editable", "prepare_metadata_for_build_wheel",
]  # fmt: skip

ROOT = Path(__file__).parents[1]
COMPILER = "mypy>=2.4,<3"

# The compiled group: what runs per bit, symbol, element or value. No click and no numpy inside, no frozen dataclasses
# (they stay interpreted), and nothing that tests patch from outside.
HOT = (
    "bitstream/cursor",
    "bitstream/sink",
    "entropy/blocks",
    "entropy/kernel",
    "entropy/literal",
    "entropy/model",
    "entropy/prefix",
    "entropy/shares",
    "face/columns",
    "face/dct_syntax",
    "face/dct_transform",
    "face/encode",
    "face/encode_part",
    "face/parameters",
    "face/reconstruct",
    "face/records",
    "face/state",
    "face/syntax",
    "mesh/motion",
    "mesh/records",
    "mesh/state",
    "mesh/syntax",
    "syntax/base",
    "syntax/element",
    "syntax/faulty",
    "syntax/reader",
    "syntax/temporal",
    "syntax/tracer",
    "syntax/writer",
    "systems/visual",
)

# No configuration file, and none of the libraries: the build environment has mypy and nothing else.
_MYPY_OPTIONS = ("--config-file=", "--namespace-packages", "--explicit-package-bases", "--ignore-missing-imports")

# What setup.py hands to setuptools; filled while a compiled form is built.
EXTENSIONS: list[Extension] = []


class CannotCompile(Exception):
    """Why the compiled form cannot be made, in one line."""


def _flag(name: str) -> bool:
    return os.environ.get(name, "") not in ("", "0")


def wanted(editable: bool) -> bool:
    """Whether the environment asks for the compiled form, or leaves it to the machine."""
    if _flag("SNHC_PURE"):
        return False
    return _flag("SNHC_COMPILE") or not editable


def check_compiler() -> None:
    """Compile three lines against the Python headers. Raises CannotCompile."""
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "")
    if not command or shutil.which(command[0]) is None:
        raise CannotCompile(f"no C compiler ({command[0] if command else 'CC is not set'})")
    include = [f"-I{sysconfig.get_path(key)}" for key in ("include", "platinclude")]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "probe.c")
        source.write_text("#include <Python.h>\nint probe(void) { return PY_VERSION_HEX != 0; }\n")
        probe = [*command, *include, "-c", str(source), "-o", str(source.with_suffix(".o"))]
        try:
            done = subprocess.run(probe, capture_output=True, text=True, timeout=120, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise CannotCompile(f"the C compiler {command[0]} does not run: {error}") from error
        if done.returncode or not source.with_suffix(".o").exists():
            missing = "Python.h" in done.stderr
            what = "no Python headers (Python.h)" if missing else f"the C compiler {command[0]} compiles nothing"
            raise CannotCompile(what)


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """mypy, whose mypyc compiles, only where there is something to compile with."""
    return [*_setuptools.get_requires_for_build_wheel(config_settings), *_compiler_requirement(editable=False)]


def get_requires_for_build_editable(config_settings: Any = None) -> list[str]:
    """As for a wheel, with SNHC_COMPILE=1 only."""
    return [*_setuptools.get_requires_for_build_editable(config_settings), *_compiler_requirement(editable=True)]


def _compiler_requirement(editable: bool) -> list[str]:
    if not wanted(editable):
        return []
    try:
        check_compiler()
    except CannotCompile:
        # Said once, when the wheel is built.
        return []
    return [COMPILER]


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """A wheel of the compiled form if it can be had, else of the pure one."""
    return _build(_setuptools.build_wheel, False, wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """An editable wheel, of the pure form but for SNHC_COMPILE=1."""
    return _build(_setuptools.build_editable, True, wheel_directory, config_settings, metadata_directory)


def _build(build: Any, editable: bool, *arguments: Any) -> str:
    if wanted(editable):
        try:
            check_compiler()
            with _translated() as extensions:
                EXTENSIONS.extend(extensions)
                return str(build(*arguments))
        # mypyc and setuptools end a failed compilation in SystemExit or any error: all of them mean "pure".
        except (Exception, SystemExit) as error:
            if _flag("SNHC_COMPILE"):
                raise
            line = next(iter(str(error).splitlines()), "") or type(error).__name__
            print(f"snhc: built in the pure form: {line}", file=sys.stderr)  # noqa: T201
        finally:
            EXTENSIONS.clear()
    _forget_builds()
    return str(build(*arguments))


@contextlib.contextmanager
def _translated() -> Iterator[list[Extension]]:
    """The hot modules as C, under the names that they are installed by."""
    from mypyc.build import mypycify

    _forget_builds()
    here = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="snhc-build-") as folder:
        # The folders of the repository are installed below `snhc`: mypyc must see them there.
        stage = Path(folder, "stage")
        (stage / "snhc").mkdir(parents=True)
        (stage / "snhc" / "reference_impl").symlink_to(ROOT / "reference_impl", target_is_directory=True)
        files = [f"snhc/reference_impl/{module}.py" for module in HOT]
        os.chdir(stage)
        try:
            extensions = mypycify(
                [*_MYPY_OPTIONS, *files],
                only_compile_paths=files,
                # Measured: -O3 takes 28 s instead of 18 and decodes no faster.
                opt_level="1",
                debug_level="0",
                target_dir=str(Path(folder, "c")),
                group_name="snhc",
            )
        finally:
            os.chdir(here)
        if os.name == "posix":
            # Products and sums are rounded one by one, as in the pure form: no machine may make one operation of both.
            for extension in extensions:
                extension.extra_compile_args.append("-ffp-contract=off")
        yield extensions


def _forget_builds() -> None:
    """Remove what earlier builds left behind, or a wheel would hold modules of the other form."""
    build = ROOT / "build"
    for old in (*build.glob("lib*"), *build.glob("temp*"), *build.glob("bdist*")):
        shutil.rmtree(old, ignore_errors=True)
