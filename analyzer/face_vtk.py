"""Pictures and a window through GL (pyvista, VTK).

Rules: FAC-10, CNF-19.

VTK ends the process where it finds no GL. So a child process tries it first, and says which kind of render window
works; the answer is kept for this process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Final

import numpy as np

from snhc.reference_impl.bitstream.errors import EncodeError

from .face_render import (
    AMBIENT,
    BACKGROUND,
    EYE_SHINE,
    HEADLIGHT,
    LIGHTS,
    SKIN_SHINE,
    Camera,
    Picture,
    Vertices,
    check_size,
    is_eye,
    vertex_normals,
)
from .face_scene import FaceModel

_WINDOW: Final = "VTK_DEFAULT_OPENGL_WINDOW"
_PROBE_SECONDS: Final = 120
_PROBE: Final = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.set_background("black")
plotter.add_mesh(pyvista.Sphere(), color="white")
picture = plotter.screenshot(None, return_img=True)
print("drawn" if picture.min() < picture.max() else "empty")
"""


@cache
def gl_window() -> str | None:
    """The kind of VTK render window that works here (empty: VTK's own choice), None where none does.

    Rules: CNF-19. Tried in child processes: without GL libraries VTK does not raise, it ends the process.
    """
    windows = ["vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"]
    if os.environ.get(_WINDOW):
        windows = [os.environ[_WINDOW]]
    elif os.environ.get("DISPLAY") or sys.platform in ("win32", "darwin"):
        windows.insert(0, "")
    for window in windows:
        environment = {**os.environ, _WINDOW: window} if window else dict(os.environ)
        try:
            child = subprocess.run(
                [sys.executable, "-c", _PROBE],
                env=environment, capture_output=True, timeout=_PROBE_SECONDS, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            continue
        if child.returncode == 0 and child.stdout.strip() == b"drawn":
            return window
    return None


def _plotter(off_screen: bool, size: tuple[int, int]) -> Any:
    if off_screen:
        window = gl_window()
        if window is None:
            raise EncodeError("CNF-19", "picture", value="no GL", allowed="the software renderer (--software)")
        if window:
            os.environ[_WINDOW] = window
    import pyvista

    return pyvista.Plotter(off_screen=off_screen, window_size=list(size), lighting="none")


class VtkRenderer:
    """The renderer that uses GL. Rules: FAC-10. `size`: width and height in pixels. Raises EncodeError without GL."""

    def __init__(self, model: FaceModel, size: tuple[int, int], off_screen: bool = True) -> None:
        import pyvista

        check_size(size)
        self._model = model
        self.plotter = _plotter(off_screen, size)
        self.plotter.set_background([part / 255 for part in BACKGROUND])
        for position, intensity in LIGHTS:
            self.plotter.add_light(
                pyvista.Light(position=position, focal_point=(0, 0, 0), intensity=intensity, light_type="scene light")
            )
        self.plotter.add_light(pyvista.Light(light_type="headlight", intensity=HEADLIGHT))
        if off_screen:
            self.plotter.enable_anti_aliasing("ssaa")
        self._surfaces: dict[str, Any] = {}
        for name, mesh in model.document.meshes.items():
            if not len(mesh.faces):
                continue
            cells = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces])
            surface = pyvista.PolyData(np.asarray(mesh.vertices, np.float64), cells.ravel())
            surface.cell_data["colour"] = model.colours[name]
            strength, power = EYE_SHINE if is_eye(name) else SKIN_SHINE
            actor = self.plotter.add_mesh(
                surface, scalars="colour", rgb=True, smooth_shading=False, ambient=AMBIENT, specular=strength,
                specular_power=power,
            )  # fmt: skip
            actor.prop.interpolation = "phong"
            self._surfaces[name] = surface

    def pose(self, vertices: Vertices) -> None:
        """Move the meshes. Rules: FAC-10."""
        for name, surface in self._surfaces.items():
            points = np.asarray(vertices[name], np.float64)
            surface.points = points
            surface.point_data["Normals"] = vertex_normals(points, self._model.document.meshes[name].faces)
            surface.point_data.active_normals_name = "Normals"

    def aim(self, camera: Camera) -> None:
        """Set the camera. Rules: FAC-10."""
        axes, focus = camera.axes(), np.array(camera.focus)
        view = self.plotter.camera
        view.position = focus + axes[2] * camera.half_height * 8
        view.focal_point = focus
        view.up = axes[1]
        view.parallel_projection = True
        view.parallel_scale = camera.half_height
        self.plotter.renderer.ResetCameraClippingRange()

    def picture(self, vertices: Vertices, camera: Camera) -> Picture:
        """uint8 (height, width, 3). Rules: FAC-10."""
        self.pose(vertices)
        self.aim(camera)
        self.plotter.render()
        drawn: Picture = np.asarray(self.plotter.screenshot(None, return_img=True), np.uint8)[:, :, :3]
        return drawn

    def close(self) -> None:
        """Give the window back. Rules: CNF-19."""
        self.plotter.close()


def play(
    model: FaceModel, frames: Iterable[Vertices], seconds: Sequence[float], camera: Camera, size: tuple[int, int]
) -> None:
    """Open a window and play the frames over and over until it is closed; the mouse turns the head.

    Rules: FAC-10. `seconds`: how long each frame is shown.
    """
    renderer = VtkRenderer(model, size, off_screen=False)
    poses = list(frames)
    renderer.pose(poses[0])
    renderer.aim(camera)
    renderer.plotter.show(interactive_update=True, auto_close=False)
    number, due = 0, time.monotonic()
    while renderer.plotter.render_window is not None and not renderer.plotter.iren.interactor.GetDone():
        now = time.monotonic()
        if now >= due:
            renderer.pose(poses[number])
            due = max(due + seconds[number], now)
            number = (number + 1) % len(poses)
        renderer.plotter.update(10)
    renderer.close()
