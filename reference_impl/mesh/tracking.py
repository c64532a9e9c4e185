"""Tracking designed meshes over pictures, and how well the first picture stands for the others.

Rules implemented: MSH-23 (informative). Positions and vectors are in half pixels, pictures are 2D arrays of
luminance, 0..255.
Not implemented here: mesh design (`design_encoder`), writing the planes (syntax), intra/inter decisions.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.mesh.design_encoder import MACROBLOCK, DesignedMesh, Picture, check_picture
from snhc.reference_impl.mesh.motion import motion_range
from snhc.reference_impl.mesh.rasteriser import covering_triangles, sample_bilinear, source_positions, warp


def _match_blocks(
    before: Picture, after: Picture, xs: list[int], ys: list[int], search: int
) -> tuple[list[int], list[int]]:
    """The best whole-pixel motion of a macroblock around every node, by the sum of absolute differences.

    A longer vector has to be better by one grey level per pixel of length, which keeps flat areas still.
    """
    half = MACROBLOCK // 2
    pad = half + search + 1
    old = np.pad(before.astype(np.int64), pad, mode="edge")
    new = np.pad(after.astype(np.int64), pad, mode="edge")
    height, width = before.shape
    steps = [(dx, dy) for dy in range(-search, search + 1) for dx in range(-search, search + 1)]
    steps.sort(key=lambda s: (abs(s[0]) + abs(s[1]), s[1], s[0]))
    vx: list[int] = []
    vy: list[int] = []
    for x, y in zip(xs, ys, strict=True):
        i = min(max(x // 2, 0), width - 1) + pad - half
        j = min(max(y // 2, 0), height - 1) + pad - half
        block = old[j : j + MACROBLOCK, i : i + MACROBLOCK]
        area = new[j - search : j + search + MACROBLOCK, i - search : i + search + MACROBLOCK]
        views = np.lib.stride_tricks.sliding_window_view(area, block.shape)
        cost = np.abs(views - block).sum(axis=(2, 3))
        best = min(
            steps,
            key=lambda s: cost[s[1] + search, s[0] + search] + 2 * MACROBLOCK * (abs(s[0]) + abs(s[1])),
        )
        vx.append(2 * best[0])
        vy.append(2 * best[1])
    return vx, vy


def _area(xs: list[int], ys: list[int], t: tuple[int, int, int]) -> int:
    a, b, c = t
    return (xs[b] - xs[a]) * (ys[c] - ys[a]) - (ys[b] - ys[a]) * (xs[c] - xs[a])


def _calm(xs: list[int], ys: list[int], vx: list[int], vy: list[int], triangles: list[tuple[int, int, int]]) -> None:
    """Shortens vectors around flipped triangles until none is left; standing still flips none."""
    while True:
        moved_xs = [x + v for x, v in zip(xs, vx, strict=True)]
        moved_ys = [y + v for y, v in zip(ys, vy, strict=True)]
        bad = {node for t in triangles if _area(moved_xs, moved_ys, t) <= 0 for node in t}
        if not bad:
            return
        if all(vx[n] == 0 and vy[n] == 0 for n in bad):
            raise EncodeError("MSH-23", "mesh", value="flipped triangles", allowed="a mesh without foldover")
        for n in bad:
            vx[n] = int(vx[n] / 2)
            vy[n] = int(vy[n] / 2)


def _star_error(
    before: Picture,
    after: Picture,
    xs: list[int],
    ys: list[int],
    new_xs: list[int],
    new_ys: list[int],
    star: list[tuple[int, int, int]],
) -> float:
    """Mean squared error of the warped triangles around a node, over the pixels they cover."""
    nodes = sorted({n for t in star for n in t})
    number = {n: k for k, n in enumerate(nodes)}
    local = [(number[a], number[b], number[c]) for a, b, c in star]
    # Only the rectangle that the triangles cover is drawn; half pixels move by an even number.
    left = max(0, min(new_xs[n] for n in nodes) // 2)
    top = max(0, min(new_ys[n] for n in nodes) // 2)
    right = min(after.shape[1], max(new_xs[n] for n in nodes) // 2 + 1)
    bottom = min(after.shape[0], max(new_ys[n] for n in nodes) // 2 + 1)
    if right <= left or bottom <= top:
        return 0.0
    target_xs = [new_xs[n] - 2 * left for n in nodes]
    target_ys = [new_ys[n] - 2 * top for n in nodes]
    owner = covering_triangles(target_xs, target_ys, local, right - left, bottom - top)
    pixels, x, y = source_positions(owner, [xs[n] for n in nodes], [ys[n] for n in nodes], target_xs, target_ys, local)
    if not pixels.size:
        return 0.0
    difference = sample_bilinear(before, x, y) - after[top:bottom, left:right].ravel()[pixels]
    return float(np.mean(difference * difference))


def track(
    before: Picture,
    after: Picture,
    xs: list[int],
    ys: list[int],
    triangles: list[tuple[int, int, int]],
    *,
    search: int = 7,
    passes: int = 2,
    range_code: int = 7,
) -> tuple[list[int], list[int]]:
    """Motion vectors of all nodes from one picture to the next: block matching, then hexagonal refinement.

    Rules: MSH-13, MSH-17, MSH-23.

    `before`, `after`: pictures of one shape. `xs`, `ys`: positions on `before` in half pixels, of a mesh
    without foldover. `search`: pixels, 0..64. `passes`: refinements by half pixels over all nodes, 0..32.
    `range_code`: vectors stay within its range. No triangle flips. Returns vectors in half pixels. Raises
    EncodeError.
    """
    check_picture(before, "picture")
    check_picture(after, "picture")
    if before.shape != after.shape:
        raise EncodeError("MSH-23", "picture", value=f"shape {after.shape}", allowed=f"{before.shape}")
    if not (0 <= search <= 64 and 0 <= passes <= 32):
        raise EncodeError("MSH-23", "search, passes", value=f"{search}, {passes}", allowed="0..64, 0..32")
    limit = motion_range(range_code)
    vx, vy = _match_blocks(before, after, xs, ys, min(search, (limit - 1) // 2))
    _calm(xs, ys, vx, vy, triangles)
    new_xs = [x + v for x, v in zip(xs, vx, strict=True)]
    new_ys = [y + v for y, v in zip(ys, vy, strict=True)]
    stars: list[list[tuple[int, int, int]]] = [[] for _ in xs]
    for t in triangles:
        for node in t:
            stars[node].append(t)
    for _ in range(passes):
        changed = False
        for node, star in enumerate(stars):
            x, y = new_xs[node], new_ys[node]
            best = (_star_error(before, after, xs, ys, new_xs, new_ys, star), x, y)
            for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)):
                new_xs[node], new_ys[node] = x + dx, y + dy
                if not (-limit <= x + dx - xs[node] < limit and -limit <= y + dy - ys[node] < limit):
                    continue
                if any(_area(new_xs, new_ys, t) <= 0 for t in star):
                    continue
                error = _star_error(before, after, xs, ys, new_xs, new_ys, star)
                if error < best[0]:
                    best = (error, x + dx, y + dy)
            new_xs[node], new_ys[node] = best[1], best[2]
            changed = changed or best[1:] != (x, y)
        if not changed:
            break
    return (
        [n - x for n, x in zip(new_xs, xs, strict=True)],
        [n - y for n, y in zip(new_ys, ys, strict=True)],
    )


def track_sequence(
    pictures: list[Picture], mesh: DesignedMesh, *, search: int = 7, passes: int = 2, range_code: int = 7
) -> list[tuple[list[int], list[int]]]:
    """The vectors of every inter plane, from each picture to the next.

    Rules: MSH-16, MSH-23.

    `pictures`: at least one; the mesh lies on the first. See `track`. Returns one pair of lists per picture
    after it.
    """
    xs, ys = mesh.xs, mesh.ys
    planes: list[tuple[list[int], list[int]]] = []
    for before, after in pairwise(pictures):
        vx, vy = track(
            before,
            after,
            xs,
            ys,
            mesh.topology.triangles,
            search=search,
            passes=passes,
            range_code=range_code,
        )
        planes.append((vx, vy))
        xs = [x + v for x, v in zip(xs, vx, strict=True)]
        ys = [y + v for y, v in zip(ys, vy, strict=True)]
    return planes


def psnr(first: Picture, second: Picture, where: NDArray[np.bool_] | None = None) -> float:
    """Peak signal-to-noise ratio in dB (peak 255); infinite for equal pictures.

    Rules: MSH-23.

    `where`: the pixels that count, all if None. Raises EncodeError where none count.
    """
    difference = first.astype(np.float64) - second
    if where is not None:
        difference = difference[where]
    if not difference.size:
        raise EncodeError("MSH-23", "coverage", value="no pixel", allowed="at least one")
    error = float(np.mean(difference * difference))
    return float("inf") if error == 0 else float(10 * np.log10(255.0 * 255.0 / error))


def self_transfiguration(
    pictures: list[Picture], mesh: DesignedMesh, planes: list[tuple[list[int], list[int]]]
) -> list[float]:
    """How well the first picture, warped along the mesh, stands for each later one: PSNR in dB over the mesh.

    Rules: MSH-16, MSH-22, MSH-23.

    `planes`: vectors of each inter plane. Returns one value per plane.
    """
    xs, ys = mesh.xs, mesh.ys
    values: list[float] = []
    for picture, (vx, vy) in zip(pictures[1:], planes, strict=True):
        xs = [x + v for x, v in zip(xs, vx, strict=True)]
        ys = [y + v for y, v in zip(ys, vy, strict=True)]
        height, width = picture.shape
        drawn, covered = warp(pictures[0], mesh.xs, mesh.ys, xs, ys, mesh.topology.triangles, width, height)
        values.append(psnr(drawn, picture, covered))
    return values
