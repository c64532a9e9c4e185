"""Mesh documents, pictures and model files: what encodes, what comes out again, and every refusal with its place."""

from __future__ import annotations

import io
import json
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner, Result
from mesh_second_parser import SAMPLES, parse, sample_names
from PIL import Image

from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.mesh.document import read_mesh_document
from snhc.reference_impl.mesh.output import MODEL_FORMATS, MeshArrays, csv_header, csv_rows, model_bytes
from snhc.reference_impl.mesh.records import MeshFrame
from snhc.reference_impl.syntax.element import Readings
from snhc.reference_impl.systems.mesh_encoding import encode_mesh, encode_pictures
from snhc.reference_impl.systems.stream import Options, decode_frames, write_stream
from snhc.vectors.mesh_builders import delaunay, mesh_stream, moved, still, uniform

Json = dict[str, Any]
SQUARE = [[0, 0], [40, 0], [43, 41], [0, 40]]


def document(*frames: Json, **header: object) -> bytes:
    return json.dumps({"format": "snhc-mesh", "version": 1, "frames": list(frames), **header}).encode()


def coded(data: bytes, **options: Any) -> list[MeshFrame]:
    frames = decode_frames(write_stream(encode_mesh(read_mesh_document(data), **options)))
    return [frame for frame in frames if isinstance(frame, MeshFrame)]


# -- documents ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sample_names())
def test_decoded_lines_encode_to_the_same_frames(name: str) -> None:
    """All of them but the time, which starts anew where a stream's rate changes cannot be told from its times."""
    data = (SAMPLES / name / "expected.ndjson").read_bytes()
    frames = list(decode_frames((SAMPLES / name / "input.m2d").read_bytes()))
    document = read_mesh_document(data)
    assert [frame.time for frame in document] == [Fraction(*frame.time) for frame in frames]
    try:
        again = coded(data)
    except (EncodeError, InconsistentSemantics) as error:
        assert error.rule in ("FBA-37", "FBA-38", "FBA-6", "FBA-7")
        lines = [json.loads(line) for line in data.splitlines()]
        for line in lines[1:]:
            del line["time"]
        again = coded(b"\n".join(json.dumps(line).encode() for line in lines))
        assert [(frame.nodes, frame.triangles, frame.order) for frame in again] == [
            (frame.nodes, frame.triangles, frame.order) for frame in frames if isinstance(frame, MeshFrame)
        ]
    else:
        assert again == frames


def test_shortest_documents() -> None:
    cells = {"nodes_hor": 2, "nodes_vert": 2, "rect_hor": 5, "rect_vert": 6, "split_code": 1}
    grid = [[0, 0], [5, 0], [0, 6], [5, 6]]
    frames = coded(document({"nodes": grid, "uniform": cells}, {"nodes": [[0, 1], *grid[1:]]}))
    assert frames[0].triangles == ((0, 1, 2), (1, 3, 2))
    assert frames[1].nodes[0] == (0, 1)
    assert coded(document({"nodes": SQUARE, "boundary_count": 4}))[0].nodes == tuple(map(tuple, SQUARE))


def test_kind_and_boundary_are_found_from_the_triangles() -> None:
    ring = [*SQUARE, [11, 12], [29, 23]]
    triangles = [list(t) for t in coded(document({"nodes": ring, "boundary_count": 4}))[0].triangles or ()]
    items = encode_mesh(read_mesh_document(document({"nodes": ring, "triangles": triangles})))
    (plane,) = parse(write_stream(items))
    assert plane.boundary_count == 4
    for split in range(4):
        first = next(decode_frames(write_stream(mesh_stream(uniform(4, 3, 7, 9, split)))))
        assert isinstance(first, MeshFrame)
        items = encode_mesh(read_mesh_document(document({"nodes": first.nodes, "triangles": first.triangles})))
        (plane,) = parse(write_stream(items))
        assert plane.uniform == (4, 3, 7, 9, split)


def test_the_smallest_range_is_chosen() -> None:
    """The largest size decides, and the lower end of each range reaches one further."""
    for size, range_code in ((31, 1), (-32, 1), (32, 2), (-33, 2), (63, 2), (64, 3), (-2048, 7), (2047, 7), (1023, 6)):
        for axis in (0, 1):
            last = [list(node) for node in SQUARE]
            last[2][axis] += size
            data = document({"nodes": SQUARE, "boundary_count": 4}, {"nodes": last})
            planes = parse(write_stream(encode_mesh(read_mesh_document(data))))
            assert planes[1].range_code == range_code, size
            assert coded(data)[1].nodes[2] == tuple(last[2])


