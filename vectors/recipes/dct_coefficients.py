"""Coefficient documents: the part of the DCT mode that needs no entropy table, and is therefore portable.

Rules: DCT-3, DCT-5, DCT-6, DCT-7, DCT-8, DCT-13, CNF-1, CNF-3, CNF-25.

A vector is a JSON document (input of `snhc dct`) with the lines it gives and their tolerance, or the class, rule and
path of its fault. Faults of documents have paths instead of bit spans, so these are recipes of their own kind.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import cleandoc
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, SnhcError
from snhc.reference_impl.face.coefficients import decode_document, parse_document
from snhc.reference_impl.face.decoded import header_line
from snhc.reference_impl.face.reconstruct import dct_reading
from snhc.reference_impl.rules import ambiguity
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings

from ..dct_tolerance import Tolerance, of_document
from ..seeded import Seeded

MEDIA: Final = "dctcoef"
TOOLS: Final = ("dct-coefficients",)

Coefficients = Mapping[int, Sequence[int]]


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong with a document, and where. Rules: CNF-7, CNF-25. `lines`: good frames before it."""

    error: type[SnhcError]
    rule: str
    path: str
    lines: int = 0


@dataclass(frozen=True, slots=True)
class Document:
    """A document and what is declared of it: values by (line, FAP), or its fault. Rules: CNF-3."""

    data: bytes
    values: Mapping[tuple[int, int], int] = field(default_factory=dict)
    fault: Fault | None = None


@dataclass(frozen=True, slots=True)
class CoefficientRecipe:
    """One coefficient vector to be made. Rules: CNF-3, CNF-4. `amb`: the ambiguity that it tells apart, or ""."""

    id: str
    title: str
    description: str
    tier: str
    rules: tuple[str, ...]
    amb: str
    build: Callable[[], Document]


@dataclass(frozen=True, slots=True)
class CoefficientVector:
    """A vector as made. Rules: CNF-1, CNF-3, DCT-8.

    `data`: the document; `text`: the lines, header first, up to the fault; `readings`: reading -> lines, where the
    recipe names an ambiguity; `tolerance`: None for documents with a fault.
    """

    recipe: CoefficientRecipe
    data: bytes
    text: str
    tolerance: Tolerance | None
    fault: Fault | None
    readings: Mapping[str, str]


RECIPES: Final[dict[str, CoefficientRecipe]] = {}


def vector(
    *, id: str, title: str, tier: str, rules: Sequence[str], amb: str = ""
) -> Callable[[Callable[[], Document]], Callable[[], Document]]:
    """Register a function as the recipe of one coefficient vector. Rules: CNF-3, CNF-4."""

    def register(function: Callable[[], Document]) -> Callable[[], Document]:
        if id in RECIPES:
            raise TypeError(f"recipe {id}: an id that another recipe has")
        RECIPES[id] = CoefficientRecipe(id, title, cleandoc(function.__doc__ or ""), tier, tuple(rules), amb, function)
        return function

    return register


def make(recipe: CoefficientRecipe) -> CoefficientVector:
    """Make one vector, and hold the decoder against what the recipe declares. Rules: CNF-3, DCT-8.

    Raises AssertionError where they disagree.
    """
    document = recipe.build()
    text, lines, error = _decode(document.data, DEFAULT_READINGS)
    wanted = document.fault
    got = None if error is None else Fault(type(error), error.rule, error.path, len(lines))
    if got != wanted:
        raise AssertionError(f"{recipe.id}: decoder {error}, declared {wanted}")
    for (line, fap), value in document.values.items():
        if lines[line]["faps"][fap - 1] != value:
            raise AssertionError(
                f"{recipe.id}: line {line}, FAP {fap}: {lines[line]['faps'][fap - 1]}, declared {value}"
            )
    readings = {}
    if recipe.amb:
        readings = {
            key: _decode(document.data, Readings({recipe.amb: key}))[0] for key in ambiguity(recipe.amb).readings
        }
        if len({other.partition("\n")[2] for other in readings.values()}) != len(readings):
            raise AssertionError(f"{recipe.id}: two readings give the same")
    tolerance = None if error is not None else of_document(parse_document(document.data))
    return CoefficientVector(recipe, document.data, text, tolerance, wanted, readings)


