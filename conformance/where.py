"""Where a decoder went wrong: from a difference to the plane and the syntax element that carried it.

Rules: CNF-17 (plane, element, bit span, rule). Not here: a second trace, symbols inside a segment, minimising.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.systems.stream import TracePart, trace_stream
from snhc.vectors.manifest import DOCUMENTS, Entry

from .differences import Difference


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
    "faps": ("fap_segment",),
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
}


def locate(entry: Entry, suite: Path, difference: Difference, *, fap_frames: bool = False) -> Location | None:
    """The place of a difference, by the reference trace; None where the stream has no such plane, and for documents.

    Rules: CNF-17. `fap_frames`: the frames are those of a `.fap` text, which leaves out planes without FAP data.
    """
    if entry.media in DOCUMENTS:
        return None
    data = (suite / entry.file).read_bytes()
    frame = 0
    number = 0
    for part in trace_stream(data, entry.options.for_decoder()):
        plane = part.plane
        if plane is None:
            continue
        lines = len(plane.frames)
        if fap_frames and isinstance(plane, FbaPlane) and plane.faps is None:
            lines = 0
        if frame <= difference.frame < frame + lines:
            return _in_part(part, number, (plane.start, plane.end), difference)
        frame += lines
        number += 1
    return None


def _in_part(part: TracePart, number: int, bits: tuple[int, int], difference: Difference) -> Location:
    trace = part.trace
    for name in _CARRIERS.get(difference.what.partition(".")[0], ()):
        rows = [row for row in range(len(trace)) if trace.el(row).name == name]
        for row in rows:
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
            return Location(number, bits, name, trace.path_text(row), (trace.start[row], trace.end[row]), el.rule)
    return Location(number, bits)


def _carries(labels: list[str], fap: int | None) -> bool:
    return fap is None or any(label.split(" ")[1:2] == [str(fap)] for label in labels)


def _masks(path: str, fap: int) -> bool:
    from snhc.reference_impl.tables import fap_groups

    group = next(group.group for group in fap_groups() if group.first_fap <= fap <= group.last_fap)
    return path.endswith(f"group[{group}]")