def test_frames_that_stay_become_planes_without_data() -> None:
    planes = parse(
        write_stream(
            encode_mesh(
                read_mesh_document(
                    document(
                        {"nodes": [], "intra": True},
                        {"nodes": SQUARE, "boundary_count": 4},
                        {"nodes": SQUARE},
                        {"nodes": SQUARE, "intra": True},
                    )
                )
            )
        )
    )
    assert [(plane.intra, plane.nodes is None, plane.range_code) for plane in planes] == [
        (True, True, 0), (True, False, 0), (False, True, 0), (True, True, 0),
    ]  # fmt: skip


def test_far_vectors_are_refused_or_make_an_intra_plane() -> None:
    far = [[x + 2048, y] for x, y in SQUARE]
    data = document({"nodes": SQUARE, "boundary_count": 4}, {"nodes": far}, {"nodes": [[2049, 1], *far[1:]]})
    with pytest.raises(RangeViolation) as caught:
        coded(data)
    assert (caught.value.rule, caught.value.path) == ("MSH-13", "frames[1].nodes[0]")
    frames = coded(data, far="intra")
    assert [frame.intra for frame in frames] == [True, True, False]
    assert frames[1].nodes == tuple(map(tuple, far))
    grid = {"nodes_hor": 2, "nodes_vert": 2, "rect_hor": 5, "rect_vert": 6, "split_code": 1}
    nodes = [[0, 0], [5, 0], [0, 6], [5, 6]]
    away = document({"nodes": nodes, "uniform": grid}, {"nodes": [[x - 2049, y] for x, y in nodes]})
    with pytest.raises(RangeViolation):
        coded(away, far="intra")


def _times(*times: str, rate: Fraction | None = None) -> tuple[list[str], int]:
    frames = [{"nodes": SQUARE, "boundary_count": 4, "time": time} for time in times]
    items = encode_mesh(read_mesh_document(document(*frames)), rate=rate)
    mesh = items[0].mesh
    assert mesh is not None
    decoded = [f"{frame.time[0]}/{frame.time[1]}" for frame in decode_frames(write_stream(items))]
    return decoded, mesh.planes[0].header.is_frame_rate


@pytest.mark.parametrize(
    ("times", "sends_rate"),
    [
        (("0/1", "1/30", "1/15", "1/10"), 0),
        (("0/1", "1/30", "17/30", "18/30"), 0),
        (("0/1", "1/25", "2/25"), 1),
        (("0/1", "1001/30000", "1001/15000"), 1),
        (("5/1", "126/25"), 1),
        (("86399/1",), 0),
        (("0/1", "20/1", "60/1"), 0),
        (("0/1", "7/16"), 1),
        (("0/1", "1/7", "1/2"), 1),
    ],
)
def test_times(times: tuple[str, ...], sends_rate: int) -> None:
    decoded, sent = _times(*times)
    assert [Fraction(time) for time in decoded] == [Fraction(time) for time in times]
    assert sent == sends_rate


@pytest.mark.parametrize(
    ("frames", "options", "error_class", "rule", "path"),
    [
        ([{"time": "0/1"}, {}], {}, InconsistentSemantics, "FBA-38", "frames[1]"),
        ([{"time": "1/1"}, {"time": "1/1"}], {}, InconsistentSemantics, "FBA-38", "frames[1].time"),
        ([{"time": "0/1"}, {"time": "1/25"}], {"rate": Fraction(10)}, EncodeError, "FBA-38", "frames[1].time"),
        ([{"time": "1/2"}], {}, EncodeError, "FBA-7", "frames[0].time"),
        ([{"time": "86400/1"}], {}, EncodeError, "FBA-7", "frames[0].time"),
        ([{"time": "0/1"}, {"time": "1/100003"}], {}, EncodeError, "FBA-37", ""),
        ([{}], {"rate": Fraction(1, 7)}, EncodeError, "FBA-37", ""),
        ([{}], {"far": "away"}, EncodeError, "MSH-13", ""),
    ],
)
def test_times_that_cannot_be_sent(
    frames: list[Json], options: Json, error_class: type[SnhcError], rule: str, path: str
) -> None:
    data = document(*({"nodes": SQUARE, "boundary_count": 4, **frame} for frame in frames))
    with pytest.raises(error_class) as caught:
        encode_mesh(read_mesh_document(data), **options)
    assert (caught.value.rule, caught.value.path) == (rule, path)


