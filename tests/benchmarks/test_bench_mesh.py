"""Speed of 2D meshes: geometry, motion, warping. Figures only, no limits."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from snhc.reference_impl.mesh.motion import VectorCode, decode_vector, move, predict
from snhc.reference_impl.mesh.polygon import first_fault
from snhc.reference_impl.mesh.rasteriser import warp
from snhc.reference_impl.mesh.topology import MeshTopology
from snhc.reference_impl.mesh.traversal import traverse
from snhc.reference_impl.mesh.triangulation import delaunay_triangles
from snhc.reference_impl.mesh.uniform import uniform_positions, uniform_triangles
from snhc.reference_impl.systems.stream import decode_planes, trace_stream, write_stream
from snhc.vectors.mesh_builders import delaunay, mesh_stream, moved, uniform


def _nodes(count: int, order: str) -> tuple[list[int], list[int]]:
    """Nodes anywhere in a square of 32,000 half pixels, the inner ones at random or row by row, to and fro."""
    source = random.Random(count)
    inner: set[tuple[int, int]] = set()
    while len(inner) < count - 4:
        inner.add((source.randint(-15999, 15999), source.randint(-15999, 15999)))
    nodes = sorted(inner)
    if order == "random":
        source.shuffle(nodes)
    else:
        rows = round(count**0.5)
        height = 32000 // rows + 1

        def place(node: tuple[int, int]) -> tuple[int, int]:
            row = (node[1] + 16000) // height
            return row, node[0] if row % 2 == 0 else -node[0]

        nodes.sort(key=place)
    nodes = [(-16000, -16000), (16000, -16000), (16000, 16000), (-16000, 16000), *nodes]
    return [x for x, _ in nodes], [y for _, y in nodes]


def _geometry(xs: list[int], ys: list[int]) -> MeshTopology:
    assert first_fault(xs, ys, 4) is None
    return traverse(xs, ys, delaunay_triangles(xs, ys, 4))


@pytest.mark.parametrize("order", ["random", "snake"])
@pytest.mark.parametrize("count", [1000, 10000])
def test_delaunay_geometry(benchmark: Any, count: int, order: str) -> None:
    """Checks, triangulation, ties and traversal."""
    xs, ys = _nodes(count, order)
    topology = benchmark(_geometry, xs, ys)
    assert len(topology.order) == count


def test_uniform_geometry(benchmark: Any) -> None:
    xs, ys = uniform_positions(100, 100, 16, 16)
    topology = benchmark(lambda: traverse(xs, ys, uniform_triangles(100, 100, 2)))
    assert len(topology.order) == 10000


@pytest.mark.parametrize("count", [1000, 10000])
def test_motion_of_one_plane(benchmark: Any, count: int) -> None:
    """Predictions, vectors and positions; reading bits is not part of it."""
    xs, ys = _nodes(count, "random")
    topology = _geometry(xs, ys)
    source = random.Random(1)
    codes = [
        VectorCode(0, source.randint(-32, 32), source.randint(0, 3), source.randint(-32, 32), source.randint(0, 3))
        for _ in range(count)
    ]

    def decode() -> tuple[list[int], list[int]]:
        vx = [0] * count
        vy = [0] * count
        for k, node in enumerate(topology.order):
            vx[node], vy[node] = decode_vector(codes[k], predict(topology, k, vx, vy), 3)
        return move(xs, ys, vx, vy)

    assert len(benchmark(decode)[0]) == count


@pytest.mark.parametrize("cells", [10, 45])
def test_warp_of_a_picture(benchmark: Any, cells: int) -> None:
    """352 x 288 pixels on 200 and on about 4,000 triangles."""
    width, height = -(-704 // cells), -(-576 // cells)
    xs, ys = uniform_positions(cells + 1, cells + 1, width, height)
    triangles = traverse(xs, ys, uniform_triangles(cells + 1, cells + 1, 2)).triangles
    source = random.Random(2)
    moved_xs = [x + source.randint(-3, 3) for x in xs]
    moved_ys = [y + source.randint(-3, 3) for y in ys]
    image = np.random.default_rng(0).integers(0, 256, (288, 352)).astype(np.uint8)
    _, covered = benchmark(warp, image, xs, ys, moved_xs, moved_ys, triangles, 352, 288)
    assert covered.mean() > 0.98


def _stream(kind: str, count: int, motions: int) -> bytes:
    """A geometry plane of about `count` nodes, and as many times as asked for a plane in which every node moves."""
    if kind == "delaunay":
        xs, ys = _nodes(count, "snake")
        # Steps of more than 2,047 half pixels cannot be coded.
        corners = [(-1000, -1000), (1000, -1000), (1000, 1000), (-1000, 1000)]
        inner = dict.fromkeys((x // 17, y // 17) for x, y in zip(xs[4:], ys[4:], strict=True))
        first = delaunay([*corners, *inner], 4)
    else:
        side = round(count**0.5)
        first = uniform(side, side, 16, 16, 2)
    source = random.Random(4)
    vectors = {node: (source.randint(-20, 20), source.randint(-20, 20)) for node in range(count * 9 // 10)}
    motion = moved(first, vectors)
    return write_stream(mesh_stream(first, *([motion] * motions)))


def _decode(data: bytes) -> int:
    return sum(len(plane.frames) for plane in decode_planes(data))


@pytest.mark.parametrize("count", [100, 1000])
@pytest.mark.parametrize("kind", ["uniform", "delaunay"])
def test_stream_of_geometry(benchmark: Any, kind: str, count: int) -> None:
    """Bits to frames, one geometry plane."""
    data = _stream(kind, count, 0)
    assert benchmark(_decode, data) == 1
    benchmark.extra_info["bytes"] = len(data)


@pytest.mark.parametrize("count", [100, 1000])
def test_stream_of_motion(benchmark: Any, count: int) -> None:
    """Bits to frames: 10 motion planes behind a uniform geometry."""
    data = _stream("uniform", count, 10)
    assert benchmark(_decode, data) == 11
    benchmark.extra_info["bytes"] = len(data)


def test_trace_of_motion(benchmark: Any) -> None:
    """Every element written down: 10 motion planes of 1,000 nodes."""
    data = _stream("uniform", 1000, 10)
    assert benchmark(lambda: sum(len(part.trace) for part in trace_stream(data))) > 10_000
