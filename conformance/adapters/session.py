"""A conversation with one process that is asked for many vectors.

Rules: CNF-10, CNF-14.

After every answer the runner says `hello` again: a process that answers twice, writes something between two answers or
dies after one is found out with the vector that it happened on.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import select
import selectors
import shutil
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Final

from snhc.conformance.process import STDERR_BYTES, Room, Surroundings, WardenGone, room
from snhc.vectors.manifest import Entry

from . import messages
from .messages import Message, Misfit
from .oneshot import cannot_start

_CHUNK: Final = 1 << 16
# How long a process may take to leave when it has been told to.
LEAVING: Final = 2.0
# How long the news of the end of a process may take that has closed its pipes.
_NEWS: Final = 0.5


class Broken(Exception):
    """The conversation is over. Rules: CNF-10, CNF-14. `stopped`, `detail`: as of Outcome."""

    def __init__(self, stopped: str, detail: str = "") -> None:
        super().__init__(stopped, detail)
        self.stopped = stopped
        self.detail = detail


class Ended(Broken):
    """It has ended without an answer. Rules: CNF-10. `code`: as of Finished."""

    def __init__(self, code: int, said: bytes) -> None:
        tail = said.decode("utf-8", "replace").strip().splitlines()
        words = f"the process ended with {_how(code)} before it answered" + (f": {tail[-1][:200]}" if tail else "")
        # With 0 nothing has fallen over: it has only not kept to the messages.
        self.code = code
        super().__init__("protocol" if code == 0 else "crash", words)


class Session:
    """A conversation with one process. Rules: CNF-10. Closed by `close`, which kills it."""

    def __init__(self, command: tuple[str, ...], around: Surroundings) -> None:
        self._stack = contextlib.ExitStack()
        self._lines: deque[bytes] = deque()
        self._partial = bytearray()
        self._said = bytearray()
        self._code: int | None = None
        self._limit = around.output_bytes
        self._seq = 0
        self._known: Message = {}
        try:
            self.room: Room = self._stack.enter_context(room(around))
            self._selector = self._stack.enter_context(selectors.DefaultSelector())
            self._start(command)
        except BaseException:
            self.close()
            raise

    def _start(self, command: tuple[str, ...]) -> None:
        ends: list[IO[bytes]] = []
        for _ in range(3):
            read, write = os.pipe()
            ends += [
                self._stack.enter_context(os.fdopen(read, "rb", 0)),
                self._stack.enter_context(os.fdopen(write, "wb", 0)),
            ]
        their_in, self._to, self._from, their_out, self._err, their_err = ends
        try:
            self.room.start(command, (their_in.fileno(), their_out.fileno(), their_err.fileno()))
        except OSError as error:
            raise Broken("start", cannot_start(command[0], error)) from error
        except WardenGone as error:
            raise Broken("warden") from error
        for theirs in (their_in, their_out, their_err):
            theirs.close()
        for ours in (self._to, self._from, self._err):
            os.set_blocking(ours.fileno(), False)
        self._selector.register(self._from, selectors.EVENT_READ, "out")
        self._selector.register(self._err, selectors.EVENT_READ, "err")
        self._selector.register(self.room.warden.control, selectors.EVENT_READ, "warden")

    @property
    def stderr(self) -> bytes:
        """What it has said on standard error since the last question."""
        return bytes(self._said)

    def close(self) -> None:
        """Kill it. Rules: CNF-14."""
        self._stack.close()

    # -- asking --------------------------------------------------------------------------------------------------------

    def hello(self, readings: Mapping[str, str], seconds: float) -> Message:
        """Introduce ourselves; its answer. Rules: CNF-10. Raises Broken."""
        self._known = messages.hello(self._next(), dict(readings))
        return self._ask(self._known, seconds)

    def decode(self, entry: Entry, path: Path, aux: Path | None, format: str, seconds: float) -> Message:
        """Ask for one vector; its answer. Rules: CNF-10, CNF-14. Raises Broken."""
        self._said.clear()
        own = f"in{self._seq}"
        question = messages.decode(
            self._next(), entry, self.room.put(path, own),
            None if aux is None else self.room.put(aux, f"{own}/aux"), format,
        )  # fmt: skip
        try:
            answer = self._ask(question, seconds)
            self._settle(seconds)
        finally:
            shutil.rmtree(self.room.folder / own, ignore_errors=True)
        return answer

    def _settle(self, seconds: float) -> None:
        """Make sure that it waits for the next message, and has not said more than the answer."""
        try:
            self._ask({**self._known, "seq": self._next()}, seconds)
        except Broken as error:
            raise Broken(error.stopped, f"after its answer: {error.detail}" if error.detail else "") from error
        if self._lines or self._partial:
            raise Broken("protocol", f"after its answer: more text: {self._first()!r}")

    def bye(self, seconds: float = LEAVING) -> None:
        """Tell it to leave, and see it go. Rules: CNF-10. Raises Broken where it does not, or not with 0."""
        until = time.monotonic() + seconds
        try:
            # To go without a word is an answer too.
            self._ask(messages.bye(self._next()), seconds)
            while not self._lines and time.monotonic() < until:
                self._turn(until - time.monotonic())
        except Ended as ended:
            if ended.code != 0:
                raise Broken("protocol", f"after bye it ended with {_how(ended.code)}") from ended
            if self._partial:
                raise Broken("protocol", f"after bye: more text: {self._first()!r}") from ended
            return
        if self._lines:
            raise Broken("protocol", f"after bye: more text: {self._first()!r}")
        raise Broken("timeout", f"it is still there {seconds:g} s after bye")

    def _first(self) -> str:
        return (self._lines[0] if self._lines else bytes(self._partial[:80]))[:80].decode("utf-8", "replace")

    def _next(self) -> int:
        self._seq += 1
        return self._seq

    def _ask(self, question: Message, seconds: float) -> Message:
        until = time.monotonic() + seconds
        data = memoryview(json.dumps(question).encode() + b"\n")
        written = 0
        writing = False
        while not self._lines:
            if written < len(data):
                try:
                    written += os.write(self._to.fileno(), data[written:])
                except BlockingIOError:
                    if not writing:
                        self._selector.register(self._to, selectors.EVENT_WRITE, "in")
                        writing = True
                except BrokenPipeError:
                    self._gone("it has closed its standard input")
            elif writing:
                self._selector.unregister(self._to)
                writing = False
            left = until - time.monotonic()
            if left <= 0:
                raise Broken("timeout", f"no answer to {question['type']} within {seconds:g} s")
            self._turn(left)
        if written < len(data):
            raise Broken("protocol", f"it said more than was asked: {self._first()!r}")
        try:
            return messages.answer(self._lines.popleft(), question)
        except Misfit as error:
            raise Broken("protocol", str(error)) from error

    def _turn(self, seconds: float) -> None:
        """Take what comes, until something has come."""
        if self.room.warden.has_more:
            self._heard()
            return
        for key, _ in self._selector.select(seconds):
            if key.data == "warden":
                self._heard()
            elif key.data != "in":
                self._read(key.data)
        if self._code is not None and not self._lines:
            raise Ended(self._code, bytes(self._said))

    def _heard(self) -> None:
        try:
            message = self.room.warden.hear()
            if "memory" in message:
                raise Broken("memory", f"{message['memory']} bytes")
            if "code" in message:
                self._code = int(message["code"])
                # Its children may hold the pipes open; what it had written is still there.
                self.room.warden.end()
                for name in ("out", "err"):
                    while self._read(name):
                        pass
        except WardenGone as error:
            raise Broken("warden") from error

    def _read(self, name: str) -> bool:
        """Whether there may be more."""
        pipe = self._from if name == "out" else self._err
        try:
            chunk = os.read(pipe.fileno(), _CHUNK)
        except OSError as error:
            if error.errno == errno.EAGAIN:
                return False
            raise
        if not chunk:
            with contextlib.suppress(KeyError):
                self._selector.unregister(pipe)
            if name == "out" and self._code is None:
                self._gone("it has closed its standard output")
            return False
        if name == "err":
            self._said += chunk
            del self._said[:-STDERR_BYTES]
            return True
        *whole, rest = chunk.split(b"\n")
        for piece in whole:
            self._lines.append(bytes(self._partial) + piece)
            self._partial.clear()
        self._partial += rest
        if len(self._partial) > self._limit or any(len(line) > self._limit for line in self._lines):
            raise Broken("output", f"more than {self._limit} bytes in one line")
        return True

    def _gone(self, what: str) -> None:
        """A closed pipe: either it has ended, which we hear of presently, or it has only closed it."""
        control = self.room.warden.control
        while self._code is None and (self.room.warden.has_more or select.select([control], [], [], _NEWS)[0]):
            self._heard()
        if self._code is None:
            raise Broken("protocol", what)
        if not self._lines:
            raise Ended(self._code, bytes(self._said))


def _how(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"
