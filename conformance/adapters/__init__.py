"""Adapters: how a decoder is asked to decode a vector.

Rules: CNF-9, CNF-10, CNF-11, CNF-12, CNF-13, CNF-14, CNF-19.
"""

from .base import DEFAULT_TIMEOUT, FORMATS, OPTION_NAMES, REJECTED, Adapter, AdapterFault, Claims, Outcome
from .builtin import BuiltIn
from .file import find, load
from .oneshot import OneShot, from_command
from .persistent import Persistent

__all__ = [
    "DEFAULT_TIMEOUT", "FORMATS", "OPTION_NAMES", "REJECTED", "Adapter", "AdapterFault", "BuiltIn", "Claims", "OneShot",
    "Outcome", "Persistent", "find", "from_command", "load",
]  # fmt: skip
