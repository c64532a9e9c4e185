"""Decoded output as NDJSON lines, the convention `snhc-decoded` version 1.

Rules: CNF-1, CNF-24.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from ..syntax.element import Readings
from .frames import FaceFrame

VERSION: Final = 1
VISEME_KEYS: Final = ("select1", "select2", "blend", "def")
EXPRESSION_KEYS: Final = ("select1", "intensity1", "select2", "intensity2", "init_face", "def")


def header_line(kind: str, readings: Readings | None = None, profile: str = "") -> str:
    """The first line; names the readings that are not the default, and the entropy profile of DCT segments.

    Rules: CNF-1, CNF-24, DCT-1. `profile`: the profile's label, which says when it is provisional.
    """
    line = f'{{"format":"snhc-decoded","version":{VERSION},"kind":"{kind}"'
    if readings is not None and readings.chosen:
        chosen = ",".join(f'"{id}":"{key}"' for id, key in readings.chosen.items())
        line += f',"readings":{{{chosen}}}'
    if profile:
        line += f',"entropy_profile":"{profile}"'
    return line + "}"


def frame_line(frame: FaceFrame) -> str:
    """One frame as one line, without the newline. Rules: CNF-1."""
    faps = ",".join("null" if value is None else str(value) for value in frame.faps)
    line = (
        f'{{"index":{frame.index},"time":"{frame.time[0]}/{frame.time[1]}",'
        f'"intra":{"true" if frame.intra else "false"},"faps":[{faps}],'
        f'"viseme":{_object(VISEME_KEYS, frame.viseme)},"expression":{_object(EXPRESSION_KEYS, frame.expression)},'
        f'"state":"{frame.state}"'
    )
    if frame.fap_quant is not None:
        line += f',"gender":{frame.gender},"coding_type":{frame.coding_type},"fap_quant":{frame.fap_quant}'
    if frame.baps is not None:
        line += ',"baps":{' + ",".join(f'"{number}":{value}' for number, value in frame.baps.items()) + "}"
    return line + "}"


def _object(keys: tuple[str, ...], values: Iterable[int] | None) -> str:
    if values is None:
        return "null"
    return "{" + ",".join(f'"{key}":{value}' for key, value in zip(keys, values, strict=True)) + "}"


def ndjson(frames: Iterable[FaceFrame], readings: Readings | None = None) -> Iterator[str]:
    """Header and lines of a decoded face stream, each with its newline. Rules: CNF-1."""
    yield header_line("fba", readings) + "\n"
    for frame in frames:
        yield frame_line(frame) + "\n"