def _decode(data: bytes, readings: Readings) -> tuple[str, list[Any], SnhcError | None]:
    lines: list[Any] = []
    texts: list[str] = []
    error: SnhcError | None = None
    try:
        document = parse_document(data)
        texts.append(header_line("fba", readings if readings.chosen else None))
        for frame in decode_document(document, dct_reading(readings.dc_step_ratio, readings.normalisation)):
            lines.append(frame.as_json())
            texts.append(json.dumps(lines[-1], separators=(",", ":")))
    except SnhcError as fault:
        error = fault
    return "".join(text + "\n" for text in texts), lines, error


def _padded(values: Sequence[int]) -> list[int]:
    return [*values, *[0] * (16 - len(values))]


def document(quant: int, *segments: tuple[bool, Coefficients], **declared: Any) -> Document:
    """A document of segments (intra, coefficients by FAP; missing ones are 0). Rules: DCT-3, DCT-5."""
    body = [
        {"intra": intra, "coefficients": {str(fap): _padded(values) for fap, values in faps.items()}}
        for intra, faps in segments
    ]
    return Document(_bytes({"fap_quant": quant, "segments": body}), **declared)


def _bytes(value: object) -> bytes:
    return (json.dumps(value, separators=(",", ":")) + "\n").encode()


def _halfway(fap_values: Mapping[int, int]) -> Coefficients:
    return {fap: [dc] for fap, dc in fap_values.items()}


@vector(id="dct.coefficients.example.1", title="Coefficients of the worked stream", tier="semantic",
        rules=["DCT-3", "DCT-5", "DCT-6", "DCT-7"])  # fmt: skip
def example() -> Document:
    """FAP 3 and FAP 49 at fap_quant 8, intra and inter: what the worked DCT stream carries."""
    return document(
        8, (True, {3: [6, -5, 0, 2], 49: [-3, *[0] * 14, 1]}), (False, {3: [-2, 1], 49: [0]}),
        values={(0, 3): -52, (11, 3): 202, (7, 49): -1842, (16, 3): 62, (31, 3): -2, (31, 49): -765},
    )  # fmt: skip


@vector(id="dct.coefficients.halves", title="Halves are rounded away from zero", tier="semantic", rules=["DCT-7"])
def halves() -> Document:
    """DC values of 2.5, -2.5, 7.5, -7.5, and 8 AC steps of 1/4 at index 8, exactly."""
    return document(
        0, (True, {**_halfway({3: 4, 4: -4, 5: 12, 6: -12}), 18: [1]}),
        values={(0, 3): 3, (0, 4): -3, (0, 5): 8, (15, 6): -8, (0, 18): 0},
    )  # fmt: skip


def _single(k: int) -> None:
    @vector(id=f"dct.coefficients.index-{k}", title=f"The coefficient at index {k} alone", tier="syntax",
            rules=["DCT-5", "DCT-6", "DCT-7"])  # fmt: skip
    def single() -> Document:
        return document(5, (True, {3: [*[0] * k, 40], 48: [*[0] * k, -3]}))

    recipe = RECIPES[f"dct.coefficients.index-{k}"]
    text = f"One coefficient at index {k}: a sampled cosine, positive in FAP 3, negative in FAP 48."
    RECIPES[recipe.id] = CoefficientRecipe(
        recipe.id, recipe.title, text, recipe.tier, recipe.rules, recipe.amb, recipe.build
    )


for _k in range(16):
    _single(_k)


@vector(id="dct.coefficients.quantisers", title="All base steps at fap_quant 31", tier="semantic", rules=["DCT-5"])
def quantisers() -> Document:
    """DC 12 of every FAP is its base step times the scale 1039."""
    values = {(0, 3): 7793, (0, 18): 5195, (0, 23): 441575, (0, 48): 176630, (0, 68): 10390}
    return document(31, (True, {fap: [12] for fap in range(3, 69)}), values=values)


@vector(id="dct.coefficients.prediction", title="Inter DC adds up in the quantised domain", tier="semantic",
        rules=["DCT-3", "DCT-8", "DCT-13"])  # fmt: skip
def prediction() -> Document:
    """DC steps of 0.625: the values are DC * 0.625, rounded, in nine segments; the last one is intra again."""
    segments = [(True, {3: [1]}), *[(False, {3: [1]})] * 7, (True, {3: [-1]})]
    values = {(16 * i, 3): value for i, value in enumerate((1, 1, 2, 3, 3, 4, 4, 5, -1))}
    return document(0, *segments, values=values)


