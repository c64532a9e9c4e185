"""JSON documents and the frames that tables are used on: entries, lines and numbers are taken out and lowered.

Rules: CNF-17, CNF-25.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .ddmin import ddmin, lower

if TYPE_CHECKING:
    from .shrink import Shrinker

Path = tuple[str | int, ...]


def shrink(shrinker: Shrinker) -> None:
    """One round over a document, and over its frames. Rules: CNF-17."""
    if shrinker.aux is not None:
        lines = shrinker.aux.splitlines(keepends=True)
        # The first line is the header.
        ddmin(lines[1:], lambda kept: shrinker.takes(shrinker.data, b"".join([*lines[:1], *kept])))
    try:
        document = json.loads(shrinker.data)
    except (ValueError, RecursionError):
        data = shrinker.data
        ddmin(range(len(data)), lambda kept: shrinker.takes(bytes(data[i] for i in kept)))
        return
    for path in _containers(document):
        document = _without(shrinker, document, path)
    for path in _numbers(document):
        document = _lowered(shrinker, document, path)


def _written(document: Any) -> bytes:
    return json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass") + b"\n"


def _containers(document: Any, path: Path = ()) -> list[Path]:
    """Lists and objects, the outermost first."""
    if isinstance(document, dict):
        items: list[tuple[str | int, Any]] = list(document.items())
    elif isinstance(document, list):
        items = list(enumerate(document))
    else:
        return []
    return [path] + [below for key, value in items for below in _containers(value, (*path, key))]


def _numbers(document: Any) -> list[Path]:
    out: list[Path] = []
    for path in _containers(document):
        value = _at(document, path)
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        out += [(*path, key) for key, number in pairs if type(number) in (int, float)]
    return out


def _at(document: Any, path: Path) -> Any:
    for key in path:
        document = document[key]
    return document


def _exists(document: Any, path: Path) -> bool:
    try:
        _at(document, path)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def _replaced(document: Any, path: Path, value: Any) -> Any:
    if not path:
        return value
    copy: Any = dict(document) if isinstance(document, dict) else list(document)
    copy[path[0]] = _replaced(document[path[0]], path[1:], value)
    return copy


def _without(shrinker: Shrinker, document: Any, path: Path) -> Any:
    """Entries taken out of one list or object; what lies below an entry that is gone is not looked for."""
    if not _exists(document, path):
        return document
    container = _at(document, path)
    make: Callable[[list[Any]], Any]
    if isinstance(container, dict):
        units, make = list(container.items()), dict
    elif isinstance(container, list):
        units, make = list(enumerate(container)), lambda kept: [value for _, value in kept]
    else:
        return document
    kept = ddmin(units, lambda some: shrinker.takes(_written(_replaced(document, path, make(some)))))
    return _replaced(document, path, make(kept))


def _lowered(shrinker: Shrinker, document: Any, path: Path) -> Any:
    value = _at(document, path)

    def test(number: float) -> bool:
        return shrinker.takes(_written(_replaced(document, path, number)))

    if isinstance(value, int):
        return _replaced(document, path, lower(value, test))
    for number in (0.0, float(round(value)) if abs(value) < 1e15 else value):
        if number != value and test(number):
            return _replaced(document, path, number)
    return document
