"""What is shrunk, and how it fails: the reference and the candidate asked for one input.

Rules: CNF-15, CNF-16, CNF-17.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Final

from snhc.conformance.adapters import Adapter, Outcome
from snhc.conformance.compare import BAD, Verdict, judge, said
from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError, Unsupported
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.stream import decode_planes
from snhc.vectors.dct_tolerance import of_planes
from snhc.vectors.decoding import Decoded, decode_input
from snhc.vectors.documents import tolerance_of
from snhc.vectors.manifest import (
    DCT_COEFFICIENTS,
    DOCUMENTS,
    FACE,
    FAT,
    FIT,
    Accepted,
    DecodeOptions,
    Entry,
    Expect,
    Rejected,
    Tolerance,
)

_SUFFIXES: Final = {"fba": ".fba", "m2d": ".m2d"}


@dataclass(frozen=True, slots=True)
class Subject:
    """An input to shrink. Rules: CNF-17. `entry`: its vector, or one made for a file. `aux`: its second file."""

    entry: Entry
    data: bytes
    aux: bytes | None = None


@dataclass(frozen=True, slots=True)
class Signature:
    """In which way an input fails.

    Rules: CNF-17. `status`: of the candidate. `reference`: `accepted`, or the class of the fault. `kind`: what differs
    (`faps`, `nodes`, ...), what it was rejected as, how it crashed.
    """

    status: str
    reference: str
    kind: str

    def __str__(self) -> str:
        return f"{self.status} ({self.kind or 'no more is known'}; reference: {self.reference})"


def subject_of_vector(entry: Entry, suite: Path) -> Subject:
    """A vector of a suite. Rules: CNF-17."""
    aux = (suite / entry.aux).read_bytes() if entry.aux else None
    return Subject(entry, (suite / entry.file).read_bytes(), aux)


def subject_of_file(path: Path, aux: Path | None, options: DecodeOptions) -> Subject:
    """Any file: its content says what it is. Rules: CNF-2, CNF-17. Raises OSError; InputFormat without needed `aux`."""
    data = path.read_bytes()
    second = aux.read_bytes() if aux is not None else None
    media, tools = _content(data, options)
    if media in (FIT, FAT) and second is None:
        raise InputFormat("CNF-17", str(path), value=f"a {media} table alone", allowed="--aux FRAMES with it")
    entry = Entry(
        path.name, path.name, "", "valid", "real", tools, None, (), (), (), "", "", media, options,
        Accepted("fba", "", ""), {}, {}, "", "0.0.0", aux="aux" if second is not None else "",
    )  # fmt: skip
    return Subject(entry, data, second)


def _content(data: bytes, options: DecodeOptions) -> tuple[str, tuple[str, ...]]:
    if data.lstrip()[:1] == b"{":
        try:
            document = json.loads(data)
        except (ValueError, RecursionError):
            document = {}
        for key, media, tool in (
            ("segments", DCT_COEFFICIENTS, "dctcoef"), ("points", FACE, "fapu"), ("tables", FAT, "fat"),
            ("meshes", FAT, "fat"), ("FAPs", FIT, "fit"),
        ):  # fmt: skip
            if key in document:
                return media, (tool,)
    tools: dict[str, None] = {}
    kinds: list[str] = []
    try:
        for plane in decode_planes(data, options.for_decoder(), on_object=kinds.append):
            faps = getattr(plane, "faps", None)
            if faps is not None and faps.segment is not None:
                tools["dct-p1"] = None
    except SnhcError:
        pass
    return ("m2d", ("mesh",)) if kinds == ["mesh"] else ("fba", ("fba", *tools))


class Target:
    """Asks reference and candidate.

    Rules: CNF-16, CNF-17. `folder`: for the files in between. `runs`: how often the candidate was asked.
    """

    def __init__(self, adapter: Adapter, subject: Subject, folder: Path) -> None:
        self._adapter = adapter
        self._entry = subject.entry
        self._folder = folder
        self._known: dict[bytes, Signature | None] = {}
        self.runs = 0

    def signature(self, data: bytes, aux: bytes | None, only: str | None = None) -> Signature | None:
        """How an input fails, None where it does not. Rules: CNF-17.

        `only`: what the reference must say of it; the candidate is not asked for another input.
        """
        key = sha256(data + b"\0" + (aux or b"")).digest()
        if key in self._known:
            return self._known[key]
        reference, _ = self._reference(data, aux)
        if only is not None and reference != only:
            return None
        verdict, outcome, _ = self.ask(data, aux)
        found = _signature(reference, verdict, outcome) if verdict.status in BAD else None
        self._known[key] = found
        return found

    def _reference(self, data: bytes, aux: bytes | None) -> tuple[str, Decoded]:
        decoded = decode_input(self._entry.media, data, aux, self._entry.options.for_decoder())
        return "accepted" if decoded.error is None else decoded.error.error_class, decoded

    def ask(self, data: bytes, aux: bytes | None) -> tuple[Verdict, Outcome, Entry]:
        """The verdict on an input, with the vector that was made of it in the folder. Rules: CNF-16."""
        _, decoded = self._reference(data, aux)
        entry = self._made(data, aux, decoded)
        if isinstance(decoded.error, Unsupported):
            return Verdict("not_applicable", "the reference does not decode it"), Outcome(0), entry
        lacks = self._adapter.lacks(entry)
        if lacks:
            return Verdict("not_applicable", f"not claimed: {lacks}"), Outcome(0), entry
        self.runs += 1
        outcome = self._adapter.decode(
            entry, self._folder / entry.file, self._folder / entry.aux if entry.aux else None
        )
        return judge(entry, outcome, self._folder, self._adapter.format), outcome, entry

    def _made(self, data: bytes, aux: bytes | None, decoded: Decoded) -> Entry:
        entry = self._entry
        name = "input" + _SUFFIXES.get(entry.media, ".json")
        (self._folder / name).write_bytes(data)
        if aux is not None:
            (self._folder / "frames.ndjson").write_bytes(aux)
        expect = self._expect(decoded, "expected.ndjson")
        readings: Mapping[str, Mapping[str, Expect]] = {}
        if entry.readings:
            readings = {amb: self._under(amb, list(keys), data, aux) for amb, keys in entry.readings.items()}
        return replace(
            entry, file=name, aux="frames.ndjson" if aux is not None else "", expect=expect, readings=readings,
            kind="ambiguous" if readings else "valid" if decoded.error is None else "invalid",
            tolerance=self._tolerance(data, aux) if decoded.error is None else None,
        )  # fmt: skip

    def _under(self, amb: str, keys: list[str], data: bytes, aux: bytes | None) -> dict[str, Expect]:
        out: dict[str, Expect] = {}
        for number, key in enumerate(keys):
            options = self._entry.options.for_decoder(Readings({amb: key}))
            decoded = decode_input(self._entry.media, data, aux, options)
            out[key] = self._expect(decoded, f"expected-{number}.ndjson")
        return out

    def _expect(self, decoded: Decoded, name: str) -> Expect:
        error = decoded.error
        if error is None:
            (self._folder / name).write_text(decoded.text, encoding="utf-8")
            return Accepted(decoded.kind, name, "")
        conceal = isinstance(self._entry.expect, Rejected) and self._entry.expect.allowed
        allowed = conceal or ("reject",)
        return Rejected(error.error_class, error.rule, error.bits, allowed, error.path if error.bits is None else "",
                        error.line)  # fmt: skip

    def _tolerance(self, data: bytes, aux: bytes | None) -> Tolerance | None:
        if self._entry.media in DOCUMENTS:
            return tolerance_of(self._entry.media, data, aux or b"")
        if self._entry.media != "fba":
            return None
        options = self._entry.options.for_decoder()
        return of_planes(plane for plane in decode_planes(data, options) if isinstance(plane, FbaPlane))


def _signature(reference: str, verdict: Verdict, outcome: Outcome) -> Signature:
    if verdict.difference is not None:
        match = re.match(r"[A-Za-z_ ]+", verdict.difference.what)
        kind = match[0] if match is not None else ""
    elif verdict.status == "fail":
        kind = "accepted" if outcome.code == 0 else f"rejected as {said(outcome.stderr).get('class', 'nothing')}"
    elif verdict.status == "crash":
        kind = verdict.reason.partition(":")[0]
    else:
        # Without what depends on the input: numbers, and what was read.
        kind = re.sub(r"[0-9]+|'.*'", "", verdict.reason)
    return Signature(verdict.status, reference, kind)
