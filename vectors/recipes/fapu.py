"""Units of a face, measured at its feature points.

Rules: FAC-1, FAC-2, CNF-25. Input: a face definition (JSON). Output: kind `fapu`, this suite's own (see
`vectors/documents.py`). Coordinates are quarters, so that all units are exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from snhc.reference_impl.bitstream.errors import InconsistentSemantics, InputFormat, SnhcError

from ..document_builders import compact
from ..manifest import FACE
from ..recipe import Accept, Document, Reject, family, vector

TOOLS: Final = ("fapu",)
Point = tuple[float, float, float]
# The points that the units are measured at, and those that they are mistaken for.
_POINTS: Final[Mapping[str, Point]] = {
    "3.5": (32.0, 48.0, 10.0), "3.6": (-32.0, 48.0, 10.0),
    "9.15": (0.0, -16.0, 20.0),
    "2.2": (0.0, -48.0, 14.0), "2.3": (0.0, -48.0, 14.0), "8.1": (0.0, -40.0, 15.0), "8.2": (0.0, -56.0, 15.0),
    "8.3": (25.0, -48.0, 8.0), "8.4": (-25.0, -48.0, 8.0), "2.4": (23.0, -48.0, 8.0), "2.5": (-23.0, -48.0, 8.0),
    "3.1": (32.0, 54.0, 10.0), "3.3": (32.0, 42.0, 10.0), "3.2": (-32.0, 54.0, 10.0), "3.4": (-32.0, 42.0, 10.0),
}  # fmt: skip
_UNITS: Final = {
    "ES": 64 / 1024, "ENS": 64 / 1024, "MNS": 32 / 1024, "MW": 50 / 1024, "IRISD": 12 / 1024, "AU": 1e-5,
}  # fmt: skip


def _face(changes: Mapping[str, Point | None] | None = None, **more: object) -> Document:
    points = {name: list(place) for name, place in {**_POINTS, **(changes or {})}.items() if place is not None}
    return Document(FACE, compact({"format": "snhc-face", "version": 1, "name": "plain", "points": points, **more}))


@vector(id="fapu.units", title="The five distances and AU", tier="semantic", tools=TOOLS, rules=["FAC-1"])
def units() -> Accept:
    """ES0 64, ENS0 64, MNS0 32, MW0 50, IRISD0 12; AU is 1e-5 rad, not 1e-4. All feature points agree with the rest."""
    return Accept(_face(), units=_UNITS, lines=1, findings=())


@vector(id="fapu.mns-at-the-inner-lip", title="MNS ends at 2.2, not at 8.1", tier="semantic", tools=TOOLS,
        rules=["FAC-1"])  # fmt: skip
def inner_lip() -> Accept:
    """The outer contour 8.1 is far above the inner one 2.2: 40 from the nose to 2.2, 8 to 8.1."""
    changes = {"2.2": (0.0, -56.0, 14.0), "8.1": (0.0, -24.0, 15.0)}
    return Accept(_face(changes), units={**_UNITS, "MNS": 40 / 1024})


@vector(id="fapu.mw-at-the-outer-corners", title="MW lies between 8.3 and 8.4", tier="semantic", tools=TOOLS,
        rules=["FAC-1"])  # fmt: skip
def outer_corners() -> Accept:
    """The inner corners 2.4 and 2.5 are 10 apart, the outer ones 70."""
    changes: dict[str, Point] = {
        "2.4": (5.0, -48.0, 8.0), "2.5": (-5.0, -48.0, 8.0), "8.3": (35.0, -48.0, 8.0), "8.4": (-35.0, -48.0, 8.0),
    }  # fmt: skip
    return Accept(_face(changes), units={**_UNITS, "MW": 70 / 1024})


@vector(id="fapu.one-axis", title="Distances along one axis", tier="semantic", tools=TOOLS, rules=["FAC-1"])
def one_axis() -> Accept:
    """The eyes differ in y and z, the mouth's corners too: ES0 and MW0 are differences in x. Not straight lines."""
    changes: dict[str, Point] = {"3.6": (-32.0, 49.0, 3.0), "8.4": (-25.0, -90.0, -30.0), "2.2": (9.0, -48.0, -5.0)}
    return Accept(_face(changes), units=_UNITS)


