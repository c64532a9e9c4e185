"""The kill matrix in words: for the terminal, and as a page of the documentation.

Rules: CNF-8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from .matrix import KILLED, TOLD, Line, Matrix

_SHOWN: Final = 3
TOPIC_NAMES: Final = {
    "framing": "framing of face objects", "header": "temporal header and clock", "masks": "masks and states",
    "ranges": "limits", "coder": "arithmetic coder", "values": "reconstruction", "highlevel": "visemes and expressions",
    "bodies": "body data", "dct": "DCT mode", "mesh_geometry": "mesh geometry and traversal",
    "mesh_motion": "mesh motion", "mesh_errors": "faults of meshes", "fit": "interpolation tables",
    "fat": "face animation tables", "fapu": "units of a face", "systems": "visual object headers",
}  # fmt: skip
WAYS: Final = {
    "fail": "wrong output or verdict", "crash": "falls over", "timeout": "does not end",
    "reading": "another reading of an ambiguity", "concealed": "goes on behind the fault, as is allowed",
}  # fmt: skip


def summary_lines(matrix: Matrix) -> Iterator[str]:
    """Counts by topic, what is only told apart, what survives, and which vectors would be enough. Rules: CNF-8."""
    yield from _count_lines(matrix)
    told = [line for line in matrix.lines if line.kills and not line.killed]
    if told:
        yield ""
        yield "told apart: the decoder passes, and the report says how"
        for line in told:
            yield f"  {line.id}: {_ways(line)} ({line.first})"
    if matrix.survivors:
        yield ""
        yield "survive"
        for line in matrix.survivors:
            yield f"  {line.id}: {line.survives or 'NO REASON GIVEN'}"
    strange = [line for line in matrix.lines if line.kills and line.survives]
    if strange:
        yield ""
        yield "killed, although a reason says that they cannot be"
        for line in strange:
            yield f"  {line.id}: {line.first}"
    if matrix.complete:
        yield ""
        yield from _vector_lines(matrix)


def _count_lines(matrix: Matrix) -> Iterator[str]:
    yield f"kill matrix of suite {matrix.suite}: {len(matrix.lines)} mutants, {len(matrix.vectors)} vectors"
    if not matrix.complete:
        yield "each mutant only up to its first killer"
    yield ""
    yield f"{'mutants of':<34} {'all':>5} {'killed':>7} {'told apart':>11} {'survive':>8}"
    for topic in dict.fromkeys(line.topic for line in matrix.lines):
        lines = [line for line in matrix.lines if line.topic == topic]
        yield _counts(TOPIC_NAMES.get(topic, topic), lines)
    yield _counts("all", matrix.lines)


def _vector_lines(matrix: Matrix) -> Iterator[str]:
    idle = [vector for vector, mutants in matrix.columns().items() if not mutants]
    yield f"{len(matrix.enough())} vectors are enough for all {len(matrix.lines) - len(matrix.survivors)}"
    yield f"{len(matrix.alone())} vectors are the only ones that show some mutant"
    yield f"{len(matrix.redundant())} vectors show none that others do not show too, {len(idle)} of them none at all"


def mutant_lines(matrix: Matrix) -> Iterator[str]:
    """Every mutant with what it does and who kills it. Rules: CNF-8."""
    for line in matrix.lines:
        yield f"{_sign(line)} {line.id} ({', '.join(line.rules)}): {line.title}"
        for change in line.change:
            yield f"    {change}"
        yield f"    {killers_of(line) or line.survives or 'NO REASON GIVEN'}"


def killers_of(line: Line) -> str:
    """The first killer, and how many more there are; "" for a survivor. Rules: CNF-8."""
    if not line.kills:
        return ""
    more = len(line.killers) - 1
    return line.first + (f" and {more} more" if more else "")


def markdown_lines(matrix: Matrix) -> Iterator[str]:
    """The tables of the documentation. Rules: CNF-8."""
    yield "```text"
    yield from _count_lines(matrix)
    yield ""
    yield from _vector_lines(matrix)
    yield "```"
    yield ""
    yield "### Told apart, and survivors"
    yield ""
    for line in matrix.lines:
        if not line.killed:
            found = f"{_ways(line)}, told by `{line.first}`" if line.kills else line.survives
            yield f"* `{line.id}`: {found}"
    for topic in dict.fromkeys(line.topic for line in matrix.lines):
        yield ""
        name = TOPIC_NAMES.get(topic, topic)
        yield f"### {name[0].upper()}{name[1:]}"
        yield ""
        yield "| mutant | what the implementer did | rules | vectors |"
        yield "|---|---|---|---|"
        for line in matrix.lines:
            if line.topic == topic:
                yield f"| `{line.id}` | {_cell(line.title)} | {' '.join(line.rules)} | {_cell(_found(line))} |"
    yield ""
    yield "### Vectors that alone show a mutant"
    yield ""
    yield "| vector | mutants |"
    yield "|---|---|"
    for vector, mutants in matrix.alone().items():
        yield f"| `{vector}` | {', '.join(f'`{mutant}`' for mutant in mutants)} |"
    yield ""
    yield "### Vectors that show no mutant"
    yield ""
    yield ", ".join(f"`{vector}`" for vector, mutants in matrix.columns().items() if not mutants) + "."


def _found(line: Line) -> str:
    if not line.kills:
        return f"none: {line.survives}"
    told = "" if line.killed else f" ({_ways(line)})"
    return f"{len(line.killers)}, first `{line.first}`{told}"


def _counts(name: str, lines: Sequence[Line]) -> str:
    killed = sum(line.killed for line in lines)
    shown = sum(bool(line.kills) for line in lines)
    return f"{name:<34} {len(lines):>5} {killed:>7} {shown - killed:>11} {len(lines) - shown:>8}"


def _sign(line: Line) -> str:
    return "+" if line.killed else "~" if line.kills else "-"


def _ways(line: Line) -> str:
    return ", ".join(WAYS[how] for how in (*KILLED, *TOLD) if how in line.kills)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
