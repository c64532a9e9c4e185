"""The manifest: one entry per vector, with its files and what is expected of a decoder.

Rules: CNF-3, CNF-5, CNF-25, CNF-26. The form is `manifest.schema.json`; beyond the fields of CNF-3 an entry has `tier`
(CNF-5), `description` (the published documentation, CNF-4) and `options` (what a decoder must be told: CNF-26). The
input of a vector may be two files: a table (`input`) and the frames that it is used on (`input.aux`). Faults of
documents have a `path`, a `line`, or both, instead of `bits` (CNF-25). `check`: what a checker of profiles and levels
must say of the stream (SYS-8..12), where the vector is about that.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat, cause
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Readings
from snhc.reference_impl.systems.stream import Options

FORMAT: Final = "snhc-manifest"
VERSION: Final = 1
SCHEMA_FILE: Final = Path(__file__).parent / "manifest.schema.json"
MANIFEST_NAME: Final = "manifest.json"
# An editable install is a tree of links: the suite is where they lead, so that new files come to stand there too.
SUITE: Final = (Path(__file__).parent / "suite" / MANIFEST_NAME).resolve().parent
TIERS: Final = ("syntax", "semantic", "stress", "error", "real", "profile")
KINDS: Final = ("valid", "invalid", "ambiguous")
REJECT: Final = "reject"
CONCEAL: Final = "conceal"
ACCEPTABLE: Final = (REJECT, CONCEAL)
DCT_COEFFICIENTS: Final = "dctcoef"
FIT: Final = "fit"
FAT: Final = "fat"
FACE: Final = "face"
FAP: Final = "fap"
BAP: Final = "bap"
# What a decoder can claim (CNF-13): a vector names the tools that it needs.
TOOLS: Final = ("fba", "bap", "systems", "dct-p1", "dctcoef", "mesh", "fit", "fat", "fapu", "fap-text", "bap-text")
DOCUMENTS: Final = (DCT_COEFFICIENTS, FIT, FAT, FACE, FAP, BAP)
"""The media that are no bitstreams: coefficients, tables (with frames as `aux`), face definitions, parameter texts."""


@dataclass(frozen=True, slots=True)
class DecodeOptions:
    """What a decoder must be told to decode a vector. Rules: FBA-4, FBA-44, CNF-26.

    `draft`: take the start codes of the drafts. `strict`: bytes behind the end are an error. `object_number`: which
    object. `limits`: lowered limits by name.
    """

    draft: bool = False
    strict: bool = False
    object_number: int = 0
    limits: Mapping[str, int] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """The manifest's `options`; only what differs from the default."""
        out: dict[str, Any] = {}
        if self.draft:
            out["compat"] = "draft"
        if self.strict:
            out["strict"] = True
        if self.object_number:
            out["object"] = self.object_number
        if self.limits:
            out["limits"] = dict(sorted(self.limits.items()))
        return out

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> DecodeOptions:
        """The options of a manifest entry."""
        return cls(
            data.get("compat") == "draft", bool(data.get("strict", False)), int(data.get("object", 0)),
            dict(data.get("limits", {})),
        )  # fmt: skip

    def for_decoder(self, readings: Readings = DEFAULT_READINGS) -> Options:
        """The same for the reference decoder."""
        limits = DEFAULT_LIMITS.with_values(dict(self.limits))
        return Options(self.draft, self.strict, self.object_number, limits, readings)


@dataclass(frozen=True, slots=True)
class Accepted:
    """The stream decodes to a file. Rules: CNF-3. `kind`: the kind of CNF-1; `file`: relative to the suite."""

    kind: str
    file: str
    sha256: str

    def as_json(self) -> dict[str, Any]:
        """The manifest's `expect`."""
        return {"accept": {"kind": self.kind, "file": self.file, "sha256": self.sha256}}


