"""What is fuzzed: every reader of something that a stranger wrote, with the law that holds for any input.

A law takes bytes. It returns, or raises AssertionError or whatever a bug raises: that is a finding. Refusals are part
of the law: which error class a reader may raise, and what the error must say.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from fba_helpers import SAMPLES
from fuzz_law import check_bytes, check_mode

from snhc.analyzer.check import CheckOptions, check_input
from snhc.analyzer.diff.compare import compare
from snhc.analyzer.dump import TreeOptions, dump_tree
from snhc.analyzer.dump_csv import dump_csv
from snhc.analyzer.dump_encode import encode_dump
from snhc.analyzer.dump_json import dump_json
from snhc.analyzer.parts import Parts
from snhc.analyzer.policy import load_policy
from snhc.analyzer.query import Query, QueryError
from snhc.conformance.adapters import file as adapter_file
from snhc.conformance.adapters import messages
from snhc.conformance.candidate import Malformed, csv_rows, fap_text, ndjson
from snhc.conformance.filters import selector
from snhc.reference_impl.bitstream.errors import SnhcError
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.face.bap_text import read_bap, write_bap
from snhc.reference_impl.face.coefficients import decode_document, parse_document
from snhc.reference_impl.face.epf_text import read_epf, write_epf
from snhc.reference_impl.face.fap_text import read_fap, write_fap
from snhc.reference_impl.interpolation.fit_table import parse_fit_json
from snhc.reference_impl.interpolation.fit_text import parse_fit_text
from snhc.reference_impl.mesh.document import read_mesh_document
from snhc.reference_impl.model.face_definition import parse_face_definition_json, parse_fdp
from snhc.reference_impl.model.fat_json import parse_fat_json
from snhc.reference_impl.model.fat_text import parse_fat_text
from snhc.reference_impl.systems.stream import Options, trace_stream
from snhc.vectors.manifest import SUITE, validate

Law = Callable[[bytes], None]
TOP = Path(__file__).parents[2]
# A uniform mesh of ten bytes may have a million nodes; what that costs is a law of limits, not of readers.
FEW = Limits(mesh_nodes_uniform=400, mesh_nodes_delaunay=200, fat_vertices=500, fit_sets=32, fit_links=64)


@dataclass(frozen=True, slots=True)
class Target:
    """Something to be fuzzed.

    `share`: of all inputs of a campaign, in parts. `streams`: inputs are visual streams. `pumped_to`: bytes of the long
    inputs, in which one part is repeated.
    """

    name: str
    law: Law
    seeds: Callable[[], Iterable[bytes]]
    share: int
    longest: int = 256
    streams: bool = False
    pumped_to: tuple[int, ...] = (2_000, 8_000, 30_000)


def _located(error: SnhcError, data: bytes) -> None:
    """A refusal of text: class, rule, what is allowed, and a place where it has one."""
    assert error.rule and (error.allowed or error.expected is not None), error
    assert error.bits is None or 0 <= error.bits[0] <= error.bits[1] <= 8 * len(data)
    assert error.line is None or error.line >= 1
    json.dumps(error.as_json())
    assert "\n" not in str(error), "an error is one line"


def refusing(read: Callable[[bytes], object], *refusals: type[Exception]) -> Law:
    """The law of a reader: it reads, or refuses in the way that it says it does."""

    def law(data: bytes) -> None:
        try:
            read(data)
        except SnhcError as error:
            _located(error, data)
        except refusals as error:
            assert str(error)

    return law


# -- streams -----------------------------------------------------------------------------------------------------------

_STARTS = (
    "000001ba", "000001ba7f000001bb", "000001b063000001b523000001ba", "000001b59147000001b2610000", "00000101",
    "000001bab1900192492e92000000049405172f000001b1",
    "000001baa05ec00049249241661efce13a1267aa200e7ec26f000001b1",
    "000001baa032c0004d01279200fd9f553f600a7e49fe9483ff7ff2a032a0004c81249201028d85019a000249249007e97f000001b1",
)  # fmt: skip


def _small(kinds: Iterable[str], longest: int, suffix: str = "input.*") -> list[bytes]:
    paths = [path for kind in kinds for path in sorted((SAMPLES / kind).glob(f"*/{suffix}"))]
    return [data for path in paths if len(data := path.read_bytes()) <= longest]


def face_seeds() -> list[bytes]:
    """Start codes, worked examples, small cases, small vectors."""
    vectors = [path.read_bytes() for path in sorted((SUITE / "fap").glob("*.fba")) if path.stat().st_size <= 120]
    return [bytes.fromhex(start) for start in _STARTS] + _small(("fba", "neg", "dct"), 256) + vectors[:150]


def mesh_seeds() -> list[bytes]:
    """Small meshes."""
    vectors = [path.read_bytes() for path in sorted((SUITE / "mesh").glob("*.m2d")) if path.stat().st_size <= 200]
    return _small(("mesh", "meshtie"), 256) + vectors


def _mesh(data: bytes) -> None:
    check_mode(data, Options(limits=FEW))


def _dump(data: bytes) -> None:
    """Every form of the dump; what decodes encodes again from its dump."""
    options = Options(limits=FEW)
    source = BytesSource(data)

    def parts(symbols: bool = True) -> Parts:
        return Parts(trace_stream(source, options, symbols=symbols))

    try:
        found = parts()
    except SnhcError as error:
        _located(error, data)
        return
    for _ in dump_tree(found, source, TreeOptions(symbols=True)):
        pass
    for _ in dump_csv(parts(), source, symbols=True):
        pass
    last = parts()
    text = "".join(dump_json(last, source, options, symbols=True))
    json.loads(text)
    if last.error is None:
        assert encode_dump(text.encode(), limits=FEW) == data


def _check(data: bytes) -> None:
    check_input(io.BytesIO(data), lambda finding: json.dumps(finding.as_json()) and None, _CHECK)


_CHECK = CheckOptions(stream=Options(limits=FEW), limits=FEW, levels=True)


def _diff(data: bytes) -> None:
    """Two inputs, cut at a byte that the first one names."""
    at = data[0] if data else 0
    a, b = BytesSource(data[1 : 1 + at]), BytesSource(data[1 + at :])
    there = compare(a, b, Options(limits=FEW))
    back = compare(b, a, Options(limits=FEW))
    json.dumps(there.as_json())
    assert there.equal == back.equal
    if data[1 : 1 + at] == data[1 + at :] and there.error is None:
        assert there.equal


def _diff_seeds() -> list[bytes]:
    seeds = [seed for seed in (*face_seeds(), *mesh_seeds(), *_frames_seeds()) if len(seed) < 128]
    return [bytes([len(a)]) + a + b for a, b in zip(seeds, (*seeds[:1], *seeds[2:], seeds[0]), strict=True)]


# -- text --------------------------------------------------------------------------------------------------------------

_FAP = (
    b"2.1 name 25 2\n" + b"0 " * 2 + b"1 " * 4 + b"0 " * 62 + b"\n0 1 2 3 4\n" + b"1 " * 2 + b"0 " * 66
    + b"\n1 1 2 63 0 1 2 3 4 0 1\n"
)  # fmt: skip


def _frames(record: object) -> object:
    return getattr(record, "frames", record)


def _fap(data: bytes) -> None:
    first = read_fap(io.BytesIO(data), limits=FEW)
    again = read_fap(io.BytesIO(b"".join(write_fap(first))), limits=FEW)
    assert again.frames == first.frames
    assert again.frame_rate == first.frame_rate


def _bap(data: bytes) -> None:
    first = read_bap(io.BytesIO(data), limits=FEW)
    assert _frames(read_bap(io.BytesIO(b"".join(write_bap(first))), limits=FEW)) == _frames(first)


def _epf(data: bytes) -> None:
    first = read_epf(io.BytesIO(data), limits=FEW)
    assert _frames(read_epf(io.BytesIO(b"".join(write_epf(first))), limits=FEW)) == _frames(first)


def _corpus(pattern: str, longest: int = 4_000) -> list[bytes]:
    return [path.read_bytes() for path in sorted(SUITE.glob(pattern)) if path.stat().st_size <= longest]


def _documents(data: bytes) -> None:
    """Every reader of documents gets the same bytes; each refuses or reads."""
    for read in (
        lambda: parse_fit_json(data, max_sets=32, max_links=64),
        lambda: parse_fat_json(data, max_vertices=500),
        lambda: parse_face_definition_json(data),
        lambda: read_mesh_document(data, limits=FEW),
        lambda: list(decode_document(parse_document(data))),
        lambda: encode_dump(data, limits=FEW),
    ):
        refusing(lambda _, read=read: read())(data)  # type: ignore[misc]


def _nodes(data: bytes) -> None:
    for read in (lambda: parse_fit_text(data), lambda: parse_fat_text(data), lambda: parse_fdp(data)):
        refusing(lambda _, read=read: read())(data)  # type: ignore[misc]


_NODES = (
    b"FIT { FAPs [ 3 -1 4 5 -1 ] Graph [ 0 1 ] numeratorTerms [ 1 1 ] denominatorTerms [ 0 0 ]\n"
    b" numeratorExp [ 1 1 ] numeratorCoefs [ 0.5 2 ] }\n",
    b"FDP { faceDefTables [ FaceDefTables { fapID 6 faceDefMesh [ FaceDefMesh { faceSceneGraphNode DEF m "
    b"IndexedFaceSet { coord Coordinate { point [ 0 0 0 1 0 0 0 1 0 ] } coordIndex [ 0 1 2 -1 ] }\n"
    b" intervalBorders [ -1000 0 500 ] coordIndex [ 1 ] displacements [ 1 0 0 0.9 0 0 ] } ] } ] }\n",
    b"2.1 0 0 0.5 7.1\n3.5 0.1 0.2 0.3 0.0\n# comment\n",
)


# -- messages, outputs and files of other people -----------------------------------------------------------------------

_ASKED = {"seq": 7, "type": "decode", "input": "x", "media": "fba", "format": "ndjson", "options": {}}
_HELLO = {"seq": 0, "type": "hello", "protocol": "snhc-adapter", "version": 1, "readings": {}}


def _answers(data: bytes) -> None:
    for asked in (_ASKED, _HELLO):
        try:
            message = messages.answer(data, asked)
        except messages.Misfit as error:
            assert str(error) and len(str(error)) < 1_000
            continue
        if asked is _HELLO:
            messages.claims(message)


def _answer_seeds() -> list[bytes]:
    return [
        json.dumps(message).encode()
        for message in (
            {"seq": 7, "type": "decode", "status": "accepted", "output": "x"},
            {"seq": 7, "type": "decode", "status": "rejected", "error": {"class": "MarkerBit", "bits": [3, 4]}},
            {"seq": 0, "type": "hello", "protocol": "snhc-adapter", "version": 1, "tools": ["fba"], "readings": []},
        )
    ]


def _outputs(data: bytes) -> None:
    for kind in ("fba", "mesh", "vertices", "faces", "fapu"):
        refusing(lambda text, kind=kind: ndjson(text, kind), Malformed)(data)  # type: ignore[misc]
    refusing(csv_rows, Malformed)(data)
    refusing(fap_text, Malformed)(data)


def _frames_seeds() -> list[bytes]:
    return [data[:3_000].rpartition(b"\n")[0] + b"\n" for data in _corpus("*/*.ndjson")[::20]]


def _in_file(read: Callable[[Path], object]) -> Law:
    """A reader of a file, whose file is this process's own."""
    import os
    import tempfile

    folder = Path("/dev/shm") if Path("/dev/shm").is_dir() else Path(tempfile.gettempdir())
    path = folder / f"snhc-fuzz-{os.getpid()}.toml"

    def law(data: bytes) -> None:
        path.write_bytes(data)
        try:
            read(path)
        finally:
            path.unlink()

    return law


