"""Running a foreign program: limits on time, memory and output, and nothing of it left behind.

Rules: CNF-14.

Every program runs below a *warden* (`isolation/warden.py`), a small process of ours that is started once and used for
many programs, one at a time. Programs get a temporary folder of their own as working folder and TMPDIR, copies of the
input files in it, standard input, output and error and no other descriptor, and the environment of `environment()`.

What cannot be enforced everywhere: memory is limited by kernel and warden on Linux, nowhere else; writing outside the
folder is refused by the kernel where it has Landlock (`fenced()` says so), not elsewhere; there is no limit on the
number of files and processes, and the network is open.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import json
import os
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final

from .scratch import Scratch

_CHUNK: Final = 1 << 16
# How long what a program wrote before it ended may take to arrive.
_DRAIN: Final = 1.0
# How long the warden may take for what is its own work.
_PATIENCE: Final = 20.0
_WARDEN: Final = Path(__file__).parent / "isolation" / "warden.py"
STDERR_BYTES: Final = 1 << 20
DEFAULT_MEMORY: Final = 2 << 30
# A program may fill no file beyond this.
FILE_BYTES: Final = 1 << 30

# What a program sees of our environment; beyond it TMPDIR, TMP and TEMP, and what its adapter file names.
PASSED: Final = (
    "PATH", "HOME", "USER", "LOGNAME", "SHELL", "LANG", "LANGUAGE", "TZ", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH",
    "VIRTUAL_ENV", "JAVA_HOME", "DOTNET_ROOT", "SYSTEMROOT",
)  # fmt: skip


class WardenGone(Exception):
    """The warden has ended: something has killed it. Rules: CNF-14."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a program may take, see and touch.

    Rules: CNF-14. `memory_bytes`: private memory, 0 for no limit. `output_bytes`: standard output. `folder`: where
    relative names in the command lie. `variables`: set beyond `PASSED`; `passed`: further names taken from our
    environment. `writable`: folders that it may write into beyond its own.
    """

    memory_bytes: int = DEFAULT_MEMORY
    output_bytes: int = 256 << 20
    folder: Path | None = None
    variables: Mapping[str, str] = field(default_factory=dict)
    passed: tuple[str, ...] = ()
    writable: tuple[str, ...] = ()

    def environment(self, own: str) -> dict[str, str]:
        """The environment of a program whose folder is `own`. Rules: CNF-14."""
        names = {*PASSED, *self.passed, *(name for name in os.environ if name.startswith("LC_"))}
        kept = {name: os.environ[name] for name in sorted(names) if name in os.environ}
        return {**kept, "TMPDIR": own, "TMP": own, "TEMP": own, **self.variables}


@dataclass(frozen=True, slots=True)
class Finished:
    """What became of a program.

    Rules: CNF-14. `code`: exit code, negative for a signal, None where it was stopped. `stopped`: "", `timeout`,
    `output`, `memory`, or `warden` (the process that watched it is gone). `seconds`: wall time. `peak`: resident
    memory of its largest process, bytes, 0 where it was stopped.
    """

    code: int | None
    stdout: bytes
    stderr: bytes
    stopped: str
    seconds: float
    peak: int = 0


def fenced() -> bool:
    """Whether this machine's kernel refuses to let programs write outside their folder. Rules: CNF-14."""
    with room(Surroundings()) as own:
        return own.fenced


# -- the warden, seen from here ----------------------------------------------------------------------------------------


