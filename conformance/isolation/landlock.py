"""Landlock: a process gives up the right to write anywhere but below given folders, for itself and all it starts.

Rules: CNF-14. Linux 5.13 and newer, where the kernel has it switched on; no privileges are needed. Standard library
only, and nothing of this package: the warden runs without site-packages.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterable

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_VERSION_FLAG = 1
_PATH_BENEATH = 1
_NO_NEW_PRIVS = 38

_WRITE_FILE = 1 << 1
_REMOVE_DIR, _REMOVE_FILE = 1 << 4, 1 << 5
_MAKE = (1 << 6) | (1 << 7) | (1 << 8) | (1 << 9) | (1 << 10) | (1 << 11) | (1 << 12)
_REFER = 1 << 13  # ABI 2: renames and links between folders
_TRUNCATE = 1 << 14  # ABI 3
_OF_FILES = _WRITE_FILE | _TRUNCATE


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed_access", ctypes.c_uint64), ("parent_fd", ctypes.c_int32))


def version() -> int:
    """The kernel's Landlock ABI; 0 where there is none. Rules: CNF-14."""
    if not sys.platform.startswith("linux"):
        return 0
    return max(0, int(ctypes.CDLL(None).syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), _VERSION_FLAG)))


def restrict(folders: Iterable[str], files: Iterable[str] = ()) -> bool:
    """Allow writing below `folders` and into the files below `files` only. Rules: CNF-14.

    Folders that are not there are left out. Returns False where the kernel cannot do it: nothing has changed then.
    """
    abi = version()
    if abi < 1:
        return False
    handled = _WRITE_FILE | _REMOVE_DIR | _REMOVE_FILE | _MAKE
    if abi >= 2:
        handled |= _REFER
    if abi >= 3:
        handled |= _TRUNCATE
    libc = ctypes.CDLL(None, use_errno=True)
    attributes = ctypes.c_uint64(handled)
    ruleset = libc.syscall(_CREATE_RULESET, ctypes.byref(attributes), ctypes.c_size_t(8), 0)
    if ruleset < 0:
        return False
    try:
        for access, places in ((handled, folders), (handled & _OF_FILES, files)):
            for place in places:
                try:
                    there = os.open(place, os.O_PATH | os.O_CLOEXEC)
                except OSError:
                    continue
                rule = _Beneath(access if os.path.isdir(place) else access & _OF_FILES, there)  # noqa: PTH112
                added = libc.syscall(_ADD_RULE, ruleset, _PATH_BENEATH, ctypes.byref(rule), 0)
                os.close(there)
                if added != 0:
                    return False
        if libc.prctl(_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
            return False
        return bool(libc.syscall(_RESTRICT_SELF, ruleset, 0) == 0)
    finally:
        os.close(ruleset)
