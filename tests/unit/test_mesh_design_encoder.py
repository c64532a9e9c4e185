"""Mesh design and tracking (MSH-23) on small synthetic pictures."""

from __future__ import annotations

import numpy as np
import pytest

from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.mesh import design_encoder as design
from snhc.reference_impl.mesh import tracking
from snhc.reference_impl.mesh.motion import foldovers
from snhc.reference_impl.mesh.polygon import first_fault
from snhc.reference_impl.mesh.rasteriser import covering_triangles


def _scene(dx: float = 0.0, dy: float = 0.0, height: int = 72, width: int = 88) -> np.ndarray:
    """A smooth pattern with features everywhere, moved by (dx, dy) pixels."""
    y, x = np.mgrid[:height, :width].astype(float)
    x -= dx
    y -= dy
    waves = np.sin(x / 5.3) * np.cos(y / 6.1) + np.sin((x + 2 * y) / 9.7) + 0.7 * np.cos((x * 3 - y) / 11.0)
    return np.clip(np.round(128 + 40 * waves), 0, 255).astype(np.uint8)


def _disc(height: int = 72, width: int = 88, radius: float = 30.0) -> np.ndarray:
    y, x = np.mgrid[:height, :width]
    return (x - 44) ** 2 + (y - 36) ** 2 <= radius * radius