class Warden:
    """One warden process. Rules: CNF-14. Not to be used by two threads at the same time."""

    def __init__(self, writable: Sequence[str] = ()) -> None:
        self._scratch = Scratch()
        self.root = self._scratch.path
        self.control, theirs = socket.socketpair()
        self._pending = b""
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(_WARDEN), str(theirs.fileno()), str(self.root), *writable],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                # With the lock: the folder is in use until the warden is gone too.
                pass_fds=(theirs.fileno(), self._scratch.lock), start_new_session=True,
            )  # fmt: skip
        try:
            self.fenced = bool(self.hear()["fenced"])
        except BaseException:
            self.close()
            raise

    def start(self, command: Sequence[str], own: Path, around: Surroundings, streams: Sequence[int]) -> int:
        """Start a program; its process id. Rules: CNF-14. Raises OSError where it cannot be started, WardenGone."""
        request = {
            "do": "start", "command": list(command), "cwd": str(own), "env": around.environment(str(own)),
            "memory": around.memory_bytes, "file_bytes": FILE_BYTES,
        }  # fmt: skip
        data = json.dumps(request).encode() + b"\n"
        try:
            sent = socket.send_fds(self.control, [data], list(streams))
            self.control.sendall(data[sent:])
        except OSError as error:
            raise WardenGone from error
        answer = self.hear()
        if "pid" in answer:
            return int(answer["pid"])
        raise OSError(answer["errno"], answer["error"], answer["file"])

    def hear(self, seconds: float = _PATIENCE) -> dict[str, Any]:
        """The next message. Rules: CNF-14. Raises WardenGone where none comes in time."""
        until = time.monotonic() + seconds
        while b"\n" not in self._pending:
            self.control.settimeout(max(0.001, until - time.monotonic()))
            try:
                chunk = self.control.recv(_CHUNK)
            except OSError as error:
                raise WardenGone from error
            if not chunk:
                raise WardenGone
            self._pending += chunk
        line, _, self._pending = self._pending.partition(b"\n")
        message: dict[str, Any] = json.loads(line)
        return message

    @property
    def has_more(self) -> bool:
        """Whether a message has been read that nobody has heard yet."""
        return b"\n" in self._pending

    def end(self) -> int:
        """Kill all that is left of the program; how many processes there were. Rules: CNF-14. Raises WardenGone."""
        try:
            self.control.settimeout(_PATIENCE)
            self.control.sendall(b'{"do": "end"}\n')
        except OSError as error:
            raise WardenGone from error
        while True:
            message = self.hear()
            if "gone" in message:
                return int(message["gone"])

    def close(self) -> None:
        """End it, with all that runs below it. Rules: CNF-14."""
        self.control.close()
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._scratch.close()


_idle: dict[tuple[int, tuple[str, ...]], list[Warden]] = {}
_busy: Final[set[Warden]] = set()
_lock: Final = threading.Lock()


def _taken(writable: tuple[str, ...]) -> Warden:
    with _lock:
        # Of this process: a child that was forked off must not speak on its parent's socket.
        waiting = _idle.get((os.getpid(), writable), [])
        warden = waiting.pop() if waiting else None
    warden = warden or Warden(writable)
    with _lock:
        _busy.add(warden)
    return warden


def kill_running() -> None:
    """End every program that a thread waits for: the run has been interrupted. Rules: CNF-14, CNF-20."""
    with _lock:
        for warden in _busy:
            # It takes that for the end of the runner; the thread takes it for the end of the warden.
            with contextlib.suppress(OSError):
                warden.control.shutdown(socket.SHUT_RDWR)


def close() -> None:
    """End all wardens that wait for work; more are started when they are needed. Rules: CNF-14."""
    with _lock:
        mine = [warden for key, waiting in _idle.items() if key[0] == os.getpid() for warden in waiting]
        _idle.clear()
    for warden in mine:
        warden.close()


atexit.register(close)


@dataclass(slots=True)
class Room:
    """A folder for one program, and the warden that runs it. Rules: CNF-14. `folder`: its working folder."""

    folder: Path
    warden: Warden
    around: Surroundings

    @property
    def fenced(self) -> bool:
        """Whether the program cannot write elsewhere."""
        return self.warden.fenced

    def put(self, source: Path, below: str = "in") -> Path:
        """A copy of a file, under its name: what a program writes beside its input stays in its folder."""
        place = self.folder / below
        place.mkdir(exist_ok=True)
        return Path(shutil.copyfile(source, place / source.name))

    def start(self, command: Sequence[str], streams: Sequence[int]) -> int:
        """Start the program; its process id. Raises OSError where it cannot be started, WardenGone."""
        return self.warden.start(resolved(command, self.around.folder), self.folder, self.around, streams)

    def run(self, command: Sequence[str], stdin: Path | None, seconds: float) -> Finished:
        """Run a program to its end or to a limit. Rules: CNF-14. Raises OSError where it cannot be started."""
        started = time.monotonic()
        with contextlib.ExitStack() as stack:
            read_out, write_out = _pipe(stack)
            read_err, write_err = _pipe(stack)
            source = stack.enter_context((stdin or Path(os.devnull)).open("rb"))
            try:
                pid = self.start(command, (source.fileno(), write_out.fileno(), write_err.fileno()))
                # Now the program alone holds the ends that are written to.
                write_out.close()
                write_err.close()
            except WardenGone:
                return Finished(None, b"", b"", "warden", time.monotonic() - started)
            return _Watch(self.warden, pid, started, started + seconds, self.around.output_bytes).run(
                read_out, read_err
            )


