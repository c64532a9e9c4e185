"""FAP interpolation tables and frames with one fault each.

Rules: FIT-1, FIT-2, FIT-3, FIT-5, FIT-9, CNF-1, CNF-6, CNF-22, CNF-25.
"""

from __future__ import annotations

from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, RangeViolation, SnhcError

from ..document_builders import HEADER, JsonTable, compact, fit, fit_table, frame, frames, linear
from ..manifest import FIT, DecodeOptions
from ..recipe import Accept, Document, Reject, family, vector

TOOLS: Final = ("fit",)
Change = tuple[str, object, type[SnhcError], str, str]
"""Field, what it becomes, class, rule, path."""


def _good() -> JsonTable:
    """Two sets, one link, two functions: 2 F3 + 3 F4^2 over 1 + F4^2, and F3."""
    return fit_table(
        [[3, 4], [10, 11]],
        [(0, 1, [([(2.0, (1, 0)), (3.0, (0, 2))], [(1.0, (0, 0)), (1.0, (0, 2))]), linear(1.0, 0.0)])],
    )


def _pulsed() -> JsonTable:
    return fit_table([[2], [10]], [(0, 1, [([(1.0, (0, 1, 0, 0))], [])])], impulses=[0, 1])


@vector(id="fit.error.none", title="The table that the faults are made in", tier="syntax", tools=TOOLS,
        rules=["FIT-9"], features=["denominator"])  # fmt: skip
def good() -> Accept:
    """(2 F3 + 3 F4^2) / (1 + F4^2) and F3, without a fault."""
    return Accept(fit(_good(), frame({3: 5, 4: 3})), values={(0, 10): 4, (0, 11): 5})


_RANGE: Final = RangeViolation
_LIST: Final = InconsistentSemantics


@family(
    {
        "fap 0": ("FAPs", [3, 0, -1, 10, 11, -1], _RANGE, "FIT-1", "FAPs[1]"),
        "fap 69": ("FAPs", [3, 4, -1, 10, 69, -1], _RANGE, "FIT-1", "FAPs[4]"),
        "fap minus 2": ("FAPs", [-2, 4, -1, 10, 11, -1], _RANGE, "FIT-1", "FAPs[0]"),
        "high level child": ("FAPs", [3, 4, -1, 10, 2, -1], _RANGE, "FIT-1", "FAPs[4]"),
        "empty set": ("FAPs", [3, 4, -1, -1, 10, 11, -1], _LIST, "FIT-1", "FAPs[3]"),
        "open set": ("FAPs", [3, 4, -1, 10, 11], _LIST, "FIT-1", "FAPs[5]"),
        "set 2 of 2": ("Graph", [0, 2], _RANGE, "FIT-2", "Graph[1]"),
        "half a link": ("Graph", [0, 1, 0], _LIST, "FIT-2", "Graph[3]"),
        "exponent 16": ("numeratorExp", [1, 0, 0, 16, 1, 0, 0, 0], _RANGE, "FIT-3", "numeratorExp[3]"),
        "exponents missing": ("numeratorExp", [1, 0, 0, 2, 1, 0, 0], _LIST, "FIT-3", "numeratorExp[7]"),
        "exponents too many": ("denominatorExp", [0, 0, 0, 2, 1], _LIST, "FIT-3", "denominatorExp[4]"),
        "terms 11": ("numeratorTerms", [11, 2], _RANGE, "FIT-3", "numeratorTerms[0]"),
        "terms missing": ("denominatorTerms", [2], _LIST, "FIT-3", "denominatorTerms[1]"),
        "coefficients missing": ("numeratorCoefs", [2.0, 3.0, 1.0], _LIST, "FIT-3", "numeratorCoefs[3]"),
        "coefficients too many": ("denominatorCoefs", [1.0, 1.0, 1.0], _LIST, "FIT-3", "denominatorCoefs[2]"),
        "impulse without use": ("numeratorImpulse", [0, 1], _LIST, "FIT-5", "numeratorImpulse[0]"),
        "text for a number": ("Graph", [0, "1"], InputFormat, "FIT-2", "Graph[1]"),
        "fraction for a number": ("FAPs", [3.5, 4, -1, 10, 11, -1], InputFormat, "FIT-1", "FAPs[0]"),
    },
    id="fit.error.{case}", title="Table: {case}", tier="error", tools=TOOLS, rules=["FIT-9"],
)  # fmt: skip
def field(change: Change) -> Reject:
    """One list of a good table is wrong ({case}): the error names field and index. No frame is filled."""
    name, value, error, rule, path = change
    return Reject(fit({**_good(), name: value}, frame({3: 5, 4: 3})), error, rule, path=path, lines=None)


