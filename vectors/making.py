"""Making one vector from its recipe.

Rules: CNF-3, CNF-4, CNF-6, CNF-16, CNF-24, CNF-25.

What a decoder must give is what the reference decoder gives now, held against what the recipe itself declares: class,
rule and place of a fault, and whatever an `Accept` spells out. Beyond that every valid stream must be written back to
the same bytes, and read alike by reader and tracer. The tolerance is computed from the vector; an ambiguous one has the
largest of its readings.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.rules import ambiguity
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import (
    Options,
    decode_planes,
    read_stream,
    trace_stream,
    write_faulty,
    write_stream,
)

from .checking import profile_check
from .dct_tolerance import of_planes
from .decoding import Decoded, decode_input
from .manifest import BAP, FACE, FAP, FAT, FIT, Accepted, Entry, Expect, Rejected, Tolerance
from .recipe import Accept, Ambiguous, Document, Place, Recipe, Reject, Stream, build_fault

GENERATOR: Final = 1


class RecipeFault(Exception):
    """A recipe and the reference decoder disagree, or a recipe is out of form. Rules: CNF-4."""


@dataclass(frozen=True, slots=True)
class Made:
    """A vector: its entry, and its files by name. Rules: CNF-3."""

    entry: Entry
    files: dict[str, bytes]


@dataclass(frozen=True, slots=True)
class _Input:
    """The files that a decoder gets. `names`: their endings."""

    media: str
    data: bytes
    aux: bytes | None = None
    ending: str = ""

    def decode(self, recipe: Recipe, readings: Readings = DEFAULT_READINGS) -> Decoded:
        return decode_input(self.media, self.data, self.aux, recipe.options.for_decoder(readings))

    @property
    def is_document(self) -> bool:
        return bool(self.ending)


# How the files of documents end; frames are always `.frames.ndjson`.
_ENDINGS: Final = {FIT: "table.json", FAT: "table.json", FACE: "face.json", FAP: "fap", BAP: "bap"}
_COEFFICIENTS: Final = "json"


def make(recipe: Recipe) -> Made:
    """Make one vector. Rules: CNF-3, CNF-6. Raises RecipeFault where recipe and decoder disagree."""
    build = recipe.build()
    readings: dict[str, dict[str, Expect]] = {}
    files: dict[str, bytes] = {}
    base = f"{recipe.id.partition('.')[0]}/{recipe.id}"
    tolerance: Tolerance | None = None
    check: dict[str, Any] | None = None
    expect: Expect
    try:
        _demand(not (fault := build_fault(build)), fault)
        if isinstance(build, Reject):
            source, expect = _reject(recipe, build)
            kind = "invalid"
            if not source.is_document:
                tolerance = _tolerance(recipe, source)
        else:
            source = _input(recipe, build.stream)
            tolerance = _tolerance(recipe, source)
            if isinstance(build, Accept):
                decoded = _accept(recipe, build, source, tolerance)
                if build.check is not None:
                    check, faults = profile_check(source.data, recipe.options.for_decoder(), build.check)
                    _demand(not faults, "; ".join(faults))
                kind = "valid"
            else:
                decoded = source.decode(recipe)
                _demand(decoded.error is None, f"refused under the reading followed: {decoded.error}")
                _findings(build.findings, decoded)
                kind = "ambiguous"
            expect = _accepted(files, f"{base}.ndjson", decoded)
        if isinstance(build, Ambiguous):
            readings = {build.amb: _readings(recipe, build, source, base, files, expect)}
            tolerance = _largest(recipe, build, source)
        if not source.is_document:
            _check_traced(recipe, source.data)
    except SnhcError as error:
        raise RecipeFault(f"{recipe.id}: {error}") from error
    except RecipeFault as error:
        raise RecipeFault(f"{recipe.id}: {error}") from error
    name = f"{base}.{source.ending or source.media}"
    files[name] = source.data
    aux = ("", "")
    if source.aux is not None:
        aux = f"{base}.frames.ndjson", _sha(source.aux)
        files[aux[0]] = source.aux
    own = build.rule if isinstance(build, Reject) else ""
    named = dict.fromkeys([*recipe.rules, own] if own else recipe.rules)
    entry = Entry(
        recipe.id, recipe.title, recipe.description, kind, recipe.tier, recipe.tools, recipe.profile, tuple(named),
        recipe.features, recipe.value_classes, name, _sha(source.data), source.media, recipe.options, expect, readings,
        {"recipe": recipe.name, "generator": GENERATOR, "seed": recipe.seed}, recipe.notes, recipe.since,
        tolerance, *aux, check,
    )  # fmt: skip
    return Made(entry, files)


def _demand(ok: object, message: str) -> None:
    if not ok:
        raise RecipeFault(message)


def _sha(data: bytes) -> str:
    return sha256(data).hexdigest()


def _input(recipe: Recipe, stream: Stream) -> _Input:
    if isinstance(stream, Document):
        return _Input(stream.media, stream.data, stream.aux, _ENDINGS.get(stream.media, _COEFFICIENTS))
    data = stream if isinstance(stream, bytes) else write_stream(stream, _writer(recipe))
    return _Input("m2d" if "mesh" in recipe.tools else "fba", data)


def _writer(recipe: Recipe) -> Writer:
    writer = Writer()
    writer.draft = recipe.options.draft
    return writer


def _accepted(files: dict[str, bytes], name: str, decoded: Decoded) -> Accepted:
    text = decoded.text.encode()
    files[name] = text
    return Accepted(decoded.kind, name, _sha(text))


def _tolerance(recipe: Recipe, source: _Input, readings: Readings = DEFAULT_READINGS) -> Tolerance | None:
    if source.is_document:
        from .documents import tolerance_of

        return tolerance_of(source.media, source.data, source.aux or b"", readings)
    if "dct-p1" not in recipe.tools:
        return None
    return of_planes(_good_planes(source.data, recipe.options.for_decoder(readings)), readings)


def _largest(recipe: Recipe, build: Ambiguous, source: _Input) -> Tolerance | None:
    found = [
        _tolerance(recipe, source, Readings({build.amb: key}))
        for key in ambiguity(build.amb).readings
        if key not in build.faults
    ]
    return max((one for one in found if one is not None), key=lambda one: one.bound, default=None)


def _good_planes(data: bytes, options: Options) -> list[FbaPlane]:
    """The planes before the first fault."""
    out: list[FbaPlane] = []
    try:
        for plane in decode_planes(data, options):
            if isinstance(plane, FbaPlane):
                out.append(plane)
    except SnhcError:
        # The lines before the fault are compared, and only they.
        return out
    return out


def _accept(recipe: Recipe, build: Accept, source: _Input, tolerance: Tolerance | None) -> Decoded:
    decoded = source.decode(recipe)
    _demand(decoded.error is None, f"the decoder refuses it: {decoded.error}")
    lines = decoded.lines[1:]
    if build.lines is not None:
        _demand(len(lines) == build.lines, f"{len(lines)} lines, declared {build.lines}")
    for line, part in build.text.items():
        _demand(part in lines[line], f"line {line}: {lines[line]!r} without {part!r}")
    _findings(build.findings, decoded)
    if source.is_document:
        _spelled_out(lines, build.values, build.points, build.states, build.units)
        return _declared(build, decoded, tolerance)
    frames = [frame for frame in decoded.frames if isinstance(frame, FaceFrame)]
    for (line, fap), value in build.values.items():
        got = frames[line].faps[fap - 1]
        _demand(got == value, f"line {line}, FAP {fap}: decoder {got}, declared {value}")
    for (line, fap), state in build.states.items():
        letter = frames[line].state[fap - 1]
        _demand(letter == state, f"line {line}, state of FAP {fap}: decoder {letter}, declared {state}")
    for line, time in build.times.items():
        numerator, denominator = decoded.frames[line].time
        _demand(f"{numerator}/{denominator}" == time, f"line {line}: {numerator}/{denominator}, declared {time}")
    _written_back(recipe, build, source.data)
    return decoded


def _findings(declared: tuple[str, ...] | None, decoded: Decoded) -> None:
    if declared is not None:
        # Nearly all vectors are bare objects, which is no news.
        ids = tuple(finding.id for finding in decoded.findings if finding.id != "no-sequence-header")
        _demand(ids == declared, f"findings {ids}, declared {declared}")


def _written_back(recipe: Recipe, build: Accept, data: bytes) -> None:
    if build.same_as is not None:
        _demand(data == build.same_as, f"wrote {data.hex()}, declared {build.same_as.hex()}")
    again = write_stream(read_stream(data, recipe.options.for_decoder()), _writer(recipe))
    _demand(again == data, f"read and written back: {again.hex()}, was {data.hex()}")


def _spelled_out(
    lines: Sequence[str],
    values: Mapping[tuple[int, int], float | None],
    points: Mapping[tuple[int, str], Sequence[Sequence[float]]],
    states: Mapping[tuple[int, int], str] | None = None,
    units: Mapping[str, float] | None = None,
) -> None:
    """Hold the lines of a document against what the recipe declares."""
    found: list[Any] = [json.loads(line) for line in lines]
    for (line, fap), value in values.items():
        got = found[line]["faps"][fap - 1]
        _demand(got == value, f"line {line}, FAP {fap}: decoder {got}, declared {value}")
    for (line, fap), state in (states or {}).items():
        letter = found[line]["state"][fap - 1]
        _demand(letter == state, f"line {line}, state of FAP {fap}: decoder {letter}, declared {state}")
    for (line, mesh), vertices in points.items():
        given = found[line]["meshes"][mesh]
        wanted = [list(vertex) for vertex in vertices]
        _demand(given == wanted, f"line {line}, mesh {mesh}: decoder {given}, declared {wanted}")
    for name, unit in (units or {}).items():
        size = found[0]["units"][name]
        _demand(size == unit, f"unit {name}: decoder {size!r}, declared {unit!r}")


def _declared(build: Accept, decoded: Decoded, tolerance: Tolerance | None) -> Decoded:
    """The lines that stand in the file: the decoder's, or those that the recipe declares and the decoder comes near."""
    if not build.declared:
        return decoded
    assert tolerance is not None
    lines = tuple(line + "\n" for line in build.declared)
    _demand(len(lines) == len(decoded.lines) - 1, f"{len(decoded.lines) - 1} lines, declared {len(lines)}")
    for i, (ours, theirs) in enumerate(zip(lines, decoded.lines[1:], strict=True)):
        _demand(
            _near(json.loads(ours), json.loads(theirs), tolerance.bound), f"line {i}: {theirs!r}, declared {ours!r}"
        )
    return Decoded((decoded.lines[0], *lines), decoded.frames, decoded.findings, None, decoded.kind)


