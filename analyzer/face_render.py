"""Pictures of a head: cameras, normals, lights, and a renderer in software.

Rules: FAC-10, CNF-19 (the same picture on every machine, with or without GL).

The software renderer has exact integer coverage and depth, smooth normals per pixel and 2 x 2 samples. The one that
uses GL is in `face_vtk`, files are in `face_pictures`. Both look along parallel rays and use the same lights.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, radians, sin
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import RangeViolation

from .face_scene import FaceModel, FaceScene

Picture = NDArray[np.uint8]
Vertices = Mapping[str, NDArray[np.floating]]
Floats = NDArray[np.float64]

BACKGROUND: Final = (209, 217, 224)
# Direction towards the light, intensity; in model coordinates: the light comes from the face's upper right.
LIGHTS: Final = (
    ((-150.0, 250.0, 400.0), 0.68),
    ((300.0, 100.0, 250.0), 0.25),
    ((0.0, -100.0, 300.0), 0.12),
)
# One more from the camera.
HEADLIGHT: Final = 0.2
AMBIENT: Final = 0.12
# Strength and power of highlights; eyes are wet.
SKIN_SHINE: Final = (0.12, 12)
EYE_SHINE: Final = (0.6, 30)
# Azimuth (towards the face's left) and elevation in degrees.
VIEWS: Final = {"front": (0.0, 0.0), "three-quarter": (35.0, 5.0), "side": (90.0, 0.0)}
MIN_SIDE: Final = 16
MAX_SIDE: Final = 4096
_SUBPIXEL: Final = 16
_SAMPLES: Final = 2
_DEPTHS: Final = 1 << 30
_MARGIN: Final = 1.12
_CHUNK: Final = 1 << 19


@dataclass(frozen=True, slots=True)
class Camera:
    """A parallel projection.

    Rules: FAC-10. `azimuth`, `elevation`: degrees. `focus`: the point in the middle. `half_height`: of the picture;
    lengths are model units.
    """

    azimuth: float
    elevation: float
    focus: tuple[float, float, float]
    half_height: float

    def axes(self) -> Floats:
        """Right, up and towards the viewer, as the rows of a 3 x 3 matrix. Rules: FAC-10."""
        a, e = radians(self.azimuth), radians(self.elevation)
        return np.array(
            [
                [cos(a), 0.0, -sin(a)],
                [-sin(a) * sin(e), cos(e), -cos(a) * sin(e)],
                [sin(a) * cos(e), sin(e), cos(a) * cos(e)],
            ]
        )


class Renderer(Protocol):
    """Draws vertices as a picture. Rules: FAC-10."""

    def picture(self, vertices: Vertices, camera: Camera) -> Picture:
        """uint8 (height, width, 3), sRGB. Rules: FAC-10."""


def check_size(size: tuple[int, int]) -> None:
    """Raise RangeViolation for a width or height that cannot be drawn. Rules: CNF-22."""
    for what, value in zip(("width", "height"), size, strict=True):
        if not MIN_SIDE <= value <= MAX_SIDE:
            raise RangeViolation("CNF-22", what, value=value, allowed=f"{MIN_SIDE}..{MAX_SIDE}")


def camera_for(scene: FaceScene, view: str, size: tuple[int, int]) -> Camera:
    """A camera that has the neutral face in view, with a margin for its motion.

    Rules: FAC-10. `view`: a name of VIEWS. `size`: width and height in pixels.
    """
    azimuth, elevation = VIEWS[view]
    points = np.concatenate([np.zeros((0, 3)), *(p.astype(np.float64) for p in scene.neutral().values() if len(p))])
    if not len(points):
        return Camera(azimuth, elevation, (0.0, 0.0, 0.0), 1.0)
    low, high = points.min(axis=0), points.max(axis=0)
    focus = (low + high) / 2
    camera = Camera(azimuth, elevation, (float(focus[0]), float(focus[1]), float(focus[2])), 1.0)
    seen = np.abs((points - focus) @ camera.axes().T).max(axis=0)
    half = max(float(seen[1]), float(seen[0]) * size[1] / size[0]) * _MARGIN
    return Camera(azimuth, elevation, camera.focus, half or 1.0)


def vertex_normals(points: Floats, faces: NDArray[np.int64]) -> Floats:
    """Unit normals, (V, 3), of the faces around each vertex, weighted by their angles there.

    Rules: FAC-10. Vertices without area around them get 0.
    """
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-12)[:, None]
    out = np.zeros_like(points)
    for k in range(3):
        a = corners[:, (k + 1) % 3] - corners[:, k]
        b = corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-12)
        angle = np.arccos(np.clip((a * b).sum(axis=1) / lengths, -1.0, 1.0))
        np.add.at(out, faces[:, k], normals * angle[:, None])
    out /= np.maximum(np.linalg.norm(out, axis=1), 1e-12)[:, None]
    return out


def is_closed(faces: NDArray[np.int64]) -> bool:
    """Whether every edge has two faces that run through it in opposite directions. Rules: FAC-10."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    key = edges[:, 0] << 32 | edges[:, 1]
    other = edges[:, 1] << 32 | edges[:, 0]
    return len(np.unique(key)) == len(key) and bool(np.array_equal(np.sort(key), np.sort(other)))