@pytest.mark.parametrize(("width", "height"), [(176, 144), (352, 288), (20, 16), (1, 1), (1920, 1080), (32768, 3)])
def test_uniform_design(width: int, height: int) -> None:
    mesh = design.uniform_design(width, height)
    assert mesh.cells is not None
    hor, vert, rect_hor, rect_vert, split = mesh.cells
    assert split == 2 and mesh.boundary_count == 0
    assert 2 * width <= max(mesh.xs) <= 2 * width + hor and 2 * height <= max(mesh.ys) <= 2 * height + vert
    assert max(rect_hor, rect_vert) <= 255
    macroblocks = -(-width // 16) * -(-height // 16)
    if macroblocks >= 64 and height > 64:
        assert abs(len(mesh.topology.triangles) - macroblocks) < 0.15 * macroblocks


def test_content_based_design_fits_the_object() -> None:
    mask = _disc()
    mesh = design.content_based_design(_scene(), mask, interior_nodes=40, spacing=5.0)
    assert first_fault(mesh.xs, mesh.ys, mesh.boundary_count) is None
    assert 8 <= mesh.boundary_count <= 40 and len(mesh.xs) > mesh.boundary_count + 25
    covered = covering_triangles(mesh.xs, mesh.ys, mesh.topology.triangles, 88, 72) >= 0
    assert (covered & mask).sum() > 0.95 * (covered | mask).sum()
    inner = np.array([mesh.xs, mesh.ys]).T[mesh.boundary_count :]
    distances = np.linalg.norm(inner[:, None] - inner[None], axis=2) + 1e9 * np.eye(len(inner))
    assert distances.min() > 2 * 5.0
    again = design.content_based_design(_scene(), mask, interior_nodes=40, spacing=5.0)
    assert (again.xs, again.ys, again.topology.triangles) == (mesh.xs, mesh.ys, mesh.topology.triangles)


def test_whole_picture_and_odd_masks() -> None:
    mesh = design.content_based_design(_scene(), interior_nodes=30)
    assert (max(mesh.xs), max(mesh.ys), mesh.boundary_count) == (176, 144, 4)
    cross = np.zeros((72, 88), bool)
    cross[30:42, 10:70] = True
    cross[5:65, 34:46] = True
    shape = design.content_based_design(_scene(), cross, interior_nodes=30, spacing=3.0, tolerance=0.6)
    assert shape.boundary_count >= 12
    dot = np.zeros((72, 88), bool)
    dot[20, 20] = True
    assert design.content_based_design(_scene(), dot).boundary_count == 4


def test_interior_nodes_lie_on_the_strongest_gradients() -> None:
    picture = np.zeros((60, 60), np.uint8)
    picture[:, 30:] = 200
    mesh = design.content_based_design(picture, interior_nodes=5, spacing=6.0)
    assert len(mesh.xs) == 4 + 5
    assert all(abs(x - 60) <= 2 for x in mesh.xs[4:])


def test_tracking_a_shift() -> None:
    """Pixels move by (3, -2): inner nodes follow exactly, nothing flips, the warp is nearly perfect."""
    pictures = [_scene(3 * k, -2 * k) for k in range(3)]
    mesh = design.content_based_design(pictures[0], _disc(radius=24.0), interior_nodes=20, spacing=6.0)
    planes = tracking.track_sequence(pictures, mesh, passes=1)
    for vx, vy in planes:
        assert vx == [6] * len(vx) and vy == [-4] * len(vy)
    assert min(tracking.self_transfiguration(pictures, mesh, planes)) > 50


def test_refinement_follows_a_growing_pattern() -> None:
    """A zoom by 8 %: refined vectors beat unrefined ones, and standing still; no triangle flips."""
    y, x = np.mgrid[:72, :88].astype(float)

    def scene(zoom: float) -> np.ndarray:
        u, v = (x - 44) / zoom, (y - 36) / zoom
        return np.round(128 + 50 * np.sin(u / 4.1) * np.cos(v / 5.3) + 40 * np.sin((u - v) / 7.7)).astype(np.uint8)

    pictures = [scene(1.0), scene(1.08)]
    mesh = design.content_based_design(pictures[0], _disc(radius=26.0), interior_nodes=16, spacing=8.0)
    still = ([0] * len(mesh.xs), [0] * len(mesh.xs))
    coarse = tracking.track_sequence(pictures, mesh, passes=0)
    fine = tracking.track_sequence(pictures, mesh, passes=2)
    quality = [tracking.self_transfiguration(pictures, mesh, planes)[0] for planes in ([still], coarse, fine)]
    assert quality[0] < quality[1] - 1 < quality[2] - 2
    for vx, vy in (coarse[0], fine[0]):
        xs = [a + v for a, v in zip(mesh.xs, vx, strict=True)]
        ys = [a + v for a, v in zip(mesh.ys, vy, strict=True)]
        assert foldovers(xs, ys, mesh.topology.triangles) == []


def test_tracking_never_folds() -> None:
    """Unrelated pictures: block matching scatters the nodes, and still every triangle keeps its side."""
    source = np.random.default_rng(3)
    pictures = [source.integers(0, 256, (48, 48)).astype(np.uint8) for _ in range(3)]
    mesh = design.content_based_design(pictures[0], interior_nodes=25, spacing=3.0)
    planes = tracking.track_sequence(pictures, mesh, search=5, passes=1, range_code=1)
    xs, ys = mesh.xs, mesh.ys
    for vx, vy in planes:
        assert min(vx + vy) >= -32 and max(vx + vy) <= 31 and any(vx)
        xs = [a + v for a, v in zip(xs, vx, strict=True)]
        ys = [a + v for a, v in zip(ys, vy, strict=True)]
        assert foldovers(xs, ys, mesh.topology.triangles) == []


def test_search_stops_at_the_range() -> None:
    """A shift of 20 pixels is beyond motion_range_code 1 (16 pixels) and within code 2."""
    pictures = [_scene(), _scene(20.0)]
    mesh = design.content_based_design(pictures[0], _disc(radius=20.0), interior_nodes=5)
    (far,) = tracking.track_sequence(pictures, mesh, search=24, passes=0, range_code=2)
    assert far == ([40] * len(mesh.xs), [0] * len(mesh.xs))
    ((vx, vy),) = tracking.track_sequence(pictures, mesh, search=24, passes=1, range_code=1)
    assert min(vx + vy) >= -32 and max(vx + vy) <= 31


def test_psnr() -> None:
    grey = np.full((4, 4), 100, np.uint8)
    assert tracking.psnr(grey, grey) == float("inf")
    assert tracking.psnr(grey, grey + np.uint8(5)) == pytest.approx(34.15, abs=0.01)
    where = np.zeros((4, 4), bool)
    with pytest.raises(EncodeError, match="coverage"):
        tracking.psnr(grey, grey, where)


def test_what_cannot_be_designed() -> None:
    picture = _scene()
    for bad in (
        lambda: design.uniform_design(0, 10),
        lambda: design.content_based_design(np.zeros((3, 3, 3))),
        lambda: design.content_based_design(picture, np.zeros((72, 88))),
        lambda: design.content_based_design(picture, np.ones((2, 2))),
        lambda: design.content_based_design(picture, interior_nodes=-1),
        lambda: design.content_based_design(picture, spacing=0.0),
        lambda: tracking.track(picture, picture[:-1], [0], [0], []),
        lambda: tracking.track(picture, picture, [0], [0], [], search=99),
        lambda: tracking.track(picture, picture, [0, 8, 0], [0, 0, 8], [(0, 2, 1)]),
    ):
        with pytest.raises(EncodeError, match="MSH-23"):
            bad()
