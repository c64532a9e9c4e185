"""Comparators: from what a decoder did to a status.

Rules: CNF-9, CNF-15, CNF-16, CNF-19, CNF-21, CNF-25, CNF-26, DCT-8. What differs is found in `differences`.

* A valid vector: exit 0 and every line equal; FAPs that come from DCT segments and floats within the vector's
  tolerance. The triangles of a mesh are a set, but where the vector is about their order (MSH-21). `.fap` text holds
  less (FBA-54): the frames with FAP data, their distance, and what was transmitted.
* An invalid vector: exit 1; class and place (bits, or path and line) are held against the manifest where the decoder
  names them. Where it may conceal: exit 0, well-formed output, and all lines before the fault equal, and more of them
  unless the data ends there.
* An ambiguous vector: as any one of its readings.
* Exit 1 with the traceback of a run-time system is a crash, not a rejection.
* `Unsupported`, named in the JSON line: not_applicable, never a pass.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.dct_comparison import first_mismatch
from snhc.reference_impl.face.fap_text import FapTextFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.rules import ambiguities, ambiguity
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.systems.output import FapFrames
from snhc.reference_impl.systems.stream import decode_planes
from snhc.vectors.dct_tolerance import Unrounded, unrounded_planes
from snhc.vectors.decoding import Decoded, decode_input
from snhc.vectors.manifest import CONCEAL, DOCUMENTS, REJECT, Accepted, Entry, Rejected

from .adapters import REJECTED, Outcome
from .candidate import Frame, Malformed, csv_rows, document_fap, fap_text, ndjson, shown
from .differences import Difference, Near, difference_of, exactly, fap_difference, float_difference, mesh_difference

STATUSES: Final = ("pass", "fail", "error", "timeout", "crash", "skipped", "not_applicable", "xfail", "xpass")
BAD: Final = ("fail", "error", "timeout", "crash", "xpass")


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
        return Verdict("error", outcome.detail or f"more than {len(outcome.stdout)} bytes of output")
    if outcome.stopped == "memory":
        return Verdict("crash", f"more memory than it may take ({outcome.peak or outcome.detail} bytes)")
    if outcome.stopped == "warden":
        return Verdict("crash", "it has killed the process that watched it")
    if outcome.stopped == "unclaimed":
        return Verdict("not_applicable", f"not claimed: {outcome.detail}")
    if outcome.stopped:
        return Verdict("error", outcome.detail)
    if outcome.code not in (0, REJECTED) or (outcome.code == REJECTED and fell_over(outcome.stderr)):
        return Verdict("crash", _crash(outcome))
    try:
        line = said(outcome.stderr)
        if outcome.code == REJECTED and line.get("class") == "Unsupported":
            return Verdict("not_applicable", "the decoder says Unsupported")
        followed = followed_by(outcome)
        if followed:
            return _following(entry, outcome, line, suite, format, followed)
        if entry.readings:
            return _ambiguous(entry, outcome, line, suite, format)
        if isinstance(entry.expect, Rejected):
            return _rejected(entry, entry.expect, outcome, line, suite, format)
        return _accepted(entry, entry.expect, outcome, line, suite, format, Readings())
    except Malformed as error:
        return Verdict("error", str(error))


# Run-time systems that end with 1 when a program falls over, and shells whose child did, say so in these words.
_SIGNALS: Final = rb"(Segmentation fault|Bus error|Illegal instruction|Floating point exception|Aborted|Killed)"
_FALLEN: Final = re.compile(
    rb'^(Traceback \(most recent call last\):|Exception in thread "main"|Node\.js v[0-9]|stack traceback:'
    rb"|==[0-9]+==\s*ERROR: \w+Sanitizer: |SUMMARY: \w+Sanitizer: "
    rb"|(.*: line [0-9]+: |bash: )\s*[0-9]+ " + _SIGNALS + rb"|" + _SIGNALS + rb"( \(core dumped\))?$)",
    re.MULTILINE,
)


def fell_over(stderr: bytes) -> bool:
    """Whether standard error holds the traceback of a run-time system, the report of a sanitizer or the like.

    Rules: CNF-9.
    """
    return _FALLEN.search(stderr) is not None


def _crash(outcome: Outcome) -> str:
    code = outcome.code or 0
    how = outcome.detail or (f"signal {-code}" if code < 0 else f"exit code {code}")
    tail = outcome.stderr.decode("utf-8", "replace").strip().splitlines()
    return f"{how}: {tail[-1][:200]}" if tail else how


def said(stderr: bytes) -> dict[str, Any]:
    """The JSON line on standard error: the last one with a class or a place, {} for none. Rules: CNF-9."""
    for line in reversed(stderr.decode("utf-8", "replace").splitlines()):
        if not line.lstrip().startswith("{"):
            continue
        try:
            value = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(value, dict) and value.keys() & {"class", "bits", "bit", "path", "line"}:
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
        what = (
            f" ({said.get('class', 'no class')} at {said.get('bits', said.get('bit', said.get('path', 'no place')))})"
            if said
            else ""
        )
        return Verdict("fail", f"a valid stream was rejected{what}")
    difference = _against_file(entry, expect, outcome, suite, format, readings)
    return Verdict("pass") if difference is None else Verdict("fail", str(difference), difference)


def _parsed(format: str, text: bytes, kind: str) -> list[Frame]:
    return csv_rows(text) if format == "csv" else ndjson(text, kind)


def _against_file(
    entry: Entry, expect: Accepted, outcome: Outcome, suite: Path, format: str, readings: Readings
) -> Difference | None:
    wanted = _wanted(entry, expect, suite, readings)
    if format == "fap":
        texts, unrounded = _reference_fap(entry, suite, readings)
        return fap_difference(texts, fap_text(outcome.stdout), _face_near(entry, unrounded))
    if format == "ndjson" and outcome.stdout == wanted:
        return None
    reference, candidate = ndjson(wanted, expect.kind), _parsed(format, outcome.stdout, expect.kind)
    return _difference(entry, expect.kind, reference, candidate, suite, readings)


def _wanted(entry: Entry, expect: Accepted, suite: Path, readings: Readings) -> bytes:
    if expect.file:
        return (suite / expect.file).read_bytes()
    # Nobody has written down what this choice of readings gives.
    return _reference(entry, suite, readings).text.encode()


def _reference(entry: Entry, suite: Path, readings: Readings) -> Decoded:
    aux = (suite / entry.aux).read_bytes() if entry.aux else None
    return decode_input(entry.media, (suite / entry.file).read_bytes(), aux, entry.options.for_decoder(readings))


def _difference(
    entry: Entry,
    kind: str,
    reference: Sequence[Frame],
    candidate: Sequence[Frame],
    suite: Path,
    readings: Readings,
    prefix: bool = False,
) -> Difference | None:
    if kind == "mesh":
        # What the vector shows is then the order itself.
        return mesh_difference(reference, candidate, ordered="MSH-21" in entry.rules, prefix=prefix)
    if kind in ("vertices", "fapu"):
        bound = entry.tolerance.bound if entry.tolerance is not None else 0.0
        return float_difference(reference, candidate, bound, prefix=prefix)
    found = difference_of(reference, candidate, prefix=prefix)
    if found is None or entry.tolerance is None:
        return found
    # Only now is it worth while to compute what stands before rounding.
    return difference_of(reference, candidate, _face_near(entry, _unrounded(entry, suite, readings)), prefix=prefix)


def _unrounded(entry: Entry, suite: Path, readings: Readings) -> list[Unrounded]:
    data = (suite / entry.file).read_bytes()
    if entry.media in DOCUMENTS:
        from snhc.vectors.documents import unrounded

        return unrounded(data, readings)
    return [row for _, rows in _face_planes(entry, data, readings) for row in rows]


def _face_planes(entry: Entry, data: bytes, readings: Readings) -> Iterator[tuple[FbaPlane, list[Unrounded]]]:
    """The planes before the first fault, with what stands before rounding."""
    planes: list[FbaPlane] = []
    try:
        for plane in decode_planes(data, entry.options.for_decoder(readings)):
            if isinstance(plane, FbaPlane):
                planes.append(plane)
    except SnhcError:
        # What stands before the fault is wanted.
        return unrounded_planes(planes, readings)
    return unrounded_planes(planes, readings)


def _face_near(entry: Entry, unrounded: Sequence[Unrounded]) -> Near:
    """DCT-8: a value from a segment may differ by 1, within the bound of what stands before rounding."""
    if entry.tolerance is None:
        return exactly
    bound = entry.tolerance.bound

    def near(line: int, fap: int, reference: int | None, candidate: int | None) -> bool:
        if reference is None or candidate is None or line >= len(unrounded):
            return reference == candidate
        value = unrounded[line][fap - 1]
        if value is None:
            return reference == candidate
        return first_mismatch([reference], [candidate], bound, [value]) is None

    return near


def _reference_fap(entry: Entry, suite: Path, readings: Readings) -> tuple[list[FapTextFrame], list[Unrounded]]:
    frames = FapFrames(readings)
    data = (suite / entry.file).read_bytes()
    texts: list[FapTextFrame] = []
    unrounded: list[Unrounded] = []
    if entry.media in DOCUMENTS:
        decoded = decode_input(entry.media, data, None, entry.options.for_decoder(readings))
        return document_fap(decoded.lines[1:]), _unrounded(entry, suite, readings)
    for plane, rows in _face_planes(entry, data, readings):
        texts += frames.of(plane)
        if plane.faps is not None:
            unrounded += rows
    return texts, unrounded


# -- rejected ----------------------------------------------------------------------------------------------------------


def _rejected(
    entry: Entry,
    expect: Rejected,
    outcome: Outcome,
    said: Mapping[str, Any],
    suite: Path,
    format: str,
    readings: Readings = DEFAULT_READINGS,
) -> Verdict:
    wanted = f"{expect.error_class} ({expect.rule}) at {expect.place or 'no place'}"
    if outcome.code == 0:
        if CONCEAL not in expect.allowed:
            return Verdict("fail", f"a broken stream was accepted, expected {wanted}")
        return _concealed(entry, expect, outcome, suite, format, readings)
    if REJECT not in expect.allowed:
        return Verdict("fail", "the stream was rejected, the decoder has to go on")
    if "class" in said and said["class"] != expect.error_class:
        return Verdict("fail", f"rejected as {shown(said['class'])}, expected {wanted}")
    elsewhere = _elsewhere(expect, said)
    if elsewhere:
        return Verdict("fail", f"rejected at {elsewhere}, expected {wanted}")
    return Verdict("pass", "" if said else "rejected, no class and no place named")


def _elsewhere(expect: Rejected, said: Mapping[str, Any]) -> str:
    """The place that a decoder names, if it is not that of the manifest; "" if it is, or if none is named."""
    if expect.bits is not None:
        found = span(said)
        return f"bits {list(found)}" if found is not None and not overlap(found, expect.bits) else ""
    path, line = said.get("path"), said.get("line")
    if path is not None and not isinstance(path, str):
        raise Malformed(f"path is {shown(path)}, not a text")
    if line is not None and type(line) is not int:
        raise Malformed(f"line is {shown(line)}, not an integer")
    if path and expect.path and not related(path, expect.path):
        return f"path {path}"
    return f"line {line}" if line is not None and expect.line is not None and line != expect.line else ""


def related(a: str, b: str) -> bool:
    """Whether one path leads to the other: a decoder may name the list for its entry. Rules: CNF-25."""
    steps = [re.findall(r"[^.\[\]]+", path) for path in (a, b)]
    return all(x == y for x, y in zip(*steps, strict=False))


def span(said: Mapping[str, Any]) -> tuple[int, int] | None:
    """The bits that a JSON line names, None for none. Rules: CNF-9, CNF-21. Raises Malformed."""
    bits = said.get("bits")
    if bits is not None:
        if not (isinstance(bits, list) and len(bits) == 2 and all(type(bit) is int for bit in bits)):
            raise Malformed(f"bits is {shown(bits)}, not [first, end]")
        return bits[0], bits[1]
    bit = said.get("bit")
    if bit is not None:
        if type(bit) is not int:
            raise Malformed(f"bit is {shown(bit)}, not an integer")
        return bit, bit + 1
    return None


def overlap(a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Whether two half-open spans share a bit; an empty span counts as the place between two bits. Rules: CNF-21."""
    if a[0] == a[1] or b[0] == b[1]:
        return a[0] <= b[1] and b[0] <= a[1]
    return a[0] < b[1] and b[0] < a[1]


