"""Temporary folders: gone with their process, whatever ended it, and never taken from one that lives.

Rules: CNF-14, CNF-20.
"""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from snhc.conformance import scratch as module
from snhc.conformance.scratch import PREFIX, Scratch, scratch, sweep

HOLD = "import sys; from snhc.conformance.scratch import Scratch; print(Scratch().path, flush=True); sys.stdin.read()"


@pytest.fixture
def base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def _holder(base: Path) -> tuple[subprocess.Popen[bytes], Path]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(base)},
    )  # fmt: skip
    assert process.stdout is not None
    path = Path(process.stdout.readline().decode().strip())
    (path / "deep").mkdir()
    (path / "deep" / "file").write_bytes(b"content")
    return process, path


def test_the_next_process_clears_what_a_killed_one_left_and_nothing_of_a_live_one(base: Path) -> None:
    (live, kept), (dead, left) = _holder(base), _holder(base)
    try:
        assert sweep(base) == []
        dead.send_signal(signal.SIGKILL)
        dead.wait(timeout=30)
        assert left.exists()
        with scratch() as own:
            assert not left.exists() and kept.exists() and own.exists()
            # Its own are live too.
            assert sweep(base) == []
        assert list(base.iterdir()) == [kept]
    finally:
        for process in (live, dead):
            process.kill()
            process.communicate()


def test_what_is_not_ours_stays(base: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "file").write_bytes(b"")
    elsewhere.chmod(0o700)
    for name in ("snhc-suite", "snhc-41h3zs10", f"{PREFIX}results", f"{PREFIX}abcdefgh.tar"):
        (base / name).mkdir(mode=0o700)
    (base / f"{PREFIX}filefile").write_bytes(b"a file")
    (base / f"{PREFIX}linklink").symlink_to(elsewhere, target_is_directory=True)
    (base / f"{PREFIX}openopen").mkdir()
    (base / f"{PREFIX}openopen").chmod(0o755)
    before = sorted(base.iterdir())
    assert sweep(base) == []
    assert sorted(base.iterdir()) == before and (elsewhere / "file").exists()
    assert sweep(base / "nowhere") == []


def test_a_folder_that_was_cleared_before_it_was_locked_is_made_anew(
    base: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    real = tempfile.mkdtemp

    def mkdtemp(**words: str) -> str:
        path = real(**words)
        made.append(path)
        if len(made) == 1:
            assert sweep(base) == [Path(path)]
        return path

    monkeypatch.setattr(module.tempfile, "mkdtemp", mkdtemp)
    own = Scratch()
    assert str(own.path) == made[1] and own.path.is_dir()
    own.close()
    assert list(base.iterdir()) == []


def _once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second folder is a fault: the first one is good."""
    real = tempfile.mkdtemp
    monkeypatch.setattr(module.tempfile, "mkdtemp", real)
    left = [None]

    def mkdtemp(**words: str) -> str:
        left.pop()
        return real(**words)

    monkeypatch.setattr(module.tempfile, "mkdtemp", mkdtemp)


def test_below_a_folder_that_hands_its_group_on(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # What is made there has the bit too.
    base.chmod(0o2770)
    process, left = _holder(base)
    process.kill()
    process.communicate()
    assert left.stat().st_mode & 0o7777 == 0o2700
    _once(monkeypatch)
    with scratch() as own:
        assert own.is_dir() and not left.exists()
        assert sweep(base) == []


def test_where_there_are_no_locks_nothing_is_cleared(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = base / f"{PREFIX}leftleft"
    left.mkdir(mode=0o700)

    def flock(held: int, how: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(module.fcntl, "flock", flock)
    _once(monkeypatch)
    with scratch() as own:
        assert own.is_dir()
    assert left.is_dir() and not own.exists()
