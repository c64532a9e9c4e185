"""Adapter files: TOML that says how a decoder is asked. The form is `adapter.schema.json`; the guide explains it.

Rules: CNF-9, CNF-10, CNF-11, CNF-12, CNF-13, CNF-19, CNF-25.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from snhc.conformance.process import DEFAULT_MEMORY, Surroundings, resolved
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
from snhc.reference_impl.documents.toml_text import TomlFault, load_toml
from snhc.vectors.manifest import KINDS

from .base import DEFAULT_TIMEOUT, Adapter, AdapterFault, Claims, unknown_reading
from .builtin import BuiltIn
from .oneshot import OneShot
from .persistent import ANYTHING, Persistent

if TYPE_CHECKING:
    from jsonschema import ValidationError

SCHEMA_FILE: Final = Path(__file__).parent / "adapter.schema.json"
HOST: Final = Path(__file__).parent / "host.py"
BUILT_IN: Final = "snhc"
ENTRY_POINT: Final = "decoder:"
# In commands and environments: the folder of the adapter file.
FOLDER: Final = "{folder}"
WAYS: Final = ("command", "library", "decoder", "object")

Table = dict[str, Any]


def read(path: Path) -> Table:
    """The content of an adapter file. Rules: CNF-9. Raises AdapterFault where it is no TOML, OSError."""
    try:
        return load_toml(path)
    except TomlFault as error:
        raise AdapterFault("CNF-9", "adapter file", value=str(path), allowed=f"TOML: {error}") from error


def check(table: Table, name: str) -> None:
    """Hold the content against the schema. Rules: CNF-25. Raises AdapterFault with the first misfit."""
    import jsonschema

    validator = jsonschema.Draft202012Validator(json.loads(SCHEMA_FILE.read_text(encoding="utf-8")))
    errors = sorted(validator.iter_errors(table), key=lambda error: (len(error.absolute_path) == 0, error.json_path))
    if errors:
        raise _misfit(errors[0], table, name)
    wrong = unknown_reading(table.get("readings", {}))
    if wrong:
        raise AdapterFault("CNF-24", f"{name}: readings", value=wrong, allowed="what `snhc rules AMB` lists")


def _misfit(error: ValidationError, table: Table, name: str) -> AdapterFault:
    def fault(key: str, value: object, law: str) -> AdapterFault:
        return AdapterFault("CNF-9", f"{name}: {key}", value=f"{value!s:.80}", allowed=law)

    if error.absolute_path:
        key = str(error.absolute_path[0])
        entry = _property(key)
        return fault(key, json.dumps(table[key], default=str), entry["description"])
    if error.validator == "additionalProperties":
        import difflib

        known = list(json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))["properties"])
        key = next(key for key in table if key not in known)
        near = difflib.get_close_matches(key, known, n=1)
        return fault(key, "unknown", f"the keys of the guide{f'; did you mean {near[0]}?' if near else ''}")
    if error.validator == "oneOf":
        given = [way for way in WAYS if way in table]
        return fault("command", " and ".join(given) or "none", f"exactly one of {', '.join(WAYS)}")
    key = next(key for key in ("options", "protocol", "interpreter") if key in table and key in error.schema_path)
    law = {
        "options": "with one-shot commands; other decoders claim options in hello",
        "protocol": "with command",
        "interpreter": "with decoder or object",
    }[key]
    return fault(key, "given", law)


def _property(key: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))["properties"][key]
    return found


def load(path: Path) -> OneShot | Persistent:
    """An adapter from its TOML file. Rules: CNF-9, CNF-25. Raises AdapterFault with the path of the misfit, OSError."""
    table = read(path)
    check(table, path.name)
    return made(table, path)


def made(table: Table, path: Path) -> OneShot | Persistent:
    """An adapter from the content of its file, which fits the schema. Rules: CNF-9, CNF-10, CNF-11, CNF-12."""
    name = table.get("name", path.stem)
    folder = path.absolute().parent
    reproduce = shlex.quote(str(path))
    variables = {key: value.replace(FOLDER, str(folder)) for key, value in table.get("environment", {}).items()}
    around = Surroundings(
        table.get("memory_bytes", DEFAULT_MEMORY), table.get("output_bytes", DEFAULT_LIMITS.adapter_output_bytes),
        folder, variables, tuple(table.get("pass_environment", [])),
        tuple(str(folder / os.path.expandvars(Path(place).expanduser())) for place in table.get("writable", [])),
    )  # fmt: skip
    timeout = float(table.get("timeout", DEFAULT_TIMEOUT))
    profiles = tuple(table["profiles"]) if "profiles" in table else None
    if "command" in table and table.get("protocol", "one-shot") == "one-shot":
        return OneShot(
            name, command_of(table, folder), table.get("format", "ndjson"), timeout, around.output_bytes,
            tuple(table.get("tools", ["fba"])),
            {option: tuple(words) for option, words in table.get("options", {}).items()}, folder, reproduce,
            around.memory_bytes, tuple(table.get("kinds", KINDS)), profiles, table.get("limits", {}),
            table.get("readings", {}), around.variables, around.passed, around.writable,
        )  # fmt: skip
    claims = Claims(
        frozenset(table["tools"]) if "tools" in table else ANYTHING.tools, frozenset(table.get("kinds", KINDS)),
        None if profiles is None else frozenset(profiles), table.get("limits", {}), table.get("readings", {}),
        ANYTHING.options, (table["format"],) if "format" in table else ANYTHING.formats,
    )  # fmt: skip
    return Persistent(
        name, command_of(table, folder), claims, around, timeout,
        float(table.get("start_timeout", max(timeout, DEFAULT_TIMEOUT))), reproduce,
    )  # fmt: skip


def command_of(table: Table, folder: Path) -> tuple[str, ...]:
    """The command that speaks for a decoder. Rules: CNF-10, CNF-11, CNF-12."""
    if "command" in table:
        return tuple(word.replace(FOLDER, str(folder)) for word in table["command"])
    if "library" in table:
        # As files in commands: beside the adapter file.
        return sys.executable, "-I", "-S", str(HOST), "--library", resolved(["", table["library"]], folder)[1]
    python = table.get("interpreter", sys.executable)
    if "decoder" in table:
        return python, str(HOST), "--decoder", table["decoder"]
    return python, str(HOST), "--object", table["object"], str(folder)


def find(word: str) -> Adapter:
    """The adapter that a word of the command line names: a TOML file, `decoder:NAME` or `snhc`.

    Rules: CNF-9, CNF-11, CNF-19. Raises AdapterFault, OSError.
    """
    path = Path(word)
    if path.exists():
        return load(path)
    if word == BUILT_IN:
        return replace(BuiltIn(), reproduce=BUILT_IN)
    name = word.removeprefix(ENTRY_POINT)
    if name != word and name:
        adapter = made({"name": name, "decoder": name}, Path.cwd() / "entry-point")
        return replace(adapter, reproduce=shlex.quote(word)) if isinstance(adapter, Persistent) else adapter
    return load(path)