# Behind these a decoder has nothing that it could go on with.
_NOTHING_FOLLOWS: Final = ("Truncated", "ResourceLimit")


def _concealed(
    entry: Entry, expect: Rejected, outcome: Outcome, suite: Path, format: str, readings: Readings
) -> Verdict:
    found: Difference | None
    if format == "fap":
        texts, unrounded = _reference_fap(entry, suite, readings)
        got = fap_text(outcome.stdout)
        found, before, given = (
            fap_difference(texts, got, _face_near(entry, unrounded), prefix=True),
            len(texts),
            len(got),
        )
    else:
        decoded = _reference(entry, suite, readings)
        lines = ndjson(decoded.text.encode(), decoded.kind)
        frames = _parsed(format, outcome.stdout, decoded.kind)
        found = _difference(entry, decoded.kind, lines, frames, suite, readings, prefix=True)
        before, given = len(lines), len(frames)
    if found is not None:
        return Verdict("fail", f"the fault was concealed, but before it: {found}", found)
    if given == before and expect.error_class not in _NOTHING_FOLLOWS:
        return Verdict("fail", "the stream was accepted, and nothing was made of what follows the fault")
    return Verdict("pass", "concealed")


# -- ambiguous ---------------------------------------------------------------------------------------------------------


def _ambiguous(entry: Entry, outcome: Outcome, said: Mapping[str, Any], suite: Path, format: str) -> Verdict:
    first: Verdict | None = None
    words = "as no reading says; as the one followed"
    for amb, readings in entry.readings.items():
        followed = ambiguity(amb).followed
        keys = sorted(readings, key=lambda key: key != followed)
        if outcome.readings.get(amb) in readings:
            # It has said which one it follows.
            keys = [outcome.readings[amb]]
            words = f"not as {amb}={keys[0]}, which it claims to follow"
        for key in keys:
            expect = readings[key]
            if isinstance(expect, Rejected):
                verdict = _rejected(entry, expect, outcome, said, suite, format)
            else:
                verdict = _accepted(entry, expect, outcome, said, suite, format, Readings({amb: key}))
            if verdict.status == "pass":
                return Verdict("pass", verdict.reason, reading=f"{amb}={key}")
            first = first or verdict
    assert first is not None
    return Verdict(first.status, f"{words}: {first.reason}", first.difference)


