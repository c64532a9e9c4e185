"""Temporary folders that are gone with the process that made them, also one that was killed.

Rules: CNF-14, CNF-20.

A process holds a lock (flock) on each of its folders. The kernel takes the lock away with the process, however that
ends; whoever makes the first folder of its own clears those that nobody holds. A lock tells more than a process id:
ids come again, and mean nothing between containers that share a folder.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import shutil
import stat
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Final

# No name that a person gives a folder, and none that an older version gave: those held no lock.
PREFIX: Final = "snhc-scratch-"
_NAME: Final = re.compile(rf"{PREFIX}[a-z0-9_]{{8}}")
_OPENED: Final = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_lock: Final = threading.Lock()
_swept: Final[set[str]] = set()


class Scratch:
    """A temporary folder of this process. Rules: CNF-14. `lock`: the descriptor that holds its lock."""

    def __init__(self) -> None:
        base = tempfile.gettempdir()
        with _lock:
            if base not in _swept:
                _swept.add(base)
                sweep(Path(base))
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=PREFIX, dir=base))
            # Before it has its lock another process may clear it.
            with contextlib.suppress(FileNotFoundError):
                self.lock = os.open(self.path, _OPENED)
                # Where a file system knows no locks nobody gets one, and nothing is ever cleared.
                with contextlib.suppress(OSError):
                    fcntl.flock(self.lock, fcntl.LOCK_EX)
                if _is_at(self.lock, self.path):
                    return
                os.close(self.lock)

    def close(self) -> None:
        """Remove it, with all that is in it. Rules: CNF-14."""
        shutil.rmtree(self.path, ignore_errors=True)
        os.close(self.lock)


@contextlib.contextmanager
def scratch() -> Iterator[Path]:
    """A temporary folder for the block. Rules: CNF-14."""
    own = Scratch()
    try:
        yield own.path
    finally:
        own.close()


def sweep(base: Path) -> list[Path]:
    """Remove the folders of ours below `base` whose processes are gone; which they were. Rules: CNF-14, CNF-20."""
    gone: list[Path] = []
    with contextlib.suppress(OSError), os.scandir(base) as entries:
        for entry in entries:
            if _NAME.fullmatch(entry.name) is None:
                continue
            path = Path(entry.path)
            held = _taken(path)
            if held is None:
                continue
            try:
                shutil.rmtree(path, ignore_errors=True)
            finally:
                os.close(held)
            gone.append(path)
    return gone


def _taken(path: Path) -> int | None:
    """A descriptor that locks a folder of ours; None where another holds it, or it is not there or not ours."""
    try:
        held = os.open(path, _OPENED)
    except OSError:
        return None
    with contextlib.suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        inside = os.fstat(held)
        # Below a folder that hands its group on, the mode has that bit too.
        is_private = stat.S_IMODE(inside.st_mode) & 0o777 == 0o700
        if inside.st_uid == os.getuid() and is_private and _is_at(held, path):
            return held
    os.close(held)
    return None


def _is_at(held: int, path: Path) -> bool:
    try:
        inside, outside = os.fstat(held), path.lstat()
    except FileNotFoundError:
        return False
    return (inside.st_dev, inside.st_ino) == (outside.st_dev, outside.st_ino)
