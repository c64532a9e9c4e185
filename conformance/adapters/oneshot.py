"""One-shot adapters: a command that is started once per vector.

Rules: CNF-9, CNF-13 (tools and options), CNF-14.

It gets the input's path, writes decoded output to standard output, and exits with 0; or it exits with 1: the stream is
rejected, with an optional JSON line (`class`, `bits` or `bit`) on standard error.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Self

from snhc.conformance import process
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.vectors.manifest import Entry

from .base import DEFAULT_TIMEOUT, Outcome, needed

# What `.fap` text and CSV can hold.
_FACE_TOOLS: Final = frozenset({"fba", "dct-p1", "dctcoef"})


@dataclass(frozen=True, slots=True)
class OneShot:
    """A decoder that is started once per vector. Rules: CNF-9, CNF-13, CNF-14. Fields: as in the TOML file."""

    name: str
    command: tuple[str, ...]
    format: str = "ndjson"
    timeout: float = DEFAULT_TIMEOUT
    output_bytes: int = DEFAULT_LIMITS.adapter_output_bytes
    tools: tuple[str, ...] = ("fba",)
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    folder: Path | None = None
    reproduce: str = ""

    def lacks(self, entry: Entry) -> str:
        """Tools and options that are not claimed, and what the format or the command cannot carry."""
        missing = [tool for tool in entry.tools if tool not in self.tools]
        if entry.aux and not missing and not any("{aux}" in word for word in self.command):
            missing.append("{aux} in the command")
        if self.format != "ndjson" and not _FACE_TOOLS.issuperset(entry.tools):
            missing.append("format ndjson")
        missing += [f"option {name}" for name, _ in needed(entry.options) if name not in self.options]
        return ", ".join(missing)

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Start the command for one vector, and wait for its end or for a limit."""
        command = list(self.command)
        for name, values in needed(entry.options):
            command += [_filled(word, values) for word in self.options[name]]
        by_path = any("{input}" in word for word in command)
        if aux is None:
            command = [word for word in command if "{aux}" not in word]
        places = {"input": str(path.absolute()), "aux": str(aux.absolute()) if aux is not None else ""}
        command = [_filled(word, {**places, "media": entry.media}) for word in command]
        try:
            ended = process.run(
                command, None if by_path else path, seconds=self.timeout, output_bytes=self.output_bytes,
                folder=self.folder,
            )  # fmt: skip
        except OSError as error:
            return Outcome(None, stopped="start", detail=f"{command[0]}: {error.strerror or error}")
        return Outcome(ended.code, ended.stdout, ended.stderr, ended.stopped, "", ended.seconds)

    def timed(self, seconds: float) -> Self:
        """The same with another time limit."""
        return replace(self, timeout=seconds)

    def close(self) -> None:
        """Nothing runs between two vectors."""


def _filled(word: str, values: Mapping[str, str]) -> str:
    # In one go: what is put in may hold braces itself.
    return re.sub(r"\{([a-z]+)\}", lambda match: values.get(match[1], match[0]), word)


def from_command(text: str, *, format: str = "ndjson", timeout: float = DEFAULT_TIMEOUT) -> OneShot:
    """An adapter from a command line, split as a shell would. Rules: CNF-9. Raises InputFormat without any words."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InputFormat("CNF-9", "adapter command", value=text, allowed=str(error)) from error
    if not words:
        raise InputFormat("CNF-9", "adapter command", value=text, allowed="a program and its arguments")
    extra = f" --adapter-format {format}" if format != "ndjson" else ""
    return OneShot(
        " ".join(Path(word).name for word in words if "{input}" not in word), tuple(words), format, timeout,
        folder=Path.cwd(),
        reproduce=f"--adapter-command {shlex.quote(text)}{extra}",
    )  # fmt: skip
