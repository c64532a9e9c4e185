"""The warden: starts one foreign program at a time, watches its memory, and ends everything that it left behind.

Rules: CNF-14. Started as `python -I -S warden.py FD FOLDER [WRITABLE...]`; standard library only.

* As the subreaper of its children it inherits every orphan, whatever session that has made for itself; so nothing that
  a program started outlives it (Linux; elsewhere the process group is killed).
* Where the kernel has Landlock, nothing below the warden can write outside FOLDER and WRITABLE (and the devices).
* When the runner is gone, the socket is at its end: everything is killed, and the warden goes too.
* Memory: the kernel limits the private writable memory of each process (RLIMIT_DATA; not on macOS), and the warden
  looks at the sum of all of them, every TICK seconds (Linux).

JSON lines on the socket. The runner says `{"do": "start", "command", "env", "cwd", "memory", "file_bytes"}` with three
descriptors, and gets `{"pid"}` or `{"errno", "error", "file"}`; then, unasked, `{"memory": bytes}` when too much was
taken and `{"code", "peak"}` when the program has ended. `{"do": "end"}` kills all that is left: `{"gone": count}`.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import resource
import select
import signal
import socket
import subprocess
import sys
import time
from typing import Any

TICK = 0.05
_SUBREAPER = 36
_PATIENCE = 5.0
_PAGE = resource.getpagesize()
_LINUX = sys.platform.startswith("linux")


def _children(pid: int) -> list[int]:
    found: list[int] = []
    try:
        for task in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208 (pathlib is not worth its import)
            with open(f"/proc/{pid}/task/{task}/children") as file:  # noqa: PTH123
                found += map(int, file.read().split())
    except OSError:
        pass  # it ended meanwhile
    return found


def _below(pid: int) -> list[int]:
    found: list[int] = []
    new = _children(pid)
    while new:
        found += new
        new = [grandchild for child in new for grandchild in _children(child)]
    return found


def _taken(pids: list[int]) -> int:
    """Resident private memory, in bytes."""
    pages = 0
    for pid in pids:
        with contextlib.suppress(OSError, ValueError, IndexError), open(f"/proc/{pid}/statm") as file:  # noqa: PTH123
            words = file.read().split()
            pages += int(words[1]) - int(words[2])
    return pages * _PAGE


class Warden:
    """Rules: CNF-14."""

    def __init__(self, control: socket.socket, folder: str) -> None:
        self._control = control
        self._folder = folder
        self._pid = 0
        self._group = 0
        self._limit = 0
        self._wake, end = os.pipe()
        for fd in (self._wake, end):
            os.set_blocking(fd, False)
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        signal.set_wakeup_fd(end, warn_on_full_buffer=False)
        # What interrupts the runner interrupts the warden through the runner.
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    def serve(self) -> None:
        """Until the runner is gone. Rules: CNF-14."""
        pending = b""
        descriptors: list[int] = []
        while True:
            waiting = (self._control.fileno(), self._wake)
            ready, _, _ = select.select(waiting, [], [], TICK if self._pid else None)
            if self._wake in ready:
                with contextlib.suppress(BlockingIOError):
                    os.read(self._wake, 4096)
            self._reap()
            if self._control.fileno() in ready:
                chunk, fds, _, _ = socket.recv_fds(self._control, 1 << 16, 3)
                if not chunk:
                    break
                descriptors += fds
                pending += chunk
                while b"\n" in pending:
                    line, _, pending = pending.partition(b"\n")
                    self._obey(json.loads(line), descriptors)
                    descriptors = []
            elif self._pid and self._limit and _LINUX:
                taken = _taken(_below(os.getpid()))
                if taken > self._limit:
                    self._say({"memory": taken})
                    self._end()
        self._end()

    def _say(self, message: dict[str, Any]) -> None:
        with contextlib.suppress(BrokenPipeError):
            self._control.sendall(json.dumps(message).encode() + b"\n")

    def _obey(self, message: dict[str, Any], descriptors: list[int]) -> None:
        if message["do"] == "end":
            self._say({"gone": self._end()})
            return
        try:
            self._start(message, descriptors)
        except OSError as error:
            name = error.filename if isinstance(error.filename, str) else ""
            self._say({"errno": error.errno, "error": error.strerror or str(error), "file": name})
        finally:
            for fd in descriptors:
                os.close(fd)

    def _start(self, message: dict[str, Any], descriptors: list[int]) -> None:
        # Set on the warden for the moment of the start: no code of ours runs between fork and exec.
        limits = {resource.RLIMIT_CORE: 0, resource.RLIMIT_FSIZE: message["file_bytes"]}
        if message["memory"]:
            limits[resource.RLIMIT_DATA] = message["memory"]
        before = {which: resource.getrlimit(which) for which in limits}
        stdin, stdout, stderr = descriptors
        try:
            for which, value in limits.items():
                hard = before[which][1]
                soft = value if hard == resource.RLIM_INFINITY else min(value, hard)
                resource.setrlimit(which, (soft, hard))
            process = subprocess.Popen(
                message["command"], stdin=stdin, stdout=stdout, stderr=stderr, cwd=message["cwd"],
                env=message["env"], start_new_session=True, close_fds=True,
            )  # fmt: skip
        finally:
            for which, pair in before.items():
                resource.setrlimit(which, pair)
        self._pid = self._group = process.pid
        self._limit = message["memory"]
        # It is reaped here, by its number.
        process.returncode = 0
        self._say({"pid": process.pid})

    def _reap(self) -> None:
        while True:
            try:
                pid, status, usage = os.wait4(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if pid == 0:
                return
            if pid == self._pid:
                self._pid = 0
                peak = usage.ru_maxrss * (1024 if _LINUX else 1)
                self._say({"code": os.waitstatus_to_exitcode(status), "peak": peak})

    def _end(self) -> int:
        """Kill all that is left; how many there were."""
        group, self._group = self._group, 0
        gone = set()
        until = time.monotonic() + _PATIENCE
        while True:
            left = _below(os.getpid()) if _LINUX else []
            for pid in left:
                gone.add(pid)
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(pid, signal.SIGKILL)
            if group:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(group, signal.SIGKILL)
            self._reap()
            if not (left or self._pid) or time.monotonic() > until:
                return len(gone)
            time.sleep(0.0005)


def main() -> None:
    """Rules: CNF-14."""
    control = socket.socket(fileno=int(sys.argv[1]))
    control.set_inheritable(False)
    folder = sys.argv[2]
    os.chdir(folder)
    if _LINUX:
        ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # noqa: PTH100, PTH120
    from landlock import restrict  # type: ignore[import-not-found]

    fenced = restrict([folder, "/dev/shm", *sys.argv[3:]], ["/dev", "/proc"])
    control.sendall(json.dumps({"fenced": fenced}).encode() + b"\n")
    with contextlib.suppress(ConnectionError):
        Warden(control, folder).serve()


if __name__ == "__main__":
    main()
