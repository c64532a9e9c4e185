"""Rows of a trace as a tree.

Rules: CNF-17, CNF-21. Law: the leaves, from left to right, are the rows in their order.
"""

from __future__ import annotations

from collections.abc import Iterator

from snhc.reference_impl.syntax.tracer import Trace

from .parts import path_names


class Node:
    """A level of the path with what stands below it: rows (as row numbers) and further nodes, in stream order.

    Rules: CNF-21. `start`, `end`: the bits of all its rows.
    """

    __slots__ = ("children", "end", "name", "start")

    def __init__(self, name: str, start: int) -> None:
        self.name = name
        self.start = start
        self.end = start
        self.children: list[Node | int] = []

    def rows(self) -> Iterator[int]:
        """All row numbers below. Rules: CNF-21."""
        for child in self.children:
            if isinstance(child, Node):
                yield from child.rows()
            else:
                yield child


def build_tree(trace: Trace) -> Node:
    """The tree of a trace; the root has no name.

    Rules: CNF-17, CNF-21. Neighbouring rows of one path share its nodes; a path that comes again later gets new ones,
    so that the order of the rows stays.
    """
    root = Node("", trace.start[0] if len(trace) else 0)
    open_nodes = [root]
    names: list[str] = []
    path = -1
    for row in range(len(trace)):
        start = trace.start[row]
        if trace.path[row] != path or row == 0:
            path = trace.path[row]
            wanted = path_names(trace, path)
            shared = 0
            while shared < len(wanted) and shared < len(names) and wanted[shared] == names[shared]:
                shared += 1
            del open_nodes[shared + 1 :]
            for name in wanted[shared:]:
                node = Node(name, start)
                open_nodes[-1].children.append(node)
                open_nodes.append(node)
            names = wanted
        open_nodes[-1].children.append(row)
        for node in open_nodes:
            node.end = trace.end[row]
    return root
