"""Laws of whole mesh streams: read(write(x)) == x, write(read(b)) == b, the trace partitions, tracer = decoder.

Two parsers that share no code find the same fields, and what is decoded follows from those fields by MSH-12..16.
"""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st
from mesh_helpers import check_mesh_input, decoded, plain, with_bits
from strategies_mesh import MeshStream, delaunay_planes, mesh_streams, uniform_planes
from unit.mesh_second_parser import parse

from snhc.reference_impl.mesh.decoded import mesh_line
from snhc.reference_impl.mesh.document import read_mesh_document
from snhc.reference_impl.mesh.motion import smallest_range_code
from snhc.reference_impl.mesh.records import MeshPlane
from snhc.reference_impl.systems.mesh_encoding import encode_mesh
from snhc.reference_impl.systems.stream import decode_frames, read_stream, write_stream
from snhc.vectors.mesh_builders import mesh_stream, moved, topology_of


@given(mesh_streams())
def test_records_survive_writing_and_reading(stream: MeshStream) -> None:
    data = write_stream(stream.items)
    items = read_stream(data)
    assert plain(items) == plain(stream.items)
    assert write_stream(items) == data


@given(mesh_streams())
def test_trace_partitions_and_tracer_is_decoder(stream: MeshStream) -> None:
    assert check_mesh_input(write_stream(stream.items)) is None


@given(mesh_streams().filter(lambda stream: stream.sized))
def test_the_second_parser_finds_the_same_fields(stream: MeshStream) -> None:
    planes = parse(write_stream(stream.items))
    assert len(planes) == len(stream.planes)
    for theirs, ours in zip(planes, stream.planes, strict=True):
        assert theirs.intra == bool(ours.is_intra)
        geometry, motion = ours.geometry, ours.motion
        if geometry is None:
            assert theirs.nodes is None
        elif theirs.uniform is not None:
            assert theirs.uniform == (
                geometry.nodes_hor, geometry.nodes_vert, geometry.rect_hor, geometry.rect_vert, geometry.split_code,
            )  # fmt: skip
        else:
            assert theirs.nodes == list(zip(geometry.xs, geometry.ys, strict=True))
            assert theirs.boundary_count == geometry.boundary_count
        assert theirs.range_code == (motion.range_code if motion else 0)
        if motion is not None:
            assert theirs.codes == [(c.zero, c.x_vlc, c.x_res, c.y_vlc, c.y_res) for c in motion.codes]


@given(mesh_streams())
def test_motion_follows_the_rules(stream: MeshStream) -> None:
    """Vectors from positions: every one is the prediction plus its differential, up to one period (MSH-12..15)."""
    frames, _, error = decoded(write_stream(stream.items))
    assert error is None
    geometry: MeshPlane | None = None
    before = frames[0]
    for plane, frame in zip(stream.planes, frames, strict=True):
        if plane.geometry is not None:
            geometry = plane
            assert frame.order is not None and sorted(frame.order) == list(range(len(frame.nodes)))
        elif plane.motion is None:
            assert frame.nodes == before.nodes
        else:
            assert geometry is not None
            f = 1 << (plane.motion.range_code - 1)
            limit = 32 * f
            topology = topology_of(geometry)
            v = [(n[0] - o[0], n[1] - o[1]) for n, o in zip(frame.nodes, before.nodes, strict=True)]
            for node, code, (a, b) in zip(topology.order, plane.motion.codes, topology.predictors, strict=True):
                for axis, vlc, res in ((0, code.x_vlc, code.x_res), (1, code.y_vlc, code.y_res)):
                    assert -limit <= v[node][axis] < limit
                    if code.zero:
                        assert v[node][axis] == 0
                        continue
                    prediction = 0 if a < 0 else (v[a][axis] + v[b][axis] + 1) // 2
                    size = 0 if vlc == 0 else (abs(vlc) - 1) * f + res + 1
                    d = size if vlc > 0 else -size
                    assert (v[node][axis] - prediction - d) % (2 * limit) == 0
        before = frame


@given(mesh_streams(), st.integers(0, 2**30), st.integers(1, 255), st.booleans())
def test_damage_gives_a_decode_or_one_located_error(stream: MeshStream, place: int, mask: int, cut: bool) -> None:
    data = write_stream(stream.items)
    at = place % len(data)
    damaged = data[:at] if cut else data[:at] + bytes([data[at] ^ mask]) + data[at + 1 :]
    check_mesh_input(damaged)


@given(st.one_of(uniform_planes(), delaunay_planes()), st.data())
def test_documents_of_decoded_meshes_encode_to_the_same_frames(plane: MeshPlane, data: st.DataObject) -> None:
    """CNF-1 lines are enough: kind of mesh, boundary and split are found again from nodes and triangles."""
    count = len(topology_of(plane).order)
    step = data.draw(st.sampled_from((1, 31, 32, 500, 2047)))
    vector = st.tuples(st.integers(-step - 1, step), st.integers(-step - 1, step))
    vectors = data.draw(st.dictionaries(st.integers(0, count - 1), vector, max_size=count))
    motion = moved(plane, vectors)
    assert motion.motion is not None
    assert motion.motion.range_code == smallest_range_code(
        [x for x, _ in vectors.values()], [y for _, y in vectors.values()]
    )
    skip = data.draw(st.integers(0, 3))
    plane.header.skip_frames, plane.header.number_of_frames_to_skip = 1, skip
    frames = list(decode_frames(write_stream(mesh_stream(plane, motion))))
    lines = ['{"format":"snhc-decoded","version":1,"kind":"mesh"}', *(mesh_line(frame) for frame in frames)]
    document = read_mesh_document("\n".join(lines).encode())
    assert document[1].time == Fraction(1 + skip, 30)
    again = list(decode_frames(write_stream(encode_mesh(document))))
    assert again == frames


@given(st.integers(0, 2**44 - 1), st.integers(0, 2**60 - 1))
def test_any_bits_behind_a_plane_header(word: int, more: int) -> None:
    data = bytes.fromhex("000001bc000001bd") + bytes(13)
    check_mesh_input(with_bits(data, 64, f"11000{word:044b}{more:055b}"[:104]))
