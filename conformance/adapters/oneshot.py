"""One-shot adapters: a command that is started once per vector.

Rules: CNF-9, CNF-13, CNF-14, CNF-24.

It gets the input's path, writes decoded output to standard output, and exits with 0; or it exits with 1: the stream is
rejected, with an optional JSON line (`class`, `bits` or `bit`) on standard error.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from snhc.conformance.process import DEFAULT_MEMORY, Surroundings, room
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.vectors.manifest import KINDS, Entry

from .base import DEFAULT_TIMEOUT, AdapterFault, Claims, Outcome, needed


@dataclass(frozen=True, slots=True)
class OneShot:
    """A decoder that is started once per vector. Rules: CNF-9, CNF-13, CNF-14. Fields: as in the TOML file.

    `folder`: where relative names in the command lie. `reproduce`: words for `snhc run`.
    """

    name: str
    command: tuple[str, ...]
    format: str = "ndjson"
    timeout: float = DEFAULT_TIMEOUT
    output_bytes: int = DEFAULT_LIMITS.adapter_output_bytes
    tools: tuple[str, ...] = ("fba",)
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    folder: Path | None = None
    reproduce: str = ""
    memory_bytes: int = DEFAULT_MEMORY
    kinds: tuple[str, ...] = KINDS
    profiles: tuple[str, ...] | None = None
    limits: Mapping[str, int] = field(default_factory=dict)
    readings: Mapping[str, str] = field(default_factory=dict)
    environment: Mapping[str, str] = field(default_factory=dict)
    pass_environment: tuple[str, ...] = ()
    writable: tuple[str, ...] = ()

    @property
    def claims(self) -> Claims:
        """What it says it can do."""
        profiles = None if self.profiles is None else frozenset(self.profiles)
        return Claims(
            frozenset(self.tools), frozenset(self.kinds), profiles, self.limits, self.readings,
            frozenset(self.options), (self.format,),
        )  # fmt: skip

    @property
    def around(self) -> Surroundings:
        """What it may take, see and touch."""
        return Surroundings(
            self.memory_bytes, self.output_bytes, self.folder, self.environment, self.pass_environment, self.writable
        )

    def lacks(self, entry: Entry) -> str:
        """What is not claimed, and what the command cannot carry."""
        missing = self.claims.lacks(entry)
        if entry.aux and not missing and not any("{aux}" in word for word in self.command):
            return "{aux} in the command"
        return missing

    def words(self, entry: Entry, path: Path, aux: Path | None) -> list[str]:
        """The command for one vector. Rules: CNF-9."""
        command = list(self.command)
        told = needed(entry.options)
        if "reading" in self.options:
            told += [("reading", {"name": name, "value": key}) for name, key in self.readings.items()]
        for name, values in told:
            command += [_filled(word, values) for word in self.options[name]]
        if aux is None:
            command = [word for word in command if "{aux}" not in word]
        places = {"input": str(path.absolute()), "aux": str(aux.absolute()) if aux is not None else ""}
        return [_filled(word, {**places, "media": entry.media}) for word in command]

    def decode(self, entry: Entry, path: Path, aux: Path | None = None) -> Outcome:
        """Start the command for one vector, and wait for its end or for a limit."""
        exceeded = self.claims.exceeded(entry, path, aux)
        if exceeded:
            return Outcome(None, stopped="unclaimed", detail=exceeded)
        with room(self.around) as own:
            here = own.put(path)
            second = None if aux is None else own.put(aux, "aux")
            command = self.words(entry, here, second)
            by_path = any("{input}" in word for word in self.command)
            try:
                ended = own.run(command, None if by_path else here, self.timeout)
            except OSError as error:
                return Outcome(None, stopped="start", detail=cannot_start(command[0], error))
        return Outcome(
            ended.code, ended.stdout, ended.stderr, ended.stopped, "", ended.seconds, self.readings, ended.peak
        )

    def timed(self, seconds: float) -> Self:
        """The same with another time limit."""
        return replace(self, timeout=seconds)

    def following(self, readings: Mapping[str, str]) -> Self:
        """The same, told by the option `reading` if it has one."""
        return replace(self, readings={**self.readings, **readings})

    def close(self) -> None:
        """Nothing runs between two vectors."""


def cannot_start(program: str, error: OSError) -> str:
    """Why a program could not be started, in words. Rules: CNF-9."""
    return f"{program}: {error.strerror or error}"


def _filled(word: str, values: Mapping[str, str]) -> str:
    # In one go: what is put in may hold braces itself.
    return re.sub(r"\{([a-z]+)\}", lambda match: values.get(match[1], match[0]), word)


def from_command(text: str, *, format: str = "ndjson", timeout: float = DEFAULT_TIMEOUT) -> OneShot:
    """An adapter from a command line, split as a shell would. Rules: CNF-9. Raises AdapterFault without any words."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise AdapterFault("CNF-9", "adapter command", value=text, allowed=str(error)) from error
    if not words:
        raise AdapterFault("CNF-9", "adapter command", value=text, allowed="a program and its arguments")
    extra = f" --adapter-format {format}" if format != "ndjson" else ""
    return OneShot(
        " ".join(Path(word).name for word in words if "{input}" not in word), tuple(words), format, timeout,
        folder=Path.cwd(),
        reproduce=f"--adapter-command {shlex.quote(text)}{extra}",
    )  # fmt: skip