@vector(id="fapu.sign", title="A face turned over", tier="semantic", tools=TOOLS, rules=["FAC-1"])
def sign() -> Accept:
    """All coordinates negated: distances have no sign."""
    changes = {name: (-x, -y, -z) for name, (x, y, z) in _POINTS.items()}
    return Accept(_face(changes), units=_UNITS)


@vector(id="fapu.iris-mismatch", title="Irises of two sizes", tier="semantic", tools=TOOLS, rules=["FAC-1", "FAC-3"])
def iris() -> Accept:
    """The right iris is 10 high, the left one 12: the unit is the left one's, and a checker has a finding."""
    changes = {"3.2": (-32.0, 53.0, 10.0), "3.4": (-32.0, 43.0, 10.0)}
    return Accept(_face(changes), units=_UNITS, findings=("iris-diameter",))


@vector(id="fapu.iris-within-one-percent", title="Irises that agree within 1 %", tier="semantic", tools=TOOLS,
        rules=["FAC-1"])  # fmt: skip
def iris_near() -> Accept:
    """12 and 12.0625: no finding."""
    return Accept(_face({"3.2": (-32.0, 54.0625, 10.0)}), units=_UNITS, findings=())


@vector(id="fapu.unit-by-fap", title="The unit of every FAP", tier="semantic", tools=TOOLS, rules=["FAC-1", "FAC-4"])
def by_fap() -> Accept:
    """All five units differ. FAP 19, a lid, is in IRISD and not in MNS; FAP 23 and 48 are angles; FAP 1 has none."""
    changes: dict[str, Point] = {"9.15": (0.0, -20.0, 20.0)}
    mns, es, ens, irisd = 28 / 1024, 64 / 1024, 68 / 1024, 12 / 1024
    values = {
        (0, 1): None, (0, 2): None, (0, 3): mns, (0, 4): mns, (0, 19): irisd, (0, 22): irisd, (0, 23): 1e-5,
        (0, 31): ens, (0, 37): es, (0, 48): 1e-5,
    }  # fmt: skip
    units = {**_UNITS, "MNS": mns, "ENS": ens}
    return Accept(_face(changes), units=units, values=values)


@vector(id="fapu.no-extent", title="A face without a mouth's width", tier="stress", tools=TOOLS, rules=["FAC-1"],
        value_classes=["zero"])  # fmt: skip
def no_extent() -> Accept:
    """Both corners in one place: MW is 0, which is a unit like any other."""
    changes: dict[str, Point] = {"8.3": (0.0, -48.0, 8.0), "8.4": (0.0, -48.0, 8.0)}
    return Accept(_face(changes), units={**_UNITS, "MW": 0.0})


@family(
    {name: name for name in ("2.2", "3.1", "3.5", "8.4", "9.15")},
    id="fapu.error.missing-{case}", title="A face without {case}", tier="error", tools=TOOLS, rules=["FAC-1", "FAC-2"],
)  # fmt: skip
def missing(name: str) -> Reject:
    """A unit is measured at {case}, which the face has not."""
    return Reject(_face({name: None}), InconsistentSemantics, "FAC-2", path=f"points.{name}")


@family(
    {
        "two coordinates": ({"2.2": [0, 1]}, InconsistentSemantics, "points.2.2"),
        "text": ({"2.2": [0, 1, "2"]}, InputFormat, "points.2.2[2]"),
        "no such point": ({"12.1": [0, 1, 2]}, InputFormat, "points.12.1"),
    },
    id="fapu.error.{case}", title="Face definition: {case}", tier="error", tools=TOOLS, rules=["FAC-2", "CNF-25"],
)  # fmt: skip
def wrong_point(case: tuple[object, type[SnhcError], str]) -> Reject:
    """A feature point of the definition is wrong: {case}."""
    changes, error, path = case
    assert isinstance(changes, dict)
    points = {**{name: list(place) for name, place in _POINTS.items()}, **changes}
    return Reject(Document(FACE, compact({"points": points})), error, "FAC-2", path=path)
