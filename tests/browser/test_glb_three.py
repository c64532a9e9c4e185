"""GLB files of `snhc render` in a standard viewer: three.js in Chromium loads one and plays its animation.

Rules: FAT-2..5, FAT-7, FAT-9, FBA-38. three.js is installed by npm into a temporary folder, in the version and with
the checksum of `three/package-lock.json`; nothing of it is kept.
"""

from __future__ import annotations

import http.server
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import Page
from numpy.typing import NDArray
from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

from snhc.analyzer.face_scene import FaceModel, exact_vertices, load_model
from snhc.conformance.cli import snhc
from snhc.reference_impl.systems.stream import decode_frames

VIEWER = Path(__file__).with_name("three")
RATE = 25
WIDTH, HEIGHT = 600, 720
# Metres. Sums of float32 products; the turns of head and eyes are float32 quaternions, some 0.15 m from their centre.
BOUND = 2e-6
# What moves and until where: no value leaves its interval between two keys, so that the weights' mean is the values'.
FAPS = {
    3: 280, 4: -150, 5: -500, 10: -350, 11: -350, 19: 240, 20: 240, 23: 12_000, 24: 12_000, 31: 200, 32: 200,
    49: 25_000,
}  # fmt: skip
STEPS = (0.0, 0.25, 0.5, 1.0, 0.75, 0.5, 0.0)
_NETWORK = ("ENOTFOUND", "EAI_AGAIN", "ETIMEDOUT", "ECONNREFUSED", "ECONNRESET", "ENETUNREACH", "EHOSTUNREACH")


@dataclass
class _Pose:
    faps: list[float | None]
    viseme: None = None
    expression: None = None


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        pass


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the viewer's page and three.js."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("no npm, which installs three.js (Debian: npm)")
    folder = tmp_path_factory.mktemp("three")
    shutil.copytree(VIEWER, folder, dirs_exist_ok=True)
    installed = subprocess.run(
        [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )
    if installed.returncode and any(word in installed.stderr for word in _NETWORK):
        pytest.skip("npm does not reach its registry for three.js")
    assert installed.returncode == 0, installed.stderr
    return folder


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Where a local server offers the folder: modules cannot be loaded from files."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(site)))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()
    thread.join()


@pytest.fixture(scope="module")
def stream(site: Path) -> Path:
    """A stream, and the GLB files that `snhc render` makes of it and of its frame 3 alone."""
    mask = " ".join("1" if fap in FAPS else "0" for fap in range(1, 69))
    rows = [" ".join(str(round(value * step)) for value in FAPS.values()) for step in STEPS]
    text = site / "moves.fap"
    text.write_text(f"2.1 moves {RATE} {len(rows)}\n" + "".join(f"{mask}\n{n} {row}\n" for n, row in enumerate(rows)))
    path = site / "moves.fba"
    _run("encode", text, "--quant", "4", "-o", path)
    _run("render", path, "-o", site / "moves.glb")
    _run("render", path, "--planes", "3", "-o", site / "still.glb")
    return path


def _run(*args: object) -> None:
    done = CliRunner().invoke(snhc, [str(arg) for arg in args])
    assert done.exit_code == 0, done.output


@pytest.fixture(scope="module")
def frames(stream: Path) -> list[list[int | None]]:
    return [list(frame.faps) for frame in decode_frames(stream.read_bytes())]


@pytest.fixture(scope="module")
def model() -> FaceModel:
    return load_model()


@pytest.fixture
def play(page: Page, address: str, stream: Path) -> Callable[[str], webdriver.Chrome]:
    """Opens a file of the folder in the viewer."""

    def opened(name: str) -> webdriver.Chrome:
        page.errors()
        page.browser.get(f"{address}/index.html?file={name}")
        WebDriverWait(page.browser, 60).until(lambda browser: browser.title == "ready")
        return page.browser

    return opened


def _positions(browser: webdriver.Chrome, second: float) -> Iterator[tuple[str, NDArray[np.float64]]]:
    browser.execute_script("face.seek(arguments[0])", second)
    for name, flat in browser.execute_script("return face.positions()"):
        yield name, np.array(flat).reshape(-1, 3)


def _pixels(browser: webdriver.Chrome) -> NDArray[np.int64]:
    return np.array(browser.execute_script("return face.pixels()"), np.int64).reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]


def _assert_posed(
    browser: webdriver.Chrome, second: float, model: FaceModel, faps: list[float | None], bound: float
) -> None:
    expected = exact_vertices(model, _Pose(faps))
    found = list(_positions(browser, second))
    assert {name for name, _ in found} == set(expected)
    for name, points in found:
        assert np.abs(points - expected[name] * model.unit).max() < bound, (name, second)


def test_every_key_is_our_own_position(play: Any, frames: list[Any], model: FaceModel) -> None:
    browser = play("moves.glb")
    assert browser.execute_script("return face.durations") == [pytest.approx((len(STEPS) - 1) / RATE)]
    for n, faps in enumerate(frames):
        _assert_posed(browser, n / RATE, model, faps, BOUND)
    # There is something to see: the lower lip falls and the brow rises by millimetres, the nose turns by centimetres.
    still, moved = (dict(_positions(browser, n / RATE)) for n in (0, 3))
    assert np.abs(moved["left_brow"] - still["left_brow"]).max() > 0.003
    assert np.abs(moved["skin"] - still["skin"]).max() > 0.02


def test_between_keys_the_face_is_between(play: Any, frames: list[Any], model: FaceModel) -> None:
    browser = play("moves.glb")
    for n in range(len(frames) - 1):
        for part in (0.25, 0.5):
            mixed = [None if a is None else a + (b - a) * part for a, b in zip(frames[n], frames[n + 1], strict=True)]
            _assert_posed(browser, (n + part) / RATE, model, mixed, BOUND)


def test_the_morphs_are_drawn(play: Any, page: Page) -> None:
    browser = play("moves.glb")
    neutral = _pixels(browser)
    page.shot("neutral")
    browser.execute_script("face.seek(arguments[0])", 3 / RATE)
    posed = _pixels(browser)
    page.shot("posed")
    changed = (np.abs(posed - neutral) > 24).any(axis=2)
    assert changed.mean() > 0.05
    # A file that holds the one frame without animation gives the same picture.
    play("still.glb")
    again = _pixels(browser)
    page.shot("still")
    assert (np.abs(again - posed) > 24).any(axis=2).mean() < 0.001


def test_it_plays_in_real_time_to_the_end(play: Any, frames: list[Any], model: FaceModel) -> None:
    browser = play("moves.glb")
    drawn, reached = browser.execute_async_script("face.play().then(arguments[0])")
    assert drawn >= 2 and reached == pytest.approx((len(STEPS) - 1) / RATE)
    _assert_posed(browser, reached, model, frames[-1], BOUND)
