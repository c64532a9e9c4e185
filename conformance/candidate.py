"""Reading what a decoder printed: CNF-1 and CNF-2 lines, CSV rows, `.fap` text. Nothing of it is trusted.

Rules: CNF-1, CNF-2, CNF-9, CNF-25.
"""

from __future__ import annotations

import csv
import io
import json
import re
import reprlib
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.face.decoded import EXPRESSION_KEYS, VERSION, VISEME_KEYS
from snhc.reference_impl.face.fap_text import FapReader, FapTextFrame
from snhc.reference_impl.systems.output import CSV_COLUMNS

Frame = Mapping[str, Any]

_FAPS: Final = 68
# Exact times of a stream that goes through every frame rate have some 1,800 digits.
_TIME: Final = re.compile(r"-?[0-9]{1,2000}/[1-9][0-9]{0,2000}")
_STATE: Final = re.compile(r"[TRIUFS]{68}")
_INTEGER: Final = re.compile(r"-?[0-9]{1,20}")


# A decoder may print anything: what is said of a value is short.
_SHOWN: Final = reprlib.Repr()
_SHOWN.maxstring = _SHOWN.maxlong = _SHOWN.maxother = 60


def shown(value: object) -> str:
    """A value as a verdict shows it. Rules: CNF-17."""
    return _SHOWN.repr(value)


class Malformed(Exception):
    """The output has not the form that the adapter claims. Rules: CNF-1, CNF-9."""


def _lines(text: bytes) -> list[str]:
    try:
        decoded = text.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Malformed(f"output is not UTF-8 (byte {error.start})") from error
    if not decoded:
        raise Malformed("no output")
    lines = decoded.split("\n")
    if lines[-1] == "":
        lines.pop()
    return lines


def _object(line: str, number: int) -> dict[str, Any]:
    def constant(word: str) -> None:
        raise Malformed(f"line {number}: {word} is no JSON number")

    try:
        value = json.loads(line, parse_constant=constant)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"line {number} is no JSON: {line[:60]!r}") from error
    if not isinstance(value, dict):
        raise Malformed(f"line {number} is no JSON object: {line[:60]!r}")
    return value


def ndjson(text: bytes, kind: str = "fba") -> list[Frame]:
    """The frames of a stream of a kind. Rules: CNF-1, CNF-2. Raises Malformed."""
    lines = _lines(text)
    header = _object(lines[0], 1)
    if header.get("format") != "snhc-decoded" or header.get("kind") != kind:
        raise Malformed(f"line 1 is no snhc-decoded header of kind {kind}: {lines[0][:80]!r}")
    if header.get("version") != VERSION or not _is_integer(header["version"]):
        raise Malformed(f"snhc-decoded version {shown(header.get('version'))}, known is {VERSION}")
    frames: list[Frame] = []
    for number, line in enumerate(lines[1:], 2):
        frame = _object(line, number)
        fault = _FAULTS[kind](frame)
        if fault:
            raise Malformed(f"line {number}: {fault}")
        frames.append(frame)
    return frames


def _is_integer(value: object) -> bool:
    return type(value) is int


def _head_fault(frame: Mapping[str, Any], keys: tuple[str, ...]) -> str:
    missing = [key for key in keys if key not in frame]
    if missing:
        return f"no {', '.join(missing)}"
    if not _is_integer(frame["index"]):
        return f"index is {shown(frame['index'])}, not an integer"
    if "time" in keys and (not isinstance(frame["time"], str) or not _TIME.fullmatch(frame["time"])):
        return f'time is {shown(frame["time"])}, not "p/q"'
    if "intra" in keys and not isinstance(frame["intra"], bool):
        return f"intra is {shown(frame['intra'])}, not true or false"
    return ""


def _mesh_fault(frame: Mapping[str, Any]) -> str:
    fault = _head_fault(frame, ("index", "time", "intra", "nodes"))
    if fault:
        return fault
    for key, size in (("nodes", 2), ("triangles", 3)):
        rows = frame.get(key, [])
        if not isinstance(rows, list) or not all(
            isinstance(row, list) and len(row) == size and all(map(_is_integer, row)) for row in rows
        ):
            return f"{key} is not a list of {size} integers each"
    order = frame.get("order", [])
    if not isinstance(order, list) or not all(map(_is_integer, order)):
        return "order is not a list of integers"
    return ""


def _is_number(value: object) -> bool:
    # Beyond the range of float64 an integer cannot be compared with a float.
    return (type(value) is float and isfinite(value)) or (type(value) is int and abs(value) < 1 << 1000)


def _vertices_fault(frame: Mapping[str, Any]) -> str:
    fault = _head_fault(frame, ("index", "time", "meshes"))
    if fault:
        return fault
    if not isinstance(frame["meshes"], dict):
        return "meshes is not an object"
    for name, points in frame["meshes"].items():
        if not isinstance(points, list) or not all(
            isinstance(point, list) and len(point) == 3 and all(map(_is_number, point)) for point in points
        ):
            return f"mesh {name[:40]!r} is not a list of 3 numbers each"
    return ""


