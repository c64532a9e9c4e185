"""Making the suite from its recipes, and checking that it is what the recipes make.

Rules: CNF-3, CNF-4, CNF-6, CNF-24. Nothing here reads a clock, the environment, or the order of a hash.

What a decoder must give is what the reference decoder gives now, held against what the recipe itself declares: class,
rule and bits of a fault, and whatever an `Accept` spells out. Beyond that every valid stream must be written back to
the same bytes, and read alike by reader and tracer.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.rules import ambiguity, rules
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.syntax.writer import Writer
from snhc.reference_impl.systems.stream import read_stream, trace_stream, write_faulty, write_stream

from .decoding import Decoded, decode
from .manifest import MANIFEST_NAME, SUITE, Accepted, Entry, Expect, Manifest, Rejected, Tombstone, validate
from .recipe import Accept, Ambiguous, Recipe, Reject, Stream, all_recipes, build_fault

SUITE_VERSION: Final = "0.1.0"
GENERATOR: Final = 1
TOMBSTONES: Final = Path(__file__).parent / "tombstones.toml"


class RecipeFault(Exception):
    """A recipe and the reference decoder disagree, or a recipe is out of form. Rules: CNF-4."""


@dataclass(frozen=True, slots=True)
class Made:
    """A vector: its entry, and its files by name. Rules: CNF-3."""

    entry: Entry
    files: dict[str, bytes]


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A file of a suite that is not what the recipes make. Rules: CNF-4. `what`: `differs`, `missing`, `left over`."""

    file: str
    what: str


def make(recipe: Recipe) -> Made:
    """Make one vector. Rules: CNF-3, CNF-6. Raises RecipeFault where recipe and decoder disagree."""
    build = recipe.build()
    try:
        _demand(not (fault := build_fault(build)), fault)
        folder = recipe.id.partition(".")[0]
        base = f"{folder}/{recipe.id}"
        files: dict[str, bytes] = {}
        expect: Expect
        if isinstance(build, Reject):
            data, expect = _reject(recipe, build)
            kind = "invalid"
        else:
            data = _bytes(recipe, build.stream)
            if isinstance(build, Accept):
                decoded = _accept(recipe, build, data)
                kind = "valid"
            else:
                decoded = decode(data, recipe.options.for_decoder())
                _demand(decoded.error is None, f"refused under the reading followed: {decoded.error}")
                kind = "ambiguous"
            expect = _accepted(files, f"{base}.ndjson", decoded)
        readings: dict[str, dict[str, Expect]] = {}
        if isinstance(build, Ambiguous):
            readings = {build.amb: _readings(recipe, build, data, base, files, expect)}
        _check_traced(recipe, data)
    except SnhcError as error:
        raise RecipeFault(f"{recipe.id}: {error}") from error
    except RecipeFault as error:
        raise RecipeFault(f"{recipe.id}: {error}") from error
    media = _media(recipe)
    files[f"{base}.{media}"] = data
    own = build.rule if isinstance(build, Reject) else ""
    named = dict.fromkeys([*recipe.rules, own] if own else recipe.rules)
    entry = Entry(
        recipe.id, recipe.title, recipe.description, kind, recipe.tier, recipe.tools, recipe.profile, tuple(named),
        recipe.features, recipe.value_classes, f"{base}.{media}", _sha(data), media, recipe.options, expect, readings,
        {"recipe": recipe.name, "generator": GENERATOR, "seed": recipe.seed}, recipe.notes, recipe.since,
    )  # fmt: skip
    return Made(entry, files)


def _demand(ok: object, message: str) -> None:
    if not ok:
        raise RecipeFault(message)


def _sha(data: bytes) -> str:
    return sha256(data).hexdigest()


def _bytes(recipe: Recipe, stream: Stream) -> bytes:
    return stream if isinstance(stream, bytes) else write_stream(stream, _writer(recipe))


def _writer(recipe: Recipe) -> Writer:
    writer = Writer()
    writer.draft = recipe.options.draft
    return writer


def _accepted(files: dict[str, bytes], name: str, decoded: Decoded) -> Accepted:
    text = decoded.text.encode()
    files[name] = text
    return Accepted(decoded.kind, name, _sha(text))


def _media(recipe: Recipe) -> str:
    return "m2d" if "mesh" in recipe.tools else "fba"


def _accept(recipe: Recipe, build: Accept, data: bytes) -> Decoded:
    options = recipe.options.for_decoder()
    decoded = decode(data, options)
    _demand(decoded.error is None, f"the decoder refuses it: {decoded.error}")
    if build.same_as is not None:
        _demand(data == build.same_as, f"wrote {data.hex()}, declared {build.same_as.hex()}")
    frames = [frame for frame in decoded.frames if isinstance(frame, FaceFrame)]
    if build.lines is not None:
        _demand(len(decoded.frames) == build.lines, f"{len(decoded.frames)} lines, declared {build.lines}")
    for (line, fap), value in build.values.items():
        got = frames[line].faps[fap - 1]
        _demand(got == value, f"line {line}, FAP {fap}: decoder {got}, declared {value}")
    for (line, fap), state in build.states.items():
        letter = frames[line].state[fap - 1]
        _demand(letter == state, f"line {line}, state of FAP {fap}: decoder {letter}, declared {state}")
    for line, time in build.times.items():
        numerator, denominator = decoded.frames[line].time
        _demand(f"{numerator}/{denominator}" == time, f"line {line}: {numerator}/{denominator}, declared {time}")
    for line, part in build.text.items():
        _demand(part in decoded.lines[line + 1], f"line {line}: {decoded.lines[line + 1]!r} without {part!r}")
    if build.findings is not None:
        # Nearly all vectors are bare objects, which is no news.
        ids = tuple(finding.id for finding in decoded.findings if finding.id != "no-sequence-header")
        _demand(ids == build.findings, f"findings {ids}, declared {build.findings}")
    again = write_stream(read_stream(data, options), _writer(recipe))
    _demand(again == data, f"read and written back: {again.hex()}, was {data.hex()}")
    return decoded


