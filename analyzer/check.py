"""Checks of an input: its findings. What kind of input it is, its content tells.

Rules: CNF-2 (recognised by content), CNF-23, FAC-1, FAC-2, FAC-3, FAC-7, FAT-11, FIT-9.
Profiles and levels: `profiles`.

    JSON with `points`                 face definition: locations, neutral face, missing points
    JSON with `tables` or `meshes`     model with face animation tables
    JSON with FIT field names          FAP interpolation table
    text `g.n x y z m.v`               face definition
    text with a `.fap` header          FAP text
    node text that begins with FIT     FAP interpolation table
    other node text                    model with face animation tables
    anything else                      a stream: what its decoding finds, and negative values of unidirectional FAPs
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.bitstream.source import Source, open_source
from snhc.reference_impl.documents.kinds import HEAD_BYTES, hint, kind_of_input
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.systems.stream import DEFAULT_OPTIONS, Options, decode_planes

if TYPE_CHECKING:
    from snhc.reference_impl.interpolation.fit import FitReadings
    from snhc.reference_impl.tables import ProfileLevel

    from .policy import Policy
    from .profiles import LevelReport

Report = Callable[[Finding], None]
_OUTSIDE: Final = "profile-tool"
_PIECE: Final = 1 << 16

_PROPERTIES: Final = {"points": "face", "tables": "model", "meshes": "model", "FAPs": "fit", "Graph": "fit"}
_DOCUMENTS: Final = f"a document with one of {', '.join(_PROPERTIES)}"


@dataclass(frozen=True, slots=True)
class Checked:
    """What was checked. Rules: CNF-2, SYS-10. `kind`: of the input; `levels`: of a stream, where they were wanted."""

    kind: str
    levels: LevelReport | None = None


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """What a check may be told.

    Rules: CNF-23, SYS-10. `tolerance`: of places of feature points in model units, None: 2 % of ES0. `stream`: how a
    stream is read. `levels`: hold a stream against `profile`, None: the one that it signals. `policies`: further rules
    for streams. `folder`: where the face definition that a model may name stands; None: it may name none.
    """

    tolerance: float | None = None
    stream: Options = DEFAULT_OPTIONS
    limits: Limits = DEFAULT_LIMITS
    strict: bool = False
    levels: bool = False
    profile: ProfileLevel | None = None
    policies: tuple[Policy, ...] = ()
    folder: Path | None = None


DEFAULT_CHECK: Final = CheckOptions()


def kind_of_text(head: bytes) -> str:
    """`json`, `fdp`, `fap`, `fit` or `model` (node text), or `stream`, by the first bytes of an input. Rules: CNF-2."""
    if head.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{":
        return "json"
    kind = kind_of_input(head)
    return kind if kind in ("fdp", "fap", "fit", "model") else "stream"


def check_input(stream: BinaryIO, report: Report, options: CheckOptions = DEFAULT_CHECK) -> Checked:
    """Report all findings of an input; returns what it is: `face`, `model`, `fit`, `fap` or `stream`.

    Rules: CNF-2, CNF-22, CNF-23. `stream`: opened in binary mode, at its beginning. Raises what reading it raises.
    """
    # Not `peek`: of a pipe it shows what has come so far.
    source = open_source(stream)
    kind = kind_of_text(source.read_at(0, HEAD_BYTES))
    limits = options.limits
    if kind == "json":
        return Checked(_check_json(source.read_at(0, limits.json_bytes + 1), report, options))
    if kind == "fit":
        from snhc.reference_impl.interpolation.fit import parse_fit

        data = source.read_at(0, limits.json_bytes + 1)
        parse_fit(
            data, _fit_readings(options), max_sets=limits.fit_sets, max_links=limits.fit_links, limit=limits.json_bytes
        )
        return Checked(kind)
    if kind == "model":
        from .face_scene import read_model

        read_model(source.read_at(0, limits.json_bytes + 1), options.folder, limits, report)
        return Checked(kind)
    if kind == "fdp":
        from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES
        from snhc.reference_impl.model.face_definition import parse_fdp

        definition, findings = parse_fdp(source.read_at(0, MAX_JSON_BYTES + 1))
        for finding in (*findings, *_face_findings(definition, options)):
            report(finding)
        return Checked("face")
    if kind == "fap":
        from snhc.reference_impl.face.fap_text import FapReader

        reader = FapReader(_pieces(source), strict=options.strict, limits=limits)
        for _ in reader:
            pass
        for finding in reader.findings():
            report(finding)
        return Checked("fap")
    return Checked("stream", _check_stream(source, report, options))


def _pieces(source: Source) -> Iterator[bytes]:
    offset = 0
    while piece := source.read_at(offset, _PIECE):
        yield piece
        offset += len(piece)


def _check_json(data: bytes, report: Report, options: CheckOptions) -> str:
    from snhc.reference_impl.documents.json_text import as_object, parse_json

    known = hint(data[:HEAD_BYTES], "json")
    if known:
        raise InputFormat("CNF-2", "document", value=data[:4].hex(), allowed=f"{_DOCUMENTS}; {known}")
    root = as_object(parse_json(data, rule="CNF-2", what="document", limit=options.limits.json_bytes), "", "CNF-2")
    kind = next((kind for key, kind in _PROPERTIES.items() if key in root), "")
    if not kind:
        raise InputFormat("CNF-2", "document", value=", ".join(list(root)[:5])[:60], allowed=_DOCUMENTS)
    if kind == "face":
        from snhc.reference_impl.model.face_definition import face_definition_from_json

        for finding in _face_findings(face_definition_from_json(root), options):
            report(finding)
    elif kind == "model":
        from .face_scene import model_from_json

        model_from_json(root, options.folder, options.limits)
    else:
        from snhc.reference_impl.interpolation.fit_table import fit_from_json

        limits, impulse = options.limits, _fit_readings(options).impulse
        fit_from_json(root, impulse=impulse, max_sets=limits.fit_sets, max_links=limits.fit_links)
    return kind


def _fit_readings(options: CheckOptions) -> FitReadings:
    from .face_lines import fit_readings

    return fit_readings(options.stream.readings)


def _face_findings(definition: object, options: CheckOptions) -> Iterator[Finding]:
    from snhc.reference_impl.model.face_checks import check_locations, check_neutral, missing_points
    from snhc.reference_impl.model.face_definition import FaceDefinition

    assert isinstance(definition, FaceDefinition)
    missing = missing_points(definition)
    if missing:
        names = ", ".join(missing[:12]) + (", ..." if len(missing) > 12 else "")
        text = f"{len(missing)} of 84 points are not given: {names}"
        yield Finding("face-point-missing", "info", "FAC-2", text, path="points")
    reading = options.stream.readings.chosen.get("AMB-FAC-1", "anatomy")
    for check in check_locations(definition, tolerance=options.tolerance, reading=reading):
        yield check.finding
    for check in check_neutral(definition, tolerance=options.tolerance):
        yield check.finding


def _check_stream(source: Source, report: Report, options: CheckOptions) -> LevelReport | None:
    from snhc.reference_impl.model.feature_motion import unidirectional_findings

    outside: set[tuple[int, int] | None] = set()

    def reported(finding: Finding) -> None:
        if finding.id == _OUTSIDE:
            outside.add(finding.bits)
        report(finding)

    for plane in decode_planes(source, options.stream, reported):
        for frame in plane.frames:
            if isinstance(frame, FaceFrame):
                sent = [v if s == "T" else None for v, s in zip(frame.faps, frame.state, strict=True)]
                for finding in unidirectional_findings(sent, frame.index):
                    report(finding)
    if options.policies:
        from .policy import check_policy

        for policy in options.policies:
            check_policy(source, policy, report, options.stream)
    if not options.levels:
        return None
    from .profiles import check_profile

    def further(finding: Finding) -> None:
        # What the object that was decoded holds has been reported; the levels are about all of them.
        if finding.id == _OUTSIDE and finding.bits not in outside:
            report(finding)

    levels = check_profile(source, options.stream, options.profile, further)
    for finding in levels.findings:
        report(finding)
    return levels
