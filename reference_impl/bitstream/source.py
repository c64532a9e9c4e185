"""Where the bytes come from: memory, a file, a pipe.

Rules: CNF-22 (memory does not grow with the input). A file is read by position, never mapped: a file that shrinks
while it is read is an I/O error, not a crash. A pipe is spooled to disk as far as it has been asked for, so that
output can begin before the input ends; the look-ahead of a segment keeps it about 2 KiB behind.
"""

from __future__ import annotations

import os
import tempfile
from typing import IO, BinaryIO

_PIPE_CHUNK = 1 << 16


class SourceChanged(OSError):
    """The file became shorter while it was read. Rules: CNF-19 (exit code 3)."""


class Source:
    """Random access to bytes. Rules: CNF-22."""

    def read_at(self, offset: int, count: int) -> bytes:
        """Up to `count` bytes from `offset`; fewer only where the data ends. Rules: CNF-22."""
        raise NotImplementedError

    def read_some(self, offset: int, least: int, most: int) -> tuple[bytes, bool]:
        """At least `least` bytes from `offset`, and up to `most` where they are at hand; whether the data ends there.

        Rules: CNF-22. Fewer than `least` only where the data ends.
        """
        data = self.read_at(offset, most)
        return data, len(data) < most

    def size(self) -> int:
        """Bytes in all; reads a pipe to its end. Rules: CNF-21."""
        raise NotImplementedError


class BytesSource(Source):
    """Bytes in memory. Rules: CNF-22."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def read_at(self, offset: int, count: int) -> bytes:
        return self._data[offset : offset + count]

    def size(self) -> int:
        return len(self._data)


class FileSource(Source):
    """A regular file, read by position. Rules: CNF-19, CNF-22."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._fd = file.fileno()
        self._size = os.fstat(self._fd).st_size

    def read_at(self, offset: int, count: int) -> bytes:
        wanted = min(count, self._size - offset)
        if wanted <= 0:
            return b""
        data = os.pread(self._fd, wanted, offset)
        while len(data) < wanted:
            more = os.pread(self._fd, wanted - len(data), offset + len(data))
            if not more:
                raise SourceChanged(f"the file ended at byte {offset + len(data)} of {self._size} while it was read")
            data += more
        return data

    def size(self) -> int:
        return self._size


class PipeSource(Source):
    """A pipe, spooled to a temporary file as far as it has been asked for. Rules: CNF-22."""

    def __init__(self, pipe: BinaryIO) -> None:
        self._pipe = pipe
        self._spool = tempfile.TemporaryFile()  # noqa: SIM115 (lives as long as the source)
        self._have = 0
        self._ended = False

    def _pull(self, upto: int) -> None:
        # read1: hand over what is there, so that a slow producer does not hold back planes already complete.
        while self._have < upto and not self._ended:
            chunk = self._pipe.read1(_PIPE_CHUNK) if hasattr(self._pipe, "read1") else self._pipe.read(_PIPE_CHUNK)
            if not chunk:
                self._ended = True
                break
            self._spool.seek(self._have)
            self._spool.write(chunk)
            self._have += len(chunk)

    def read_some(self, offset: int, least: int, most: int) -> tuple[bytes, bool]:
        # A slow producer must not hold back what is already there.
        self._pull(offset + least)
        data = self.read_at(offset, min(most, self._have - offset))
        return data, self._ended and offset + len(data) >= self._have

    def read_at(self, offset: int, count: int) -> bytes:
        self._pull(offset + count)
        self._spool.seek(offset)
        return self._spool.read(max(0, min(count, self._have - offset)))

    def size(self) -> int:
        while not self._ended:
            self._pull(self._have + _PIPE_CHUNK)
        return self._have

    def __del__(self) -> None:
        # The spool is the source's own: left to the collector it would warn of a file that nobody closed.
        self._spool.close()


def open_source(file: BinaryIO) -> Source:
    """A source for an open binary file: by position where it is a regular file, else spooled. Rules: CNF-22."""
    try:
        # Only a real file read from its start; a partly consumed one goes on from where it is.
        if os.path.isfile(file.fileno()) and file.tell() == 0:  # noqa: PTH113 (a descriptor, not a path)
            return FileSource(file)
    except OSError:
        return PipeSource(file)
    return PipeSource(file)