def is_eye(name: str) -> bool:
    """Whether a mesh shines like an eye. Rules: FAC-10."""
    return name.endswith("_eye")


class SoftwareRenderer:
    """The renderer that needs numpy only; the same vertices give the same picture in every run.

    Rules: FAC-10. `size`: width and height in pixels. Faces are sRGB, lit as they are. Closed meshes show their
    outside only.
    """

    def __init__(self, model: FaceModel, size: tuple[int, int]) -> None:
        check_size(size)
        self._size = size
        self._names = tuple(name for name, mesh in model.document.meshes.items() if len(mesh.faces))
        faces, colours, shine, closed = [], [], [], []
        first = 0
        for name in self._names:
            mesh = model.document.meshes[name]
            faces.append(mesh.faces + first)
            first += len(mesh.vertices)
            colours.append(model.colours[name].astype(np.float64))
            shine.append(np.tile(EYE_SHINE if is_eye(name) else SKIN_SHINE, (len(mesh.faces), 1)))
            closed.append(np.full(len(mesh.faces), is_closed(mesh.faces)))
        self._faces = np.concatenate([np.zeros((0, 3), np.int64), *faces])
        self._colours = np.concatenate([np.zeros((0, 3)), *colours])
        self._shine = np.concatenate([np.zeros((0, 2)), *shine])
        self._closed = np.concatenate([np.zeros(0, np.bool_), *closed])

    def picture(self, vertices: Vertices, camera: Camera) -> Picture:
        """uint8 (height, width, 3). Rules: FAC-10."""
        width, height = self._size[0] * _SAMPLES, self._size[1] * _SAMPLES
        flat = np.empty((height * width, 3))
        flat[:] = BACKGROUND
        if len(self._faces):
            points = np.concatenate([np.asarray(vertices[name], np.float64) for name in self._names])
            axes = camera.axes()
            seen = (points - np.array(camera.focus)) @ axes.T
            scale = height / (2 * camera.half_height) * _SUBPIXEL
            # What lies far outside is cut there: it must not leave the range of the integer arithmetic.
            far = 8.0 * _SUBPIXEL * MAX_SIDE
            x = np.clip(width * _SUBPIXEL / 2 + seen[:, 0] * scale, -far, far)
            y = np.clip(height * _SUBPIXEL / 2 - seen[:, 1] * scale, -far, far)
            screen = np.stack([np.floor(x + 0.5), np.floor(y + 0.5)], axis=1).astype(np.int64)
            owner = self._owners(screen, seen[:, 2], width, height)
            pixels = np.flatnonzero(owner >= 0)
            flat[pixels] = self._lit(points, screen, owner[pixels], pixels, width, axes)
        shape = (self._size[1], _SAMPLES, self._size[0], _SAMPLES, 3)
        mean: Picture = np.floor(flat.reshape(shape).mean(axis=(1, 3)) + 0.5).clip(0, 255).astype(np.uint8)
        return mean

    def _owners(self, screen: NDArray[np.int64], depth: Floats, width: int, height: int) -> NDArray[np.int64]:
        """The nearest face of every sample, -1 for none; flat."""
        corners = screen[self._faces]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        near, far = float(depth.max()), float(depth.min())
        levels = np.floor((depth - far) * ((_DEPTHS - 1) / max(near - far, 1e-12)))[self._faces]
        # Outward faces run clockwise on screen, whose y points down: their area is negative there.
        drawn = (area < 0) | ((area > 0) & ~self._closed)
        turned = np.where((area < 0)[:, None, None], corners[:, [0, 2, 1]], corners)
        levels = np.where((area < 0)[:, None], levels[:, [0, 2, 1]], levels)
        half = _SUBPIXEL // 2
        first = np.maximum(-((half - turned.min(axis=1)) // _SUBPIXEL), 0)
        last = np.minimum((turned.max(axis=1) - half) // _SUBPIXEL, np.array([width - 1, height - 1]))
        extent = last - first + 1
        wanted = np.flatnonzero(drawn & (extent > 0).all(axis=1))
        side = extent.max(axis=1)
        keys = np.full(width * height, -1, np.int64)
        size = 4
        while len(wanted):
            fits = side[wanted] <= size
            batch, wanted = wanted[fits], wanted[~fits]
            step = max(1, _CHUNK // (size * size))
            for at in range(0, len(batch), step):
                some = batch[at : at + step]
                block = (min(size, width), min(size, height))
                self._draw(keys, turned[some], levels[some], first[some], some, block, width, height)
            size *= 2
        return np.where(keys >= 0, keys % len(self._faces), -1)

    def _draw(
        self,
        keys: NDArray[np.int64],
        corners: NDArray[np.int64],
        levels: Floats,
        first: NDArray[np.int64],
        faces: NDArray[np.int64],
        block: tuple[int, int],
        width: int,
        height: int,
    ) -> None:
        column = first[:, 0, None] + np.arange(block[0])
        row = first[:, 1, None] + np.arange(block[1])
        inside = (column < width)[:, None, :] & (row < height)[:, :, None]
        px, py = column * _SUBPIXEL + _SUBPIXEL // 2, row * _SUBPIXEL + _SUBPIXEL // 2
        total = np.zeros(len(faces))
        level = np.zeros(inside.shape)
        for k in range(3):
            a, b = corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]
            dx, dy = b[:, 0] - a[:, 0], b[:, 1] - a[:, 1]
            # A centre on an edge belongs to the face to its right or below.
            least = np.where((dy < 0) | ((dy == 0) & (dx > 0)), 0, 1)
            along = dx[:, None] * (py - a[:, 1, None])
            across = dy[:, None] * (px - a[:, 0, None])
            weight = along[:, :, None] - across[:, None, :]
            inside &= weight >= least[:, None, None]
            level += weight * levels[:, k, None, None]
            c = corners[:, k]
            total += dx * (c[:, 1] - a[:, 1]) - dy * (c[:, 0] - a[:, 0])
        t, j, i = np.nonzero(inside)
        nearest = np.floor(level[t, j, i] / total[t]).clip(0, _DEPTHS - 1).astype(np.int64)
        np.maximum.at(keys, row[t, j] * width + column[t, i], nearest * len(self._faces) + faces[t])

    def _lit(
        self,
        points: Floats,
        screen: NDArray[np.int64],
        owner: NDArray[np.int64],
        pixels: NDArray[np.int64],
        width: int,
        axes: Floats,
    ) -> Floats:
        """The colours of covered samples, (N, 3), 0..255."""
        faces = self._faces[owner]
        px = pixels % width * _SUBPIXEL + _SUBPIXEL // 2
        py = pixels // width * _SUBPIXEL + _SUBPIXEL // 2
        corners = screen[faces]
        all_normals = vertex_normals(points, self._faces)
        normal = np.zeros((len(pixels), 3))
        for k in range(3):
            a, b = corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]
            weight = (b[:, 0] - a[:, 0]) * (py - a[:, 1]) - (b[:, 1] - a[:, 1]) * (px - a[:, 0])
            normal += np.abs(weight)[:, None] * all_normals[faces[:, k]]
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
        facing = normal @ axes[2]
        # The inside of an open mesh is lit like its outside.
        normal = np.where((~self._closed[owner] & (facing < 0))[:, None], -normal, normal)
        strength, power = self._shine[owner].T
        diffuse = np.full(len(pixels), AMBIENT)
        shine = np.zeros(len(pixels))
        for direction, intensity in (*LIGHTS, (tuple(axes[2]), HEADLIGHT)):
            light = np.array(direction) / np.linalg.norm(direction)
            cosine = normal @ light
            diffuse += intensity * np.maximum(cosine, 0.0)
            mirrored = 2 * cosine * (normal @ axes[2]) - float(light @ axes[2])
            shine += np.where(cosine > 0, intensity * np.maximum(mirrored, 0.0) ** power, 0.0)
        lit: Floats = self._colours[owner] * diffuse[:, None] + 255.0 * (strength * shine)[:, None]
        return lit
