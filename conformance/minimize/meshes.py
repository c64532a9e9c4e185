"""Mesh objects: nodes, rows and columns taken out, vectors and positions lowered.

Rules: CNF-17, MSH-5, MSH-12..16, MSH-31, MSH-32.

Vectors are coded in the order of the traversal, and predicted from their neighbours: without a node all that changes.
So an object is taken apart into geometries with the vectors of their nodes, edited, and coded anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from snhc.reference_impl.mesh.encode import delaunay_geometry, motion_plane
from snhc.reference_impl.mesh.records import UNIFORM, MeshGeometry, MeshObject, MeshPlane
from snhc.reference_impl.mesh.state import MeshState
from snhc.reference_impl.syntax.element import DEFAULT_READINGS
from snhc.reference_impl.systems.visual import StreamItem

if TYPE_CHECKING:
    from .streams import Edit, Stream

Node = tuple[int, int]
"""Of a uniform mesh (column, row), of a Delaunay mesh (number, 0)."""


@dataclass(slots=True)
class Part:
    """A geometry with the planes up to the next. `vectors`: of each plane with motion, by node; None for others."""

    geometry: MeshGeometry
    planes: list[MeshPlane] = field(default_factory=list)
    vectors: list[dict[Node, tuple[int, int]] | None] = field(default_factory=list)

    def nodes(self) -> list[Node]:
        """All nodes in the order of their numbers."""
        g = self.geometry
        if g.type == UNIFORM:
            return [(x, y) for y in range(g.nodes_vert) for x in range(g.nodes_hor)]
        return [(n, 0) for n in range(len(g.xs))]


def _objects(items: list[StreamItem]) -> list[MeshObject]:
    return [item.mesh for item in items if item.mesh is not None]


def _apart(obj: MeshObject) -> list[Part]:
    parts: list[Part] = []
    before: tuple[tuple[int, int], ...] = ()
    for plane in obj.planes:
        now = plane.frames[0].nodes
        if plane.geometry is not None:
            parts.append(Part(plane.geometry, [plane], [None]))
        elif parts:
            moved: dict[Node, tuple[int, int]] | None = None
            if plane.motion is not None:
                steps = [(x - u, y - v) for (x, y), (u, v) in zip(now, before, strict=True)]
                moved = dict(zip(parts[-1].nodes(), steps, strict=True))
            parts[-1].planes.append(plane)
            parts[-1].vectors.append(moved)
        before = now
    return parts


def _together(parts: list[Part]) -> None:
    """Code the vectors of all planes anew, for the geometries as they are."""
    for part in parts:
        state = MeshState(DEFAULT_READINGS)
        state.set_geometry(part.geometry)
        assert state.topology is not None
        nodes = part.nodes()
        for plane, vectors in zip(part.planes, part.vectors, strict=True):
            if vectors is not None:
                steps = [vectors[node] for node in nodes]
                plane.motion = motion_plane(state.topology, [x for x, _ in steps], [y for _, y in steps]).motion


def _edit(change: Callable[[list[list[Part]]], None]) -> Edit:
    def edit(items: list[StreamItem]) -> None:
        objects = [_apart(obj) for obj in _objects(items)]
        change(objects)
        for parts in objects:
            _together(parts)

    return edit


def shrink(stream: Stream) -> None:
    """One round over all mesh objects. Rules: CNF-17."""
    for o, obj in enumerate(_objects(stream.items())):
        for p, part in enumerate(_apart(obj)):
            if part.geometry.type == UNIFORM:
                _grid(stream, o, p)
            else:
                _nodes(stream, o, p)
    _vectors(stream)


def _grid(stream: Stream, o: int, p: int) -> None:
    for name, least in (("nodes_hor", 2), ("nodes_vert", 2), ("rect_hor", 1), ("rect_vert", 1), ("split_code", 0)):

        def setting(value: int, name: str = name, least: int = least) -> Edit:
            def change(objects: list[list[Part]]) -> None:
                setattr(objects[o][p].geometry, name, value + least)

            return _edit(change)

        value = getattr(_apart(_objects(stream.items())[o])[p].geometry, name) - least
        stream.lower(value, setting)


def _nodes(stream: Stream, o: int, p: int) -> None:
    count = len(_apart(_objects(stream.items())[o])[p].geometry.xs)

    def keeping(kept: list[int]) -> Edit:
        def change(objects: list[list[Part]]) -> None:
            part = objects[o][p]
            g = part.geometry
            places = [(g.xs[n], g.ys[n]) for n in kept]
            boundary = sum(n < g.boundary_count for n in kept)
            part.geometry = delaunay_geometry(places, boundary)
            part.planes[0].geometry = part.geometry
            part.vectors = [
                None if vectors is None else {(i, 0): vectors[n, 0] for i, n in enumerate(kept)}
                for vectors in part.vectors
            ]

        return _edit(change)

    stream.reduce(range(count), keeping)
    # Coordinates: the differences get shorter where a node comes nearer to the origin.
    for axis in ("xs", "ys"):
        for n in range(len(_apart(_objects(stream.items())[o])[p].geometry.xs)):

            def setting(value: int, axis: str = axis, n: int = n) -> Edit:
                def change(objects: list[list[Part]]) -> None:
                    getattr(objects[o][p].geometry, axis)[n] = value

                return _edit(change)

            value = getattr(_apart(_objects(stream.items())[o])[p].geometry, axis)[n]
            stream.lower(value, setting)


def _vectors(stream: Stream) -> None:
    places = [
        (o, p, i, node)
        for o, obj in enumerate(_objects(stream.items()))
        for p, part in enumerate(_apart(obj))
        for i, vectors in enumerate(part.vectors)
        if vectors is not None
        for node, step in vectors.items()
        if step != (0, 0)
    ]

    def keeping(kept: list[tuple[int, int, int, Node]]) -> Edit:
        def change(objects: list[list[Part]]) -> None:
            for o, p, i, node in set(places) - set(kept):
                vectors = objects[o][p].vectors[i]
                assert vectors is not None
                vectors[node] = (0, 0)

        return _edit(change)

    for o, p, i, node in stream.reduce(places, keeping):
        for axis in (0, 1):

            def setting(value: int, axis: int = axis, at: tuple[int, int, int, Node] = (o, p, i, node)) -> Edit:
                def change(objects: list[list[Part]]) -> None:
                    vectors = objects[at[0]][at[1]].vectors[at[2]]
                    assert vectors is not None
                    x, y = vectors[at[3]]
                    vectors[at[3]] = (value, y) if axis == 0 else (x, value)

                return _edit(change)

            vectors = _apart(_objects(stream.items())[o])[p].vectors[i]
            if vectors is None or node not in vectors:
                continue
            stream.lower(vectors[node][axis], setting)