# -- readings that a decoder follows -----------------------------------------------------------------------------------


def followed_by(outcome: Outcome) -> dict[str, str]:
    """The readings that a decoder claims and that are not the default. Rules: CNF-24."""
    known = ambiguities()
    return {
        amb: key
        for amb, key in outcome.readings.items()
        if amb in known and known[amb].built and key in known[amb].readings and key != known[amb].followed
    }


def _following(
    entry: Entry, outcome: Outcome, said: Mapping[str, Any], suite: Path, format: str, followed: Mapping[str, str]
) -> Verdict:
    """As the reference decoder with the same readings; many streams show one that were not made to show it."""
    choices: list[dict[str, str]] = [dict(followed)]
    for amb, readings in entry.readings.items():
        if amb not in outcome.readings:
            choices = [{**choice, amb: key} for choice in choices for key in readings]
    first: Verdict | None = None
    for choice in choices:
        chosen = Readings(choice)
        decoded = _reference(entry, suite, chosen)
        if decoded.error is None:
            expect = Accepted(decoded.kind, "", "")
            verdict = _accepted(entry, expect, outcome, said, suite, format, chosen)
        else:
            verdict = _rejected(entry, _fault(entry, decoded.error), outcome, said, suite, format, chosen)
        names = ", ".join(f"{amb}={key}" for amb, key in choice.items())
        if verdict.status == "pass":
            return Verdict("pass", verdict.reason, reading=names if entry.readings else "")
        first = first or Verdict(verdict.status, f"with {names}: {verdict.reason}", verdict.difference)
    assert first is not None
    return first


def _fault(entry: Entry, error: SnhcError) -> Rejected:
    allowed = entry.expect.allowed if isinstance(entry.expect, Rejected) else (REJECT,)
    return Rejected(error.error_class, error.rule, error.bits, allowed, error.path, error.line)
