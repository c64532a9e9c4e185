"""A trace as columns for a page: rows, parts, symbols, findings, frames.

Rules: CNF-17, CNF-21, CNF-22, CNF-23, FBA-23, FBA-25.

Rows partition the bits of their part, so a row needs its width only. Paths are kept without their plane, and are the
same few texts in every plane. `data.js` reads what is made here.
"""

from __future__ import annotations

from array import array
from typing import Final

from snhc.reference_impl.bitstream.errors import ResourceLimit
from snhc.reference_impl.bitstream.source import Source
from snhc.reference_impl.entropy.literal import SegmentTrace
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.syntax.element import ELEMENTS
from snhc.reference_impl.systems.visual import AnyPlane

from ..elements import meaning
from ..parts import Part, path_names
from .packing import packed

# What a browser holds with ease. More is looked at by planes.
MOST_BYTES: Final = 32 << 20
MOST_ROWS: Final = 2_000_000
MOST_SYMBOLS: Final = 4_000_000
_KINDS: Final = (
    "", "visual_object_sequence", "visual_object_sequence_end", "user_data", "visual_object", "fba_object",
    "mesh_object", "trailing_data",
)  # fmt: skip

OPENS: Final = 1
CLOSES: Final = 2
INTRA: Final = 4
FAULT: Final = 8
# In bits of a symbol's flags.
ADAPTIVE: Final = 1
RESCALED: Final = 2

# The path of a row of a plane's part that stands above the plane.
ROOT: Final = "/"

Index = dict[str, int]


def _number(text: str, known: Index) -> int:
    return known.setdefault(text, len(known))


class Rows:
    """The elements of all parts. Rules: CNF-21."""

    def __init__(self, source: Source, with_symbols: bool) -> None:
        self._source = source
        self._with_symbols = with_symbols
        self.element = array("H")
        self.width = array("I")
        self.value = array("i")
        self.path = array("I")
        self.blobs = array("I")
        self.paths: Index = {}
        self._elements: dict[int, int] = {}
        self._meanings: dict[int, dict[int, str]] = {}
        self.segment_row = array("I")
        self.segment_labels = array("I")
        self.label_sets: Index = {}
        self.level = array("i")
        self.shifts = array("B")
        self.guard_segment = array("I")
        self.guard = array("d")
        self.details = {name: array("H") for name in ("low", "high", "code", "c", "cumLow", "cumHigh", "total")}
        self.symbol_flags = array("B")

    def __len__(self) -> int:
        return len(self.element)

    def add(self, part: Part) -> None:
        """Take the rows of a part. Rules: CNF-21, CNF-22. Raises ResourceLimit."""
        trace = part.trace
        if len(self) + len(trace) > MOST_ROWS:
            raise too_large("elements", MOST_ROWS)
        if len(trace) and trace.end[-1] - trace.start[0] > 8 * MOST_BYTES:
            raise too_large("bytes", MOST_BYTES)
        texts: dict[int, int] = {}
        # The plane is known from the part, but for one that a fault cut short.
        above = 1 if part.plane is not None or part.closes else 0
        for row in range(len(trace)):
            index, value = trace.element[row], trace.value[row]
            if index not in self._elements:
                self._elements[index] = len(self._elements)
                self._meanings[index] = {}
            words = meaning(ELEMENTS[index], value)
            if words:
                self._meanings[index][value] = words
            path = trace.path[row]
            if path not in texts:
                names = path_names(trace, path)
                # What stands before a plane in its part, the start code of the object, is at the root.
                text = ".".join(names[above:]) if names or not above else ROOT
                texts[path] = _number(text, self.paths)
            if row in trace.segments:
                self._segment(len(self.element), *trace.segments[row])
            elif row in trace.blobs:
                self.blobs.append(len(self.element))
            self.element.append(self._elements[index])
            self.width.append(trace.end[row] - trace.start[row])
            self.value.append(value)
            self.path.append(texts[path])

    def _segment(self, row: int, segment: SegmentTrace, labels: list[str]) -> None:
        if len(self.level) + len(segment.levels) > MOST_SYMBOLS:
            raise too_large("symbols", MOST_SYMBOLS)
        number = len(self.segment_row)
        self.segment_row.append(row)
        self.segment_labels.append(_number("\n".join(labels), self.label_sets))
        self.level.extend(segment.levels)
        for position, _ in segment.guards:
            self.guard_segment.append(number)
            self.guard.append(position)
        for step in segment.steps:
            self.shifts.append(step.shifts)
            if self._with_symbols:
                numbers = (step.low, step.high, step.code_value, step.c, step.cum_low, step.cum_high, step.total)
                for column, value in zip(self.details.values(), numbers, strict=True):
                    column.append(value)
                self.symbol_flags.append(ADAPTIVE * step.adaptive + RESCALED * step.rescaled)

    def rules(self) -> set[str]:
        """The rules of the elements. Rules: CNF-21."""
        return {ELEMENTS[index].rule for index in self._elements}

    def as_json(self) -> dict[str, object]:
        """The columns and what their numbers stand for. Rules: CNF-25."""
        elements = [
            {
                "name": ELEMENTS[index].name,
                "rule": ELEMENTS[index].rule,
                "allowed": ELEMENTS[index].allowed if ELEMENTS[index].restricted else "",
                "meaning": {str(value): words for value, words in sorted(self._meanings[index].items())},
            }
            for index in self._elements
        ]
        symbols: dict[str, object] = {
            "level": packed(narrowest(self.level), self.level),
            "shifts": packed("B", self.shifts),
        }
        if self._with_symbols:
            symbols |= {name: packed("H", column) for name, column in self.details.items()}
            symbols["flags"] = packed("B", self.symbol_flags)
        return {
            "elements": elements,
            "paths": list(self.paths),
            "rows": {
                "element": packed("H", self.element),
                "width": packed("I", self.width),
                "value": packed("i", self.value),
                "path": packed("I", self.path),
                "blobs": packed("I", self.blobs),
            },
            "labelSets": [labels.split("\n") if labels else [] for labels in self.label_sets],
            "segments": {
                "row": packed("I", self.segment_row),
                "labels": packed("I", self.segment_labels),
                "guardSegment": packed("I", self.guard_segment),
                "guard": packed("d", self.guard),
            },
            "symbols": symbols,
        }


