"""Mutants of visual object headers.

Rules: SYS-1..8, FBA-1, FBA-3.
"""

from __future__ import annotations

from snhc.reference_impl.bitstream.errors import ForbiddenValue, InconsistentSemantics, ReservedValue

from .mutant import edit, mutant, value

_OBJECT = "systems.visual:_visual_object"
_STREAM = "systems.visual:visual_stream"

mutant(
    "sys.object.identifier-always",
    "verid and priority are read whether or not the identifier flag is set",
    ["SYS-3"],
    edit(_OBJECT, "if header.identifier:", "if True:"),
)
mutant(
    "sys.object.identifier-never",
    "verid and priority are never read",
    ["SYS-3"],
    edit(_OBJECT, "if header.identifier:", "if False:"),
)
mutant(
    "sys.object.priority-before-verid",
    "The priority is read before verid",
    ["SYS-3"],
    edit(
        _OBJECT,
        "header.verid = io.u(VISUAL_OBJECT_VERID, 4, header.verid)\n"
        "        header.priority = io.u(VISUAL_OBJECT_PRIORITY, 3, header.priority)",
        "header.priority = io.u(VISUAL_OBJECT_PRIORITY, 3, header.priority)\n"
        "        header.verid = io.u(VISUAL_OBJECT_VERID, 4, header.verid)",
    ),
)
mutant(
    "sys.object.priority-0",
    "Priority 0 is accepted",
    ["SYS-3"],
    value("systems.visual:VISUAL_OBJECT_PRIORITY.lo", 1, 0),
)
mutant(
    "sys.object.priority-class",
    "Priority 0 is reported as forbidden, not reserved",
    ["SYS-3", "CNF-7"],
    value("systems.visual:VISUAL_OBJECT_PRIORITY.fault", ReservedValue, ForbiddenValue),
)
mutant(
    "sys.object.types-swapped",
    "visual_object_type 3 is taken for FBA, 4 for mesh",
    ["SYS-4"],
    value("systems.visual:TYPE_MESH", 3, 4),
    value("systems.visual:TYPE_FBA", 4, 3),
)
mutant(
    "sys.object.reserved-type-unsupported",
    "Reserved types are reported as unsupported",
    ["SYS-4", "CNF-7"],
    value("systems.visual:VISUAL_OBJECT_TYPE.hi", 5, 15),
    survives="Unsupported is never judged: a decoder that says so of a reserved type counts as not applicable (CNF-26)",
)
mutant(
    "sys.object.type-0-as-video",
    "visual_object_type 0 is reported as forbidden",
    ["SYS-4", "CNF-7"],
    value("systems.visual:VISUAL_OBJECT_TYPE.fault", ReservedValue, ForbiddenValue),
)
mutant(
    "sys.object.type-not-compared",
    "The object need not be the one that visual_object_type names",
    ["SYS-6"],
    edit(_STREAM, "expected = _visual_object(io, item)", "_visual_object(io, item)\n            expected = 0"),
)
mutant(
    "sys.object.wrong-object-class",
    "Another object than the header names is reported as a forbidden value",
    ["SYS-6", "CNF-7"],
    value("systems.visual:_WRONG_OBJECT.error", InconsistentSemantics, ForbiddenValue),
)
mutant(
    "sys.object.stuffing-unchecked",
    "The stuffing of visual_object is passed over unread",
    ["SYS-3", "FBA-3"],
    edit(_OBJECT, "    stuffing(io)", "    io.u(TRAILING, 8 - (io.tell() & 7), 0)"),
)
mutant(
    "sys.sequence.without-profile",
    "profile_and_level_indication is not read",
    ["SYS-2"],
    edit(
        "systems.visual:_sequence_header",
        "item.profile = io.u(PROFILE_AND_LEVEL, 8, item.profile)",
        "item.profile = 0x61",
    ),
)
mutant(
    "sys.sequence.unknown-profile-refused",
    "An unknown profile is an error",
    ["SYS-8"],
    edit(
        "systems.visual:_sequence_header",
        "if not profile_name(item.profile):",
        "io.require(bool(profile_name(item.profile)), _NO_OBJECT, item.profile, start, io.tell())\n"
        "    if not profile_name(item.profile):",
    ),
)
mutant(
    "sys.sequence.unknown-profile-not-reported",
    "An unknown profile is not reported",
    ["SYS-8", "CNF-23"],
    edit("systems.visual:_sequence_header", "if not profile_name(item.profile):", "if False:"),
    findings=True,
)
mutant(
    "sys.sequence.fe-and-ff-reported",
    "Profiles FE and FF are reported as unknown",
    ["SYS-8", "CNF-23"],
    edit(
        "systems.visual:profile_name", 'return {0xFE: "none of these", 0xFF: "none needed"}.get(code, "")', 'return ""'
    ),
    findings=True,
)
mutant(
    "sys.sequence.object-without-header",
    "A sequence without visual_object is accepted",
    ["SYS-2"],
    edit(_STREAM, "elif is_object and phase != _IN_SEQUENCE:", "elif is_object:"),
)
mutant(
    "sys.sequence.header-required",
    "A stream that begins with an object is refused",
    ["SYS-7", "FBA-1"],
    edit(
        _STREAM, "elif is_object and phase != _IN_SEQUENCE:", "elif is_object and phase not in (_IN_SEQUENCE, _BEGIN):"
    ),
    edit("systems.visual:_refuse", "_NOT_BUILT if known else _NOT_OURS", "_NOT_OURS"),
)
mutant(
    "sys.sequence.no-object-accepted",
    "A sequence that ends before its object is accepted",
    ["SYS-2", "SYS-6"],
    edit(
        _STREAM,
        "io.require(phase not in _OPEN, _ENDS_EARLY.get(phase, _WRONG_OBJECT), None, io.tell(), io.tell())",
        "pass",
    ),
    edit(
        _STREAM,
        "elif phase in _OPEN:\n            _misplaced(io, code, item.start, phase)",
        "elif phase in _OPEN:\n            return",
    ),
    edit(
        "systems.stream:decode_planes", "if number < options.object_number:", "if 0 <= number < options.object_number:"
    ),
)
mutant(
    "sys.user-data.unknown",
    "User data is not known: the stream is refused",
    ["SYS-5"],
    edit(_STREAM, "elif code == USER_DATA and phase in _OPEN:", "elif code == USER_DATA and phase == 99:"),
)
mutant(
    "sys.user-data.behind-sequence-only",
    "User data behind visual_object is not known",
    ["SYS-5", "SYS-3"],
    edit(_STREAM, "elif code == USER_DATA and phase in _OPEN:", "elif code == USER_DATA and phase == _IN_SEQUENCE:"),
)
mutant(
    "sys.user-data.fixed-length",
    "User data ends at the first zero byte",
    ["SYS-5"],
    edit("syntax.reader:Reader.bytes_to_prefix", 'at = window.find(b"\\0\\0\\1")', 'at = window.find(b"\\0")'),
)
mutant(
    "sys.file.no-start-code-class",
    "A file without a start code is reported as forbidden",
    ["FBA-1", "FBA-44", "CNF-7"],
    edit(
        "systems.visual:_refuse",
        "io.require(False, _NOT_OURS, head.hex() if head else None, start, start + bits)",
        "io.require(False, _TRAILING, head.hex() if head else None, start, start + bits)",
    ),
)
mutant(
    "sys.file.searched-for-a-start-code",
    "Bytes before the first start code are passed over",
    ["FBA-1", "FBA-44"],
    edit(
        _STREAM,
        "item.code = io.next_code(item.code)\n",
        "while phase == _BEGIN and io.reading and io.next_code(0) < 0 and io.bits_left(40) >= 40:\n"
        "            io.u(STUFFING, 8, 0)\n        item.start = io.tell()\n"
        "        item.code = io.next_code(item.code)\n",
    ),
)
mutant(
    "sys.file.empty-accepted",
    "An empty file is accepted as a stream without objects",
    ["FBA-1", "FBA-44"],
    edit(
        _STREAM,
        "if phase == _BEGIN and io.reading:\n                _refuse(io, -1, 0)",
        "if phase == _BEGIN and io.reading:\n                return",
    ),
    edit(
        "systems.stream:decode_planes", "if number < options.object_number:", "if 0 <= number < options.object_number:"
    ),
)
mutant(
    "sys.sequence.no-header-not-reported",
    "A stream without headers is not reported",
    ["SYS-7", "CNF-23"],
    edit("systems.visual:_bare", "if not in_sequence and start == 0:", "if False:"),
    findings=True,
    survives="nearly all vectors are bare objects, so recipes do not declare no-sequence-header; unit tests hold it",
)
