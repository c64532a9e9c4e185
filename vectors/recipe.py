"""Recipes: functions that say how a vector is made, and whose docstrings are its documentation.

Rules: CNF-3, CNF-4, CNF-5, CNF-6.

    @vector(id="fap.arith.segment.empty", title="...", tier="syntax", rules=["FBA-26"])
    def empty_segment() -> Accept:
        \"\"\"What it shows, and what decoders get wrong.\"\"\"
        return Accept(stream(intra({})))

`@family` makes one vector per case; id, title and docstring may hold `{case}`. Ids are permanent.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from inspect import cleandoc
from typing import Final, TypeVar

from snhc.reference_impl.bitstream.errors import ERROR_CLASSES, SnhcError
from snhc.reference_impl.syntax.faulty import Mutation
from snhc.reference_impl.systems.visual import StreamItem

from .checking import ProfileCheck
from .manifest import ACCEPTABLE, DOCUMENTS, REJECT, TIERS, DecodeOptions


@dataclass(frozen=True, slots=True)
class Document:
    """An input that is no bitstream. Rules: CNF-3. `media`: of the manifest; `aux`: frames that a table is used on."""

    media: str
    data: bytes
    aux: bytes | None = None


Stream = list[StreamItem] | bytes | Document
Place = tuple[int, int] | str
"""Where a fault is: bits, or the path in a document. Rules: CNF-21, CNF-25."""


@dataclass(frozen=True, slots=True)
class Accept:
    """A stream or document that decodes. Rules: CNF-3.

    `stream`: records for our own writer, bytes, or a document. What else is given must come out, or generating fails:
    `same_as`: the bytes; `lines`: how many; `values`: by (line, FAP); `times`: by line; `text`: whole lines by line;
    `findings`: ids, in order of the stream, all that are reported but `no-sequence-header`; `points`: of vertices, by
    (line, mesh), exactly; `units`: of a face, by name.

    `declared`: lines behind the header that stand in the file instead of the decoder's, whose floats hang on the sine
    and cosine of the machine (CNF-4); the decoder must come within the vector's tolerance of them.

    `check`: what a checker of profiles and levels must say of the stream.
    """

    stream: Stream
    same_as: bytes | None = None
    lines: int | None = None
    values: Mapping[tuple[int, int], float | None] = field(default_factory=dict)
    times: Mapping[int, str] = field(default_factory=dict)
    states: Mapping[tuple[int, int], str] = field(default_factory=dict)
    text: Mapping[int, str] = field(default_factory=dict)
    findings: tuple[str, ...] | None = None
    points: Mapping[tuple[int, str], Sequence[Sequence[float]]] = field(default_factory=dict)
    units: Mapping[str, float] = field(default_factory=dict)
    declared: tuple[str, ...] = ()
    check: ProfileCheck | None = None


@dataclass(frozen=True, slots=True)
class Reject:
    """A stream or document with one fault. Rules: CNF-6, CNF-7, CNF-21, CNF-25.

    `mutations`: what the faulty writer breaks. `bits`: where the fault is; None: the first span that the first
    mutation recorded. Of documents: `path`, `line` (None: the fault has none). `allowed`: `reject`, `conceal`. `lines`:
    how many are complete before the fault, where that is declared.
    """

    stream: Stream
    error: type[SnhcError]
    rule: str
    mutations: tuple[Mutation, ...] = ()
    bits: tuple[int, int] | None = None
    allowed: tuple[str, ...] = (REJECT,)
    path: str = ""
    line: int | None = None
    lines: int | None = None


@dataclass(frozen=True, slots=True)
class Ambiguous:
    """A stream that readings of the standard decode differently. Rules: CNF-3, CNF-24.

    `stream`: made under the first reading. `amb`: the ambiguity; every reading of the register gets an expectation,
    all of them different. `faults`: the readings under which the stream is refused, with class, rule and place.
    `values`, `points`: what documents give, by reading, then as in `Accept`. `findings`: under the reading followed, as
    in `Accept`.
    """

    stream: Stream
    amb: str
    faults: Mapping[str, tuple[type[SnhcError], str, Place]] = field(default_factory=dict)
    values: Mapping[str, Mapping[tuple[int, int], int | None]] = field(default_factory=dict)
    points: Mapping[str, Mapping[tuple[int, str], Sequence[Sequence[float]]]] = field(default_factory=dict)
    findings: tuple[str, ...] | None = None


Build = Accept | Reject | Ambiguous


@dataclass(frozen=True, slots=True)
class Recipe:
    """One vector to be made. Rules: CNF-3, CNF-4. `name`: module and function."""

    id: str
    title: str
    description: str
    tier: str
    rules: tuple[str, ...]
    features: tuple[str, ...]
    value_classes: tuple[str, ...]
    tools: tuple[str, ...]
    profile: str | None
    options: DecodeOptions
    notes: str
    since: str
    seed: int | None
    name: str
    build: Callable[[], Build]


RECIPES: Final[dict[str, Recipe]] = {}
_RECIPES: Final = f"{__package__}.recipes"
_ID: Final = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*(\.[a-z0-9]+(-[a-z0-9]+)*)+")
TOPICS: Final = (
    "examples", "framing", "header", "masks", "ranges", "coder", "values", "highlevel", "bodies", "systems", "errors",
    "truncation", "ambiguity", "mesh", "mesh_motion", "mesh_framing", "mesh_errors", "dct", "dct_errors",
    "dct_coefficients", "fit", "fit_errors", "fat", "fat_errors", "fapu", "real", "profiles", "mistakes",
    "mesh_mistakes", "table_mistakes",
    "levels", "fields", "cuts", "texts", "documents", "stream_errors",
)  # fmt: skip

T = TypeVar("T")


def _add(recipe: Recipe) -> None:
    for ok, what in (
        (recipe.id not in RECIPES, "an id that another recipe has"),
        (_ID.fullmatch(recipe.id), "an id that is not of dotted words"),
        (recipe.tier in TIERS, f"tier {recipe.tier}"),
        (recipe.description and recipe.rules, "no docstring or no rules"),
    ):
        if not ok:
            raise TypeError(f"recipe {recipe.id} ({recipe.name}): {what}")
    RECIPES[recipe.id] = recipe


def vector(
    *,
    id: str,
    title: str,
    tier: str,
    rules: Iterable[str],
    features: Iterable[str] = (),
    value_classes: Iterable[str] = (),
    tools: Iterable[str] = ("fba",),
    profile: str | None = None,
    options: DecodeOptions | None = None,
    notes: str = "",
    since: str = "0.1.0",
    seed: int | None = None,
) -> Callable[[Callable[[], Build]], Callable[[], Build]]:
    """Register a function as the recipe of one vector. Rules: CNF-3, CNF-4. Raises TypeError for a bad form."""

    def register(function: Callable[[], Build]) -> Callable[[], Build]:
        _add(
            Recipe(
                id, title, cleandoc(function.__doc__ or ""), tier, tuple(rules), tuple(features), tuple(value_classes),
                tuple(tools), profile, options or DecodeOptions(), notes, since, seed,
                f"{function.__module__.rpartition('.')[2]}.{function.__name__}", function,
            )
        )  # fmt: skip
        return function

    return register


def family(
    cases: Mapping[str, T],
    *,
    id: str,
    title: str,
    tier: str,
    rules: Iterable[str],
    features: Iterable[str] = (),
    value_classes: Iterable[str] = (),
    tools: Iterable[str] = ("fba",),
    profile: str | Mapping[str, str | None] | None = None,
    options: DecodeOptions | None = None,
    notes: str = "",
    since: str = "0.1.0",
    seed: int | None = None,
) -> Callable[[Callable[[T], Build]], Callable[[T], Build]]:
    """Register a function as the recipe of one vector per case. Rules: CNF-3, CNF-4.

    `cases`: name of the case -> what the function gets. `{case}` in id, title and docstring stands for the name (in
    the id with - for blanks, lower case). `profile`: one for all, or one for each.
    """

    def register(function: Callable[[T], Build]) -> Callable[[T], Build]:
        for case, argument in cases.items():
            key = re.sub(r"[^a-z0-9]+", "-", case.lower()).strip("-")

            def build(argument: T = argument) -> Build:
                return function(argument)

            build.__name__ = function.__name__
            build.__module__ = function.__module__
            build.__doc__ = (function.__doc__ or "").replace("{case}", case)
            vector(
                id=id.replace("{case}", key), title=title.replace("{case}", case), tier=tier, rules=rules,
                features=features, value_classes=value_classes, tools=tools,
                profile=profile[case] if isinstance(profile, Mapping) else profile, options=options,
                notes=notes, since=since, seed=seed,
            )(build)  # fmt: skip
        return function

    return register


def all_recipes() -> dict[str, Recipe]:
    """Every recipe of this suite by id, sorted. Rules: CNF-4."""
    for topic in TOPICS:
        import_module(f"{_RECIPES}.{topic}")
    return {id: recipe for id, recipe in sorted(RECIPES.items()) if recipe.build.__module__.startswith(f"{_RECIPES}.")}


def recipes_of(module: str) -> list[Recipe]:
    """The recipes that a module of somebody else registered (`__name__`), by id. Rules: CNF-4."""
    return [recipe for _, recipe in sorted(RECIPES.items()) if recipe.build.__module__ == module]


def build_fault(build: Build) -> str:
    """What is wrong with the form of a build, or "". Rules: CNF-3, CNF-7."""
    if isinstance(build.stream, Document) and build.stream.media not in DOCUMENTS:
        return f"media {build.stream.media} is no document"
    if isinstance(build, Reject):
        if build.error.__name__ not in ERROR_CLASSES or build.error.__name__ == "Unsupported":
            return f"error class {build.error.__name__} is no fault of a stream"
        if not build.allowed or any(way not in ACCEPTABLE for way in build.allowed):
            return f"allowed {build.allowed}"
        if isinstance(build.stream, Document):
            return "" if build.path or build.line is not None else "neither path nor line"
        if build.bits is None and not build.mutations:
            return "no bits and no mutation that could tell them"
    return ""
