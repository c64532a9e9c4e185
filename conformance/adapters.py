"""Adapters: how a decoder is asked to decode a vector.

Rules: CNF-9, CNF-13 (tools and options), CNF-14, CNF-19. Not here: persistent processes (CNF-10), entry points
(CNF-11), the C ABI (CNF-12).

A one-shot adapter is a command. It gets the input's path, writes decoded output to standard output, and exits with 0;
or it exits with 1: the stream is rejected, with an optional JSON line (`class`, `bits` or `bit`) on standard error.
The TOML file that describes one:

    name = "my decoder"
    command = ["./mydecoder", "{input}"]     # {input}: path of the vector; left out: the vector is standard input;
                                             # {aux}: path of its second file, for tools with two; {media}: what it is
    format = "ndjson"                        # or "fap", "csv"
    timeout = 10.0                           # seconds per vector
    output_bytes = 268435456                 # standard output beyond this is cut, and an error
    tools = ["fba"]                          # what is not claimed is not_applicable, never a pass; also dct-p1, mesh,
                                             # dctcoef, fit, fat, fapu

    [options]                                # words put behind the command for vectors that need them
    draft = ["--compat", "draft"]            # left out: such vectors are not_applicable
    strict = ["--strict"]
    object = ["--object", "{value}"]
    limit = ["--limit", "{name}={value}"]

Relative names of files in the command are those beside the TOML file.
"""

from __future__ import annotations

import json
import re
import shlex
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Protocol

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.vectors.decoding import decode_input
from snhc.vectors.manifest import TOOLS, DecodeOptions, Entry

from . import process

FORMATS: Final = ("ndjson", "fap", "csv")
OPTION_NAMES: Final = ("draft", "strict", "object", "limit")
DEFAULT_TIMEOUT: Final = 10.0
REJECTED: Final = 1
# What `.fap` text and CSV can hold.
_FACE_TOOLS: Final = frozenset({"fba", "dct-p1", "dctcoef"})


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a decoder did with a vector.

    Rules: CNF-9, CNF-14. `code`: 0 accepted, 1 rejected, anything else (None: stopped) neither. `stopped`: "",
    `timeout`, `output`, `start` (it could not be started). `detail`: why, in words.
    """

    code: int | None
    stdout: bytes = b""
    stderr: bytes = b""
    stopped: str = ""
    detail: str = ""
    seconds: float = 0.0


class Adapter(Protocol):
    """A decoder that can be asked. Rules: CNF-9, CNF-13."""

    @property
    def name(self) -> str:
        """What reports call it."""

    @property
    def format(self) -> str:
        """One of FORMATS."""

    @property
    def reproduce(self) -> str:
        """The words that name it on the command line of `snhc run`."""

    def lacks(self, entry: Entry) -> str:
        """What a vector needs and the decoder does not claim, "" for nothing. Rules: CNF-13."""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Decode one vector. Rules: CNF-9. `aux`: its second file, None where it has one only."""


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """The reference decoder of this installation, in this process. Rules: CNF-9, CNF-19."""

    name: str = "snhc"
    format: str = "ndjson"
    reproduce: str = ""

    def lacks(self, entry: Entry) -> str:
        """Nothing: what is not built says `Unsupported` itself."""
        return ""

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Decode one vector; a fault is a rejection with its JSON line, an internal error is a crash."""
        started = time.monotonic()
        try:
            second = None if aux is None else aux.read_bytes()
            decoded = decode_input(entry.media, path.read_bytes(), second, entry.options.for_decoder())
        except Exception:  # noqa: BLE001 (a bug of the reference decoder is a result, like any other decoder's crash)
            return Outcome(None, stderr=traceback.format_exc().encode(), detail="internal error")
        error = decoded.error
        return Outcome(
            0 if error is None else REJECTED,
            decoded.text.encode(),
            b"" if error is None else json.dumps(error.as_json()).encode() + b"\n",
            seconds=time.monotonic() - started,
        )


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
        missing += [f"option {name}" for name, _ in _needed(entry.options) if name not in self.options]
        return ", ".join(missing)

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Start the command for one vector, and wait for its end or for a limit."""
        command = list(self.command)
        for name, values in _needed(entry.options):
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


def _needed(options: DecodeOptions) -> list[tuple[str, dict[str, str]]]:
    out: list[tuple[str, dict[str, str]]] = []
    if options.draft:
        out.append(("draft", {}))
    if options.strict:
        out.append(("strict", {}))
    if options.object_number:
        out.append(("object", {"value": str(options.object_number)}))
    out += [("limit", {"name": name, "value": str(value)}) for name, value in options.limits.items()]
    return out


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


_FORM: Final[dict[str, type | tuple[type, ...]]] = {
    "name": str, "command": list, "format": str, "timeout": (int, float), "output_bytes": int, "tools": list,
    "options": dict,
}  # fmt: skip


def load(path: Path) -> OneShot:
    """An adapter from its TOML file. Rules: CNF-9, CNF-25. Raises InputFormat, with the path of the misfit."""
    import tomllib

    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputFormat("CNF-9", "adapter file", value=str(path), allowed=f"TOML: {error}") from error

    def misfit(key: str, law: str) -> InputFormat:
        return InputFormat("CNF-9", f"{path.name}: {key}", value=str(table.get(key)), allowed=law, path=key)

    for key, value in table.items():
        if key not in _FORM:
            raise misfit(key, f"one of {', '.join(_FORM)}")
        if not isinstance(value, _FORM[key]) or isinstance(value, bool):
            raise misfit(key, "the type that the guide names")
    command = table.get("command", [])
    if not command or not all(isinstance(word, str) for word in command):
        raise misfit("command", "a list of words, the program first")
    if table.get("format", "ndjson") not in FORMATS:
        raise misfit("format", ", ".join(FORMATS))
    for key in ("timeout", "output_bytes"):
        if not table.get(key, 1) > 0:
            raise misfit(key, "a number above 0")
    if not all(tool in TOOLS for tool in table.get("tools", [])):
        raise misfit("tools", f"of {', '.join(TOOLS)}")
    options = table.get("options", {})
    for name, words in options.items():
        if name not in OPTION_NAMES or not isinstance(words, list) or not all(isinstance(word, str) for word in words):
            raise misfit("options", f"lists of words by {', '.join(OPTION_NAMES)}")
    return OneShot(
        table.get("name", path.stem), tuple(command), table.get("format", "ndjson"),
        float(table.get("timeout", DEFAULT_TIMEOUT)), table.get("output_bytes", DEFAULT_LIMITS.adapter_output_bytes),
        tuple(table.get("tools", ["fba"])), {name: tuple(words) for name, words in options.items()},
        path.absolute().parent, shlex.quote(str(path)),
    )  # fmt: skip
