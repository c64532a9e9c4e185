"""Mutants of mesh motion.

Rules: MSH-12..17, MSH-40, MSH-41.
"""

from __future__ import annotations

from .mutant import edit, mutant

_DIFFERENTIAL = "mesh.motion:differential"
_WRAP = "mesh.motion:wrap"
_PREDICT = "mesh.motion:predict"
_MOTION = "mesh.syntax:mesh_motion"
_VECTOR = "mesh.syntax:_vector"

mutant(
    "mesh.motion.differential-positive-off-by-one",
    "Positive differentials are one too small",
    ["MSH-12"],
    edit(
        _DIFFERENTIAL,
        "return ((vlc - 1) << (range_code - 1)) + res + 1",
        "return ((vlc - 1) << (range_code - 1)) + res",
    ),
)
mutant(
    "mesh.motion.differential-without-minus-one",
    "The code word counts from 0, not from 1",
    ["MSH-12"],
    edit(_DIFFERENTIAL, "((vlc - 1) << (range_code - 1)) + res + 1", "(vlc << (range_code - 1)) + res + 1"),
)
mutant(
    "mesh.motion.differential-sign-of-residual",
    "The residual is added to negative differentials",
    ["MSH-12"],
    edit(
        _DIFFERENTIAL,
        "return -(((-vlc - 1) << (range_code - 1)) + res + 1)",
        "return -((-vlc - 1) << (range_code - 1)) + res - 1",
    ),
)
mutant(
    "mesh.motion.residual-one-bit-more",
    "The residual has motion_range_code bits",
    ["MSH-41", "MSH-12"],
    edit(
        _VECTOR,
        "code.x_res = io.u(DELTA_MV_X_RES, range_code - 1, code.x_res)",
        "code.x_res = io.u(DELTA_MV_X_RES, range_code, code.x_res)",
    ),
    edit(
        _VECTOR,
        "code.y_res = io.u(DELTA_MV_Y_RES, range_code - 1, code.y_res)",
        "code.y_res = io.u(DELTA_MV_Y_RES, range_code, code.y_res)",
    ),
)
mutant(
    "mesh.motion.residual-behind-zero",
    "A residual follows the code word 0 too",
    ["MSH-41"],
    edit("mesh.motion:has_residual", "range_code != 1 and vlc != 0", "range_code != 1"),
)
mutant(
    "mesh.motion.factor-is-the-code",
    "The scale of differentials is the range code, not a power of two",
    ["MSH-12"],
    edit(_DIFFERENTIAL, "return ((vlc - 1) << (range_code - 1)) + res + 1", "return (vlc - 1) * range_code + res + 1"),
    edit(
        _DIFFERENTIAL,
        "return -(((-vlc - 1) << (range_code - 1)) + res + 1)",
        "return -((-vlc - 1) * range_code + res + 1)",
    ),
)
mutant(
    "mesh.motion.no-wrap",
    "Vectors are not taken back into the range",
    ["MSH-13"],
    edit(_WRAP, "if v < -limit:", "if False:"),
    edit(_WRAP, "if v > limit - 1:", "if False:"),
)
mutant(
    "mesh.motion.wrap-symmetric",
    "R itself is taken for a vector in range",
    ["MSH-13"],
    edit(_WRAP, "if v > limit - 1:", "if v > limit:"),
)
mutant(
    "mesh.motion.wrap-lower-off-by-one",
    "-R is wrapped",
    ["MSH-13"],
    edit(_WRAP, "if v < -limit:", "if v <= -limit:"),
)
mutant(
    "mesh.motion.wrap-clips",
    "Vectors out of range are clipped",
    ["MSH-13"],
    edit(_WRAP, "return v + 2 * limit", "return -limit"),
    edit(_WRAP, "return v - 2 * limit", "return limit - 1"),
)
mutant(
    "mesh.motion.range-32",
    "R is 32 << r, twice as large",
    ["MSH-13", "MSH-40"],
    edit(_WRAP, "limit = 16 << range_code", "limit = 32 << range_code"),
)
mutant(
    "mesh.motion.range-8",
    "R is 16 << (r - 1), half as large",
    ["MSH-13", "MSH-40"],
    edit(_WRAP, "limit = 16 << range_code", "limit = 8 << range_code"),
)
mutant(
    "mesh.motion.zero-flag-inverted",
    "node_motion_vector_flag 1 says that a vector follows",
    ["MSH-41", "MSH-14"],
    edit(
        _VECTOR,
        "code.zero = io.u(NODE_MOTION_VECTOR_FLAG, 1, code.zero)",
        "code.zero = 1 - io.u(NODE_MOTION_VECTOR_FLAG, 1, code.zero)",
    ),
)
mutant(
    "mesh.motion.zero-flag-predicts",
    "The flag says that the vector is the prediction",
    ["MSH-14"],
    edit(
        _MOTION,
        "if not code.zero:",
        "if code.zero:\n            vx[node], vy[node] = predict(topology, k, vx, vy)\n        if not code.zero:",
    ),
)
mutant(
    "mesh.motion.zero-not-predictor",
    "A node with the zero flag keeps its last vector as predictor",
    ["MSH-14", "MSH-15"],
    edit(
        _MOTION,
        "vx = [0] * len(xs)\n    vy = [0] * len(xs)",
        "vx = [0] * len(xs) if len(state.vx) != len(xs) else list(state.vx)\n"
        "    vy = [0] * len(xs) if len(state.vy) != len(xs) else list(state.vy)",
    ),
)
mutant(
    "mesh.motion.predict-truncated",
    "The mean of two vectors is rounded down",
    ["MSH-15"],
    edit(
        _PREDICT,
        "(vx[first] + vx[second] + 1) >> 1, (vy[first] + vy[second] + 1) >> 1",
        "(vx[first] + vx[second]) >> 1, (vy[first] + vy[second]) >> 1",
    ),
)
mutant(
    "mesh.motion.predict-toward-zero",
    "The mean of two vectors is divided with rounding toward zero",
    ["MSH-15"],
    edit(
        _PREDICT,
        "return (vx[first] + vx[second] + 1) >> 1, (vy[first] + vy[second] + 1) >> 1",
        "return int((vx[first] + vx[second] + 1) / 2), int((vy[first] + vy[second] + 1) / 2)",
    ),
)
mutant(
    "mesh.motion.predict-away-from-zero",
    "Halves of the mean are rounded away from zero",
    ["MSH-15"],
    edit(
        _PREDICT,
        "return (vx[first] + vx[second] + 1) >> 1, (vy[first] + vy[second] + 1) >> 1",
        "a, b = vx[first] + vx[second], vy[first] + vy[second]\n    return (a + (a > 0)) >> 1, (b + (b > 0)) >> 1",
    ),
)
mutant(
    "mesh.motion.predict-one-node",
    "The prediction is the vector of one node of the base edge",
    ["MSH-15"],
    edit(_PREDICT, "(vx[first] + vx[second] + 1) >> 1, (vy[first] + vy[second] + 1) >> 1", "vx[first], vy[first]"),
)
mutant(
    "mesh.motion.predict-none",
    "Vectors are not predicted",
    ["MSH-15"],
    edit(_PREDICT, "if first < 0:", "if True:"),
)
mutant(
    "mesh.motion.predict-second-node-from-zero",
    "The second node is not predicted from the first",
    ["MSH-15"],
    edit(_PREDICT, "if first < 0:", "if first < 0 or first == second:"),
)
mutant(
    "mesh.motion.predict-last-decoded",
    "The prediction is the mean of the last two vectors decoded, wherever they are",
    ["MSH-15"],
    edit(
        _PREDICT,
        "first, second = topology.predictors[k]",
        "first, second = topology.predictors[k] if k < 2 else (topology.order[k - 1], topology.order[k - 2])",
    ),
)
mutant(
    "mesh.motion.from-the-intra-plane",
    "Vectors are those from the positions of the intra plane",
    ["MSH-16"],
    edit(
        "mesh.state:reconstruct_mesh",
        "state.xs, state.ys = move(state.xs, state.ys, state.vx, state.vy)",
        "moved = move(state.xs, state.ys, state.vx, state.vy)\n        state.nodes = tuple(zip(*moved))",
    ),
    edit(
        "mesh.state:reconstruct_mesh",
        "if plane.motion is not None or plane.geometry is not None:",
        "if plane.geometry is not None:",
    ),
)
mutant(
    "mesh.motion.in-node-order",
    "Vectors come in the order of node numbers",
    ["MSH-21", "MSH-41"],
    edit(_MOTION, "for k, node in enumerate(topology.order):", "for k, node in enumerate(sorted(topology.order)):"),
)
mutant(
    "mesh.motion.x-and-y",
    "Vectors move x by their y",
    ["MSH-41", "MSH-16"],
    edit("mesh.motion:move", "zip(xs, vx, strict=True)", "zip(xs, vy, strict=True)"),
)
mutant(
    "mesh.motion.subtracted",
    "Vectors lead from the new position to the old one",
    ["MSH-16"],
    edit("mesh.motion:move", "new_xs = [x + v for", "new_xs = [x - v for"),
    edit("mesh.motion:move", "new_ys = [y + v for", "new_ys = [y - v for"),
)
mutant(
    "mesh.motion.range-code-2-bits",
    "motion_range_code has 2 bits",
    ["MSH-40"],
    edit(_MOTION, "io.u(MOTION_RANGE_CODE, 3, motion.range_code)", "io.u(MOTION_RANGE_CODE, 2, motion.range_code)"),
)
mutant(
    "mesh.motion.foldover-refused",
    "A triangle that flips over is an error",
    ["MSH-17"],
    edit(
        "mesh.syntax:_report_foldovers",
        "if flipped:",
        "if flipped:\n        io.require(False, _MOTION_FIRST, 0, plane.start, plane.end)",
    ),
)
mutant(
    "mesh.motion.foldover-not-reported",
    "A triangle that flips over is not reported",
    ["MSH-17", "CNF-23"],
    edit("mesh.syntax:_report_foldovers", "if flipped:", "if False:"),
    findings=True,
)
mutant(
    "mesh.motion.flat-triangle-reported",
    "A triangle that has shrunk to a line is reported as flipped",
    ["MSH-17", "CNF-23"],
    edit("mesh.motion:foldovers", "< (ys[b] - ys[a]) * (xs[c] - xs[a])", "<= (ys[b] - ys[a]) * (xs[c] - xs[a])"),
    findings=True,
)
