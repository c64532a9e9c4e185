"""Decoded meshes as NDJSON lines.

Rules: CNF-1.
"""

from __future__ import annotations

from .records import MeshFrame


def mesh_line(frame: MeshFrame) -> str:
    """One frame as one line, without the newline. Rules: CNF-1."""
    nodes = ",".join(f"[{x},{y}]" for x, y in frame.nodes)
    line = (
        f'{{"index":{frame.index},"time":"{frame.time[0]}/{frame.time[1]}",'
        f'"intra":{"true" if frame.intra else "false"},"nodes":[{nodes}]'
    )
    if frame.triangles is not None and frame.order is not None:
        triangles = ",".join(f"[{a},{b},{c}]" for a, b, c in frame.triangles)
        line += f',"triangles":[{triangles}],"order":[{",".join(map(str, frame.order))}]'
    return line + "}"
