"""Mutants of mesh geometry and traversal.

Rules: MSH-1..3, MSH-5..10, MSH-18..21, MSH-30..39.
"""

from __future__ import annotations

from .mutant import edit, mutant

_SPLIT = "mesh.uniform:splits_down"
_POSITIONS = "mesh.uniform:uniform_positions"
_TRIANGLES = "mesh.uniform:uniform_triangles"
_DELTA = "mesh.syntax:_delta"
_NODES = "mesh.syntax:_nodes"
_TRAVERSE = "mesh.traversal:traverse"
_TOP_LEFT = "mesh.traversal:top_left_node"
_DELAUNAY = "mesh.triangulation:delaunay_triangles"
_STATE = "mesh.state:MeshState.set_geometry"
_FRAME = "mesh.state:reconstruct_mesh"

mutant(
    "mesh.uniform.columns-and-rows",
    "nr_of_mesh_nodes_hor is taken for the number of rows",
    ["MSH-31", "MSH-32"],
    edit(
        _STATE,
        "geometry.nodes_hor, geometry.nodes_vert, geometry.rect_hor, geometry.rect_vert",
        "geometry.nodes_vert, geometry.nodes_hor, geometry.rect_hor, geometry.rect_vert",
    ),
    edit(
        _STATE,
        "shape = (geometry.nodes_hor, geometry.nodes_vert, geometry.split_code)",
        "shape = (geometry.nodes_vert, geometry.nodes_hor, geometry.split_code)",
    ),
)
mutant(
    "mesh.uniform.column-by-column",
    "Nodes are numbered column by column",
    ["MSH-6"],
    edit(
        _POSITIONS,
        "return xs, ys",
        "return [x for x in row for _ in range(nodes_vert)], [y * rect_vert for y in range(nodes_vert)] * nodes_hor",
    ),
)
mutant(
    "mesh.uniform.cell-sizes-swapped",
    "Width and height of the cells are exchanged",
    ["MSH-34", "MSH-35", "MSH-6"],
    edit(
        _STATE,
        "geometry.nodes_vert, geometry.rect_hor, geometry.rect_vert",
        "geometry.nodes_vert, geometry.rect_vert, geometry.rect_hor",
    ),
)
mutant(
    "mesh.uniform.pixels",
    "Cell sizes are taken for pixels: positions are twice as large",
    ["MSH-6", "MSH-34"],
    edit(
        _POSITIONS,
        "row = [col * rect_hor for",
        "rect_hor, rect_vert = 2 * rect_hor, 2 * rect_vert\n    row = [col * rect_hor for",
    ),
)
mutant(
    "mesh.uniform.y-up",
    "y counts upward from the bottom row",
    ["MSH-6"],
    edit(_POSITIONS, "[line * rect_vert] * nodes_hor", "[(nodes_vert - 1 - line) * rect_vert] * nodes_hor"),
)
mutant(
    "mesh.uniform.cells-for-nodes",
    "The numbers of nodes are taken for numbers of cells",
    ["MSH-31", "MSH-32"],
    edit(
        _STATE,
        "if geometry.type == UNIFORM:",
        "if geometry.type == UNIFORM:\n            geometry.nodes_hor += 1\n            geometry.nodes_vert += 1",
    ),
)
mutant(
    "mesh.uniform.split-0-and-1",
    "Split codes 00 and 01 are exchanged",
    ["MSH-7", "MSH-36"],
    edit(_SPLIT, "return split_code == 0", "return split_code == 1"),
)
mutant(
    "mesh.uniform.split-2-and-3",
    "Split codes 10 and 11 are exchanged",
    ["MSH-7", "MSH-36"],
    edit(_SPLIT, "(parity & 1) == (split_code & 1)", "(parity & 1) != (split_code & 1)"),
)
mutant(
    "mesh.uniform.split-by-column",
    "Alternating splits alternate along the row only",
    ["MSH-7"],
    edit(_SPLIT, "parity = row + col", "parity = col"),
)
mutant(
    "mesh.uniform.split-by-cell-number",
    "Alternating splits alternate from cell to cell in the order of numbers, across the ends of rows",
    ["MSH-7"],
    edit(
        _TRIANGLES,
        "down = [splits_down(split_code, i >> 1, i & 1, alternation) for i in range(4)]",
        "down = [splits_down(split_code, (i >> 1) * cols, i & 1, alternation) for i in range(4)]",
    ),
)
mutant(
    "mesh.uniform.marker-behind-sizes",
    "The marker is read behind the cell sizes",
    ["MSH-33"],
    edit(
        "mesh.syntax:_uniform",
        "    io.marker(MARKER)\n    geometry.rect_hor = io.u(RECT_SIZE_HOR, 8, geometry.rect_hor)",
        "    geometry.rect_hor = io.u(RECT_SIZE_HOR, 8, geometry.rect_hor)\n    io.marker(MARKER)",
    ),
)
mutant(
    "mesh.uniform.same-shape-keeps-cells",
    "A geometry of the same shape keeps the cell sizes of the last one",
    ["MSH-6"],
    edit(
        _STATE,
        "shape = (geometry.nodes_hor, geometry.nodes_vert, geometry.split_code)",
        "shape = (geometry.nodes_hor, geometry.nodes_vert, geometry.split_code)\n"
        "            if shape == self._shape:\n"
        "                self.xs, self.ys = [n[0] for n in self.nodes], [n[1] for n in self.nodes]",
    ),
)
mutant(
    "mesh.uniform.same-shape-not-told-apart",
    "The topology of the last uniform mesh is kept whatever the split code says",
    ["MSH-7", "MSH-16"],
    edit(_STATE, "if shape == self._shape:", "if shape[:2] == self._shape[:2]:"),
)
mutant(
    "mesh.uniform.topology-of-the-mesh-before",
    "Behind a Delaunay mesh the topology of the uniform mesh before it is used again",
    ["MSH-16", "MSH-7"],
    edit(_STATE, "self._shape = (0, 0, 0)", "pass"),
)
mutant(
    "mesh.delaunay.value-twos-complement",
    "Deltas of nodes are two's complement numbers",
    ["MSH-5"],
    edit(
        _DELTA,
        "return code if code >> (length - 1) else code - lowest",
        "return code - (1 << length) if code >> (length - 1) else code",
    ),
)
mutant(
    "mesh.delaunay.value-sign-inverted",
    "A leading 1 of a delta is taken for: negative",
    ["MSH-5"],
    edit(
        _DELTA,
        "return code if code >> (length - 1) else code - lowest",
        "return -code if code >> (length - 1) else lowest - code",
    ),
)
mutant(
    "mesh.delaunay.value-off-by-one",
    "Negative deltas are one too small",
    ["MSH-5"],
    edit(_DELTA, "else code - lowest", "else code - lowest - 1"),
)
mutant(
    "mesh.delaunay.length-0-reads-a-bit",
    "Length 0 is followed by a bit",
    ["MSH-5"],
    edit(_DELTA, "if length == 0:\n        return 0", "if length == 0:\n        return io.u(element, 1, 0)"),
)
mutant(
    "mesh.delaunay.absolute",
    "Deltas are those to node 0",
    ["MSH-5"],
    edit(
        _NODES,
        "x += _delta(io, DELTA_X_LEN, DELTA_X, 0 if reading else xs[n] - x)",
        "x = (xs[0] if reading else x) + _delta(io, DELTA_X_LEN, DELTA_X, 0 if reading else xs[n] - x)",
    ),
)
mutant(
    "mesh.delaunay.y-before-x",
    "delta_y is read before delta_x",
    ["MSH-5"],
    edit(
        _NODES,
        "x += _delta(io, DELTA_X_LEN, DELTA_X, 0 if reading else xs[n] - x)\n"
        "        y += _delta(io, DELTA_Y_LEN, DELTA_Y, 0 if reading else ys[n] - y)",
        "y += _delta(io, DELTA_Y_LEN, DELTA_Y, 0 if reading else ys[n] - y)\n"
        "        x += _delta(io, DELTA_X_LEN, DELTA_X, 0 if reading else xs[n] - x)",
    ),
)
mutant(
    "mesh.delaunay.node-0-unsigned",
    "The position of node 0 is unsigned",
    ["MSH-39"],
    edit(_NODES, "x = io.s(NODE0_X, 13, 0 if reading else xs[0])", "x = io.u(NODE0_X, 13, 0)"),
    edit(_NODES, "y = io.s(NODE0_Y, 13, 0 if reading else ys[0])", "y = io.u(NODE0_Y, 13, 0)"),
)
mutant(
    "mesh.delaunay.no-marker-behind-node-0",
    "No marker is expected behind the x of node 0",
    ["MSH-33"],
    edit(_NODES, "io.marker(MARKER)\n    y = io.s(NODE0_Y", "y = io.s(NODE0_Y"),
)
mutant(
    "mesh.delaunay.unconstrained",
    "The triangulation is not constrained: polygon edges are not enforced",
    ["MSH-8"],
    edit(_DELAUNAY, "enforce_polygon(box_xs, box_ys, boundary_count, start, twin)", "pass"),
)
mutant(
    "mesh.delaunay.not-delaunay-behind-constraints",
    "Behind an enforced edge the triangles are not made Delaunay again",
    ["MSH-8"],
    edit("mesh.constraints:_cut", "_flip_until_delaunay(xs, ys, stack, boundary_count, start, twin, leaving)", "pass"),
)
mutant(
    "mesh.delaunay.convex-hull",
    "The polygon is taken to be clockwise always, so that the wrong side of it is kept",
    ["MSH-10"],
    edit(_DELAUNAY, "clockwise = doubled_area(xs, ys, boundary_count) > 0", "clockwise = True"),
)
mutant(
    "mesh.delaunay.ties-highest",
    "Co-circular nodes are joined as a fan from the highest number",
    ["MSH-9"],
    edit(_DELAUNAY, '_join_ties(xs, ys, mesh, reading == "lowest")', "_join_ties(xs, ys, mesh, False)"),
)
mutant(
    "mesh.delaunay.ties-as-they-fall",
    "Co-circular nodes stay as the triangulation left them",
    ["MSH-9"],
    edit(_DELAUNAY, '_join_ties(xs, ys, mesh, reading == "lowest")', "pass"),
)
mutant(
    "mesh.delaunay.boundary-nodes-last",
    "The boundary is made of the last nodes, not the first",
    ["MSH-8"],
    edit(
        _STATE,
        "mesh = delaunay_triangles(self.xs,",
        "self.xs, self.ys = self.xs[::-1], self.ys[::-1]\n            mesh = delaunay_triangles(self.xs,",
    ),
)
mutant(
    "mesh.traversal.top-left-minimum-y",
    "The top-left node is the one with the smallest y, then x",
    ["MSH-18"],
    edit(
        _TOP_LEFT,
        "diagonal = xs[node] + ys[node] - xs[best] - ys[best]",
        "diagonal = ys[node] - ys[best] or xs[node] - xs[best]",
    ),
)
mutant(
    "mesh.traversal.top-left-first-of-ties",
    "Among equal x + y the top-left node is the one with the lowest number",
    ["MSH-18"],
    edit(_TOP_LEFT, "if diagonal < 0 or (diagonal == 0 and ys[node] < ys[best]):", "if diagonal < 0:"),
)
mutant(
    "mesh.traversal.top-left-smallest-x-of-ties",
    "Among equal x + y the top-left node is the one with the smallest x",
    ["MSH-18"],
    edit(_TOP_LEFT, "(diagonal == 0 and ys[node] < ys[best])", "(diagonal == 0 and xs[node] < xs[best])"),
)
mutant(
    "mesh.traversal.top-left-is-node-0",
    "The traversal begins at node 0",
    ["MSH-18"],
    edit(_TOP_LEFT, "return best", "return 0"),
)
mutant(
    "mesh.traversal.counter-clockwise",
    "The first edge leads to the next counter-clockwise node of the boundary",
    ["MSH-19"],
    edit(
        "mesh.traversal:_initial_base_edge",
        "if twin[edge] < 0 and start[edge] == node:",
        "if twin[edge] < 0 and start[edge + 1 if edge % 3 < 2 else edge - 2] == node:",
    ),
)
mutant(
    "mesh.traversal.left-first",
    "The neighbour over the left edge is labelled before the one over the right edge",
    ["MSH-20"],
    edit(_TRAVERSE, "right = twin[before]", "right = twin[after]"),
    edit(_TRAVERSE, "left = twin[after]", "left = twin[before]"),
)
mutant(
    "mesh.traversal.depth-first",
    "Triangles are visited depth first",
    ["MSH-20"],
    edit(_TRAVERSE, "for edge in queue:", "while queue:\n        edge = queue.pop()"),
)
mutant(
    "mesh.traversal.third-node-late",
    "A triangle's third node is listed when its neighbours have been labelled, and its base edge reversed",
    ["MSH-21", "MSH-15"],
    edit(_TRAVERSE, "order = [first, second]", "order = [second, first]"),
)
mutant(
    "mesh.traversal.triangles-by-number",
    "Triangles are listed in the order of their lowest node",
    ["MSH-21", "CNF-1"],
    edit(
        _TRAVERSE,
        "return MeshTopology(triangles, order, predictors)",
        "return MeshTopology(sorted(triangles), order, predictors)",
    ),
)
mutant(
    "mesh.traversal.triangles-mirrored",
    "Triangles are printed counter-clockwise",
    ["CNF-1"],
    edit(_TRAVERSE, "triangles.append((el, em, en))", "triangles.append((el, en, em))"),
    edit(_TRAVERSE, "triangles.append((em, en, el))", "triangles.append((em, el, en))"),
    edit(_TRAVERSE, "triangles.append((en, el, em))", "triangles.append((en, em, el))"),
)
mutant(
    "mesh.traversal.on-moved-positions",
    "The traversal is computed again on the moved positions",
    ["MSH-16", "MSH-18"],
    edit(
        "mesh.syntax:mesh_motion",
        "for k, node in enumerate(topology.order):",
        "top = min(range(len(xs)), key=lambda n: (xs[n] + ys[n], ys[n]))\n    at = topology.order.index(top)\n"
        "    for k, node in enumerate(topology.order[at:] + topology.order[:at]):",
    ),
)
mutant(
    "mesh.plane.mask-0-no-nodes",
    "A plane with mesh_mask 0 is printed without nodes",
    ["MSH-3"],
    edit(_FRAME, "bool(plane.is_intra), state.nodes,", "bool(plane.is_intra), state.nodes if plane.mesh_mask else (),"),
)
mutant(
    "mesh.plane.mask-0-no-line",
    "A plane with mesh_mask 0 gives no output",
    ["MSH-3"],
    edit(_FRAME, "return [frame]", "return [frame] if plane.mesh_mask else []"),
)
mutant(
    "mesh.plane.geometry-adds",
    "An intra plane's motion of the planes before is added to its positions",
    ["MSH-16", "MSH-2"],
    edit(
        _FRAME,
        "if plane.motion is not None:\n        state.xs",
        "if plane.motion is not None or (plane.geometry is not None and len(state.vx) == len(state.xs)):\n"
        "        state.xs",
    ),
)
mutant(
    "mesh.plane.header-without-rate",
    "The temporal header of mesh planes is read as that of an inter plane always",
    ["MSH-2", "FBA-6"],
    edit(
        "mesh.syntax:mesh_object_plane",
        "temporal_header(io, plane.header, plane.is_intra)",
        "temporal_header(io, plane.header, 0)",
    ),
)
mutant(
    "mesh.plane.mask-before-intra",
    "mesh_mask is read before is_intra",
    ["MSH-2"],
    edit(
        "mesh.syntax:mesh_object_plane",
        "plane.is_intra = io.u(IS_INTRA, 1, plane.is_intra)\n    plane.mesh_mask = io.u(MESH_MASK, 1, plane.mesh_mask)",
        "plane.mesh_mask = io.u(MESH_MASK, 1, plane.mesh_mask)\n    plane.is_intra = io.u(IS_INTRA, 1, plane.is_intra)",
    ),
)
mutant(
    "mesh.plane.user-data-unknown",
    "User data between planes ends the object",
    ["MSH-2", "SYS-5"],
    edit("mesh.syntax:_end_of_plane", "== USER_DATA:", "== -7:"),
)
mutant(
    "mesh.plane.user-data-once",
    "Only one user data is taken behind a plane",
    ["MSH-2", "SYS-5"],
    edit("mesh.syntax:_end_of_plane", "while io.next_code(", "while count < 1 and io.next_code("),
)
mutant(
    "mesh.object.stuffing-refused",
    "A byte 0x7F behind the object start code is an error",
    ["MSH-2"],
    edit("mesh.syntax:mesh_object", "if io.follows(0x7F, 8, bool(obj.stuffing)) else 0", "if False else 0"),
)
mutant(
    "mesh.object.stuffing-not-reported",
    "A byte 0x7F behind the object start code is taken in silence",
    ["MSH-2", "CNF-23"],
    edit("mesh.syntax:mesh_object", 'io.finding("object-stuffing"', '"" and io.finding("object-stuffing"'),
    findings=True,
)
mutant(
    "mesh.object.padding-refused",
    "Zero bytes up to the end of the data are an error",
    ["MSH-25"],
    edit("mesh.syntax:_next_plane", "if io.only_zeros_left(bool(obj.padding)):", "if False:"),
)
mutant(
    "mesh.object.padding-not-reported",
    "Zero bytes up to the end of the data are passed over in silence",
    ["MSH-25", "CNF-23"],
    edit("mesh.syntax:_next_plane", 'io.finding("zero-padding"', '"" and io.finding("zero-padding"'),
    findings=True,
)