def _adapter(path: Path) -> None:
    table = adapter_file.read(path)
    adapter_file.check(table, path.name)
    adapter_file.made(table, path)


def _ledger(path: Path) -> None:
    from snhc.conformance import ledger

    ledger.load(path)


def _files(data: bytes) -> None:
    for read in (_adapter, load_policy, _ledger):
        refusing(_in_file(read))(data)


_FILES = (
    b'name = "x"\ncommand = ["./x", "{input}"]\nformat = "fap"\ntimeout = 1.5\ntools = ["fba"]\n'
    b"[options]\ndraft = []\n",
    b'[[rule]]\nid = "a"\nexpression = "value > 15"\nmessage = "{value}"\nseverity = "info"\n',
    b'[[known]]\nvector = "fap.*"\nreason = "x"\nexpires = 2030-01-01\n',
)


def _expressions(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    refusing(lambda _: Query(text), QueryError)(data)
    refusing(lambda _: selector(text))(data)


_EXPRESSIONS = (
    b"name == 'fap_quant' && value > 15", b"kind == 'plane' && bits > 500", b"levels.exists(l, l < -3)",
    b"rule=FBA-25 !tier=stress fap.arith.*", b"path.matches('plane.[0-9]+') || raw.contains('0101')",
)  # fmt: skip


def _manifest(data: bytes) -> None:
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return
    validate(document)


def _manifest_seeds() -> list[bytes]:
    manifest = json.loads((SUITE / "manifest.json").read_text(encoding="utf-8"))
    out = []
    for entry in manifest["vectors"][::150]:
        out.append(json.dumps({**manifest, "vectors": [entry]}).encode())
    return out


TARGETS = {
    target.name: target
    for target in (
        Target("face", check_bytes, face_seeds, 4, streams=True),
        Target("mesh", _mesh, mesh_seeds, 2, streams=True),
        Target("dump", _dump, lambda: [*face_seeds(), *mesh_seeds()], 2, streams=True),
        Target("check", refusing(_check), lambda: [*face_seeds(), *mesh_seeds()], 2, streams=True),
        Target("diff", refusing(_diff), _diff_seeds, 1),
        Target("fap", refusing(_fap), lambda: [_FAP], 14, 600),
        Target("bap", refusing(_bap), lambda: [b"2.1 n 25 1\n" + b"1 0 " * 93 + b"\n0 " + b"5 " * 93 + b"\n"], 8, 900),
        Target("epf", refusing(_epf), lambda: [b"FBM 1\nFFR 0\nISI 1\nFRR 25 0 0\nFQU 3\nGDR 1\n"], 9, 400),
        Target("documents", _documents, lambda: _corpus("*/*.json")[:200], 12, 2_000),
        Target("nodes", _nodes, lambda: _NODES, 12, 600),
        Target("outputs", _outputs, _frames_seeds, 12, 2_000),
        Target("answers", _answers, _answer_seeds, 8, 400),
        Target("files", _files, lambda: _FILES, 4, 400),
        Target("expressions", _expressions, lambda: _EXPRESSIONS, 6, 200),
        Target("manifest", refusing(_manifest), _manifest_seeds, 4, 4_000),
    )
}
