"""A decoder's own trace against the reference trace: the first syntax element that they do not agree on.

Rules: CNF-17, CNF-21. The trace has the form of `snhc dump --format json` (`analyzer/dump.schema.json`); of each
element `element`, `bits` and `value` or `levels` are compared, as far as they are given.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

from snhc.analyzer.dump_json import dump_json
from snhc.analyzer.parts import Parts
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import trace_stream
from snhc.vectors.manifest import DOCUMENTS, Entry

BYTES: Final = 64 << 20
_COMPARED: Final = ("element", "bits", "value", "levels")


def trace_file(folder: Path | None, adapter: str, vector: str) -> Path | None:
    """`ADAPTER/VECTOR.json` or `VECTOR.json` in the folder, None if there is neither. Rules: CNF-17."""
    if folder is None:
        return None
    for path in (folder / adapter / f"{vector}.json", folder / f"{vector}.json"):
        if path.is_file():
            return path
    return None


def divergence(entry: Entry, suite: Path, path: Path) -> dict[str, Any]:
    """The first element that differs: `reference`, `candidate`, each null where its trace has ended; `fault`: the
    trace cannot be read; {"agree": true}: nothing differs. Rules: CNF-17."""
    if entry.media in DOCUMENTS:
        return {"fault": "documents have no trace"}
    try:
        if path.stat().st_size > BYTES:
            return {"fault": f"more than {BYTES} bytes"}
        theirs = list(_elements(json.loads(path.read_bytes())))
    except (ValueError, RecursionError, TypeError, KeyError, AttributeError) as error:
        return {"fault": f"not of the form of a JSON dump: {type(error).__name__}: {error}"[:300]}
    source = BytesSource((suite / entry.file).read_bytes())
    options = entry.options.for_decoder()
    ours = json.loads("".join(dump_json(Parts(trace_stream(source, options)), source, options)))
    for reference, candidate in zip_longest(_elements(ours), theirs):
        if reference is None or candidate is None or _differ(reference, candidate):
            return {"reference": _shown(reference), "candidate": _shown(candidate)}
    return {"agree": True}


def _elements(document: Any) -> Iterator[Mapping[str, Any]]:
    for part in document["parts"]:
        for element in part["elements"]:
            if not isinstance(element["element"], str):
                raise TypeError("element is not a text")
            yield element


def _differ(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> bool:
    return any(key in ours and key in theirs and ours[key] != theirs[key] for key in _COMPARED)


def _shown(element: Mapping[str, Any] | None) -> dict[str, str] | None:
    if element is None:
        return None
    keys = ("path", "element", "bits", "value", "levels", "rule")
    return {key: str(element[key])[:200] for key in keys if key in element}
