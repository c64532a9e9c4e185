"""The host: a child process that holds a decoder written in Python, or a shared library, and speaks for it.

Rules: CNF-11, CNF-12. Started as a script, `python host.py --library FILE`, `--decoder NAME` (entry point of the group
`snhc.decoders`) or `--object MODULE:NAME FOLDER` (where the module may lie); standard library only, so that it runs on
any interpreter. To the runner it is a persistent adapter like any other (CNF-10).

Standard output belongs to the messages: what the decoder prints goes to standard error.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
import traceback
from collections.abc import Callable, Iterable
from types import SimpleNamespace
from typing import Any

GROUP = "snhc.decoders"
ABI_VERSION = 1
REJECTED = 1

Message = dict[str, Any]
Decode = Callable[[Message], Message]


class CannotLoad(Exception):
    """There is no such decoder, or it does not load. Rules: CNF-11, CNF-12."""


# -- Python ------------------------------------------------------------------------------------------------------------


def entry_point(name: str) -> Any:
    """The decoder of an installed package. Rules: CNF-11. Raises CannotLoad."""
    from importlib.metadata import entry_points

    found = list(entry_points(group=GROUP, name=name))
    if not found:
        known = sorted({point.name for point in entry_points(group=GROUP)})
        raise CannotLoad(f"no entry point {name!r} in the group {GROUP}; there are: {', '.join(known) or 'none'}")
    return _loaded(found[0].load, f"entry point {name}")


def named_object(name: str) -> Any:
    """`package.module:object`. Rules: CNF-11. Raises CannotLoad."""
    from importlib import import_module
    from operator import attrgetter

    module, _, path = name.partition(":")
    return _loaded(lambda: attrgetter(path)(import_module(module)), name)


def _loaded(load: Callable[[], Any], what: str) -> Any:
    try:
        decoder = load()
    except Exception as error:
        raise CannotLoad(f"{what} does not load: {type(error).__name__}: {error}") from error
    if not callable(decoder):
        raise CannotLoad(f"{what} cannot be called")
    return decoder


def python_decoder(decoder: Any) -> tuple[Message, Decode]:
    """What it can do, and how it is asked. Rules: CNF-11."""

    def decode(message: Message) -> Message:
        request = SimpleNamespace(
            data=_read(message["input"]), aux=_read(message["aux"]) if "aux" in message else None,
            media=message["media"], format=message["format"], options=message["options"], path=message["input"],
        )  # fmt: skip
        pieces: list[str] = []
        try:
            for piece in _pieces(decoder(request)):
                pieces.append(piece)
        except Exception as error:
            said = getattr(error, "snhc_error", None)
            if not isinstance(said, dict):
                raise
            return {"status": "rejected", "error": said, "output": "".join(pieces)}
        return {"status": "accepted", "output": "".join(pieces)}

    return dict(getattr(decoder, "capabilities", {})), decode


def _pieces(result: Any) -> Iterable[str]:
    if isinstance(result, str):
        yield result
        return
    for item in result:
        yield item if isinstance(item, str) else json.dumps(item) + "\n"


def _read(path: str) -> bytes:
    with open(path, "rb") as file:  # noqa: PTH123
        return file.read()


# -- C -----------------------------------------------------------------------------------------------------------------


class Limit(ctypes.Structure):
    """`snhc_limit`. Rules: CNF-12."""

    _fields_ = (("name", ctypes.c_char_p), ("value", ctypes.c_uint64))


class Reading(ctypes.Structure):
    """`snhc_reading`. Rules: CNF-12, CNF-24."""

    _fields_ = (("ambiguity", ctypes.c_char_p), ("key", ctypes.c_char_p))


class Request(ctypes.Structure):
    """`snhc_request`. Rules: CNF-12."""

    _fields_ = (
        ("struct_bytes", ctypes.c_size_t), ("media", ctypes.c_char_p), ("format", ctypes.c_char_p),
        ("data", ctypes.c_char_p), ("size", ctypes.c_size_t), ("aux", ctypes.c_char_p), ("aux_size", ctypes.c_size_t),
        ("draft", ctypes.c_int32), ("strict", ctypes.c_int32), ("object", ctypes.c_uint32),
        ("limit_count", ctypes.c_uint32), ("limits", ctypes.POINTER(Limit)), ("readings", ctypes.POINTER(Reading)),
        ("reading_count", ctypes.c_size_t),
    )  # fmt: skip


class Rejection(ctypes.Structure):
    """`snhc_rejection`. Rules: CNF-12."""

    _fields_ = (
        ("struct_bytes", ctypes.c_size_t), ("error_class", ctypes.c_char * 32), ("has_bits", ctypes.c_int32),
        ("line", ctypes.c_uint32), ("first_bit", ctypes.c_uint64), ("end_bit", ctypes.c_uint64),
        ("path", ctypes.c_char * 256),
    )  # fmt: skip


Write = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)


def library_decoder(path: str, readings: Message) -> tuple[Message, Decode]:
    """What a shared library can do, and how it is asked. Rules: CNF-12. Raises CannotLoad."""
    try:
        library = ctypes.CDLL(path)
        version = library.snhc_abi_version
        describe = library.snhc_describe
        run = library.snhc_decode
    except (OSError, AttributeError) as error:
        raise CannotLoad(str(error)) from error
    version.restype = ctypes.c_uint32
    if version() != ABI_VERSION:
        raise CannotLoad(f"{path} has ABI version {version()}, this is {ABI_VERSION}")
    describe.restype = ctypes.c_char_p
    try:
        can = json.loads(describe() or b"{}")
    except ValueError as error:
        raise CannotLoad(f"snhc_describe gives no JSON: {error}") from error
    run.restype = ctypes.c_int
    run.argtypes = (ctypes.POINTER(Request), Write, ctypes.c_void_p, ctypes.POINTER(Rejection))

    def decode(message: Message) -> Message:
        data = _read(message["input"])
        aux = _read(message["aux"]) if "aux" in message else None
        options = message["options"]
        limits = options.get("limits", {})
        request = Request(
            ctypes.sizeof(Request), message["media"].encode(), message["format"].encode(), data, len(data), aux,
            len(aux or b""), int(options.get("compat") == "draft"), int(options.get("strict", False)),
            options.get("object", 0), len(limits),
            (Limit * len(limits))(*(Limit(name.encode(), value) for name, value in limits.items())),
            (Reading * len(readings))(*(Reading(name.encode(), key.encode()) for name, key in readings.items())),
            len(readings),
        )  # fmt: skip
        pieces: list[bytes] = []

        def write(context: int | None, text: int | None, length: int) -> int:
            if length:
                pieces.append(ctypes.string_at(text or 0, length))
            return 0

        rejection = Rejection(ctypes.sizeof(Rejection))
        code = run(ctypes.byref(request), Write(write), None, ctypes.byref(rejection))
        # Bytes that are no UTF-8 have to stay what they are: a surrogate cannot be told from U+FFFD otherwise.
        output = b"".join(pieces).decode("utf-8", "surrogateescape")
        if code == 0:
            return {"status": "accepted", "output": output}
        if code == REJECTED:
            return {"status": "rejected", "error": _rejection(rejection), "output": output}
        return {"status": "crash", "detail": f"snhc_decode returned {code}"}

    return can, decode


def _rejection(said: Rejection) -> Message:
    out: Message = {}
    if said.error_class:
        out["class"] = said.error_class.decode("utf-8", "replace")
    if said.has_bits:
        out["bits"] = [said.first_bit, said.end_bit]
    if said.line:
        out["line"] = said.line
    if said.path:
        out["path"] = said.path.decode("utf-8", "replace")
    return out


# -- messages ----------------------------------------------------------------------------------------------------------


def main() -> int:
    """Answer messages until `bye`. Rules: CNF-10."""
    messages = os.fdopen(os.dup(1), "w", encoding="utf-8", newline="\n")
    os.dup2(2, 1)
    kind, what, *folder = sys.argv[1:4]
    sys.path[:0] = folder
    can: Message = {}
    decode: Decode | None = None
    for line in sys.stdin:
        message = json.loads(line)
        answer: Message = {"seq": message["seq"], "type": message["type"]}
        if message["type"] == "hello":
            if decode is None:
                try:
                    if kind == "--library":
                        can, decode = library_decoder(what, message["readings"])
                    else:
                        can, decode = python_decoder(entry_point(what) if kind == "--decoder" else named_object(what))
                except CannotLoad as error:
                    sys.stderr.write(f"{error}\n")
                    return 5
            answer |= {"protocol": message["protocol"], "version": message["version"], **can}
        elif message["type"] == "decode" and decode is not None:
            try:
                answer |= decode(message)
            except Exception as error:  # noqa: BLE001 (whatever a foreign decoder does is its result)
                traceback.print_exc()
                answer |= {"status": "crash", "detail": f"{type(error).__name__}: {error}"}
        messages.write(json.dumps(answer) + "\n")
        messages.flush()
        if message["type"] == "bye":
            break
    return 0


if __name__ == "__main__":
    sys.exit(main())
