"""The VRML/BT text form of a FIT node.

Rules: FIT-1, FIT-9, SYS-58, CNF-25. `[DEF name] FIT { FAPs [ ... ] Graph [ ... ] ... }`.
Not implemented: a FIT inside a Face node (the scene reader takes it out).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat, SnhcError
from snhc.reference_impl.documents.bt_text import BtNode, floats, ints, parse_nodes, unknown_field
from snhc.reference_impl.documents.json_text import MAX_JSON_BYTES
from snhc.reference_impl.interpolation.fit_table import (
    FIT_COEFS,
    FIT_FIELDS,
    MAX_LINKS,
    MAX_SETS,
    FitTable,
    build_fit,
    fit_to_fields,
)

_KNOWN: Final = frozenset((*FIT_FIELDS, *FIT_COEFS))
_PATH: Final = re.compile(r"(\w+)\[([0-9]+)\]")


def parse_fit_text(
    data: bytes | str,
    *,
    impulse: str = "from-0",
    max_sets: int = MAX_SETS,
    max_links: int = MAX_LINKS,
    limit: int = MAX_JSON_BYTES,
) -> FitTable:
    """A table from the text of one FIT node.

    Rules: FIT-1, FIT-9, SYS-58, CNF-22, CNF-25. Raises `InputFormat` with line and column, and what
    `build_fit` raises with the path and the line and column of the entry (of the field, where an entry is
    missing).
    """
    found = parse_nodes(data, limit=limit)
    if len(found) != 1 or found[0].type != "FIT":
        place = found[min(len(found), 2) - 1].start if found else None
        raise InputFormat(
            "FIT-9", "text", value=f"{len(found)} nodes" if len(found) != 1 else found[0].type or "USE",
            allowed="one FIT node", line=place.line if place else 1, column=place.column if place else 1,
        )  # fmt: skip
    node = found[0]
    unknown_field(node, _KNOWN)
    fields = {name: ints(node.fields[name], name) for name in FIT_FIELDS if name in node.fields}
    coefs = {name: floats(node.fields[name], name) for name in FIT_COEFS if name in node.fields}
    try:
        return build_fit(fields, coefs, impulse=impulse, max_sets=max_sets, max_links=max_links)
    except SnhcError as error:
        _locate(error, node)
        raise


def _locate(error: SnhcError, node: BtNode) -> None:
    match = _PATH.fullmatch(error.path)
    place = node.end
    if match is not None and match[1] in node.fields:
        values, index = node.fields[match[1]], int(match[2])
        entry = values[index] if index < len(values) else node.places[match[1]]
        place = entry.start if isinstance(entry, BtNode) else entry
    error.line, error.column = place.line, place.column


def fit_text(table: FitTable, name: str = "") -> str:
    """The text form of a table; reading it back gives the same table.

    Rules: FIT-1, SYS-58. `name`: for DEF, or empty.
    """
    head = f"DEF {name} FIT" if name else "FIT"

    def values(numbers: Sequence[float]) -> str:
        return " ".join(map(repr, numbers))

    fields = fit_to_fields(table).items()
    lines = [f"  {field} [ {values(numbers)} ]" for field, numbers in fields if numbers]
    return "\n".join((head + " {", *lines, "}", ""))
