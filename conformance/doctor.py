"""The doctor: walks an adapter through every step, says what is wrong in plain words, and what would help.

Rules: CNF-9, CNF-10, CNF-11, CNF-12, CNF-13, CNF-14, CNF-25.

A step that fails ends the walk where nothing behind it can work; else the others go on.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, NoReturn

from snhc.vectors.manifest import REJECT, SUITE, Accepted, Entry, Manifest, Rejected

from .adapters import REJECTED, AdapterFault, OneShot, Outcome, Persistent, find
from .adapters.base import needed
from .adapters.file import check, command_of, made, read
from .adapters.session import Broken, Ended, Session
from .candidate import Malformed, csv_rows, fap_text, ndjson
from .compare import fell_over, judge, said
from .diagnosis import DECODER, NOT_RUN, NOTE, OK, WRONG, Diagnosis, Step
from .process import resolved
from .scratch import scratch

_REJECTS: Final = "a stream is rejected by exit code 1 without a traceback, and by nothing else"


def examine(word: str, manifest: Manifest, suite: Path = SUITE) -> Diagnosis:
    """Walk an adapter through every step. Rules: CNF-13. `word`: as on the command line of `snhc run`."""
    walk = _Walk(manifest, suite)
    try:
        walk.all(word)
    except _Stop:
        pass
    finally:
        if walk.adapter is not None:
            walk.adapter.close()
    return Diagnosis(word, tuple(walk.steps))


class _Stop(Exception):
    """Nothing behind this step can work."""


class _Walk:
    def __init__(self, manifest: Manifest, suite: Path) -> None:
        self.steps: list[Step] = []
        self.adapter: OneShot | Persistent | None = None
        self._manifest = manifest
        self._suite = suite

    # -- saying --------------------------------------------------------------------------------------------------------

    def _ok(self, name: str, what: str) -> None:
        self.steps.append(Step(name, OK, what))

    def _note(self, name: str, what: str, fix: str = "", section: str = "") -> None:
        self.steps.append(Step(name, NOTE, what, fix, section))

    def _wrong(self, name: str, what: str, fix: str, section: str, state: str = WRONG) -> None:
        self.steps.append(Step(name, state, what, fix, section))

    def _stop(self, name: str, what: str, fix: str, section: str, state: str = WRONG) -> NoReturn:
        self._wrong(name, what, fix, section, state)
        raise _Stop

    # -- the way -------------------------------------------------------------------------------------------------------

    def all(self, word: str) -> None:
        self._file(word)
        assert self.adapter is not None
        if isinstance(self.adapter, Persistent):
            self._conversation(self.adapter)
        valid, invalid = self._vectors()
        first = self._decode(valid)
        self._output(valid, first)
        self._again(valid, first)
        if invalid is not None:
            self._reject(invalid)
        self._nonsense(valid)
        self._options()
        self._limits(first)
        if isinstance(self.adapter, Persistent):
            self._bye(self.adapter)

    def _file(self, word: str) -> None:
        path = Path(word)
        if not path.exists() and not path.suffix:
            adapter = find(word) if word.startswith("decoder:") else None
            if isinstance(adapter, Persistent):
                self.adapter = adapter
                self._ok("file", f"none is needed for {word}")
                return
        if not path.is_file():
            self._stop(
                "file",
                f"there is no file {word}",
                "give the path of the TOML file, or decoder:NAME for an installed Python decoder",
                "The TOML file",
            )
        self._ok("file", f"{word} is there")
        try:
            table = read(path)
        except AdapterFault as error:
            self._stop(
                "toml",
                f"it is no TOML: {error.allowed.removeprefix('TOML: ')}",
                "texts stand in quotes, lists in brackets, tables after all other keys",
                "The TOML file",
            )
        except OSError as error:
            self._stop("toml", f"it cannot be read: {error.strerror}", "let this user read it", "The TOML file")
        self._ok("toml", "it is TOML")
        try:
            check(table, path.name)
        except AdapterFault as error:
            self._stop(
                "keys",
                error.what.partition(": ")[2] + f" is {error.value}",
                f"allowed: {error.allowed}",
                "The TOML file",
            )
        self._ok("keys", "all keys are known and have values that fit")
        self._program(table, path.absolute().parent)
        self.adapter = made(table, path)

    def _program(self, table: dict[str, Any], folder: Path) -> None:
        if "library" in table:
            there = folder / table["library"]
            if not there.is_file():
                self._stop(
                    "program",
                    f"there is no file {there}",
                    "build the library; the name is relative to the TOML file",
                    "A shared library",
                )
            self._ok("program", f"{there.name} is there")
            return
        command = resolved(command_of(table, folder), folder)
        program = command[0]
        found = shutil.which(program)
        if found is None:
            if Path(program).is_file():
                self._stop(
                    "program",
                    f"{program} is there, but may not be executed",
                    f"chmod +x {program}, or name its interpreter first in the command",
                    "The TOML file",
                )
            near = "" if os.sep in program else f"; for a file beside the TOML file write ./{program}"
            self._stop(
                "program",
                f"there is no program {program}",
                f"give its path, relative to the TOML file, or a name in PATH{near}",
                "The TOML file",
            )
        else:
            self._interpreter(Path(found))
        self._ok("program", f"{found} can be executed")
        for word in command[1:]:
            looks_so = Path(word).suffix and not word.startswith("-") and not set("{} ").intersection(word)
            if looks_so and not Path(word).exists():
                self._note(
                    "program",
                    f"the command names {word}, which is not there",
                    "names of files are relative to the TOML file",
                    "The TOML file",
                )

    def _interpreter(self, program: Path) -> None:
        with program.open("rb") as file:
            head = file.read(200)
        if not head.startswith(b"#!"):
            return
        line = head[2:].split(b"\n")[0]
        words = line.strip().decode("utf-8", "replace").split()
        if line.endswith(b"\r"):
            self._stop(
                "program",
                f"the first line of {program.name} ends with a carriage return",
                "save the script with Unix line ends",
                "The program",
            )
        if words and shutil.which(words[0]) is None:
            self._stop(
                "program",
                f"the first line of {program.name} names {words[0]}, which is not there",
                "correct the line that begins with #!",
                "The program",
            )

    def _conversation(self, adapter: Persistent) -> None:
        try:
            session = Session(adapter.command, adapter.around)
        except Broken as error:
            self._stop("start", f"it cannot be started: {error.detail}", "try the command by hand", "The TOML file")
        self._ok("start", "it can be started")
        try:
            answer = session.hello(adapter.claims.readings, adapter.start_timeout)
        except Broken as error:
            tail = session.stderr.decode("utf-8", "replace").strip().splitlines()
            what = error.detail or error.stopped
            fix = (
                'answer every line with one line, {"seq": the same, "type": the same, ...}, and flush it; '
                "what is meant for people goes to standard error"
            )
            if isinstance(error, Ended):
                fix = "it has to stay until bye; see what it said, and try the command by hand"
            elif tail:
                what += f"; it said: {tail[-1][:200]}"
            self._stop("hello", what, fix, "One process for all vectors")
        finally:
            session.close()
        tools = ", ".join(answer.get("tools", ["fba"]))
        self._ok("hello", f"it answers, and claims {tools or 'nothing'}")

    def _vectors(self) -> tuple[Entry, Entry | None]:
        assert self.adapter is not None
        if isinstance(self.adapter, Persistent):
            # The process has its word too.
            probe = self._manifest.entries[0]
            self._asked(probe)
        can = [
            entry for entry in self._manifest.entries if not self.adapter.lacks(entry) and not entry.options.as_json()
        ]
        valid = [entry for entry in can if entry.kind == "valid"]
        if not valid:
            self._stop("claims", "there is no valid vector for what it claims", "claim tools and kinds", "Tools")
        invalid = [entry for entry in can if isinstance(entry.expect, Rejected) and entry.expect.allowed == (REJECT,)]
        count = len(can)
        self._ok("claims", f"{count} of {len(self._manifest.entries)} vectors are for it")
        return _first_valid(valid, self._suite), _first_invalid(invalid, self._suite) if invalid else None

    def _asked(self, entry: Entry) -> Outcome:
        assert self.adapter is not None
        aux = self._suite / entry.aux if entry.aux else None
        return self.adapter.decode(entry, self._suite / entry.file, aux)

    def _decode(self, entry: Entry) -> Outcome:
        outcome = self._asked(entry)
        name = "decode"
        tail = outcome.stderr.decode("utf-8", "replace").strip().splitlines()
        words = f"; it said: {tail[-1][:200]}" if tail else ""
        if outcome.stopped == "start":
            self._stop(name, f"it cannot be started: {outcome.detail}", "try the command by hand", "The program")
        if outcome.stopped == "timeout":
            assert self.adapter is not None
            self._stop(
                name,
                f"{entry.id} is tiny, and there was no end after {self.adapter.timeout:g} s{words}",
                "it may wait for input: name {input} in the command, or read standard input; else raise timeout",
                "The program",
            )
        if outcome.stopped == "protocol":
            self._stop(
                name,
                outcome.detail,
                "one answer to every question, nothing else on standard output",
                "One process for all vectors",
            )
        if outcome.stopped:
            self._stop(
                name,
                f"it was stopped: {judge(entry, outcome, self._suite, 'ndjson').reason}{words}",
                "see the limits",
                "Limits",
            )
        if outcome.code == REJECTED and fell_over(outcome.stderr):
            self._stop(
                name,
                f"it fell over on the valid stream {entry.id}{words}",
                "correct the program; where it means to reject a stream, it has to end with 1 and no traceback",
                "The program",
            )
        if outcome.code == REJECTED:
            self._stop(
                name,
                f"the valid stream {entry.id} was rejected{words}",
                "if the program could not read the file, or was called in the wrong way, it has to end with "
                "another code than 1",
                "The program",
                state=DECODER if said(outcome.stderr) or isinstance(self.adapter, Persistent) else WRONG,
            )
        if outcome.code != 0:
            self._stop(
                name,
                f"{judge(entry, outcome, self._suite, 'ndjson').reason}",
                "try the command by hand with a file of the suite: it has to end with 0",
                "The program",
            )
        self._ok(name, f"{entry.id} is accepted (exit code 0, {outcome.seconds:.2f} s)")
        return outcome

    def _output(self, entry: Entry, outcome: Outcome) -> None:
        assert self.adapter is not None and isinstance(entry.expect, Accepted)
        section, text, kind = "What it prints", outcome.stdout, entry.expect.kind
        if not text:
            self._stop(
                "output",
                "it prints nothing on standard output",
                "decoded frames go to standard output, not to a file, not to standard error",
                section,
            )
        try:
            text.decode("utf-8")
        except UnicodeDecodeError as error:
            self._stop(
                "output", f"byte {error.start} of what it prints is no UTF-8", "print text, not binary data", section
            )
        self._ok("output", f"{len(text)} bytes of text")
        if self.adapter.format == "ndjson":
            self._header(text, kind)
        readers: dict[str, Callable[[], list[Any]]] = {
            "ndjson": lambda: list(ndjson(text, kind)),
            "csv": lambda: list(csv_rows(text)),
            "fap": lambda: list(fap_text(text)),
        }
        try:
            frames = readers[self.adapter.format]()
        except Malformed as error:
            self._stop(
                "frames",
                str(error),
                f"print {self.adapter.format} as the guide says, one line per plane, and nothing else",
                section,
            )
        self._ok("frames", f"{len(frames)} frames can be read")
        verdict = judge(entry, outcome, self._suite, self.adapter.format)
        if verdict.status != "pass":
            self._wrong(
                "values",
                f"{entry.id}: {verdict.reason}",
                f"the adapter works, the decoder differs; right is {entry.expect.file}",
                "The verdict",
                state=DECODER,
            )
        else:
            self._ok("values", "all values are right")

    def _header(self, text: bytes, kind: str) -> None:
        line = text.split(b"\n")[0]
        wanted = f'{{"format":"snhc-decoded","version":1,"kind":"{kind}"}}'
        fix = f"the first line has to be {wanted}"
        if line.startswith(b"\xef\xbb\xbf"):
            self._stop("header", "the output begins with a byte order mark", "print UTF-8 without it", "What it prints")
        try:
            header = json.loads(line)
        except ValueError:
            header = None
        if not isinstance(header, dict):
            self._stop("header", f"the first line is {line[:60].decode('utf-8', 'replace')!r}", fix, "What it prints")
        elif "format" not in header:
            self._stop("header", "the first line is no header", fix, "What it prints")
        elif (header.get("format"), header.get("version"), header.get("kind")) != ("snhc-decoded", 1, kind):
            self._stop("header", f"the header says {header}", fix, "What it prints")
        self._ok("header", wanted)

    def _again(self, entry: Entry, first: Outcome) -> None:
        second = self._asked(entry)
        if (second.code, second.stdout) != (first.code, first.stdout):
            self._wrong(
                "again",
                "asked a second time, it answers otherwise",
                "nothing may be kept from one vector to the next, no file, no state",
                "The program",
            )
        else:
            self._ok("again", "asked a second time, it answers the same")

    def _reject(self, entry: Entry) -> None:
        assert self.adapter is not None and isinstance(entry.expect, Rejected)
        outcome = self._asked(entry)
        verdict = judge(entry, outcome, self._suite, self.adapter.format)
        if outcome.code == 0:
            self._wrong(
                "reject",
                f"the broken stream {entry.id} was accepted",
                'exit code 1 says that a stream is rejected; a decoder that finds no faults claims kinds = ["valid"]',
                "The program",
                state=DECODER,
            )
        elif verdict.status in ("crash", "timeout", "error"):
            self._wrong(
                "reject",
                f"on the broken stream {entry.id}: {verdict.status}: {verdict.reason}",
                _REJECTS,
                "The program",
            )
        elif verdict.status == "fail":
            self._wrong(
                "reject",
                f"{entry.id}: {verdict.reason}",
                "name the class and bits of the first fault, or nothing at all",
                "The program",
                state=DECODER,
            )
        elif verdict.status == "not_applicable":
            self._note("reject", f"it says Unsupported to {entry.id}")
        else:
            told = said(outcome.stderr)
            self._ok("reject", f"{entry.id} is rejected" + (f" as {json.dumps(told)[:100]}" if told else ""))
            if not told:
                self._note(
                    "reject",
                    "it does not say why",
                    'one JSON line on standard error, {"class": ..., "bits": [first, end]}, is compared too',
                    "The program",
                )

    def _nonsense(self, entry: Entry) -> None:
        """An empty file: the first thing that users do."""
        assert self.adapter is not None
        if not any(self.adapter.lacks(one) == "" for one in self._manifest.entries if one.kind == "invalid"):
            self.steps.append(Step("empty", NOT_RUN, "it does not claim vectors with faults"))
            return
        empty = self._suite / entry.file
        with _empty(empty.name) as path:
            outcome = self.adapter.decode(entry, path, self._suite / entry.aux if entry.aux else None)
        if outcome.code == REJECTED and judge(entry, outcome, self._suite, "ndjson").status != "crash":
            self._ok("empty", "an empty file is rejected")
        else:
            how = "accepted" if outcome.code == 0 else judge(entry, outcome, self._suite, "ndjson").reason
            self._wrong("empty", f"an empty file is not rejected: {how}", _REJECTS, "The program", state=DECODER)

    def _options(self) -> None:
        assert self.adapter is not None
        seen: set[str] = set()
        for entry in self._manifest.entries:
            names = {name for name, _ in needed(entry.options)}
            if not names - seen or self.adapter.lacks(entry):
                continue
            seen |= names
            verdict = judge(entry, self._asked(entry), self._suite, self.adapter.format)
            label = ", ".join(sorted(names))
            if verdict.status == "pass":
                self._ok("options", f"{label}: {entry.id} passes")
            else:
                self._wrong(
                    "options",
                    f"{label}: {entry.id}: {verdict.status}: {verdict.reason}",
                    "see what the option means; an option that is not claimed is not asked for",
                    "The TOML file",
                    state=DECODER,
                )

    def _limits(self, outcome: Outcome) -> None:
        assert self.adapter is not None
        peak = f", {outcome.peak >> 20} MiB of memory" if outcome.peak else ""
        words = f"{outcome.seconds:.2f} s of {self.adapter.timeout:g} s{peak}, {len(outcome.stdout)} bytes of output"
        if outcome.seconds > self.adapter.timeout / 2:
            self._note("limits", f"{words}: on a busy machine that is too near", "raise timeout", "Limits")
        else:
            self._ok("limits", words)

    def _bye(self, adapter: Persistent) -> None:
        session = Session(adapter.command, adapter.around)
        try:
            session.hello(adapter.claims.readings, adapter.start_timeout)
            session.bye()
        except Broken as error:
            self._wrong(
                "bye",
                error.detail or error.stopped,
                "after bye the process has to end with exit code 0, within 2 s",
                "One process for all vectors",
            )
        else:
            self._ok("bye", "it ends when it is told to")
        finally:
            session.close()


def _first_valid(entries: list[Entry], suite: Path) -> Entry:
    """A worked example or the smallest vector with two frames and with values in them; exact ones first."""

    def order(entry: Entry) -> tuple[bool, bool, bool, int, bool, int]:
        assert isinstance(entry.expect, Accepted)
        lines = [json.loads(line) for line in (suite / entry.expect.file).read_text(encoding="utf-8").splitlines()]
        filled = [line for line in lines if any(line.get("faps", ())) or line.get("nodes") or line.get("meshes")]
        size = (suite / entry.file).stat().st_size
        exact = entry.tolerance is None
        return len(filled) < 2, not exact, ".example." not in entry.id, len(entry.tools), bool(entry.aux), size

    return min(entries, key=order)


def _first_invalid(entries: list[Entry], suite: Path) -> Entry:
    """The smallest vector whose fault does not lie in its first bytes already."""

    def order(entry: Entry) -> tuple[bool, int, bool, int]:
        assert isinstance(entry.expect, Rejected)
        early = entry.expect.error_class == "InputFormat" or (entry.expect.bits or (99, 99))[0] < 64
        return early, len(entry.tools), bool(entry.aux), (suite / entry.file).stat().st_size

    return min(entries, key=order)


@contextlib.contextmanager
def _empty(name: str) -> Iterator[Path]:
    with scratch() as folder:
        path = folder / name
        path.write_bytes(b"")
        yield path
