"""What the tests of face streams share: fixtures by name, deep comparison of records, the laws of errors."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from snhc.reference_impl.bitstream.errors import ERROR_CLASSES, SnhcError
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.face.records import FbaObject, FbaPlane, ParameterData
from snhc.reference_impl.rules import rule
from snhc.reference_impl.syntax.temporal import TemporalHeader
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, decode_frames, is_object, trace_stream
from snhc.reference_impl.systems.visual import StreamItem, VisualObjectHeader

SAMPLES = Path(__file__).parent / "fixtures" / "samples"
RECORDS = (StreamItem, FbaObject, FbaPlane, ParameterData, TemporalHeader, VisualObjectHeader)

Json = dict[str, Any]


def case_names(kind: str, profile_prefix: str = "") -> list[str]:
    """Folder names of the cases of a kind whose profile begins so."""
    names = []
    for folder in sorted((SAMPLES / kind).iterdir()):
        case = json.loads((folder / "case.json").read_text())
        if case["profile"].startswith(profile_prefix):
            names.append(folder.name)
    return names


def case_files(kind: str, name: str) -> tuple[Json, bytes, list[Json]]:
    """(case.json, input, expected lines) of a case."""
    folder = SAMPLES / kind / name
    case: Json = json.loads((folder / "case.json").read_text())
    lines = [json.loads(line) for line in (folder / "expected.ndjson").read_text().splitlines()]
    return case, (folder / case["input"]).read_bytes(), lines


def fields_of(record: object) -> tuple[str, ...]:
    """Names of a record's fields, in either form: a compiled class keeps no `__slots__`."""
    kind = type(record)
    return tuple(getattr(kind, "__slots__", ()) or getattr(kind, "__mypyc_attrs__", ()))


def plain(value: object, *, spans: bool = True) -> object:
    """A record as nested tuples and dicts, for comparison; `spans` False leaves `start` and `end` bits out."""
    if isinstance(value, RECORDS):
        left_out = set() if spans or isinstance(value, FbaObject) else {"start", "end"}
        return {name: plain(getattr(value, name), spans=spans) for name in fields_of(value) if name not in left_out}
    if isinstance(value, list | tuple):
        return [plain(entry, spans=spans) for entry in value]
    return value


def frames_of(items: list[StreamItem]) -> list[Any]:
    """All frames that the planes of the first object hold."""
    for item in items:
        planes = item.fba.planes if item.fba is not None else item.mesh.planes if item.mesh is not None else None
        if planes is not None:
            return [frame for plane in planes for frame in plane.frames]
    return []


def traced(data: Any, options: Options = DEFAULT_OPTIONS) -> tuple[list[Any], list[Finding], SnhcError | None]:
    """(frames of the first object, all findings, error or None) as the tracer sees them."""
    frames: list[Any] = []
    findings: list[Finding] = []
    error = None
    first = None
    for part in trace_stream(data, options):
        findings += part.findings
        if first is None and part.item is not None and is_object(part.item):
            first = part.item
        if part.plane is not None and part.item is first:
            frames += part.plane.frames
        error = part.error
    return frames, findings, error


def decoded(data: Any, options: Options = DEFAULT_OPTIONS) -> tuple[list[Any], list[Finding], SnhcError | None]:
    """(frames, findings, error or None) of the first object as the decoder sees them."""
    frames: list[Any] = []
    findings: list[Finding] = []
    try:
        for frame in decode_frames(data, options, findings.append):
            frames.append(frame)
    except SnhcError as error:
        return frames, findings, error
    return frames, findings, None


def spans(data: Any, options: Options = DEFAULT_OPTIONS) -> Iterator[tuple[str, int, int, int, str]]:
    """(element name, start, end, value, path) of every row of a trace."""
    for part in trace_stream(data, options):
        for element, start, end, value, path in part.trace.rows():
            yield element.name, start, end, value, path


def check_partition(data: bytes, options: Options = DEFAULT_OPTIONS) -> None:
    """The spans of a trace follow each other without gap or overlap from bit 0 to the end of the data."""
    at = 0
    for name, start, end, _, path in spans(data, options):
        assert start == at, f"{path}.{name} begins at {start}, the row before ended at {at}"
        assert end > start or name in ("trailing_data", "user_data"), f"{path}.{name} has no bits"
        at = end
    assert at == 8 * len(data)


def check_error(error: SnhcError, bits: int) -> None:
    """A fault of a bitstream is located: class of CNF-7, registered rule, a span inside the data, something read."""
    assert type(error) is ERROR_CLASSES[error.error_class]
    assert rule(error.rule).id == error.rule
    assert error.bits is not None, f"{error} has no span"
    start, end = error.bits
    assert 0 <= start <= end <= bits, f"{error}: span outside [0, {bits})"
    # Only a missing end may be seen without a single bit of what is missing (CNF-21).
    assert end > start or error.error_class == "Truncated" or bits == 0, f"{error}: empty span"
    assert error.what and error.allowed, f"{error} does not say what was read and what is allowed"
    assert error.line is None and error.column is None
    message = str(error)
    assert message.startswith(f"{error.error_class}: {error.what}") and message.endswith(f"({error.rule})")
    json.dumps(error.as_json())


def key(error: SnhcError | None) -> object:
    """What two machines have to agree on about a fault."""
    return None if error is None else error.as_json()


def check_input(data: bytes, options: Options = DEFAULT_OPTIONS) -> SnhcError | None:
    """The law of bad input: a decode or one located fault, the same one from decoder and tracer; returns it.

    The tracer walks all objects, the decoder stops behind the first: behind it their verdicts may differ.
    """
    frames, findings, error = decoded(data, options)
    frames_traced, findings_traced, error_traced = traced(data, options)
    assert frames == frames_traced
    if error is not None:
        check_error(error, 8 * len(data))
    if error_traced is not None:
        check_error(error_traced, 8 * len(data))
    others = any(finding.id == "trailing-data" for finding in findings)
    if not others:
        assert key(error) == key(error_traced)
        assert findings == findings_traced
    for finding in findings + findings_traced:
        assert finding.bits is not None and 0 <= finding.bits[0] <= finding.bits[1] <= 8 * len(data)
    return error
