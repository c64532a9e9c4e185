"""Start codes as numbers, for the syntax functions; their names and ranges are in tables/start_codes.csv.

Rules: SYS-1, FBA-1, FBA-2, FBA-4.
"""

from __future__ import annotations

from typing import Final

PREFIX: Final = 0x000001
VISUAL_OBJECT_SEQUENCE: Final = 0x000001B0
VISUAL_OBJECT_SEQUENCE_END: Final = 0x000001B1
USER_DATA: Final = 0x000001B2
VISUAL_OBJECT: Final = 0x000001B5
FBA_OBJECT: Final = 0x000001BA
FBA_OBJECT_PLANE: Final = 0x000001BB
MESH_OBJECT: Final = 0x000001BC
MESH_OBJECT_PLANE: Final = 0x000001BD
DRAFT_OBJECT: Final = 0x00000101
DRAFT_PLANE: Final = 0x00000103
