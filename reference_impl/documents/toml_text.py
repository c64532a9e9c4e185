"""TOML documents of other people: adapters, policies, ledgers; and the reasons of the coverage book.

Rules: CNF-7, CNF-25.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from ..bitstream.errors import cause

if TYPE_CHECKING:
    from pathlib import Path

MAX_TOML_BYTES: Final = 1 << 20
MAX_DEPTH: Final = 32
# Python's parser takes time and memory by the square of the names in a dotted key.
_WORD: Final = rb"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY: Final = re.compile(rb"(?<![A-Za-z0-9_-])(?:%b[ \t]*+\.[ \t]*+){%d}" % (_WORD, MAX_DEPTH))


class TomlFault(Exception):
    """A document is no TOML; its text says why, for people. Rules: CNF-7."""


def load_toml(path: Path) -> dict[str, Any]:
    """The tables of a file, of which no more than `MAX_TOML_BYTES` are read.

    Rules: CNF-7, CNF-22. Raises TomlFault as `parse_toml`, OSError.
    """
    with path.open("rb") as file:
        return parse_toml(file.read(MAX_TOML_BYTES + 1))


def parse_toml(data: bytes) -> dict[str, Any]:
    """The tables of a document.

    Rules: CNF-7. Raises TomlFault, also for integers that Python's parser does not take, for more than
    `MAX_TOML_BYTES`, and for more than `MAX_DEPTH` tables and lists in one another.
    """
    import tomllib

    if len(data) > MAX_TOML_BYTES:
        raise TomlFault(f"more than {MAX_TOML_BYTES} bytes")
    if _LONG_KEY.search(data):
        raise TomlFault(f"more than {MAX_DEPTH} words with dots between them")
    try:
        tables = tomllib.loads(data.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise TomlFault(cause(error)) from error
    except ValueError as error:
        # Of integers alone the parser hands Python's own words on.
        raise TomlFault("an integer of too many digits") from error
    within: list[object] = [tables]
    for _ in range(MAX_DEPTH):
        within = [
            inner
            for outer in within
            for inner in (outer.values() if isinstance(outer, dict) else outer if isinstance(outer, list) else ())
            if isinstance(inner, dict | list)
        ]
        if not within:
            return tables
    raise TomlFault("nested too deeply")
