"""Adapters: how a decoder is asked to decode a vector.

Rules: CNF-9, CNF-13, CNF-14, CNF-19. Not here: persistent processes (CNF-10), entry points (CNF-11), the C ABI
(CNF-12).
"""

from .base import DEFAULT_TIMEOUT, FORMATS, OPTION_NAMES, REJECTED, Adapter, Outcome
from .builtin import BuiltIn
from .file import load
from .oneshot import OneShot, from_command

__all__ = [
    "DEFAULT_TIMEOUT", "FORMATS", "OPTION_NAMES", "REJECTED", "Adapter", "BuiltIn", "OneShot", "Outcome",
    "from_command", "load",
]  # fmt: skip
