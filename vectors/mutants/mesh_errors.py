"""Mutants of the faults of mesh objects.

Rules: MSH-4, MSH-11, MSH-24, MSH-25, MSH-30..41, CNF-7, CNF-21.
"""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import ForbiddenValue, InconsistentSemantics, RangeViolation, ReservedValue

from .mutant import edit, mutant, value

_POLYGON = "mesh.polygon:_boundary_fault"
_MEETING = "mesh.polygon:_meeting"
_INTERIOR = "mesh.polygon:_interior_fault"
_FIRST = "mesh.polygon:first_fault"

mutant(
    "mesh.error.motion-first-accepted",
    "Motion before any geometry is passed over",
    ["MSH-4"],
    edit(
        "mesh.syntax:mesh_object_plane",
        "io.require(state.topology is not None, _MOTION_FIRST, 0, start, start + 1)",
        "plane.mesh_mask = 0 if state.topology is None else 1",
    ),
)
mutant(
    "mesh.error.type-3-forbidden",
    "mesh_type_code 11 is reported as forbidden, not reserved",
    ["MSH-30", "CNF-7"],
    value("mesh.syntax:_TYPE_3.error", ReservedValue, ForbiddenValue),
)
mutant(
    "mesh.error.type-0-as-uniform",
    "mesh_type_code 00 is taken for a uniform mesh",
    ["MSH-30"],
    edit(
        "mesh.syntax:mesh_geometry",
        "io.require(geometry.type != 0, _TYPE_0, geometry.type, start, start + 2)",
        "geometry.type = geometry.type or UNIFORM",
    ),
)
mutant(
    "mesh.error.one-column-accepted",
    "A uniform mesh with one column is accepted",
    ["MSH-11", "MSH-31"],
    value("mesh.syntax:NODES_HOR.lo", 2, 1),
    edit("mesh.uniform:uniform_positions", "nodes_hor, 2, MAX", "nodes_hor, 1, MAX"),
    edit("mesh.uniform:uniform_triangles", "nodes_hor, 2, MAX", "nodes_hor, 1, MAX"),
)
mutant(
    "mesh.error.one-row-class",
    "Too few rows are reported as a forbidden value",
    ["MSH-11", "MSH-32", "CNF-7"],
    value("mesh.syntax:NODES_VERT.fault", RangeViolation, ForbiddenValue),
)
mutant(
    "mesh.error.cell-0-accepted",
    "Cells without width are accepted",
    ["MSH-11", "MSH-34"],
    value("mesh.syntax:RECT_SIZE_HOR.lo", 1, 0),
    edit("mesh.uniform:uniform_positions", "rect_hor, 1, MAX", "rect_hor, 0, MAX"),
)
mutant(
    "mesh.error.cell-256",
    "Cell heights past 254 are refused",
    ["MSH-35"],
    value("mesh.syntax:RECT_SIZE_VERT.hi", 255, 254),
)
mutant(
    "mesh.error.two-nodes-accepted",
    "nr_of_mesh_nodes 2 is refused at the number of boundary nodes only",
    ["MSH-37", "MSH-11"],
    value("mesh.syntax:NR_OF_MESH_NODES.lo", 3, 0),
)
mutant(
    "mesh.error.more-boundary-than-nodes",
    "More boundary nodes than nodes are cut to the number of nodes",
    ["MSH-38", "MSH-11"],
    edit(
        "mesh.syntax:_delaunay",
        "io.require(geometry.boundary_count <= count, more, geometry.boundary_count, start, io.tell())",
        "geometry.boundary_count = min(geometry.boundary_count, count)",
    ),
)
mutant(
    "mesh.error.all-nodes-on-the-boundary",
    "A mesh without interior nodes is refused",
    ["MSH-38", "MSH-11"],
    edit("mesh.syntax:_delaunay", "geometry.boundary_count <= count,", "geometry.boundary_count < count,"),
)
mutant(
    "mesh.error.range-0-as-1",
    "motion_range_code 0 is accepted",
    ["MSH-40"],
    value("mesh.syntax:MOTION_RANGE_CODE.lo", 1, 0),
    edit("mesh.syntax:mesh_motion", "range_code = motion.range_code", "range_code = max(motion.range_code, 1)"),
)
mutant(
    "mesh.error.crossing-accepted",
    "Boundary edges that cross are not looked for",
    ["MSH-11"],
    edit(_MEETING, "return CROSSING", 'return ""'),
)
mutant(
    "mesh.error.touching-accepted",
    "Boundary edges that touch are accepted",
    ["MSH-11"],
    edit(_MEETING, "return CROSSING\n    return TOUCHING", "return CROSSING\n    return ''"),
    survives="the triangulation refuses what is left, with the same class and without a place, and that passes",
)
mutant(
    "mesh.error.spike-accepted",
    "A spike of 0 degrees is accepted",
    ["MSH-11"],
    edit(_POLYGON, "if edge and _turns_back(xs, ys, edge - 1, edge, end):", "if False:"),
)
mutant(
    "mesh.error.straight-node-refused",
    "A boundary node with 180 degrees is refused",
    ["MSH-11"],
    edit("mesh.polygon:_turns_back", "and ux * vx + uy * vy <= 0", ""),
)
mutant(
    "mesh.error.closing-edge-unchecked",
    "The closing edge of the polygon is not checked",
    ["MSH-11"],
    edit(_POLYGON, "edges = count if count == boundary_count else count - 1", "edges = count - 1"),
    survives="the triangulation refuses what is left, with the same class and without a place, and that passes",
)
mutant(
    "mesh.error.closing-edge-at-node-0",
    "A fault of the closing edge is reported at node 0",
    ["MSH-11", "CNF-21"],
    edit(_POLYGON, "node = edge if closing else end", "node = end"),
)
mutant(
    "mesh.error.fault-at-the-edges-first-node",
    "A fault of an edge is reported at its first node",
    ["MSH-11", "CNF-21"],
    edit(_POLYGON, "node = edge if closing else end", "node = edge"),
)
mutant(
    "mesh.error.outside-accepted",
    "Interior nodes outside the polygon are not looked for",
    ["MSH-11"],
    edit(_INTERIOR, "worst, kind = node, OUTSIDE", "pass"),
    edit(
        "mesh.triangulation:delaunay_triangles",
        "if mesh.triangle_count() != 2 * count - 2 - boundary_count:",
        "if False:",
    ),
    edit("mesh.traversal:traverse", "if len(order) != mesh.node_count:", "if False:"),
)
mutant(
    "mesh.error.on-polygon-accepted",
    "An interior node on the polygon is accepted",
    ["MSH-11"],
    edit(_INTERIOR, "worst, kind = node, ON_POLYGON", "pass"),
)
mutant(
    "mesh.error.on-a-horizontal-edge-accepted",
    "An interior node on a horizontal edge of the polygon is not noticed",
    ["MSH-11"],
    edit(_INTERIOR, "if not touches and y in flat:", "if False:"),
    survives="on a lower edge it counts as outside, at the same place; on an upper one the triangulation refuses it, "
    "with the "
    "same class and without a place, and that passes",
)
mutant(
    "mesh.error.even-odd-inverted",
    "Interior nodes are taken to lie outside where the number of edges beside them is odd",
    ["MSH-11"],
    edit(_INTERIOR, "elif first & 1 == 0:", "elif first & 1 == 1:"),
)
mutant(
    "mesh.error.repeated-accepted",
    "Two nodes at one position are accepted",
    ["MSH-11"],
    edit(_FIRST, "seen = _first_repeated(xs, ys)", "seen = -1"),
    survives="a repeated boundary node is a spike at the same place; a repeated node inside is refused by the "
    "triangulation, "
    "with the same class and without a place, and that passes",
)
mutant(
    "mesh.error.repeated-at-the-first",
    "A repeated node is reported at its first occurrence",
    ["MSH-11", "CNF-21"],
    edit(
        "mesh.polygon:_first_repeated",
        "return k",
        "return next(j for j in range(k) if xs[j] == xs[k] and ys[j] == ys[k])",
    ),
)
mutant(
    "mesh.error.last-interior-fault",
    "Of several bad interior nodes the topmost on screen is reported, not the first in the stream",
    ["MSH-11", "CNF-21"],
    edit(_INTERIOR, "if 0 <= worst < node:", "if 0 <= worst:"),
)
mutant(
    "mesh.error.polygon-class",
    "A broken polygon is reported as a range violation",
    ["MSH-11", "CNF-7"],
    value("mesh.syntax:_BROKEN_POLYGON.error", InconsistentSemantics, RangeViolation),
)
mutant(
    "mesh.error.polygon-behind-truncation",
    "A broken polygon is not looked for where the nodes are cut off",
    ["MSH-11", "CNF-7"],
    edit("mesh.syntax:_delaunay", "io.leave()\n        _check_polygon(io, geometry, spans)\n        raise", "raise"),
)
mutant(
    "mesh.error.node-range-unchecked",
    "Node positions are not limited",
    ["MSH-24"],
    edit("mesh.syntax:_nodes", "if not (NODE_MIN <= x <= NODE_MAX and NODE_MIN <= y <= NODE_MAX):", "if False:"),
    value("mesh.triangulation:MAX_COORDINATE", 16383, 1 << 20),
    value("mesh.triangulation:MIN_COORDINATE", -16384, -(1 << 20)),
)
mutant(
    "mesh.error.node-range-off-by-one",
    "-16384 is refused",
    ["MSH-24"],
    value("mesh.syntax:NODE_MIN", -16384, -16383),
)
mutant(
    "mesh.error.node-range-upper",
    "16384 is accepted",
    ["MSH-24"],
    value("mesh.syntax:NODE_MAX", 16383, 16384),
    value("mesh.triangulation:MAX_COORDINATE", 16383, 16384),
)
mutant(
    "mesh.error.stuffing-unchecked",
    "The stuffing behind a plane is passed over unread",
    ["MSH-2", "FBA-3"],
    edit("mesh.syntax:_end_of_plane", "    stuffing(io)", "    io.u(PADDING, 8 - (io.tell() & 7), 0)"),
)
mutant(
    "mesh.error.no-stuffing-when-aligned",
    "Behind a plane that ends at a byte boundary no stuffing is expected",
    ["MSH-2", "FBA-3"],
    edit(
        "mesh.syntax:_end_of_plane",
        "if start & 7 == 0 and io.at_end(not plane.stuffing):\n        plane.stuffing = 0\n        return False",
        "if start & 7 == 0:\n        plane.stuffing = 0\n        return _next_plane(io, obj, following)",
    ),
)
mutant(
    "mesh.error.end-without-stuffing-refused",
    "A last plane that ends exactly with the data is refused for its stuffing",
    ["MSH-25"],
    edit("mesh.syntax:_end_of_plane", "if start & 7 == 0 and io.at_end(not plane.stuffing):", "if False:"),
)
mutant(
    "mesh.error.bytes-behind-a-plane",
    "Bytes behind a plane that are no start code end the object",
    ["MSH-25"],
    edit(
        "mesh.syntax:_next_plane",
        "io.require(False, _NO_CODE, io.head(4).hex(), start, start + io.bits_left(32))",
        "return False",
    ),
)
mutant(
    "mesh.error.other-code-behind-object",
    "Any start code is accepted behind the object start code",
    ["MSH-25"],
    edit("mesh.syntax:_next_plane", "if code >= 0 and behind_object and io.reading:", "if False:"),
)
mutant(
    "mesh.error.limit-uniform",
    "The number of nodes of uniform meshes is not limited",
    ["CNF-22"],
    edit("mesh.syntax:_check_count", "if count > limit:", "if False:"),
)
mutant(
    "mesh.error.limit-off-by-one",
    "The limit of nodes is one too low",
    ["CNF-22"],
    edit("mesh.syntax:_check_count", "if count > limit:", "if count >= limit:"),
)
mutant(
    "mesh.error.vlc-no-word-class",
    "A code word outside the table is reported as truncated",
    ["MSH-5", "MSH-41", "CNF-26"],
    edit("syntax.reader:Reader._no_word", "if left < table.max_length and table.is_beginning(bits, left):", "if True:"),
)
mutant(
    "mesh.error.vlc-cut-word-class",
    "A code word that the data cuts off is reported as a word outside the table",
    ["MSH-5", "CNF-21"],
    edit(
        "syntax.reader:Reader._no_word", "if left < table.max_length and table.is_beginning(bits, left):", "if False:"
    ),
)
