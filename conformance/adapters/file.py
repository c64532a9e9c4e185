"""Adapter files: TOML that says how a decoder is asked.

Rules: CNF-9, CNF-13, CNF-25.

    name = "my decoder"
    command = ["./mydecoder", "{input}"]     # {input}: path of the vector; left out: the vector is standard input;
                                             # {aux}: path of its second file, for tools with two; {media}: what it is
    format = "ndjson"                        # or "fap", "csv"
    timeout = 10.0                           # seconds per vector
    output_bytes = 268435456                 # standard output beyond this is cut, and an error
    tools = ["fba"]                          # what is not claimed is not_applicable, never a pass; also dct-p1, mesh,
                                             # dctcoef, fit, fat, fapu

    [options]                                # words put behind the command for vectors that need them
    draft = ["--compat", "draft"]            # left out: such vectors are not_applicable
    strict = ["--strict"]
    object = ["--object", "{value}"]
    limit = ["--limit", "{name}={value}"]

Relative names of files in the command are those beside the TOML file.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any, Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.vectors.manifest import TOOLS

from .base import DEFAULT_TIMEOUT, FORMATS, OPTION_NAMES
from .oneshot import OneShot

_FORM: Final[dict[str, type | tuple[type, ...]]] = {
    "name": str, "command": list, "format": str, "timeout": (int, float), "output_bytes": int, "tools": list,
    "options": dict,
}  # fmt: skip


def load(path: Path) -> OneShot:
    """An adapter from its TOML file. Rules: CNF-9, CNF-25. Raises InputFormat, with the path of the misfit."""
    import tomllib

    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputFormat("CNF-9", "adapter file", value=str(path), allowed=f"TOML: {error}") from error

    def misfit(key: str, law: str) -> InputFormat:
        return InputFormat("CNF-9", f"{path.name}: {key}", value=str(table.get(key)), allowed=law, path=key)

    for key, value in table.items():
        if key not in _FORM:
            raise misfit(key, f"one of {', '.join(_FORM)}")
        if not isinstance(value, _FORM[key]) or isinstance(value, bool):
            raise misfit(key, "the type that the guide names")
    command = table.get("command", [])
    if not command or not all(isinstance(word, str) for word in command):
        raise misfit("command", "a list of words, the program first")
    if table.get("format", "ndjson") not in FORMATS:
        raise misfit("format", ", ".join(FORMATS))
    for key in ("timeout", "output_bytes"):
        if not table.get(key, 1) > 0:
            raise misfit(key, "a number above 0")
    if not all(tool in TOOLS for tool in table.get("tools", [])):
        raise misfit("tools", f"of {', '.join(TOOLS)}")
    options = table.get("options", {})
    for name, words in options.items():
        if name not in OPTION_NAMES or not isinstance(words, list) or not all(isinstance(word, str) for word in words):
            raise misfit("options", f"lists of words by {', '.join(OPTION_NAMES)}")
    return OneShot(
        table.get("name", path.stem), tuple(command), table.get("format", "ndjson"),
        float(table.get("timeout", DEFAULT_TIMEOUT)), table.get("output_bytes", DEFAULT_LIMITS.adapter_output_bytes),
        tuple(table.get("tools", ["fba"])), {name: tuple(words) for name, words in options.items()},
        path.absolute().parent, shlex.quote(str(path)),
    )  # fmt: skip
