"""Comparators: from what a decoder did to a status.

Rules: CNF-9, CNF-15, CNF-16 (exact, reject, ambiguous), CNF-19, CNF-21, CNF-26.

* A valid vector: exit 0 and every line equal. `.fap` text holds less (FBA-54): the frames with FAP data, their
  distance, and what was transmitted.
* An invalid vector: exit 1; class and bits are held against the manifest where the decoder names them. Where it may
  conceal: exit 0, well-formed output, and all lines before the fault equal, and more of them
  unless the data ends there.
* An ambiguous vector: as any one of its readings.
* Exit 1 with the traceback of a run-time system is a crash, not a rejection.
* `Unsupported`, named in the JSON line: not_applicable, never a pass.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.fap_text import FapTextFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.rules import ambiguity
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.output import FapFrames
from snhc.reference_impl.systems.stream import decode_planes
from snhc.vectors.decoding import decode
from snhc.vectors.manifest import CONCEAL, REJECT, Accepted, Entry, Rejected

from .adapters import REJECTED, Outcome
from .candidate import Frame, Malformed, csv_rows, fap_text, ndjson

STATUSES: Final = ("pass", "fail", "error", "timeout", "crash", "skipped", "not_applicable", "xfail", "xpass")
BAD: Final = ("fail", "error", "timeout", "crash", "xpass")

_PARSERS: Final[dict[str, Callable[[bytes], list[Frame]]]] = {"ndjson": ndjson, "csv": csv_rows}
_EXTRA: Final = ("gender", "coding_type", "fap_quant", "baps")


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing that differs.

    Rules: CNF-16, CNF-17. `frame`: line index, from 0. `what`: `faps`, `state`, `time`, `viseme.blend`, ...,
    `missing frame`, `extra frame`. `fap`: its number where one FAP is at fault.
    """

    frame: int
    what: str
    fap: int | None
    reference: Any
    candidate: Any

    def __str__(self) -> str:
        place = f"frame {self.frame}, {self.what if self.fap is None else f'FAP {self.fap} ({self.what})'}"
        return f"{place}: reference {self.reference}, candidate {self.candidate}"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The status of one vector with one decoder. Rules: CNF-15, CNF-16. `reading`: followed, of an ambiguous vector."""

    status: str
    reason: str = ""
    difference: Difference | None = None
    reading: str = ""


def judge(entry: Entry, outcome: Outcome, suite: Path, format: str) -> Verdict:
    """The status that an outcome gives. Rules: CNF-15, CNF-16."""
    if outcome.stopped == "timeout":
        return Verdict("timeout", f"no end after {outcome.seconds:.1f} s")
    if outcome.stopped == "output":
        return Verdict("error", f"more than {len(outcome.stdout)} bytes of output")
    if outcome.stopped:
        return Verdict("error", outcome.detail)
    if outcome.code not in (0, REJECTED) or (outcome.code == REJECTED and _fell_over(outcome.stderr)):
        return Verdict("crash", _crash(outcome))
    try:
        said = _said(outcome.stderr)
        if outcome.code == REJECTED and said.get("class") == "Unsupported":
            return Verdict("not_applicable", "the decoder says Unsupported")
        if entry.readings:
            return _ambiguous(entry, outcome, said, suite, format)
        if isinstance(entry.expect, Rejected):
            return _rejected(entry, entry.expect, outcome, said, suite, format)
        return _accepted(entry, entry.expect, outcome, said, suite, format, Readings())
    except Malformed as error:
        return Verdict("error", str(error))


# Run-time systems that end with 1 when a program falls over say so in these words.
_FALLEN: Final = (b"Traceback (most recent call last):", b'Exception in thread "main"')


def _fell_over(stderr: bytes) -> bool:
    return any(line.startswith(_FALLEN) for line in stderr.splitlines())


def _crash(outcome: Outcome) -> str:
    code = outcome.code or 0
    how = outcome.detail or (f"signal {-code}" if code < 0 else f"exit code {code}")
    tail = outcome.stderr.decode("utf-8", "replace").strip().splitlines()
    return f"{how}: {tail[-1][:200]}" if tail else how


def _said(stderr: bytes) -> dict[str, Any]:
    """The JSON line of CNF-9: the last one on standard error with a class or a place."""
    for line in reversed(stderr.decode("utf-8", "replace").splitlines()):
        if not line.lstrip().startswith("{"):
            continue
        try:
            value = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(value, dict) and value.keys() & {"class", "bits", "bit"}:
            return value
    return {}


# -- accepted ----------------------------------------------------------------------------------------------------------


def _accepted(
    entry: Entry,
    expect: Accepted,
    outcome: Outcome,
    said: Mapping[str, Any],
    suite: Path,
    format: str,
    readings: Readings,
) -> Verdict:
    if outcome.code == REJECTED:
        what = f" ({said.get('class', 'no class')} at {said.get('bits', said.get('bit', 'no place'))})" if said else ""
        return Verdict("fail", f"a valid stream was rejected{what}")
    difference = _against_file(entry, expect, outcome, suite, format, readings)
    return Verdict("pass") if difference is None else Verdict("fail", str(difference), difference)


def _against_file(
    entry: Entry, expect: Accepted, outcome: Outcome, suite: Path, format: str, readings: Readings
) -> Difference | None:
    wanted = (suite / expect.file).read_bytes()
    if format == "fap":
        return fap_difference(_reference_fap(entry, suite, readings), fap_text(outcome.stdout))
    if format == "ndjson" and outcome.stdout == wanted:
        return None
    return difference_of(ndjson(wanted), _PARSERS[format](outcome.stdout))


def _reference_fap(entry: Entry, suite: Path, readings: Readings) -> list[FapTextFrame]:
    frames = FapFrames(readings)
    out: list[FapTextFrame] = []
    try:
        for plane in decode_planes((suite / entry.file).read_bytes(), entry.options.for_decoder(readings)):
            if isinstance(plane, FbaPlane):
                out += frames.of(plane)
    except SnhcError:
        # What stands before the fault is wanted.
        return out
    return out


def difference_of(reference: Sequence[Frame], candidate: Sequence[Frame], *, prefix: bool = False) -> Difference | None:
    """The first difference of two decoded face streams, None if they agree.

    Rules: CNF-1, CNF-16. Keys that the candidate has not, and that CNF-1 does not demand, are not compared. `prefix`:
    the candidate may go on after the last frame of the reference.
    """
    for i, (ours, theirs) in enumerate(zip(reference, candidate, strict=False)):
        found = _frame_difference(i, ours, theirs)
        if found is not None:
            return found
    if len(candidate) < len(reference):
        return Difference(len(candidate), "missing frame", None, f"{len(reference)} frames", f"{len(candidate)} frames")
    if len(candidate) > len(reference) and not prefix:
        return Difference(len(reference), "extra frame", None, f"{len(reference)} frames", f"{len(candidate)} frames")
    return None


def _frame_difference(i: int, ours: Frame, theirs: Frame) -> Difference | None:
    for number, (a, b) in enumerate(zip(ours["faps"], theirs["faps"], strict=True), 1):
        if a != b:
            return Difference(i, "faps", number, a, b)
    for name, fap in (("viseme", 1), ("expression", 2)):
        a, b = ours[name], theirs[name]
        if a is None or b is None:
            if a is not b:
                return Difference(i, name, fap, a, b)
            continue
        for key in a:
            if a[key] != b[key]:
                return Difference(i, f"{name}.{key}", fap, a[key], b[key])
    for number, (a, b) in enumerate(zip(ours["state"], theirs["state"], strict=True), 1):
        if a != b:
            return Difference(i, "state", number, a, b)
    if Fraction(ours["time"]) != Fraction(theirs["time"]):
        return Difference(i, "time", None, ours["time"], theirs["time"])
    for key in ("intra", "index"):
        if ours[key] != theirs[key]:
            return Difference(i, key, None, ours[key], theirs[key])
    for key in _EXTRA:
        if key in ours and key in theirs and ours[key] != theirs[key]:
            return Difference(i, key, None, ours[key], theirs[key])
    return None


def fap_difference(
    reference: Sequence[FapTextFrame], candidate: Sequence[FapTextFrame], *, prefix: bool = False
) -> Difference | None:
    """The first difference of two `.fap` texts. Rules: FBA-54, CNF-16. Frame numbers count from the first frame."""
    for i, (ours, theirs) in enumerate(zip(reference, candidate, strict=False)):
        for number, (a, b) in enumerate(zip(ours.mask, theirs.mask, strict=True), 1):
            if a != b:
                return Difference(i, "mask", number, a, b)
        for number, (x, y) in enumerate(zip(ours.values, theirs.values, strict=True), 1):
            if x != y:
                return Difference(i, "faps", number, x, y)
        if ours.viseme != theirs.viseme:
            return Difference(i, "viseme", 1, ours.viseme, theirs.viseme)
        if ours.expression != theirs.expression:
            return Difference(i, "expression", 2, ours.expression, theirs.expression)
        a, b = ours.number - reference[0].number, theirs.number - candidate[0].number
        if a != b:
            return Difference(i, "frame number", None, a, b)
    if len(candidate) < len(reference):
        return Difference(len(candidate), "missing frame", None, f"{len(reference)} frames", f"{len(candidate)} frames")
    if len(candidate) > len(reference) and not prefix:
        return Difference(len(reference), "extra frame", None, f"{len(reference)} frames", f"{len(candidate)} frames")
    return None


# -- rejected ----------------------------------------------------------------------------------------------------------


def _rejected(
    entry: Entry, expect: Rejected, outcome: Outcome, said: Mapping[str, Any], suite: Path, format: str
) -> Verdict:
    wanted = f"{expect.error_class} ({expect.rule}) at bits {list(expect.bits)}"
    if outcome.code == 0:
        if CONCEAL not in expect.allowed:
            return Verdict("fail", f"a broken stream was accepted, expected {wanted}")
        return _concealed(entry, expect, outcome, suite, format)
    if REJECT not in expect.allowed:
        return Verdict("fail", "the stream was rejected, the decoder has to go on")
    if "class" in said and said["class"] != expect.error_class:
        return Verdict("fail", f"rejected as {said['class']!r}, expected {wanted}")
    span = _span(said)
    if span is not None and not overlap(span, expect.bits):
        return Verdict("fail", f"rejected at bits {list(span)}, expected {wanted}")
    return Verdict("pass", "" if said else "rejected, no class and no place named")


def _span(said: Mapping[str, Any]) -> tuple[int, int] | None:
    bits = said.get("bits")
    if bits is not None:
        if not (isinstance(bits, list) and len(bits) == 2 and all(type(bit) is int for bit in bits)):
            raise Malformed(f"bits is {bits!r}, not [first, end]")
        return bits[0], bits[1]
    bit = said.get("bit")
    if bit is not None:
        if type(bit) is not int:
            raise Malformed(f"bit is {bit!r}, not an integer")
        return bit, bit + 1
    return None


def overlap(a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Whether two half-open spans share a bit; an empty span counts as the place between two bits. Rules: CNF-21."""
    if a[0] == a[1] or b[0] == b[1]:
        return a[0] <= b[1] and b[0] <= a[1]
    return a[0] < b[1] and b[0] < a[1]


