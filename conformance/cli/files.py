"""Input and output of the verbs: files, standard input and output, progress.

Rules: CNF-19, CNF-22.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

if TYPE_CHECKING:
    from snhc.reference_impl.bitstream.source import Source

    from .common import Common


@contextmanager
def open_binary(name: str) -> Iterator[IO[bytes]]:
    """An input file, `-` for standard input. Rules: CNF-19."""
    if name == "-":
        yield sys.stdin.buffer
    else:
        with Path(name).open("rb") as file:
            yield file


@contextmanager
def open_input(name: str) -> Iterator[Source]:
    """The bytes of an input, `-` for standard input. Rules: CNF-19, CNF-22."""
    from snhc.reference_impl.bitstream.source import open_source

    with open_binary(name) as file:
        yield open_source(file)  # type: ignore[arg-type]


_BUFFER: Final = 1 << 16


class Output:
    """Where data goes: standard output, or a file that is left whole or not at all.

    Rules: CNF-19.

    Pieces given to `write` reach standard output unbroken, so that no half line is seen where each is whole lines.
    A file is written beside its place and put there at the end; with `keep_partial`, or after `keep`, also when an
    error ends it. `prompt`: pass each piece on at once.
    """

    def __init__(self, target: str | None, keep_partial: bool = False, prompt: bool = False) -> None:
        # A link stays a link: what it points to is replaced.
        self._target = Path(target).resolve() if target is not None and target != "-" else None
        self._keep = keep_partial
        self._prompt = prompt
        self._pieces: list[bytes] = []
        self._size = 0
        self._temporary: Path | None = None
        self._file: IO[bytes] = sys.stdout.buffer

    @property
    def is_terminal(self) -> bool:
        """Whether people read it at once. Rules: CNF-19."""
        return self._target is None and sys.stdout.isatty()

    def keep(self) -> None:
        """What has been written is whole, though an error comes. Rules: CNF-19."""
        self._keep = True

    def __enter__(self) -> Output:
        target = self._target
        if target is None:
            self._prompt = self._prompt or sys.stdout.isatty()
        elif target.exists() and not target.is_file():
            # A device or a named pipe cannot be replaced.
            self._file = target.open("wb", buffering=0)
        else:
            self._temporary = target.with_name(f".{target.name[:200]}.{os.getpid()}.part")
            try:
                # Pieces are gathered already; a second buffer would fail once more when it is closed.
                self._file = self._temporary.open("xb", buffering=0)
            except OSError as error:
                # The file that was asked for is the one to name.
                raise OSError(error.errno, error.strerror, str(target)) from None
        return self

    def write(self, data: str | bytes) -> None:
        """Add a piece; text as UTF-8. Rules: CNF-19."""
        piece = data.encode() if isinstance(data, str) else data
        self._pieces.append(piece)
        self._size += len(piece)
        if self._prompt or self._size >= _BUFFER:
            self.flush()

    def flush(self) -> None:
        """Pass on all pieces. Rules: CNF-19."""
        data = memoryview(b"".join(self._pieces))
        self._pieces.clear()
        self._size = 0
        try:
            while data:
                # An unbuffered standard output may take less than it is given.
                data = data[self._file.write(data) :]
            self._file.flush()
        except OSError as error:
            if self._target is None or error.filename is not None:
                raise
            # The file that was asked for is the one to name.
            raise OSError(error.errno, error.strerror, str(self._target)) from None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if self._target is None:
            self.flush()
            return
        kept = False
        try:
            with self._file:
                self.flush()
            kept = error is None or self._keep
        finally:
            if self._temporary is not None:
                if kept:
                    self._temporary.replace(self._target)
                else:
                    self._temporary.unlink()


def colour_allowed(is_terminal: bool) -> bool:
    """Whether to colour: a terminal that can, and no NO_COLOR. Rules: CNF-19."""
    return is_terminal and not os.environ.get("NO_COLOR") and os.environ.get("TERM", "") != "dumb"


@contextmanager
def progress(common: Common, label: str, total: int) -> Iterator[Callable[..., None] | None]:
    """A progress bar on standard error, or None where nobody would see it.

    Rules: CNF-19. Yields a function of the number done so far, and of the total where that is known only then; it may
    be called as often as one likes.
    """
    if not common.progress or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=total)

        def advance(done: int, total: int | None = None) -> None:
            bar.update(task, completed=done, total=total)

        yield advance
