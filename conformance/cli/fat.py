"""`snhc fat`: the vertices that frames give a model with face animation tables.

Rules: CNF-2, CNF-19, CNF-25, FAT-1..9, FAT-11.
"""

from __future__ import annotations

import click

from .common import Common, Output, common_options, open_binary


@click.command()
@click.argument("table")
@click.argument("frames")
@common_options()
def command(table: str, frames: str, common: Common) -> None:
    """Move a model by its face animation tables.

    TABLE: a model as JSON or as the text of its nodes, or the word head for the shipped one. FRAMES: what decode or
    fit prints, - for standard input.
    """
    from snhc.analyzer.face_lines import mesh_lines
    from snhc.analyzer.face_scene import load_model

    with Output(common.output, common.keep_partial, prompt=frames == "-") as out:
        model = load_model(table, common.limits, common.report, common.readings)
        with open_binary(frames) as stream:
            for line in mesh_lines(stream, model, common.readings, common.limits):
                out.write(line)