# Behind these a decoder has nothing that it could go on with.
_NOTHING_FOLLOWS: Final = ("Truncated", "ResourceLimit")


def _concealed(entry: Entry, expect: Rejected, outcome: Outcome, suite: Path, format: str) -> Verdict:
    found: Difference | None
    if format == "fap":
        texts, got = _reference_fap(entry, suite, Readings()), fap_text(outcome.stdout)
        found, before, given = fap_difference(texts, got, prefix=True), len(texts), len(got)
    else:
        decoded = decode((suite / entry.file).read_bytes(), entry.options.for_decoder())
        lines, frames = ndjson(decoded.text.encode()), _PARSERS[format](outcome.stdout)
        found, before, given = difference_of(lines, frames, prefix=True), len(lines), len(frames)
    if found is not None:
        return Verdict("fail", f"the fault was concealed, but before it: {found}", found)
    if given == before and expect.error_class not in _NOTHING_FOLLOWS:
        return Verdict("fail", "the stream was accepted, and nothing was made of what follows the fault")
    return Verdict("pass", "concealed")


# -- ambiguous ---------------------------------------------------------------------------------------------------------


def _ambiguous(entry: Entry, outcome: Outcome, said: Mapping[str, Any], suite: Path, format: str) -> Verdict:
    first: Verdict | None = None
    for amb, readings in entry.readings.items():
        followed = ambiguity(amb).followed
        for key, expect in sorted(readings.items(), key=lambda item: item[0] != followed):
            if isinstance(expect, Rejected):
                verdict = _rejected(entry, expect, outcome, said, suite, format)
            else:
                verdict = _accepted(entry, expect, outcome, said, suite, format, Readings({amb: key}))
            if verdict.status == "pass":
                return Verdict("pass", verdict.reason, reading=f"{amb}={key}")
            first = first or verdict
    assert first is not None
    return Verdict(first.status, f"as no reading says; as the one followed: {first.reason}", first.difference)