@dataclass(frozen=True, slots=True)
class Rejected:
    """The stream has a fault. Rules: CNF-3, CNF-7, CNF-21, CNF-25.

    `bits`: half-open span, None for documents: they have the `path` of the fault ("" where there is none), its `line`
    (None where there is none), or both. `allowed`: `reject`, and `conceal` where a decoder may go on: it then gives at
    least the lines before the fault.
    """

    error_class: str
    rule: str
    bits: tuple[int, int] | None = None
    allowed: tuple[str, ...] = (REJECT,)
    path: str = ""
    line: int | None = None

    @property
    def place(self) -> str:
        """Where the fault is, in words."""
        if self.bits is not None:
            return f"bits [{self.bits[0]}, {self.bits[1]})"
        return " of ".join(
            [*([self.path] if self.path else []), *([f"line {self.line}"] if self.line is not None else [])]
        )

    def as_json(self) -> dict[str, Any]:
        """The manifest's `expect`."""
        out: dict[str, Any] = {"class": self.error_class, "rule": self.rule}
        if self.bits is not None:
            out["bits"] = list(self.bits)
        if self.path:
            out["path"] = self.path
        if self.line is not None:
            out["line"] = self.line
        return {"reject": {**out, "allowed": list(self.allowed)}}


Expect = Accepted | Rejected


def expect_from_json(data: Mapping[str, Any]) -> Expect:
    """An `expect` of the manifest. Rules: CNF-3."""
    if "accept" in data:
        return Accepted(**data["accept"])
    reject = data["reject"]
    bits = (reject["bits"][0], reject["bits"][1]) if "bits" in reject else None
    return Rejected(
        reject["class"], reject["rule"], bits, tuple(reject["allowed"]), reject.get("path", ""), reject.get("line")
    )


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far a decoder may be off. Rules: CNF-3, CNF-16, DCT-8.

    `model`: `dct-8` (`bound`: from the reference before rounding, FAP units) or `geometry` (`bound`: of every float,
    in its own unit). `version`: of the model.
    """

    model: str
    version: int
    bound: float

    def as_json(self) -> dict[str, str | int | float]:
        """The manifest's `tolerance`."""
        return {"model": self.model, "version": self.version, "bound": self.bound}


@dataclass(frozen=True, slots=True)
class Entry:
    """One vector. Rules: CNF-3.

    `readings`: AMB id -> reading -> what is expected under it, for vectors of kind `ambiguous`. `tolerance`: None where
    a decoder must give exactly what is expected. `aux`, `aux_sha256`: the second input file, "" where there is none.
    """

    id: str
    title: str
    description: str
    kind: str
    tier: str
    tools: tuple[str, ...]
    profile: str | None
    rules: tuple[str, ...]
    features: tuple[str, ...]
    value_classes: tuple[str, ...]
    file: str
    sha256: str
    media: str
    options: DecodeOptions
    expect: Expect
    readings: Mapping[str, Mapping[str, Expect]]
    provenance: Mapping[str, Any]
    notes: str
    since: str
    tolerance: Tolerance | None = None
    aux: str = ""
    aux_sha256: str = ""
    check: Mapping[str, Any] | None = None

    def files(self) -> dict[str, str]:
        """All files of the vector, with their sha256. Rules: CNF-3."""
        expects = [self.expect, *(expect for readings in self.readings.values() for expect in readings.values())]
        out = {self.file: self.sha256} | ({self.aux: self.aux_sha256} if self.aux else {})
        return out | {expect.file: expect.sha256 for expect in expects if isinstance(expect, Accepted)}

    def as_json(self) -> dict[str, Any]:
        """The manifest entry."""
        files: dict[str, Any] = {"file": self.file, "sha256": self.sha256, "media": self.media}
        if self.aux:
            files["aux"] = {"file": self.aux, "sha256": self.aux_sha256}
        out = {
            "id": self.id,
            "title": self.title,
            "description": self.description,
            "kind": self.kind,
            "tier": self.tier,
            "tools": list(self.tools),
            "profile": self.profile,
            "rules": list(self.rules),
            "features": list(self.features),
            "value_classes": list(self.value_classes),
            "input": files,
            "options": self.options.as_json(),
            "expect": self.expect.as_json(),
            "tolerance": None if self.tolerance is None else self.tolerance.as_json(),
            "readings": {
                amb: {key: expect.as_json() for key, expect in readings.items()}
                for amb, readings in self.readings.items()
            },
            "provenance": dict(self.provenance),
            "notes": self.notes,
            "since": self.since,
        }
        if self.check is not None:
            out["check"] = dict(self.check)
        return out

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Entry:
        """An entry of a manifest that fits the schema."""
        aux = data["input"].get("aux", {})
        tolerance = data["tolerance"]
        return cls(
            data["id"], data["title"], data["description"], data["kind"], data["tier"], tuple(data["tools"]),
            data["profile"], tuple(data["rules"]), tuple(data["features"]), tuple(data["value_classes"]),
            data["input"]["file"], data["input"]["sha256"], data["input"]["media"],
            DecodeOptions.from_json(data["options"]), expect_from_json(data["expect"]),
            {
                amb: {key: expect_from_json(expect) for key, expect in readings.items()}
                for amb, readings in data["readings"].items()
            },
            data["provenance"], data["notes"], data["since"],
            None if tolerance is None else Tolerance(**tolerance), aux.get("file", ""), aux.get("sha256", ""),
            data.get("check"),
        )  # fmt: skip


