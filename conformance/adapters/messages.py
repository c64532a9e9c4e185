"""The messages of persistent adapters: `protocol.schema.json` holds them, and every one that comes in.

Rules: CNF-10, CNF-13, CNF-24, CNF-25.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, Final

from snhc.vectors.manifest import KINDS, Entry

from .base import FORMATS, Claims, unknown_reading

PROTOCOL: Final = "snhc-adapter"
VERSION: Final = 1
SCHEMA_FILE: Final = Path(__file__).parent / "protocol.schema.json"
Message = dict[str, Any]


class Misfit(Exception):
    """A line that is not the answer. Rules: CNF-10."""


@cache
def _validator(definition: str) -> Any:
    import jsonschema

    schema = json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))
    return jsonschema.Draft202012Validator({"$ref": f"#/$defs/{definition}", "$defs": schema["$defs"]})


def check(definition: str, message: object) -> None:
    """Hold a message against its definition in the schema. Rules: CNF-25. Raises Misfit."""
    errors = sorted(_validator(definition).iter_errors(message), key=lambda error: error.json_path)
    if errors:
        first = errors[0]
        # The value stands before the law, and may be long.
        words = first.message if len(first.message) <= 200 else f"{first.message[:80]} ... {first.message[-100:]}"
        raise Misfit(f"{first.json_path.removeprefix('$.')}: {words}")


def hello(seq: int, readings: dict[str, str]) -> Message:
    """The first message; it may come again at any time. Rules: CNF-10, CNF-24."""
    return {"seq": seq, "type": "hello", "protocol": PROTOCOL, "version": VERSION, "readings": readings}


def decode(seq: int, entry: Entry, path: Path, aux: Path | None, format: str) -> Message:
    """The question. Rules: CNF-10, CNF-26."""
    message: Message = {
        "seq": seq, "type": "decode", "input": str(path), "media": entry.media, "format": format,
        "options": entry.options.as_json(),
    }  # fmt: skip
    if aux is not None:
        message["aux"] = str(aux)
    return message


def bye(seq: int) -> Message:
    """The last message. Rules: CNF-10."""
    return {"seq": seq, "type": "bye"}


def answer(line: bytes, asked: Message) -> Message:
    """The answer to a message. Rules: CNF-10. Raises Misfit for any other line."""
    shown = line[:80].decode("utf-8", "replace")
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise Misfit(f"a line that is no JSON: {shown!r}") from error
    if not isinstance(message, dict):
        raise Misfit(f"a line that is no JSON object: {shown!r}")
    for key in ("type", "seq"):
        if key not in message:
            raise Misfit(f"an answer without {key!r}: {shown!r}")
        if message[key] != asked[key] or type(message[key]) is not type(asked[key]):
            raise Misfit(
                f"{asked['type']} {asked['seq']} was asked, the answer is for {message.get('type')!r:.40} "
                f"{message.get('seq')!r:.40}"
            )
    if asked["type"] == "hello" and (message.get("protocol"), message.get("version")) != (PROTOCOL, VERSION):
        raise Misfit(
            f"it speaks {message.get('protocol')!r:.40} version {message.get('version')!r:.40}, "
            f"this is {PROTOCOL!r} version {VERSION}"
        )
    try:
        check(f"{asked['type']}_answer", message)
    except Misfit as error:
        raise Misfit(f"the answer to {asked['type']} is wrong: {error}") from error
    wrong = unknown_reading(message.get("readings", {})) if asked["type"] == "hello" else ""
    if wrong:
        raise Misfit(f"the answer to hello is wrong: {wrong}")
    return message


def claims(message: Message) -> Claims:
    """What an answer to hello claims; the defaults are those of adapter files. Rules: CNF-13."""
    profiles = message.get("profiles")
    formats = message.get("formats", ["ndjson"])
    return Claims(
        frozenset(message.get("tools", ["fba"])), frozenset(message.get("kinds", KINDS)),
        None if profiles is None else frozenset(profiles), message.get("limits", {}), message.get("readings", {}),
        frozenset(message.get("options", [])), tuple(name for name in FORMATS if name in formats),
    )  # fmt: skip