def _near(a: Any, b: Any, bound: float) -> bool:
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(_near(a[key], b[key], bound) for key in a)
    if isinstance(a, list):
        return isinstance(b, list) and len(a) == len(b) and all(_near(x, y, bound) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) <= bound
    return bool(a == b)


def _reject(recipe: Recipe, build: Reject) -> tuple[_Input, Rejected]:
    stream = build.stream
    if isinstance(stream, Document):
        source = _input(recipe, stream)
        decoded = source.decode(recipe)
        _held(decoded, build.error, build.rule, build.path)
        assert decoded.error is not None
        line = decoded.error.line
        _demand(line == build.line, f"line of the fault: decoder {line}, declared {build.line}")
        if build.lines is not None:
            _demand(len(decoded.lines) - 1 == build.lines, f"{len(decoded.lines) - 1} lines, declared {build.lines}")
        return source, Rejected(build.error.__name__, build.rule, None, build.allowed, build.path, build.line)
    if build.mutations:
        _demand(not isinstance(stream, bytes), "mutations need records")
        assert not isinstance(stream, bytes)
        data = write_faulty(stream, list(build.mutations))
        for mutation in build.mutations:
            _demand(mutation.spans, f"{mutation.element} under {mutation.path!r} was never written")
    else:
        data = stream if isinstance(stream, bytes) else write_faulty(stream, [])
    bits = build.bits if build.bits is not None else build.mutations[0].spans[0]
    source = _input(recipe, data)
    _held(source.decode(recipe), build.error, build.rule, bits)
    return source, Rejected(build.error.__name__, build.rule, bits, build.allowed)