class PartColumns:
    """Planes, headers, and what stands behind the planes. Rules: CNF-17, CNF-21."""

    def __init__(self) -> None:
        self.row = array("I")
        self.start = array("d")
        self.plane = array("i")
        self.item = array("I")
        self.kind = array("B")
        self.flags = array("B")
        self.mask = array("B")
        self.frame = array("I")
        self.frames = array("B")
        self.findings: list[list[object]] = []

    def __len__(self) -> int:
        return len(self.row)

    def add(self, part: Part, first_row: int, first_frame: int) -> None:
        """Take the place of a part; `first_row`: how many rows were there before it. Rules: CNF-21, CNF-23."""
        plane = part.plane
        for finding in part.findings:
            bits = list(finding.bits) if finding.bits is not None else None
            self.findings.append([len(self), bits, finding.severity, finding.id, finding.rule, finding.message])
        self.row.append(first_row)
        self.start.append(part.trace.start[0] if len(part.trace) else -1)
        self.plane.append(part.plane_number)
        self.item.append(part.item_number)
        self.kind.append(_KINDS.index(part.kind) if part.kind in _KINDS else 0)
        flags = OPENS * part.opens | CLOSES * part.closes | FAULT * (part.error is not None)
        self.flags.append(flags | INTRA * bool(plane is not None and plane.is_intra))
        self.mask.append(mask_of(plane))
        self.frame.append(first_frame)
        self.frames.append(len(plane.frames) if plane is not None else 0)

    def as_json(self) -> dict[str, object]:
        """The columns. Rules: CNF-25."""
        return {
            "kinds": list(_KINDS),
            "parts": {
                "row": packed("I", self.row),
                "start": packed("d", self.start),
                "plane": packed("i", self.plane),
                "item": packed("I", self.item),
                "kind": packed("B", self.kind),
                "flags": packed("B", self.flags),
                "mask": packed("B", self.mask),
                "frame": packed("I", self.frame),
                "frames": packed("B", self.frames),
            },
            "findings": self.findings,
        }


def narrowest(numbers: array[int]) -> str:
    """The type of a column of signed numbers. Rules: CNF-25."""
    return "h" if not numbers or (min(numbers) >= -(1 << 15) and max(numbers) < 1 << 15) else "i"


def mask_of(plane: AnyPlane | None) -> int:
    """What a plane carries: bit 0 FAPs, 1 BAPs, 2 a mesh geometry, 3 mesh motion. Rules: FBA-5, MSH-2."""
    if plane is None:
        return 0
    if isinstance(plane, FbaPlane):
        return plane.fba_object_mask
    return 4 * (plane.geometry is not None) + 8 * (plane.motion is not None)


def too_large(what: str, most: int) -> ResourceLimit:
    """A stream that is too large for one page. Rules: CNF-22."""
    return ResourceLimit("CNF-22", f"{what} of the page", value=f"more than {most}", allowed="fewer; see --planes")