def read_files(entry: Entry, suite: Path) -> dict[str, bytes]:
    """The files of a vector by name. Rules: CNF-3. Raises InputFormat for one that is missing or has another sha256."""
    out = {}
    for name, checksum in entry.files().items():
        # By its name alone: in a tree of links (an editable install) every file really lies elsewhere.
        pure = PurePosixPath(name)
        if pure.is_absolute() or ".." in pure.parts or not (suite / name).is_file():
            raise InputFormat("CNF-3", f"{entry.id}: file", value=name, allowed="a file of the suite")
        out[name] = (suite / name).read_bytes()
        if sha256(out[name]).hexdigest() != checksum:
            raise InputFormat("CNF-3", f"{entry.id}: {name}", value="another content", allowed=f"sha256 {checksum}")
    return out


@dataclass(frozen=True, slots=True)
class Tombstone:
    """An id that is used up. Rules: CNF-3. `removed`: the suite version that dropped it."""

    id: str
    removed: str
    reason: str


@dataclass(frozen=True, slots=True)
class Manifest:
    """All vectors of a suite, by id. Rules: CNF-3."""

    suite: str
    entries: tuple[Entry, ...]
    tombstones: tuple[Tombstone, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The document."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "suite": self.suite,
            "tombstones": [{"id": t.id, "removed": t.removed, "reason": t.reason} for t in self.tombstones],
            "vectors": [entry.as_json() for entry in self.entries],
        }

    def text(self) -> str:
        """The file's content."""
        return json.dumps(self.as_json(), ensure_ascii=False, indent=1) + "\n"


def validate(document: object) -> None:
    """Hold a document against the schema. Rules: CNF-3. Raises InputFormat with the path of the first misfit."""
    import jsonschema

    schema = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
    errors = sorted(
        jsonschema.Draft202012Validator(schema).iter_errors(document), key=lambda error: [str(p) for p in error.path]
    )
    if errors:
        error = errors[0]
        raise InputFormat(
            "CNF-3", "manifest", value=error.message, allowed="what the schema says", path=error.json_path
        )


def load(suite: Path = SUITE, *, check_schema: bool = True, name: str = MANIFEST_NAME) -> Manifest:
    """The manifest of a suite. Rules: CNF-3. `name`: of its file.

    Raises InputFormat for one that is missing, that is no JSON, or that does not fit the schema.
    """
    path = suite / name
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise InputFormat("CNF-3", "manifest", value=cause(error), allowed="a readable manifest.json") from error
    if check_schema:
        validate(document)
        ids = Counter(entry["id"] for entry in document["vectors"])
        twice = [id for id, count in ids.items() if count > 1]
        if twice:
            raise InputFormat("CNF-3", "manifest", value=f"{twice[0]} twice", allowed="ids of one vector each")
    return Manifest(
        document["suite"],
        tuple(sorted((Entry.from_json(entry) for entry in document["vectors"]), key=lambda entry: entry.id)),
        tuple(Tombstone(**entry) for entry in document["tombstones"]),
    )