@contextlib.contextmanager
def room(around: Surroundings) -> Iterator[Room]:
    """A folder and a warden for one program; afterwards nothing of either is left of it. Rules: CNF-14."""
    warden = _taken(around.writable)
    own: Path | None = None
    try:
        own = Path(tempfile.mkdtemp(dir=warden.root, prefix="run-"))
        yield Room(own, warden, around)
    finally:
        with _lock:
            _busy.discard(warden)
        try:
            warden.end()
        except WardenGone:
            warden.close()
        else:
            if own is not None:
                shutil.rmtree(own, ignore_errors=True)
            with _lock:
                _idle.setdefault((os.getpid(), around.writable), []).append(warden)


def run(
    command: Sequence[str],
    stdin: Path | None,
    *,
    seconds: float,
    output_bytes: int,
    folder: Path | None = None,
    memory_bytes: int = DEFAULT_MEMORY,
) -> Finished:
    """Run a program to its end or to a limit; then nothing of it is left. Rules: CNF-14.

    `stdin`: a file, or nothing at all. `folder`: where relative names in the command lie. Raises OSError where it
    cannot be started.
    """
    with room(Surroundings(memory_bytes, output_bytes, folder)) as own:
        return own.run(command, stdin, seconds)


def resolved(command: Sequence[str], folder: Path | None) -> list[str]:
    """The command with names of files that lie in `folder` made absolute: the program runs elsewhere. Rules: CNF-9."""
    base = (folder or Path()).absolute()
    out: list[str] = []
    for i, word in enumerate(command):
        there = str(base / word)
        # A bare name of the first word is looked up in PATH.
        is_path = os.sep in word or i > 0
        # A word may be anything: Path.is_file raises where it is too long for a name.
        out.append(there if is_path and not word.startswith("-") and os.path.isfile(there) else word)  # noqa: PTH113
    return out


def _pipe(stack: contextlib.ExitStack) -> tuple[IO[bytes], IO[bytes]]:
    read, write = os.pipe()
    return stack.enter_context(os.fdopen(read, "rb", 0)), stack.enter_context(os.fdopen(write, "wb", 0))


class _Watch:
    """From the start of a program to its end."""

    def __init__(self, warden: Warden, pid: int, started: float, deadline: float, output_bytes: int) -> None:
        self._warden = warden
        self._pid = pid
        self._started = started
        self._deadline = deadline
        self._kept = {"out": bytearray(), "err": bytearray()}
        self._limits = {"out": output_bytes, "err": STDERR_BYTES}
        self._stopped = ""
        self._code: int | None = None
        self._peak = 0

    def run(self, out: IO[bytes], err: IO[bytes]) -> Finished:
        with selectors.DefaultSelector() as selector:
            for pipe, name in ((out, "out"), (err, "err")):
                os.set_blocking(pipe.fileno(), False)
                selector.register(pipe, selectors.EVENT_READ, name)
            selector.register(self._warden.control, selectors.EVENT_READ, "warden")
            open_pipes = 2
            # Until it has ended and all that it wrote is here.
            while not self._stopped and (open_pipes or self._code is None):
                # The news of its end may have come together with that of its start.
                if self._warden.has_more:
                    self._heard()
                    continue
                left = self._deadline - time.monotonic()
                for key, _ in selector.select(max(0.0, left)):
                    if key.data == "warden":
                        self._heard()
                    elif not self._read(key.fd, key.data):
                        selector.unregister(key.fileobj)
                        open_pipes -= 1
                if time.monotonic() >= self._deadline:
                    if self._code is None and not self._stopped:
                        self._stopped = "timeout"
                    break
        seconds = time.monotonic() - self._started
        code = None if self._stopped else self._code
        kept = self._kept
        return Finished(code, bytes(kept["out"]), bytes(kept["err"]), self._stopped, seconds, self._peak)

    def _heard(self) -> None:
        try:
            message = self._warden.hear()
            if "memory" in message:
                self._stopped = "memory"
                self._peak = message["memory"]
            elif "code" in message:
                self._code, self._peak = message["code"], message["peak"]
                # A child that it left behind may hold the pipes open.
                self._warden.end()
                self._deadline = time.monotonic() + _DRAIN
        except WardenGone:
            self._stopped = "warden"
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._pid, signal.SIGKILL)

    def _read(self, fd: int, name: str) -> bool:
        try:
            chunk = os.read(fd, _CHUNK)
        except OSError as error:
            if error.errno == errno.EAGAIN:
                return True
            raise
        kept, limit = self._kept[name], self._limits[name]
        kept += chunk
        if len(kept) > limit:
            del kept[limit:]
            # What goes to standard error beyond its limit is thrown away.
            if name == "out":
                self._stopped = "output"
        return bool(chunk)