@family(
    {
        "missing": ([], _LIST, "numeratorImpulse[0]"),
        "half": ([0], _LIST, "numeratorImpulse[1]"),
        "value 1024": ([0, 1024], _RANGE, "numeratorImpulse[1]"),
        "number 5 of 4": ([5, 1], _RANGE, "numeratorImpulse[0]"),
    },
    id="fit.error.impulse.{case}", title="Impulse: {case}", tier="error", tools=TOOLS, rules=["FIT-5", "FIT-9"],
)  # fmt: skip
def impulse(change: tuple[list[int], type[SnhcError], str]) -> Reject:
    """The impulse pair of an expression's term is wrong ({case}), however its number is counted."""
    pair, error, path = change
    table = {**_pulsed(), "numeratorImpulse": pair}
    return Reject(fit(table, frame(expression=(1, 9, 0, 0))), error, "FIT-5", path=path)


@vector(id="fit.error.limit.sets", title="More sets than the limit", tier="error", tools=TOOLS, rules=["CNF-22"],
        options=DecodeOptions(limits={"fit_sets": 1}))  # fmt: skip
def too_many_sets() -> Reject:
    """Two sets where one is allowed: the fault is the first FAP of the second set."""
    from snhc.reference_impl.bitstream.errors import ResourceLimit

    return Reject(fit(_good(), frame({3: 5, 4: 3})), ResourceLimit, "CNF-22", path="FAPs[3]")


@vector(id="fit.error.not-json", title="A table that is not JSON", tier="error", tools=TOOLS, rules=["FIT-9"])
def not_json() -> Reject:
    """The document ends in the middle of a list."""
    return Reject(Document(FIT, b'{"FAPs":[3,', frames([frame({3: 1})])), InputFormat, "FIT-9", line=1)


def _broken_line(change: dict[str, object]) -> bytes:
    good = frames([frame({3: 5, 4: 3})])
    return good + compact({"index": 1, "time": "1/25", **frame({3: 5, 4: 3}), **change})


@family(
    {
        "67 values": ({"faps": [None] * 67}, _LIST, "faps"),
        "fap 2 as a number": ({"faps": [None, 1, *[None] * 66]}, _RANGE, "faps[1]"),
        "state without a value": ({"state": "U" * 10 + "T" + "U" * 57}, _LIST, "state[10]"),
        "state of another letter": ({"state": "U" * 67 + "X"}, InputFormat, "state[67]"),
        "time": ({"time": "1.5"}, InputFormat, "time"),
    },
    id="fit.error.frames.{case}", title="Frames: {case}", tier="error", tools=TOOLS, rules=["CNF-1", "CNF-25"],
)  # fmt: skip
def line(change: tuple[object, type[SnhcError], str]) -> Reject:
    """The second frame, line 3, is wrong ({case}); the first one is filled."""
    fields, error, path = change
    assert isinstance(fields, dict)
    document = Document(FIT, compact(_good()), _broken_line(fields))
    return Reject(document, error, "CNF-1", path=path, line=3, lines=1)


@vector(id="fit.error.frames.mesh", title="Frames of a mesh", tier="error", tools=TOOLS, rules=["CNF-1", "CNF-25"])
def other_kind() -> Reject:
    """The header says that what follows is a mesh."""
    header = HEADER.replace('"fba"', '"mesh"').encode()
    return Reject(Document(FIT, compact(_good()), header), InputFormat, "CNF-1", path="kind", line=1)
