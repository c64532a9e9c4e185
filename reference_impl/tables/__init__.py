"""Every table of the standard as a data file; loaded when asked for, checked on load, frozen.

`loader` holds the typed tables, `prefix` the variable length codes, `reading` what both share. Importing
them reads no file; a table is read, checked and kept when it is first asked for.

Rules: FBA-18, FBA-40, DCT-5, MSH-5, MSH-12, SYS-1, SYS-8, SYS-9, FAC-4, FAC-6. The BIFS node tables (SYS-51) are
**not** here.
"""

from __future__ import annotations

from snhc.reference_impl.tables.loader import (
    bap_groups,
    bap_quant_scale,
    bap_table,
    expressions,
    fap_dct_base_step,
    fap_dct_scale,
    fap_groups,
    fap_table,
    left_right_pairs,
    mesh_motion_range,
    profile_level_codes,
    profile_tools,
    start_code,
    start_codes,
    viseme_expression_symbols,
    visemes,
)
from snhc.reference_impl.tables.prefix import PREFIX_TABLES, PrefixRow, PrefixTable, prefix_table
from snhc.reference_impl.tables.records import (
    Bap,
    BapGroup,
    Expression,
    Fap,
    FapGroup,
    HighLevelSymbol,
    MotionRange,
    ProfileLevel,
    StartCode,
    Viseme,
)

__all__ = [
    "PREFIX_TABLES",
    "Bap",
    "BapGroup",
    "Expression",
    "Fap",
    "FapGroup",
    "HighLevelSymbol",
    "MotionRange",
    "PrefixRow",
    "PrefixTable",
    "ProfileLevel",
    "StartCode",
    "Viseme",
    "bap_groups",
    "bap_quant_scale",
    "bap_table",
    "expressions",
    "fap_dct_base_step",
    "fap_dct_scale",
    "fap_groups",
    "fap_table",
    "left_right_pairs",
    "mesh_motion_range",
    "prefix_table",
    "profile_level_codes",
    "profile_tools",
    "start_code",
    "start_codes",
    "viseme_expression_symbols",
    "visemes",
]
