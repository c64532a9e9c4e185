"""Where a decoder went wrong: from a difference to the plane and the syntax element that carried it.

Rules: CNF-17 (plane, element, bit span, rule). What a report shows of it is in `excerpt` and `pictures`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from snhc.conformance.differences import Difference
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.systems.stream import TracePart, trace_stream
from snhc.vectors.manifest import DOCUMENTS, Entry


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a vector. Rules: CNF-17, CNF-21.

    `plane`: number and bits of the plane; `element`, `path`, `bits`, `rule`: the syntax element that carried what
    differs, where one did.
    """

    plane: int
    plane_bits: tuple[int, int]
    element: str = ""
    path: str = ""
    bits: tuple[int, int] | None = None
    rule: str = ""

    def as_json(self) -> dict[str, Any]:
        """The report's `location`."""
        out: dict[str, Any] = {"plane": self.plane, "plane_bits": list(self.plane_bits)}
        if self.bits is not None:
            out |= {"element": self.element, "path": self.path, "bits": list(self.bits), "rule": self.rule}
        return out

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Location:
        """A report's `location`."""
        bits = data.get("bits")
        return cls(
            data["plane"], (data["plane_bits"][0], data["plane_bits"][1]), data.get("element", ""),
            data.get("path", ""), None if bits is None else (bits[0], bits[1]), data.get("rule", ""),
        )  # fmt: skip

    def __str__(self) -> str:
        text = f"plane[{self.plane}] at bits [{self.plane_bits[0]}, {self.plane_bits[1]})"
        if self.bits is not None:
            text += f": {self.element} at bits [{self.bits[0]}, {self.bits[1]}) ({self.path}, {self.rule})"
        return text


# What carries a field of a line, the best first.
_CARRIERS = {
    "faps": ("fap_segment", "dc", "dc_difference"),
    "viseme": ("viseme_segment",),
    "expression": ("expression_segment",),
    "state": ("fap_mask_type", "fba_object_mask"),
    "mask": ("fap_mask_type", "fba_object_mask"),
    "time": ("time_code_hours", "frame_rate", "skip_frames"),
    "intra": ("is_intra",),
    "baps": ("bap_segment",),
    "gender": ("fba_suggested_gender",),
    "coding_type": ("fba_object_coding_type",),
    "fap_quant": ("fap_quant",),
    "nodes": ("delta_mv_x_vlc", "node_motion_vector_flag", "node0_x", "delta_x_len_vlc", "mesh_type_code"),
    "triangles": ("triangle_split_code", "nr_of_boundary_nodes", "mesh_type_code"),
    "order": ("nr_of_boundary_nodes", "mesh_type_code"),
}

# Elements that stand once per node, below its number.
_OF_NODES = frozenset({"delta_mv_x_vlc", "node_motion_vector_flag", "node0_x", "delta_x_len_vlc"})


@dataclass(frozen=True, slots=True)
class Hit:
    """A location with what stands around it. Rules: CNF-17. `row`: of the trace of `part`, -1: none in particular."""

    location: Location | None
    part: TracePart
    row: int
    before: TracePart | None
    after: TracePart | None


def locate(entry: Entry, suite: Path, difference: Difference, *, fap_frames: bool = False) -> Location | None:
    """The place of a difference, by the reference trace; None where the stream has no such plane, and for documents.

    Rules: CNF-17. `fap_frames`: the frames are those of a `.fap` text, which leaves out planes without FAP data.
    """
    hit = find(entry, suite, difference, fap_frames=fap_frames)
    return hit.location if hit is not None else None


def find(entry: Entry, suite: Path, difference: Difference, *, fap_frames: bool = False) -> Hit | None:
    """As `locate`, with the trace around it. Rules: CNF-17."""
    if entry.media in DOCUMENTS:
        return None
    data = (suite / entry.file).read_bytes()
    frame = number = 0
    before: TracePart | None = None
    parts = trace_stream(data, entry.options.for_decoder())
    for part in parts:
        plane = part.plane
        if plane is not None:
            lines = len(plane.frames)
            if fap_frames and isinstance(plane, FbaPlane) and plane.faps is None:
                lines = 0
            if frame <= difference.frame < frame + lines:
                location, row = _in_part(part, number, (plane.start, plane.end), difference)
                return Hit(location, part, row, before, next(parts, None))
            frame += lines
            number += 1
        before = part
    return None


def find_bits(entry: Entry, suite: Path, bits: tuple[int, int]) -> Hit | None:
    """The first element that shares a bit with a span; else what stands last before it. Rules: CNF-17, CNF-21."""
    if entry.media in DOCUMENTS:
        return None
    before: TracePart | None = None
    parts = trace_stream((suite / entry.file).read_bytes(), entry.options.for_decoder())
    part: TracePart | None = None
    number = -1
    for part in parts:
        number += part.plane is not None
        for row in range(len(part.trace)):
            if part.trace.end[row] > bits[0] and part.error is None:
                return Hit(_row_location(part, row, number), part, row, before, next(parts, None))
        if part.error is None:
            before = part
    if part is None:
        return None
    return Hit(None, part, -1, before if before is not part else None, None)


def _row_location(part: TracePart, row: int, number: int) -> Location | None:
    if part.plane is None:
        return None
    trace, el = part.trace, part.trace.el(row)
    return Location(
        number, (part.plane.start, part.plane.end), el.name, trace.path_text(row), (trace.start[row], trace.end[row]),
        el.rule,
    )  # fmt: skip


def _in_part(part: TracePart, number: int, bits: tuple[int, int], difference: Difference) -> tuple[Location, int]:
    trace = part.trace
    field, node = _field(difference.what)
    for name in _CARRIERS.get(field, ()):
        rows = [row for row in range(len(trace)) if trace.el(row).name == name]
        for row in rows:
            if field == "nodes" and name in _OF_NODES and not trace.path_text(row).endswith(f"node[{node}]"):
                continue
            if name.startswith("dc") and not trace.path_text(row).endswith(f".fap[{difference.fap}]"):
                continue
            segment = trace.segments.get(row)
            if name == "fap_segment" and segment is not None and not _carries(segment[1], difference.fap):
                continue
            if (
                name == "fap_mask_type"
                and difference.fap is not None
                and not _masks(trace.path_text(row), difference.fap)
            ):
                continue
            el = trace.el(row)
            span = (trace.start[row], trace.end[row])
            return Location(number, bits, name, trace.path_text(row), span, el.rule), row
    return Location(number, bits), -1


def _field(what: str) -> tuple[str, int]:
    """`nodes[7]` -> `nodes`, 7; -1 where there is no number."""
    match = re.match(r"([a-z_]+)(?:\[([0-9]+)\])?", what)
    assert match is not None
    return match[1], int(match[2] or -1)


def _carries(labels: list[str], fap: int | None) -> bool:
    return fap is None or any(label.split(" ")[1:2] == [str(fap)] for label in labels)


def _masks(path: str, fap: int) -> bool:
    from snhc.reference_impl.tables import fap_groups

    group = next(group.group for group in fap_groups() if group.first_fap <= fap <= group.last_fap)
    return path.endswith(f"group[{group}]")