def _held(decoded: Decoded, error: type[SnhcError], rule: str, place: Place) -> None:
    fault = decoded.error
    if fault is None:
        raise RecipeFault(f"the decoder takes it, declared {error.__name__} ({rule}) at {place}")
    got = (fault.error_class, fault.rule, fault.path if isinstance(place, str) else fault.bits)
    _demand(got == (error.__name__, rule, place), f"decoder {fault}, declared {error.__name__} ({rule}) at {place}")


def _readings(
    recipe: Recipe, build: Ambiguous, source: _Input, base: str, files: dict[str, bytes], followed: Expect
) -> dict[str, Expect]:
    amb = ambiguity(build.amb)
    out: dict[str, Expect] = {}
    seen: dict[str, str] = {}
    for key in amb.readings:
        decoded = source.decode(recipe, Readings({build.amb: key}))
        if key in build.faults:
            error, rule, place = build.faults[key]
            _held(decoded, error, rule, place)
            if isinstance(place, str):
                out[key] = Rejected(error.__name__, rule, path=place)
            else:
                out[key] = Rejected(error.__name__, rule, place)
            print_of = f"{error.__name__} {rule} {place}"
        else:
            _demand(decoded.error is None, f"reading {key}: the decoder refuses it: {decoded.error}")
            print_of = "".join(decoded.lines[1:])
            _spelled_out(decoded.lines[1:], build.values.get(key, {}), build.points.get(key, {}))
            if key == amb.followed:
                out[key] = followed
            else:
                out[key] = _accepted(files, f"{base}.{build.amb}.{key}.ndjson", decoded)
        _demand(print_of not in seen, f"readings {key} and {seen.get(print_of)} give the same")
        seen[print_of] = key
    return out


def _check_traced(recipe: Recipe, data: bytes) -> None:
    """Reader and tracer must agree on the fault, and the spans of the trace must partition what was read."""
    options = recipe.options.for_decoder()
    at = 0
    for part in trace_stream(data, options):
        for start, end in zip(part.trace.start, part.trace.end, strict=True):
            _demand(start == at, f"the trace leaves a gap at bit {at}")
            at = end
        if part.error is not None:
            return
    _demand(at == 8 * len(data), f"the trace ends at bit {at}")
