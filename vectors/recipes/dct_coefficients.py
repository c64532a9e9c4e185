"""Coefficient documents: the part of the DCT mode that needs no entropy table, and is therefore portable.

Rules: DCT-3, DCT-5, DCT-6, DCT-7, DCT-8, DCT-13, CNF-1, CNF-3, CNF-25.

The input is a JSON document (of `snhc dct`); faults have paths instead of bit spans.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, SnhcError

from ..manifest import DCT_COEFFICIENTS
from ..recipe import Accept, Ambiguous, Document, Reject, family, vector
from ..seeded import Seeded

TOOLS: Final = ("dctcoef",)

Coefficients = Mapping[int, Sequence[int]]


def _padded(values: Sequence[int]) -> list[int]:
    return [*values, *[0] * (16 - len(values))]


def document(quant: int, *segments: tuple[bool, Coefficients]) -> Document:
    """A document of segments (intra, coefficients by FAP; missing ones are 0). Rules: DCT-3, DCT-5."""
    body = [
        {"intra": intra, "coefficients": {str(fap): _padded(values) for fap, values in faps.items()}}
        for intra, faps in segments
    ]
    return Document(DCT_COEFFICIENTS, _bytes({"fap_quant": quant, "segments": body}))


def _bytes(value: object) -> bytes:
    return (json.dumps(value, separators=(",", ":")) + "\n").encode()


def _halfway(fap_values: Mapping[int, int]) -> Coefficients:
    return {fap: [dc] for fap, dc in fap_values.items()}


@vector(id="dct.coefficients.example.1", title="Coefficients of the worked stream", tier="semantic", tools=TOOLS,
        rules=["DCT-3", "DCT-5", "DCT-6", "DCT-7"], features=["inter"])  # fmt: skip
def example() -> Accept:
    """FAP 3 and FAP 49 at fap_quant 8, intra and inter: what the worked DCT stream carries."""
    return Accept(
        document(8, (True, {3: [6, -5, 0, 2], 49: [-3, *[0] * 14, 1]}), (False, {3: [-2, 1], 49: [0]})),
        lines=32,
        values={(0, 3): -52, (11, 3): 202, (7, 49): -1842, (16, 3): 62, (31, 3): -2, (31, 49): -765},
    )


@vector(id="dct.coefficients.halves", title="Halves are rounded away from zero", tier="semantic", tools=TOOLS,
        rules=["DCT-7"], value_classes=["half"])  # fmt: skip
def halves() -> Accept:
    """DC values of 2.5, -2.5, 7.5, -7.5, exactly; and of 5/12 in FAP 18, which is 0."""
    return Accept(
        document(0, (True, {**_halfway({3: 4, 4: -4, 5: 12, 6: -12}), 18: [1]})),
        values={(0, 3): 3, (0, 4): -3, (0, 5): 8, (15, 6): -8, (0, 18): 0},
    )


@family({str(k): k for k in range(16)}, id="dct.coefficients.index-{case}", tier="syntax", tools=TOOLS,
        title="The coefficient at index {case} alone", rules=["DCT-5", "DCT-6", "DCT-7"])  # fmt: skip
def single(k: int) -> Accept:
    """One coefficient at index {case}: a sampled cosine, positive in FAP 3, negative in FAP 48."""
    return Accept(document(5, (True, {3: [*[0] * k, 40], 48: [*[0] * k, -3]})), lines=16)


@vector(id="dct.coefficients.quantisers", title="All base steps at fap_quant 31", tier="semantic", tools=TOOLS,
        rules=["DCT-5"], value_classes=["max"])  # fmt: skip
def quantisers() -> Accept:
    """DC 12 of every FAP is its base step times the scale 1039."""
    values = {(0, 3): 7793, (0, 18): 5195, (0, 23): 441575, (0, 48): 176630, (0, 68): 10390}
    return Accept(document(31, (True, {fap: [12] for fap in range(3, 69)})), values=values)


@vector(id="dct.coefficients.prediction", title="Inter DC adds up in the quantised domain", tier="semantic",
        tools=TOOLS, rules=["DCT-3", "DCT-8", "DCT-13"], features=["inter"])  # fmt: skip
def prediction() -> Accept:
    """DC steps of 0.625: the values are DC * 0.625, rounded, in nine segments; the last one is intra again."""
    segments = [(True, {3: [1]}), *[(False, {3: [1]})] * 7, (True, {3: [-1]})]
    values = {(16 * i, 3): value for i, value in enumerate((1, 1, 2, 3, 3, 4, 4, 5, -1))}
    return Accept(document(0, *segments), values=values)


@vector(id="dct.coefficients.retained", title="FAPs that a later segment leaves out", tier="semantic", tools=TOOLS,
        rules=["DCT-13"], features=["inter"])  # fmt: skip
def retained() -> Accept:
    """FAP 4 is in the first and third segment only: R with its last value in between, and its predictor stays."""
    segments = [(True, {3: [4], 4: [8, 3]}), (False, {3: [1]}), (False, {4: [1]})]
    states = {(16, 4): "R", (32, 4): "T", (32, 3): "R"}
    return Accept(document(8, *segments), values={(16, 3): 38, (32, 3): 38}, states=states)


@vector(id="dct.coefficients.largest", title="The largest integers", tier="stress", tools=TOOLS,
        rules=["DCT-3", "DCT-6", "DCT-8"], value_classes=["max", "min"])  # fmt: skip
def largest() -> Accept:
    """What 32 bits hold, in DC and AC: the bound that is computed from the values grows with them."""
    top, bottom = 2**31 - 1, -(2**31)
    segments = [(True, {3: [top], 4: [bottom], 5: [0, top, *[0] * 13, bottom]}), (False, {3: [top], 4: [bottom]})]
    return Accept(document(31, *segments))


@vector(id="dct.coefficients.dense", title="Dense segments of all FAPs", tier="stress", tools=TOOLS,
        rules=["DCT-5", "DCT-7", "DCT-8"], seed=16)  # fmt: skip
def dense() -> Accept:
    """Sixteen coefficients of each FAP, from a seed, in three segments."""
    seeded = Seeded(16)
    segments = [
        (i != 1, {fap: [seeded.between(-40 // (k + 1), 40 // (k + 1)) for k in range(16)] for fap in range(3, 69)})
        for i in range(3)
    ]
    return Accept(document(3, *segments))


@vector(id="dct.coefficients.ambiguous.dc-step", title="Ratio of the AC step to the DC step", tier="semantic",
        tools=TOOLS, rules=["DCT-5"])  # fmt: skip
def dc_step() -> Ambiguous:
    """DC 24 at fap_quant 8 is 180, or 135 with the ratio 4."""
    values = {"3": {(0, 3): 180}, "4": {(0, 3): 135}}
    return Ambiguous(document(8, (True, {3: [24], 4: [0, 3]})), "AMB-DCT-1", values=values)


@vector(id="dct.coefficients.ambiguous.normalisation", title="Scaling of the transform", tier="semantic",
        tools=TOOLS, rules=["DCT-7"])  # fmt: skip
def normalisation() -> Ambiguous:
    """DC 32 at fap_quant 8 is 240 with orthonormal factors, 60 with the inverse of an unscaled transform."""
    values = {"orthonormal": {(0, 3): 240}, "unnormalised": {(0, 3): 60}}
    return Ambiguous(document(8, (True, {3: [32], 4: [8, -3, 0, 5]})), "AMB-DCT-2", values=values)


_GOOD: Final = {"intra": True, "coefficients": {"3": [1] * 16}}
Broken = tuple[object, type[SnhcError], str, str, int]


@family(
    {
        "inter first": (
            {"fap_quant": 1, "segments": [{**_GOOD, "intra": False}]},
            InconsistentSemantics, "DCT-13", "segments[0].intra", 0,
        ),
        "FAP never sent": (
            {"fap_quant": 1, "segments": [_GOOD, {"intra": False, "coefficients": {"4": [0] * 16}}]},
            InconsistentSemantics, "DCT-13", "segments[1].coefficients.4", 16,
        ),
        "fifteen": (
            {"fap_quant": 1, "segments": [{"intra": True, "coefficients": {"3": [1] * 15}}]},
            InputFormat, "DCT-1", "segments[0].coefficients.3", 0,
        ),
        "FAP 2": (
            {"fap_quant": 1, "segments": [{"intra": True, "coefficients": {"2": [1] * 16}}]},
            InputFormat, "DCT-1", "segments[0].coefficients", 0,
        ),
        "fap quant": ({"fap_quant": 32, "segments": [_GOOD]}, RangeViolation, "DCT-5", "fap_quant", 0),
    },
    id="dct.coefficients.error.{case}", title="Coefficients: {case}", tier="error", tools=TOOLS, rules=["DCT-1"],
)  # fmt: skip
def broken(case: Broken) -> Reject:
    """A document with one fault ({case}): nothing to predict from, too few integers, or a value out of its range."""
    data, error, rule, path, before = case
    return Reject(Document(DCT_COEFFICIENTS, _bytes(data)), error, rule, path=path, lines=before or None)


@vector(id="dct.coefficients.error.not-json", title="Coefficients: not JSON", tier="error", tools=TOOLS,
        rules=["DCT-1"])  # fmt: skip
def not_json() -> Reject:
    """The document ends in the middle."""
    return Reject(Document(DCT_COEFFICIENTS, b'{"fap_quant":1,"segments":['), InputFormat, "DCT-1", line=1)
