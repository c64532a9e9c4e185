"""`snhc fit`: what a FAP interpolation table makes of frames.

Rules: CNF-2, CNF-19, CNF-25, FIT-4..9.
"""

from __future__ import annotations

import sys

import click

from .common import Common, Output, common_options, open_binary


@click.command()
@click.argument("table")
@click.argument("frames")
@click.option("--symmetry", is_flag=True, help="Then let the one side of the face copy the other (informative).")
@common_options()
def command(table: str, frames: str, symmetry: bool, common: Common) -> None:
    """Fill frames by a FAP interpolation table.

    TABLE: JSON, or the text of a FIT node. FRAMES: what decode prints, - for standard input.
    """
    from snhc.analyzer.face_lines import face_lines, load_table

    # Frames from a pipe are passed on one by one, those of a file in blocks.
    block = {"block": 1} if frames == "-" and not sys.stdin.isatty() else {}
    with Output(common.output, common.keep_partial, prompt=bool(block)) as out:
        loaded = load_table(table, common.readings, common.limits)
        with open_binary(frames) as stream:
            for line in face_lines(stream, loaded, symmetry, common.readings, common.limits, **block):
                out.write(line)
