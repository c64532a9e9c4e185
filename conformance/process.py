"""Running a foreign program: limits on time and output, and nothing of it left behind.

Rules: CNF-14 (time limit, output limit, process group, temporary folder). Not here: memory limit.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_TICK: Final = 0.05
_CHUNK: Final = 1 << 16
# How long what a program wrote before it ended may take to arrive.
_DRAIN: Final = 1.0
STDERR_BYTES: Final = 1 << 20


@dataclass(frozen=True, slots=True)
class Finished:
    """What became of a program.

    Rules: CNF-14. `code`: exit code, negative for a signal, None where it was stopped. `stopped`: "", `timeout` or
    `output`. `seconds`: wall time.
    """

    code: int | None
    stdout: bytes
    stderr: bytes
    stopped: str
    seconds: float


def run(
    command: list[str], stdin: Path | None, *, seconds: float, output_bytes: int, folder: Path | None = None
) -> Finished:
    """Run a program to its end or to a limit; then nothing of its process group is left. Rules: CNF-14.

    `stdin`: a file, or nothing at all. The program runs in a temporary folder of its own. `folder`: where relative
    names in the command lie. Raises OSError where it cannot be started.
    """
    with tempfile.TemporaryDirectory(prefix="snhc-") as own, contextlib.ExitStack() as stack:
        source = stack.enter_context(stdin.open("rb")) if stdin is not None else subprocess.DEVNULL
        started = time.monotonic()
        process = subprocess.Popen(
            _resolved(command, folder), stdin=source, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=own,
            start_new_session=True, env={**os.environ, "TMPDIR": own},
        )  # fmt: skip
        try:
            return _watch(process, started, seconds, output_bytes)
        finally:
            _kill_group(process)
            process.wait()
            for pipe in (process.stdout, process.stderr):
                if pipe is not None:
                    pipe.close()


def _resolved(command: list[str], folder: Path | None) -> list[str]:
    """The command with names of files that lie in `folder` made absolute: the program runs elsewhere."""
    base = (folder or Path()).absolute()
    out: list[str] = []
    for i, word in enumerate(command):
        there = base / word
        # A bare name of the first word is looked up in PATH.
        is_path = os.sep in word or i > 0
        out.append(str(there) if is_path and not word.startswith("-") and there.is_file() else word)
    return out


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def _watch(process: subprocess.Popen[bytes], started: float, seconds: float, output_bytes: int) -> Finished:
    deadline = started + seconds
    streams: dict[str, bytearray] = {"out": bytearray(), "err": bytearray()}
    limits = {"out": output_bytes, "err": STDERR_BYTES}
    stopped = ""
    ended = False
    with selectors.DefaultSelector() as selector:
        assert process.stdout is not None and process.stderr is not None
        for pipe, name in ((process.stdout, "out"), (process.stderr, "err")):
            os.set_blocking(pipe.fileno(), False)
            selector.register(pipe, selectors.EVENT_READ, name)
        while selector.get_map() and not stopped:
            for key, _ in selector.select(_TICK):
                chunk = os.read(key.fd, _CHUNK)
                if not chunk:
                    selector.unregister(key.fileobj)
                    continue
                kept = streams[key.data]
                kept += chunk
                if len(kept) > limits[key.data]:
                    del kept[limits[key.data] :]
                    # What goes to standard error beyond its limit is thrown away.
                    if key.data == "out":
                        stopped = "output"
            now = time.monotonic()
            if not ended and process.poll() is not None:
                # A child that it left behind may hold the pipes open.
                ended = True
                _kill_group(process)
                deadline = now + _DRAIN
            elif now >= deadline:
                stopped = "" if ended else "timeout"
                break
    if not stopped and not ended:
        try:
            process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            stopped = "timeout"
    code = None if stopped else process.returncode
    return Finished(code, bytes(streams["out"]), bytes(streams["err"]), stopped, time.monotonic() - started)