BASE: Json = {"nodes": SQUARE, "boundary_count": 4}
GRID: Json = {"nodes_hor": 2, "nodes_vert": 2, "rect_hor": 5, "rect_vert": 6, "split_code": 1}

REFUSED: dict[str, tuple[bytes, type[SnhcError], str, str]] = {
    "no JSON": (b"{", InputFormat, "CNF-25", ""),
    "an array": (b"[]", InputFormat, "CNF-25", ""),
    "no format": (b'{"version":1}', InputFormat, "CNF-1", "format"),
    "another format": (b'{"format":"snhc-table","version":1}', InputFormat, "CNF-1", "format"),
    "another version": (document(BASE, version=2), InputFormat, "CNF-1", "version"),
    "another kind": (b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n', InputFormat, "CNF-1", "kind"),
    "no frames": (b'{"format":"snhc-mesh","version":1}', InputFormat, "CNF-1", "frames"),
    "empty": (document(), EncodeError, "MSH-1", ""),
    "a frame that is none": (document([]), InputFormat, "CNF-1", "frames[0]"),  # type: ignore[arg-type]
    "unknown key": (document({**BASE, "nods": []}), InputFormat, "CNF-1", "frames[0]"),
    "no nodes": (document({"boundary_count": 4}), InputFormat, "CNF-1", "frames[0].nodes"),
    "a node of three": (document({**BASE, "nodes": [[1, 2, 3]]}), InputFormat, "CNF-1", "frames[0].nodes[0]"),
    "half a half pixel": (document({**BASE, "nodes": [[0.5, 0]]}), InputFormat, "MSH-24", "frames[0].nodes[0][0]"),
    "a node far out": (document(BASE, {"nodes": [[1 << 31, 0]]}), RangeViolation, "MSH-24", "frames[1].nodes[0][0]"),
    "no such node": (document({"nodes": SQUARE, "triangles": [[0, 1, 4]]}), RangeViolation, "CNF-1",
                     "frames[0].triangles[0][2]"),
    "intra is no flag": (document({**BASE, "intra": 1}), InputFormat, "CNF-1", "frames[0].intra"),
    "geometry, not intra": (document({**BASE, "intra": False}), InconsistentSemantics, "MSH-2", "frames[0].intra"),
    "time without form": (document({**BASE, "time": "now"}), InputFormat, "CNF-1", "frames[0].time"),
    "time over 0": (document({**BASE, "time": "1/0"}), InputFormat, "CNF-1", "frames[0].time"),
    "two boundary nodes": (document({**BASE, "boundary_count": 2}), RangeViolation, "MSH-38",
                           "frames[0].boundary_count"),
    "five of four": (document({**BASE, "boundary_count": 5}), RangeViolation, "MSH-38", "frames[0].boundary_count"),
    "both kinds": (document({**BASE, "uniform": GRID}), InconsistentSemantics, "MSH-30", "frames[0].uniform"),
    "grid elsewhere": (document({"nodes": SQUARE, "uniform": GRID}), InconsistentSemantics, "MSH-6",
                       "frames[0].nodes[1]"),
    "grid of one column": (document({"nodes": SQUARE, "uniform": {**GRID, "nodes_hor": 1}}), RangeViolation, "MSH-31",
                           "frames[0].uniform.nodes_hor"),
    "grid without rows": (document({"nodes": SQUARE, "uniform": {"nodes_hor": 2}}), InputFormat, "CNF-1",
                          "frames[0].uniform.nodes_vert"),
    "a split of its own": (document({"nodes": [[0, 0], [5, 0], [0, 6], [5, 6]], "triangles": [[0, 1, 3]]}),
                           InconsistentSemantics, "MSH-7", "frames[0].triangles"),
    "crossing": (document({"nodes": [[0, 0], [40, 40], [40, 0], [0, 30]], "boundary_count": 4}), InconsistentSemantics,
                 "MSH-11", "frames[0].nodes[3]"),
    "outside": (document({**BASE, "nodes": [*SQUARE, [50, 5]]}), InconsistentSemantics, "MSH-11", "frames[0].nodes[4]"),
    "a step too long": (document({"nodes": [[0, 0], [2048, 0], [0, 9]], "boundary_count": 3}), RangeViolation, "MSH-5",
                        "frames[0].nodes[1]"),
    "node 0 too far": (document({"nodes": [[4096, 0], [4000, 0], [4000, 9]], "boundary_count": 3}), RangeViolation,
                       "MSH-39", "frames[0].nodes[0]"),
    "out of range": (document({"nodes": [[0, 0], [-16385, 0], [0, 9]], "boundary_count": 3}), RangeViolation, "MSH-24",
                     "frames[0].nodes[1]"),
    "the other diagonal": (document({**BASE, "triangles": [[0, 1, 2], [0, 2, 3]]}), InconsistentSemantics, "MSH-8",
                           "frames[0].triangles[0]"),
    "a triangle short": (document({**BASE, "triangles": [[0, 1, 2]]}), InconsistentSemantics, "MSH-8",
                         "frames[0].triangles"),
    "another order": (document({**BASE, "order": [1, 0, 2, 3]}), InconsistentSemantics, "MSH-21", "frames[0].order[0]"),
    "an order short": (document({**BASE, "order": [0]}), InputFormat, "CNF-1", "frames[0].order"),
    "triangles without an outline": (document({"nodes": SQUARE, "triangles": []}), RangeViolation, "MSH-38",
                                     "frames[0].triangles"),
    "motion first": (document({"nodes": SQUARE, "intra": False}), InconsistentSemantics, "MSH-4", "frames[0].intra"),
    "intra without geometry": (document(BASE, {"nodes": [[1, 1], *SQUARE[1:]], "intra": True}), InputFormat, "CNF-1",
                               "frames[1]"),
    "a node less": (document(BASE, {"nodes": SQUARE[:3]}), InconsistentSemantics, "MSH-16", "frames[1].nodes"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str) -> None:
    data, error_class, rule, path = REFUSED[name]
    with pytest.raises(SnhcError) as caught:
        coded(data)
    error = caught.value
    assert (type(error), error.rule, error.path) == (error_class, rule, path)


def test_a_bad_line_is_named_by_its_number() -> None:
    lines = b'{"format":"snhc-decoded","version":1,"kind":"mesh"}\n{"nodes":[]}\n\n{"nodes":[}\n'
    with pytest.raises(InputFormat) as caught:
        read_mesh_document(lines)
    assert (caught.value.line, caught.value.column) == (4, 11)


def test_limits_of_documents() -> None:
    few = DEFAULT_LIMITS.with_values({"mesh_nodes_delaunay": 3, "mesh_nodes_uniform": 3})
    for frame in (BASE, {"nodes": [[0, 0], [5, 0], [0, 6], [5, 6]], "uniform": GRID}):
        with pytest.raises(ResourceLimit):
            encode_mesh(read_mesh_document(document(frame)), limits=few)
    with pytest.raises(ResourceLimit):
        read_mesh_document(document(BASE), limits=DEFAULT_LIMITS.with_values({"json_bytes": 10}))


def test_other_readings_make_other_triangles_canonical() -> None:
    square = [[0, 0], [40, 0], [40, 40], [0, 40]]
    readings = Readings({"AMB-MSH-2": "other"})
    data = document({"nodes": square, "triangles": [[0, 1, 3], [1, 2, 3]]})
    with pytest.raises(InconsistentSemantics):
        coded(data)
    items = encode_mesh(read_mesh_document(data), readings=readings)
    (frame,) = decode_frames(write_stream(items), Options(readings=readings))
    assert isinstance(frame, MeshFrame) and frame.triangles == ((0, 1, 3), (1, 2, 3))


# -- pictures ----------------------------------------------------------------------------------------------------------


def _pictures(count: int, step: float) -> list[np.ndarray[Any, Any]]:
    """A soft pattern that moves to the right."""
    y, x = np.mgrid[:48, :64]
    return [
        np.asarray(128 + 60 * np.sin((x - step * k) / 5) + 50 * np.cos(y / 4 + (x - step * k) / 9), np.uint8)
        for k in range(count)
    ]


@pytest.mark.parametrize("design", ["content", "uniform"])
def test_pictures_become_a_mesh_that_follows_them(design: str) -> None:
    pictures = _pictures(3, 2.0)
    made = encode_pictures(pictures, design=design, interior_nodes=20, rate=Fraction(25), profile=0xFF)
    frames = [frame for frame in decode_frames(write_stream(made.items)) if isinstance(frame, MeshFrame)]
    assert [frame.time for frame in frames] == [(0, 1), (1, 25), (2, 25)]
    assert (len(frames[0].nodes), len(frames[0].triangles or ())) == (made.nodes, made.triangles)
    still_error = np.mean((pictures[0].astype(float) - pictures[2]) ** 2)
    still_psnr = 10 * np.log10(255**2 / still_error)
    assert len(made.psnr) == 2
    assert made.psnr[1] > still_psnr + 3, "the warped first picture is nearer to the last than the first itself"


def test_equal_pictures_and_bad_arguments() -> None:
    pictures = _pictures(2, 0.0)
    assert encode_pictures(pictures, design="uniform").psnr == (float("inf"),)
    for bad in ({"design": "free"}, {"search": 99}, {"spacing": 0.0}):
        with pytest.raises(EncodeError):
            encode_pictures(pictures, **bad)  # type: ignore[arg-type]
    with pytest.raises(EncodeError):
        encode_pictures([])
    with pytest.raises(EncodeError):
        encode_pictures([pictures[0], pictures[1][:20]])


def test_wide_pictures_get_steps_that_the_syntax_holds() -> None:
    """Sides of more than 2,047 half pixels are divided; interior nodes stand in bands."""
    y, x = np.mgrid[:20, :3000]
    picture = np.asarray(128 + 100 * np.sin(x / 7) * np.cos(y / 5), np.uint8)
    made = encode_pictures([picture], interior_nodes=40, spacing=4)
    (frame,) = decode_frames(write_stream(made.items))
    assert isinstance(frame, MeshFrame)
    assert max(x for x, _ in frame.nodes) == 6000


# -- outputs -----------------------------------------------------------------------------------------------------------


def _frames() -> list[MeshFrame]:
    first = delaunay([(0, 0), (40, 0), (43, 41), (0, 40)])
    data = write_stream(mesh_stream(still(1), first, moved(first, {2: (5, -1)}), uniform(2, 2, 6, 4)))
    return [frame for frame in decode_frames(data) if isinstance(frame, MeshFrame)]


def test_csv() -> None:
    frames = _frames()
    assert csv_header() == "index,time,intra,node,x,y\n"
    assert csv_rows(frames[0]) == ""
    assert csv_rows(frames[2]) == "2,1/15,0,0,0,0\n2,1/15,0,1,40,0\n2,1/15,0,2,48,40\n2,1/15,0,3,0,40\n"


def test_npz() -> None:
    frames = _frames()
    arrays = MeshArrays(Readings({"AMB-MSH-2": "other"}))
    for frame in frames:
        arrays.add(frame)
    pieces: list[bytes] = []
    arrays.write(pieces.append)
    with np.load(io.BytesIO(b"".join(pieces)), allow_pickle=False) as archive:
        loaded = {name: archive[name] for name in archive.files}
    header = json.loads(str(loaded["header"]))
    assert (header["kind"], header["version"], header["readings"]) == ("mesh", 1, {"AMB-MSH-2": "other"})
    assert loaded["intra"].tolist() == [True, True, False, True]
    for k, frame in enumerate(frames):
        assert tuple(loaded["time"][k]) == frame.time
        for name, wanted in (
            ("nodes", frame.nodes),
            ("triangles", frame.triangles or ()),
            ("order", frame.order or ()),
        ):
            first, last = loaded[f"{name}_offsets"][k : k + 2]
            assert loaded[name][first:last].tolist() == [list(v) if isinstance(v, tuple) else v for v in wanted]
    few = MeshArrays(limits=DEFAULT_LIMITS.with_values({"collected_planes": 1}))
    few.add(frames[0])
    with pytest.raises(ResourceLimit):
        few.add(frames[1])


@pytest.mark.parametrize("format", MODEL_FORMATS)
def test_models_load_again(format: str) -> None:
    frame = _frames()[1]
    assert frame.triangles is not None
    data = model_bytes(frame.nodes, frame.triangles, format)
    loaded: Any = trimesh.load(io.BytesIO(data), file_type=format, force="mesh", process=False)
    assert len(loaded.faces) == 2
    # Pixels, y up, faces towards +z; twice the area of the polygon is 40 * 41 + 43 * 40 square half pixels.
    assert loaded.bounds.tolist() == [[0, -20.5, 0], [21.5, 0, 0]]
    assert loaded.area == pytest.approx((40 * 41 + 43 * 40) / 8)
    assert np.allclose(loaded.face_normals, [0, 0, 1])


def test_models_of_nothing() -> None:
    for arguments in (((), (), "obj"), (((0, 0), (1, 0), (0, 1)), ((0, 1, 2),), "doc")):
        with pytest.raises(EncodeError):
            model_bytes(*arguments)  # type: ignore[arg-type]


# -- the verbs ---------------------------------------------------------------------------------------------------------


def run(*args: str, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(snhc, list(args), input=stdin, prog_name="snhc")


def test_verbs_decode_and_encode_again(tmp_path: Path) -> None:
    folder = SAMPLES / "mesh" / "mesh-11-00000"
    lines = run("decode", str(folder / "input.m2d"), "--quiet").stdout_bytes
    target = tmp_path / "again.m2d"
    assert run("encode", "-", "-o", str(target), stdin=lines).exit_code == 0
    assert run("decode", str(target), "--quiet").stdout_bytes == lines
    sequence = tmp_path / "sequence.m2d"
    assert run("encode", "-", "--profile", "255", "--no-end-code", "-o", str(sequence), stdin=lines).exit_code == 0
    assert sequence.read_bytes()[:5] == b"\0\0\1\xb0\xff"
    assert run("decode", str(sequence), "--quiet").stdout_bytes == lines


def test_verb_writes_tables_and_models(tmp_path: Path) -> None:
    mesh = str(SAMPLES / "mesh" / "mesh-11-00001" / "input.m2d")
    frames = list(decode_frames(Path(mesh).read_bytes()))
    for name in ("a.csv", "a.npz", "a.obj", "a.ply", "a.stl", "a.off", "a.glb", "b-{index}.obj"):
        assert run("decode", mesh, "-o", str(tmp_path / name), "--quiet").exit_code == 0, name
    assert (tmp_path / "a.csv").read_text().startswith("index,time,intra,node,x,y\n0,")
    with_mesh = [frame.index for frame in frames if frame.nodes]  # type: ignore[union-attr]
    assert sorted(path.name for path in tmp_path.glob("b-*.obj")) == sorted(f"b-{index}.obj" for index in with_mesh)
    assert (tmp_path / f"b-{with_mesh[0]}.obj").read_bytes() == (tmp_path / "a.obj").read_bytes()
    assert run("decode", mesh, "-o", str(tmp_path / "c-{index}.csv")).exit_code == 2
    face = str(SAMPLES / "fba" / "fba-11-00000" / "input.fba")
    refused = run("decode", face, "-o", str(tmp_path / "face.obj"))
    assert refused.exit_code == 3
    assert not (tmp_path / "face.obj").exists()


def test_verb_encodes_pictures_and_reports(tmp_path: Path) -> None:
    names = []
    for k, picture in enumerate(_pictures(3, 2.0)):
        names.append(str(tmp_path / f"{k}.png"))
        Image.fromarray(picture).save(names[-1])
    target = tmp_path / "a.m2d"
    result = run("encode", *names, "--interior-nodes", "9", "--rate", "30000/1001", "-o", str(target))
    assert result.exit_code == 0, result.stderr
    assert result.stderr.count(" dB") == 2
    frames = list(decode_frames(target.read_bytes()))
    assert frames[2].time == (1001, 15000)
    assert (
        run("encode", names[0], str(SAMPLES / "mesh" / "mesh-11-00000" / "input.m2d"), "-o", str(target)).exit_code == 3
    )
    assert run("encode", str(SAMPLES / "mesh" / "mesh-11-00000" / "expected.ndjson"), names[0]).exit_code == 2
    for rate in ("0", "x", "1/0", "-3"):
        assert run("encode", *names, "--rate", rate, "-o", str(target)).exit_code == 2


def test_verb_says_which_extra_models_need_without_trimesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    mesh = str(SAMPLES / "mesh" / "mesh-11-00001" / "input.m2d")
    result = run("decode", mesh, "-o", str(tmp_path / "a.obj"))
    assert result.exit_code == 2
    assert "needs the extra snhc[view] (trimesh is not installed)" in result.stderr
    assert list(tmp_path.iterdir()) == []
