"""GLB files of a moving head, read back by a small reader of this test and by VTK."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from snhc.analyzer.face_scene import FaceModel, exact_vertices, load_model, still
from snhc.analyzer.glb import distinct_times, glb
from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.model.fat import FatReadings, FrameLike, fat_from_json

# Millimetres as metres; a float32 sum of some ten terms of 0.2 m errs by some ulps of 1.5e-8.
TOLERANCE = 1e-6
HEAD = load_model()
FRAMES: list[FrameLike] = [
    still({}),
    still({3: 900, 4: -120, 5: -600, 10: -500, 11: -500, 19: 700, 20: -300, 23: 20000, 26: -9000, 27: 60, 29: 100}),
    still({31: 200, 47: -60000, 48: 20000, 49: -30000, 50: 15000, 14: -90}),
    still({22: -700}, (10, 4, 40), (1, 50, 4, 20)),
]
TIMES = [Fraction(n, 25) for n in range(len(FRAMES))]

COMPONENTS = {5126: ("<f4", 4), 5125: ("<u4", 4)}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Glb:
    """An independent reader of what the writer writes: chunks, accessors (also sparse), nodes, one animation."""

    def __init__(self, data: bytes) -> None:
        magic, version, size = struct.unpack_from("<4sII", data)
        assert (magic, version, size) == (b"glTF", 2, len(data))
        length, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and length % 4 == 0
        self.json: dict[str, Any] = json.loads(data[20 : 20 + length])
        binary_length, binary_kind = struct.unpack_from("<I4s", data, 20 + length)
        assert binary_kind == b"BIN\0" and binary_length % 4 == 0
        self.binary = data[28 + length :]
        assert len(self.binary) == binary_length

    def _view(self, number: int, offset: int, dtype: str, count: int) -> NDArray[Any]:
        view = self.json["bufferViews"][number]
        start = view["byteOffset"] + offset
        assert start % 4 == 0 and offset + count * 4 <= view["byteLength"]
        return np.frombuffer(self.binary, dtype, count, start).copy()

    def accessor(self, number: int) -> NDArray[Any]:
        entry = self.json["accessors"][number]
        dtype, _ = COMPONENTS[entry["componentType"]]
        width = WIDTHS[entry["type"]]
        rows = self._view(entry["bufferView"], entry["byteOffset"], dtype, entry["count"] * width).reshape(-1, width)
        if "sparse" in entry:
            sparse = entry["sparse"]
            places, values = sparse["indices"], sparse["values"]
            index = self._view(places["bufferView"], places["byteOffset"], "<u4", sparse["count"])
            assert (np.diff(index.astype(np.int64)) > 0).all()
            rows[index] = self._view(
                values["bufferView"], values["byteOffset"], dtype, sparse["count"] * width
            ).reshape(-1, width)
        if "min" in entry:
            assert np.array_equal(rows.min(axis=0), np.array(entry["min"], np.float32))
            assert np.array_equal(rows.max(axis=0), np.array(entry["max"], np.float32))
        return rows

    def keys(self, node: int, path: str, key: int) -> NDArray[Any] | None:
        for animation in self.json.get("animations", []):
            for channel in animation["channels"]:
                if channel["target"] == {"node": node, "path": path}:
                    sampler = animation["samplers"][channel["sampler"]]
                    assert sampler["interpolation"] == "LINEAR"
                    times = self.accessor(sampler["input"])
                    assert (np.diff(times[:, 0]) > 0).all()
                    output = self.accessor(sampler["output"])
                    return output.reshape(len(times), -1)[key]
        return None

    def matrix(self, node: int, key: int) -> NDArray[np.float64]:
        entry = self.json["nodes"][node]

        def value(path: str, default: list[float]) -> NDArray[np.float64]:
            found = self.keys(node, path, key)
            return np.asarray(entry.get(path, default) if found is None else found, np.float64)

        x, y, z, w = value("rotation", [0, 0, 0, 1])
        assert abs(x * x + y * y + z * z + w * w - 1) < 1e-6
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )
        out = np.eye(4)
        out[:3, :3] = turn @ np.diag(value("scale", [1, 1, 1]))
        out[:3, 3] = value("translation", [0, 0, 0])
        return out

    def meshes(self, key: int) -> Iterator[tuple[str, NDArray[np.float64], NDArray[Any]]]:
        """(name, world positions, faces) of one animation key."""

        def walk(node: int, above: NDArray[np.float64]) -> Iterator[tuple[str, NDArray[np.float64], NDArray[Any]]]:
            world = above @ self.matrix(node, key)
            entry = self.json["nodes"][node]
            if "mesh" in entry:
                mesh = self.json["meshes"][entry["mesh"]]
                weights = self.keys(node, "weights", key)
                if weights is None:
                    weights = np.array(mesh.get("weights", []))
                faces = []
                points = None
                for primitive in mesh["primitives"]:
                    points = self.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
                    normals = self.accessor(primitive["attributes"]["NORMAL"])
                    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)
                    targets = primitive.get("targets", [])
                    assert len(targets) == len(weights)
                    for weight, target in zip(weights, targets, strict=True):
                        points += float(weight) * self.accessor(target["POSITION"])
                    faces.append(self.accessor(primitive["indices"]).reshape(-1, 3))
                assert points is not None
                yield mesh["name"], points @ world[:3, :3].T + world[:3, 3], np.concatenate(faces)
            for child in entry.get("children", []):
                yield from walk(child, world)

        yield from walk(self.json["scenes"][0]["nodes"][0], np.eye(4))


@pytest.fixture(scope="module")
def head_file() -> bytes:
    return glb(HEAD, FRAMES, TIMES)


@pytest.mark.parametrize("key", range(len(FRAMES)))
def test_every_key_is_what_the_evaluation_gives(head_file: bytes, key: int) -> None:
    expected = exact_vertices(HEAD, FRAMES[key])
    found = {name: points for name, points, _ in Glb(head_file).meshes(key)}
    assert found.keys() == expected.keys()
    for name, points in found.items():
        assert np.abs(points - expected[name] * HEAD.unit).max() < TOLERANCE, name


def test_faces_and_colours_are_all_there(head_file: bytes) -> None:
    for name, _, faces in Glb(head_file).meshes(0):
        wanted = HEAD.document.meshes[name].faces
        assert sorted(map(tuple, faces.tolist())) == sorted(map(tuple, wanted.tolist()))
    assert len(Glb(head_file).json["materials"]) == len({tuple(c) for m in HEAD.colours.values() for c in m.tolist()})


def test_only_what_moves_has_targets_and_weights_stay_small(head_file: bytes) -> None:
    whole = Glb(head_file)
    names = {name for mesh in whole.json["meshes"] for name in mesh.get("extras", {}).get("targetNames", [])}
    assert "19 close_t_l_eyelid 512..768" in names and "31 raise_l_i_eyebrow" in names
    # Neither given nor part of the visemes and expressions shown.
    assert not any(name.startswith(("15 ", "65 ", "68 ")) for name in names)
    hair = next(mesh for mesh in whole.json["meshes"] if mesh["name"] == "hair")
    assert "weights" not in hair
    for channel in whole.json["animations"][0]["channels"]:
        if channel["target"]["path"] == "weights":
            weights = whole.accessor(whole.json["animations"][0]["samplers"][channel["sampler"]]["output"])
            assert np.abs(weights).max() <= 4 / 3  # FAP 22 is past its border


def test_other_tools_open_it(head_file: bytes) -> None:
    scene = trimesh.load(io.BytesIO(head_file), file_type="glb")
    names = {name.rsplit("_", 1)[0] if name.rsplit("_", 1)[-1].isdigit() else name for name in scene.geometry}
    assert set(HEAD.document.meshes) <= names
    faces = sum(len(mesh.faces) for mesh in HEAD.document.meshes.values())
    assert sum(len(part.faces) for part in scene.geometry.values()) == faces
    assert np.allclose(scene.bounds[1] - scene.bounds[0], [0.169, 0.2875, 0.2235], atol=0.002)


@pytest.mark.parametrize("key", [1, 3])
def test_vtk_plays_the_same_positions(head_file: bytes, key: int, tmp_path: Any) -> None:
    reader_module = pytest.importorskip("vtkmodules.vtkIOGeometry", reason="VTK's glTF reader cannot be loaded")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    path = tmp_path / "head.glb"
    path.write_bytes(head_file)
    reader = reader_module.vtkGLTFReader()
    reader.SetFileName(str(path))
    reader.ApplyDeformationsToGeometryOn()
    reader.UpdateInformation()
    reader.EnableAnimation(0)
    reader.UpdateTimeStep(float(TIMES[key]))
    reader.Update()

    def leaves(block: Any) -> Iterator[NDArray[Any]]:
        if hasattr(block, "GetNumberOfBlocks"):
            for n in range(block.GetNumberOfBlocks()):
                yield from leaves(block.GetBlock(n))
        elif block is not None:
            yield vtk_to_numpy(block.GetPoints().GetData())

    clouds = list(leaves(reader.GetOutput()))
    for name, points in exact_vertices(HEAD, FRAMES[key]).items():
        found = [cloud for cloud in clouds if len(cloud) == len(points)]
        # VTK multiplies with matrices in single precision.
        assert min(np.abs(cloud - points * HEAD.unit).max() for cloud in found) < 5e-6, name


def test_a_single_frame_is_a_still_head() -> None:
    whole = Glb(glb(HEAD, FRAMES[1:2], TIMES[:1]))
    assert "animations" not in whole.json
    expected = exact_vertices(HEAD, FRAMES[1])
    for name, points, _ in whole.meshes(0):
        assert np.abs(points - expected[name] * HEAD.unit).max() < TOLERANCE


def test_times_that_stand_still_or_go_back_make_no_keys() -> None:
    assert distinct_times([Fraction(2), Fraction(2), Fraction(1), Fraction(5, 2)]) == ([0, 3], [0.0, 0.5])


def test_nothing_to_write() -> None:
    with pytest.raises(EncodeError):
        glb(HEAD, [], [])
    empty = fat_from_json({"meshes": {"m": {"vertices": [[0, 0, 0]], "faces": []}}})
    with pytest.raises(EncodeError):
        glb(FaceModel(empty, {"m": np.zeros((0, 3), np.uint8)}, {}, {}), FRAMES[:1], TIMES[:1])


def model_of(tables: list[dict[str, Any]]) -> FaceModel:
    document = fat_from_json(
        {
            "fapu": {"ES": 0.5, "ENS": 0.25, "MNS": 2.0, "MW": 1.0, "IRISD": 1.5},
            "meshes": {"m": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}},
            "tables": tables,
            "transforms": {
                "a": {"translation": [1, 2, 3], "scale": [2, 1, 3], "rotation": [1, 1, 0, 0.5]},
                "b": {"parent": "a", "rotation": [0, 0, 1, -2], "meshes": ["m"]},
            },
        }
    )
    return FaceModel(document, {"m": np.zeros((1, 3), np.uint8)}, {}, {})


@settings(max_examples=40)
@given(
    borders=st.lists(st.integers(-9, 9), min_size=1, max_size=4, unique=True),
    values=st.lists(st.integers(-15, 15), min_size=1, max_size=4),
    index=st.lists(st.integers(0, 2), min_size=1, max_size=4),
    sign=st.sampled_from(["direction", "slope"]),
)
def test_any_table_gives_the_same_as_its_evaluation(
    borders: list[int], values: list[int], index: list[int], sign: str
) -> None:
    borders = sorted({0, *borders} if len(borders) > 1 else {borders[0], borders[0] + 3})
    intervals = len(borders) - 1
    rows = [[k + 1, -j, (k * j) % 3] for k in range(len(index)) for j in range(intervals)]
    model = model_of(
        [
            {
                "fapID": 6,
                "meshes": [{"mesh": "m", "intervalBorders": borders, "coordIndex": index, "displacements": rows}],
                "transforms": [
                    {"node": "a", "field": "scale", "def": [0.01, 0, 0]},
                    {"node": "b", "field": "translation", "def": [0, 1, 0]},
                    {"node": "b", "field": "rotation", "def": [0, 1, 1, 0.3]},
                ],
            }
        ]
    )
    frames = [still({6: value}) for value in values]
    readings = FatReadings(sign=sign)
    whole = Glb(glb(model, frames, [Fraction(n) for n in range(len(frames))], readings))
    for key, frame in enumerate(frames):
        expected = exact_vertices(model, frame, readings)["m"]
        ((_, points, _),) = whole.meshes(key)
        assert np.abs(points - expected).max() <= 1e-5 * max(1.0, float(np.abs(expected).max()))