def _reject(recipe: Recipe, build: Reject) -> tuple[bytes, Rejected]:
    if build.mutations:
        _demand(not isinstance(build.stream, bytes), "mutations need records")
        assert not isinstance(build.stream, bytes)
        data = write_faulty(build.stream, list(build.mutations))
        for mutation in build.mutations:
            _demand(mutation.spans, f"{mutation.element} under {mutation.path!r} was never written")
    else:
        data = build.stream if isinstance(build.stream, bytes) else write_faulty(build.stream, [])
    bits = build.bits if build.bits is not None else build.mutations[0].spans[0]
    options = recipe.options.for_decoder()
    _held(decode(data, options), build.error, build.rule, bits)
    return data, Rejected(build.error.__name__, build.rule, bits, build.allowed)


def _held(decoded: Decoded, error: type[SnhcError], rule: str, bits: tuple[int, int]) -> None:
    fault = decoded.error
    if fault is None:
        raise RecipeFault(f"the decoder takes it, declared {error.__name__} ({rule}) at {bits}")
    got = (fault.error_class, fault.rule, fault.bits)
    _demand(got == (error.__name__, rule, bits), f"decoder {fault}, declared {error.__name__} ({rule}) at {bits}")


def _readings(
    recipe: Recipe, build: Ambiguous, data: bytes, base: str, files: dict[str, bytes], followed: Expect
) -> dict[str, Expect]:
    amb = ambiguity(build.amb)
    out: dict[str, Expect] = {}
    seen: dict[str, str] = {}
    for key in amb.readings:
        decoded = decode(data, recipe.options.for_decoder(Readings({build.amb: key})))
        if key in build.faults:
            error, rule, bits = build.faults[key]
            _held(decoded, error, rule, bits)
            out[key] = Rejected(error.__name__, rule, bits)
            print_of = f"{error.__name__} {rule} {bits}"
        else:
            _demand(decoded.error is None, f"reading {key}: the decoder refuses it: {decoded.error}")
            print_of = "".join(decoded.lines[1:])
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


def tombstones(path: Path = TOMBSTONES) -> tuple[Tombstone, ...]:
    """The ids that are used up. Rules: CNF-3."""
    import tomllib

    entries = tomllib.loads(path.read_text(encoding="utf-8"))
    return tuple(Tombstone(id, entry["removed"], entry["reason"]) for id, entry in sorted(entries.items()))


def build_suite(
    recipes: Iterable[Recipe] | None = None, progress: Callable[[str], None] | None = None
) -> dict[str, bytes]:
    """All files of the suite by name, the manifest included. Rules: CNF-3, CNF-4.

    Raises RecipeFault for a recipe that the decoder contradicts, that names an unknown rule, or a dead id.
    """
    known = rules()
    dead = tombstones()
    files: dict[str, bytes] = {}
    entries: list[Entry] = []
    for recipe in all_recipes().values() if recipes is None else recipes:
        if progress is not None:
            progress(recipe.id)
        _demand(recipe.id not in {tombstone.id for tombstone in dead}, f"{recipe.id}: this id was used before")
        made = make(recipe)
        unknown = [rule for rule in made.entry.rules if rule not in known]
        _demand(not unknown, f"{recipe.id}: no such rule: {', '.join(unknown)}")
        entries.append(made.entry)
        files.update(made.files)
    manifest = Manifest(SUITE_VERSION, tuple(sorted(entries, key=lambda entry: entry.id)), dead)
    validate(manifest.as_json())
    files[MANIFEST_NAME] = manifest.text().encode()
    return dict(sorted(files.items()))


def generate(target: Path = SUITE) -> dict[str, bytes]:
    """Write the suite to a folder, which then holds nothing else. Rules: CNF-4.

    Refuses (RecipeFault) a folder that is neither empty nor a suite.
    """
    files = build_suite()
    if target.exists() and any(target.iterdir()) and not (target / MANIFEST_NAME).is_file():
        raise RecipeFault(f"{target} is neither empty nor a suite")
    for mismatch in compare(files, target):
        if mismatch.what == "left over":
            path = target / mismatch.file
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()
            continue
        path = target / mismatch.file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(files[mismatch.file])
    return files


def check(folder: Path = SUITE) -> list[Mismatch]:
    """Where a folder is not byte for byte what the recipes make. Rules: CNF-4."""
    return compare(build_suite(), folder)


def compare(files: dict[str, bytes], folder: Path) -> list[Mismatch]:
    """The files of a folder against what they should be, sorted by name. Rules: CNF-4."""
    out: list[Mismatch] = []
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file() or path.is_symlink()}
    for name, content in files.items():
        if name not in there:
            out.append(Mismatch(name, "missing"))
        elif (folder / name).read_bytes() != content:
            out.append(Mismatch(name, "differs"))
    out += [Mismatch(name, "left over") for name in there - set(files)]
    return sorted(out, key=lambda mismatch: mismatch.file)
