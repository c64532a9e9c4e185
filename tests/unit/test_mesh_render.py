"""Pictures of mesh streams: golden images compared pixel by pixel, sizes, speeds, and the verb `render`.

A golden image is made anew by running this file: `python tests/unit/test_mesh_render.py`. Look at it before it is
committed.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from snhc.conformance.cli import snhc
from snhc.reference_impl.bitstream.errors import InputFormat, RangeViolation, ResourceLimit
from snhc.reference_impl.mesh.records import MeshFrame, MeshPlane
from snhc.reference_impl.mesh.render import open_picture, picture_file, render_frames
from snhc.reference_impl.systems.stream import decode_frames, write_stream
from snhc.vectors.builders import intra, stream
from snhc.vectors.mesh_builders import delaunay, mesh_stream, mesh_timed, moved, still, uniform

GOLDEN = Path(__file__).parents[1] / "fixtures" / "golden"
EX2 = bytes.fromhex("000001bc000001bdc4000d0160008003de43a9d772fbdc6e5f5b96000001bd48a8c420382500f0143f000001b1")


def frames_of(*planes: MeshPlane) -> list[MeshFrame]:
    return [frame for frame in decode_frames(write_stream(mesh_stream(*planes))) if isinstance(frame, MeshFrame)]


def chequered(width: int, height: int) -> Image.Image:
    """Colours that tell the corners apart, and squares of 8 pixels that show every bend."""
    y, x = np.mgrid[:height, :width]
    dark = ((x // 8 + y // 8) % 2).astype(np.uint8)
    pixels = np.stack([x * 255 // width, y * 255 // height, 255 - x * 255 // width], axis=2).astype(np.uint8)
    return Image.fromarray(np.where(dark[..., None] == 1, pixels // 2, pixels).astype(np.uint8))


def uniform_alternating() -> Image.Image:
    return render_frames(frames_of(uniform(4, 3, 30, 24, 2)), numbers=False)[0][1]


def delaunay_example() -> Image.Image:
    frames = [frame for frame in decode_frames(EX2) if isinstance(frame, MeshFrame)]
    return render_frames(frames, numbers=False)[0][1]


def delaunay_motion() -> Image.Image:
    frames = [frame for frame in decode_frames(EX2) if isinstance(frame, MeshFrame)]
    return render_frames(frames, planes=(1, 2), numbers=False)[0][1]


def foldover() -> Image.Image:
    first = delaunay([(0, 0), (60, 0), (64, 52), (0, 60), (20, 30)], 4)
    return render_frames(frames_of(first, moved(first, {4: (60, 10)})), planes=(1, 2), numbers=False)[0][1]


def textured_still() -> Image.Image:
    return render_frames(frames_of(uniform(5, 4, 32, 32, 2)), texture=chequered(64, 48), scale=1)[0][1]


def textured_bent() -> Image.Image:
    first = uniform(5, 4, 32, 32, 3)
    bend = moved(first, {6: (14, 9), 7: (14, 9), 8: (14, 9), 11: (-12, -9), 12: (-12, 9), 13: (0, -20), 0: (10, 6)})
    return render_frames(frames_of(first, bend), texture=chequered(64, 48), planes=(1, 2), scale=2)[0][1]


def textured_delaunay() -> Image.Image:
    first = delaunay([(8, 4), (120, 10), (110, 84), (64, 60), (12, 90), (60, 30), (84, 48)], 5)
    turn = moved(first, {0: (10, 8), 5: (-14, 10), 6: (12, -8), 3: (0, 20)})
    texture = chequered(64, 48).convert("L")
    return render_frames(frames_of(first, turn), texture=texture, planes=(1, 2), scale=2)[0][1]


PICTURES: dict[str, Callable[[], Image.Image]] = {
    "mesh-uniform": uniform_alternating,
    "mesh-delaunay": delaunay_example,
    "mesh-motion": delaunay_motion,
    "mesh-foldover": foldover,
    "mesh-textured-still": textured_still,
    "mesh-textured-bent": textured_bent,
    "mesh-textured-delaunay": textured_delaunay,
}


@pytest.mark.parametrize("name", PICTURES)
def test_golden_image(name: str) -> None:
    path = GOLDEN / f"{name}.png"
    assert path.stat().st_size <= 10 * 1024
    drawn = PICTURES[name]()
    with Image.open(path) as golden:
        assert (golden.mode, golden.size) == (drawn.mode, drawn.size)
        differ = np.argwhere(np.asarray(golden) != np.asarray(drawn))
    assert len(differ) == 0, f"{len(differ)} values differ, the first at row, column {differ[0].tolist()}"


def test_golden_images_are_all_used() -> None:
    assert {path.stem for path in GOLDEN.glob("mesh-*")} == set(PICTURES)


def test_a_mesh_that_stays_shows_its_texture_unchanged() -> None:
    texture = chequered(64, 48)
    frames = frames_of(uniform(5, 4, 32, 32, 1), still(), moved(uniform(5, 4, 32, 32, 1), {}))
    for _, picture in render_frames(frames, texture=texture, scale=1):
        assert np.array_equal(np.asarray(picture), np.asarray(texture))


def test_a_new_geometry_takes_the_texture_anew() -> None:
    """Texture coordinates are those of the last intra plane (MSH-22)."""
    first = uniform(3, 3, 32, 24)
    shifted = moved(first, dict.fromkeys(range(9), (8, 4)))
    texture = chequered(32, 24)
    pictures = [
        np.asarray(picture) for _, picture in render_frames(frames_of(first, shifted, first), texture=texture, scale=1)
    ]
    assert np.array_equal(pictures[0], np.asarray(texture))
    assert np.array_equal(pictures[1][2:, 4:], np.asarray(texture)[:-2, :-4])
    assert not pictures[1][:2].any() and not pictures[1][:, :4].any()
    assert np.array_equal(pictures[2], pictures[0])


def test_planes_without_a_mesh_are_left_out_and_all_pictures_have_one_size() -> None:
    first = uniform(2, 2, 20, 20)
    frames = frames_of(still(1), first, moved(first, {0: (-90, 40)}), still())
    rendered = render_frames(frames)
    assert [frame.index for frame, _ in rendered] == [1, 2, 3]
    assert len({picture.size for _, picture in rendered}) == 1
    assert [frame.index for frame, _ in render_frames(frames, planes=(2, None))] == [2, 3]
    assert [frame.index for frame, _ in render_frames(frames, planes=(0, 3))] == [1, 2]
    assert [frame.index for frame, _ in render_frames(frames, most=1)] == [1]


def test_what_cannot_be_drawn() -> None:
    frames = frames_of(uniform(2, 2, 20, 20))
    with pytest.raises(InputFormat):
        render_frames(frames_of(still(1)))
    with pytest.raises(InputFormat):
        render_frames(frames, planes=(1, None))
    with pytest.raises(RangeViolation):
        render_frames(frames, scale=0)
    far = uniform(2, 2, 255, 255)
    with pytest.raises(ResourceLimit):
        render_frames(frames_of(far, moved(far, {0: (-2000, -2000)}), moved(far, {0: (-2000, -2000)})), scale=64)
    with pytest.raises(InputFormat):
        picture_file(render_frames(frames), "bmp")
    for data in (b"", b"\x89PNG\r\n\x1a\nrubbish", b"GIF89a"):
        with pytest.raises(InputFormat):
            open_picture(data, "texture")


def test_animation_has_the_speed_of_the_stream() -> None:
    first = mesh_timed(uniform(2, 2, 40, 40), rate=(5, 0, 0), skip=1)
    frames = frames_of(first, moved(first, {0: (5, 5)}), moved(first, {3: (5, 5)}))
    with Image.open(io.BytesIO(picture_file(render_frames(frames), "gif"))) as animation:
        durations = []
        for k in range(animation.n_frames):  # type: ignore[attr-defined]
            animation.seek(k)
            durations.append(animation.info["duration"])
    assert durations == [400, 200, 200]


# -- the verb ----------------------------------------------------------------------------------------------------------


def run(*args: str) -> Result:
    return CliRunner().invoke(snhc, list(args), prog_name="snhc")


def test_verb_draws_png_and_gif(tmp_path: Path) -> None:
    mesh, texture = tmp_path / "a.m2d", tmp_path / "t.png"
    mesh.write_bytes(EX2)
    chequered(48, 40).save(texture)
    for arguments, size, count in (
        (["-o", "a.png"], (228, 200), 1),
        (["-o", "b.png", "--scale", "1", "--no-numbers"], (138, 124), 1),
        (["-o", "c.gif", "--texture", str(texture)], (48, 40), 2),
        (["-o", "d.png", "--texture", str(texture), "--scale", "3", "--planes", "1"], (144, 120), 1),
    ):
        target = tmp_path / arguments[1]
        result = run("render", str(mesh), "-o", str(target), *arguments[2:])
        assert result.exit_code == 0, result.stderr
        with Image.open(target) as picture:
            picture.load()
            assert (picture.size, getattr(picture, "n_frames", 1)) == (size, count)


@pytest.mark.parametrize("planes", ["x", "3:3", "5:2", "-1:2", ":", "1:2:3", ""])
def test_verb_refuses_planes(planes: str, tmp_path: Path) -> None:
    mesh = tmp_path / "a.m2d"
    mesh.write_bytes(EX2)
    result = run("render", str(mesh), "--planes", planes, "-o", str(tmp_path / "a.png"))
    assert result.exit_code == 2


def test_verb_says_what_is_not_for_faces(tmp_path: Path) -> None:
    face = tmp_path / "a.fba"
    face.write_bytes(write_stream(stream(intra({3: 1}))))
    result = run("render", str(face), "--scale", "2", "-o", str(tmp_path / "a.png"))
    assert result.exit_code == 2
    assert "--scale is for meshes" in result.stderr
    assert not (tmp_path / "a.png").exists()


def test_verb_says_which_extra_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    mesh = tmp_path / "a.m2d"
    mesh.write_bytes(EX2)
    for name in [name for name in sys.modules if name.partition(".")[0] == "PIL" or name.endswith("mesh.render")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "PIL", None)
    result = run("render", str(mesh), "-o", str(tmp_path / "a.png"))
    assert result.exit_code == 2
    assert "needs the extra snhc[view]" in result.stderr


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for name, draw in PICTURES.items():
        draw().save(GOLDEN / f"{name}.png", optimize=True)