def _units_fault(frame: Mapping[str, Any]) -> str:
    fault = _head_fault(frame, ("index", "units", "faps"))
    if fault:
        return fault
    units, faps = frame["units"], frame["faps"]
    if not isinstance(units, dict) or not all(map(_is_number, units.values())):
        return "units is not an object of numbers"
    if not isinstance(faps, list) or not all(value is None or _is_number(value) for value in faps):
        return "faps is not a list of numbers and nulls"
    return ""


def _frame_fault(frame: Mapping[str, Any]) -> str:
    fault = _head_fault(frame, ("index", "time", "intra", "faps", "viseme", "expression", "state"))
    if fault:
        return fault
    faps = frame["faps"]
    if not isinstance(faps, list) or len(faps) != _FAPS:
        return "faps is not a list of 68"
    for number, value in enumerate(faps, 1):
        if value is not None and not _is_integer(value):
            return f"FAP {number} is {shown(value)}, neither integer nor null"
    for name, keys in (("viseme", VISEME_KEYS), ("expression", EXPRESSION_KEYS)):
        value = frame[name]
        if value is not None and not (isinstance(value, dict) and all(_is_integer(value.get(key)) for key in keys)):
            return f"{name} is not null, nor integers {', '.join(keys)}"
    if not isinstance(frame["state"], str) or not _STATE.fullmatch(frame["state"]):
        return "state is not 68 letters"
    return ""


_FAULTS: Final[dict[str, Callable[[Mapping[str, Any]], str]]] = {
    "fba": _frame_fault, "faces": _frame_fault, "mesh": _mesh_fault, "vertices": _vertices_fault, "fapu": _units_fault,
}  # fmt: skip


def csv_rows(text: bytes) -> list[Frame]:
    """The frames of a face stream in this project's CSV. Rules: CNF-25. Raises Malformed."""
    try:
        rows = list(csv.reader(_lines(text)))
    except csv.Error as error:
        raise Malformed(f"output is no CSV: {error}") from error
    if tuple(rows[0]) != CSV_COLUMNS:
        raise Malformed("line 1 is not the row of column names")
    frames: list[Frame] = []
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(CSV_COLUMNS):
            raise Malformed(f"line {number}: {len(row)} cells, {len(CSV_COLUMNS)} columns")
        cells = dict(zip(CSV_COLUMNS, row, strict=True))
        frame = _csv_frame(cells, number)
        fault = _frame_fault(frame)
        if fault:
            raise Malformed(f"line {number}: {fault}")
        frames.append(frame)
    return frames


def _csv_frame(cells: Mapping[str, str], number: int) -> Frame:
    def cell(column: str) -> int | None:
        text = cells[column]
        if text and not _INTEGER.fullmatch(text):
            raise Malformed(f"line {number}: {column} is {shown(text)}, not an integer")
        return int(text) if text else None

    def group(name: str, keys: tuple[str, ...]) -> dict[str, int | None] | None:
        values = {key: cell(f"{name}_{key}") for key in keys}
        return None if all(value is None for value in values.values()) else values

    frame: dict[str, Any] = {
        "index": cell("index"), "time": cells["time"], "intra": {"0": False, "1": True}.get(cells["intra"]),
        "faps": [None, None, *(cell(f"fap_{fap}") for fap in range(3, _FAPS + 1))],
        "viseme": group("viseme", VISEME_KEYS), "expression": group("expression", EXPRESSION_KEYS),
        "state": cells["state"],
    }  # fmt: skip
    for name in ("gender", "coding_type", "fap_quant"):
        if cells[name]:
            frame[name] = cell(name)
    if cells["baps"]:
        pairs = [pair.partition(":") for pair in cells["baps"].split(" ")]
        if not all(_INTEGER.fullmatch(number_) and _INTEGER.fullmatch(value) for number_, _, value in pairs):
            raise Malformed(f"line {number}: baps is {cells['baps'][:40]!r}, not number:value pairs")
        frame["baps"] = {number_: int(value) for number_, _, value in pairs}
    return frame


def fap_text(text: bytes) -> list[FapTextFrame]:
    """The frames of a `.fap` text. Rules: FBA-50. Raises Malformed."""
    if not text:
        raise Malformed("no output")
    try:
        return list(FapReader(io.BytesIO(text)))
    except SnhcError as error:
        raise Malformed(f"output is no .fap text: {error}") from error


def document_fap(lines: Sequence[str]) -> list[FapTextFrame]:
    """Decoded lines of a coefficient document as the frames of a `.fap` text. Rules: FBA-54, DCT-13."""
    out: list[FapTextFrame] = []
    for line in lines:
        frame = json.loads(line)
        mask = tuple(int(letter == "T") for letter in frame["state"])
        values = [value if sent else None for value, sent in zip(frame["faps"], mask, strict=True)]
        out.append(FapTextFrame(frame["index"], mask, values))
    return out