@vector(id="dct.coefficients.retained", title="FAPs that a later segment leaves out", tier="semantic", rules=["DCT-13"])
def retained() -> Document:
    """FAP 4 is in the first and third segment only: R with its last value in between, and its predictor stays."""
    segments = [(True, {3: [4], 4: [8, 3]}), (False, {3: [1]}), (False, {4: [1]})]
    return document(8, *segments, values={(16, 3): 38, (32, 3): 38})


@vector(id="dct.coefficients.largest", title="The largest integers", tier="stress", rules=["DCT-3", "DCT-6", "DCT-8"])
def largest() -> Document:
    """What 32 bits hold, in DC and AC: the bound that is computed from the values grows with them."""
    top, bottom = 2**31 - 1, -(2**31)
    segments = [(True, {3: [top], 4: [bottom], 5: [0, top, *[0] * 13, bottom]}), (False, {3: [top], 4: [bottom]})]
    return document(31, *segments)


@vector(
    id="dct.coefficients.dense", title="Dense segments of all FAPs", tier="stress", rules=["DCT-5", "DCT-7", "DCT-8"]
)
def dense() -> Document:
    """Sixteen coefficients of each FAP, from a seed, in three segments."""
    seeded = Seeded(16)
    segments = [
        (i != 1, {fap: [seeded.between(-40 // (k + 1), 40 // (k + 1)) for k in range(16)] for fap in range(3, 69)})
        for i in range(3)
    ]
    return document(3, *segments)


@vector(id="dct.coefficients.ambiguous.dc-step", title="Ratio of the AC step to the DC step", tier="semantic",
        rules=["DCT-5"], amb="AMB-DCT-1")  # fmt: skip
def dc_step() -> Document:
    """DC 24 at fap_quant 8 is 180, or 135 with the ratio 4."""
    return document(8, (True, {3: [24], 4: [0, 3]}), values={(0, 3): 180})


@vector(id="dct.coefficients.ambiguous.normalisation", title="Scaling of the transform", tier="semantic",
        rules=["DCT-7"], amb="AMB-DCT-2")  # fmt: skip
def normalisation() -> Document:
    """DC 32 at fap_quant 8 is 240 with orthonormal factors, 60 with the inverse of an unscaled transform."""
    return document(8, (True, {3: [32], 4: [8, -3, 0, 5]}), values={(0, 3): 240})


def _broken(id: str, title: str, text: str, data: object, fault: Fault) -> None:
    recipe = f"dct.coefficients.error.{id}"
    content = data if isinstance(data, bytes) else _bytes(data)
    RECIPES[recipe] = CoefficientRecipe(
        recipe, title, text, "error", (fault.rule,), "", lambda: Document(content, fault=fault)
    )


_GOOD: Final = {"intra": True, "coefficients": {"3": [1] * 16}}
for _id, _title, _text, _data, _fault in (
    ("inter-first", "An inter segment first", "Nothing to predict from.",
     {"fap_quant": 1, "segments": [{**_GOOD, "intra": False}]},
     Fault(InconsistentSemantics, "DCT-13", "segments[0].intra")),
    ("fap-never-sent", "An inter segment with a FAP never sent", "The 16 lines of the first segment are good.",
     {"fap_quant": 1, "segments": [_GOOD, {"intra": False, "coefficients": {"4": [0] * 16}}]},
     Fault(InconsistentSemantics, "DCT-13", "segments[1].coefficients.4", 16)),
    ("fifteen", "Fifteen integers", "A segment has sixteen.",
     {"fap_quant": 1, "segments": [{"intra": True, "coefficients": {"3": [1] * 15}}]},
     Fault(InputFormat, "DCT-1", "segments[0].coefficients.3")),
    ("fap-2", "FAP 2", "Visemes and expressions have no coefficients.",
     {"fap_quant": 1, "segments": [{"intra": True, "coefficients": {"2": [1] * 16}}]},
     Fault(InputFormat, "DCT-1", "segments[0].coefficients")),
    ("fap-quant", "fap_quant 32", "The field has five bits.", {"fap_quant": 32, "segments": [_GOOD]},
     Fault(RangeViolation, "DCT-5", "fap_quant")),
    ("not-json", "Not JSON", "The document ends in the middle.", b'{"fap_quant":1,"segments":[',
     Fault(InputFormat, "DCT-1", "")),
):  # fmt: skip
    _broken(_id, _title, _text, _data, _fault)
