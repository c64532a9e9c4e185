"""For decoders written in Python that are registered in the entry-point group `snhc.decoders`.

Rules: CNF-11. Nothing heavy is imported; a decoder that does not want to depend on this package may raise any exception
with an attribute `snhc_error`.
"""

from __future__ import annotations

from typing import Any, Protocol


class Request(Protocol):
    """What a decoder is called with.

    Rules: CNF-11. `data`: the input. `aux`: the second one, None for tools with one. `media`: `fba`, `m2d`, ... .
    `format`: what is wanted, `ndjson` unless `capabilities` claim others. `options`: `compat`, `strict`, `object`,
    `limits`, where they are not the default. `path`: of the input.
    """

    data: bytes
    aux: bytes | None
    media: str
    format: str
    options: dict[str, Any]
    path: str


class Rejected(Exception):
    """The stream is rejected. Rules: CNF-9, CNF-11. All of it may be left out."""

    def __init__(
        self,
        error_class: str | None = None,
        bits: tuple[int, int] | None = None,
        *,
        path: str | None = None,
        line: int | None = None,
    ) -> None:
        super().__init__(error_class, bits)
        said = {"class": error_class, "bits": None if bits is None else list(bits), "path": path, "line": line}
        self.snhc_error = {key: value for key, value in said.items() if value is not None}
