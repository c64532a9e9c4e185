"""`snhc dump`: what every bit of a stream is.

Rules: CNF-17, CNF-19, CNF-21, CNF-23.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import PurePath
from typing import Final

import click

from .common import Common, Output, colour_allowed, common_options, format_of, open_input, parse_planes

_SUFFIXES: Final = {".txt": "tree", ".json": "json", ".csv": "csv", ".html": "html", ".htm": "html"}


def _write_paged(pieces: Iterator[str]) -> None:
    """Through the reader's pager; it quits at once where all fits on the screen, as git's does."""
    os.environ.setdefault("LESS", "FRX")
    click.echo_via_pager(pieces, color=True)


@click.command()
@click.argument("file")
@click.option(
    "--format", "format_", type=click.Choice(("tree", "json", "csv", "html")),
    help="Default: by the extension of -o, else tree.",
)  # fmt: skip
@click.option(
    "--planes", metavar="A:B", callback=lambda ctx, param, value: parse_planes(value),
    help="Only planes A to B-1; reading stops behind them.",
)  # fmt: skip
@click.option(
    "--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N",
    help="Which object --planes counts in.",
)  # fmt: skip
@click.option("--depth", type=click.IntRange(min=1), metavar="N", help="Tree: levels to show.")
@click.option("--symbols", is_flag=True, help="Arithmetic segments symbol by symbol.")
@click.option("--all-bytes", is_flag=True, help="Tree: long elements with all their bytes.")
@click.option(
    "--query", metavar="EXPR",
    help="Only elements, planes and symbols that this takes, e.g. 'name == \"fap_quant\" && value > 15'.",
)  # fmt: skip
@click.option("--no-pager", is_flag=True, help="Tree: never through a pager.")
@common_options()
def command(
    file: str,
    format_: str | None,
    planes: tuple[int, int | None] | None,
    object_number: int,
    depth: int | None,
    symbols: bool,
    all_bytes: bool,
    query: str | None,
    no_pager: bool,
    common: Common,
) -> None:
    """Show what every bit of a stream is.

    Each element with its bit span [first, end), its bytes, value and rule. A fault stands in its place, behind it the
    bits that it leaves unread. FILE: - for standard input. html is one page that shows all of it; json can be encoded
    again.
    """
    chosen = format_of(format_, common.output, _SUFFIXES, "tree")
    if chosen == "html" and query is not None:
        raise click.UsageError("a page is searched in the page; --query is for tree, json and csv")
    if chosen == "html" and common.output is None and sys.stdout.isatty():
        raise click.UsageError("a page is not for terminals; give -o FILE.html")
    from snhc.analyzer.dump import TreeOptions, dump_tree
    from snhc.analyzer.dump_layout import layout_for
    from snhc.analyzer.parts import Parts, Selection
    from snhc.analyzer.query import Query
    from snhc.reference_impl.systems.stream import trace_stream

    options = common.options(object_number)
    wanted = Query(query) if query is not None else None
    selection = None if planes is None else Selection(object_number, *planes)
    with open_input(file) as source, Output(common.output, common.keep_partial) as out:
        parts = Parts(trace_stream(source, options, symbols=symbols or chosen == "html"), selection)
        if chosen == "json":
            from snhc.analyzer.dump_json import dump_json

            pieces = dump_json(parts, source, options, symbols, wanted)
        elif chosen == "csv":
            from snhc.analyzer.dump_csv import dump_csv

            pieces = dump_csv(parts, source, symbols, wanted)
        elif chosen == "html":
            from snhc.analyzer.html.page import dump_html

            name = "standard input" if file == "-" else PurePath(file).name
            pieces = dump_html(parts, source, options, name, symbols)
        else:
            layout = layout_for(shutil.get_terminal_size().columns if out.is_terminal else None)
            tree = TreeOptions(depth, symbols, all_bytes, colour_allowed(out.is_terminal), layout)
            pieces = dump_tree(parts, source, tree, wanted)
        if chosen == "tree" and out.is_terminal and not no_pager:
            _write_paged(pieces)
        else:
            for piece in pieces:
                out.write(piece)
        if parts.missed and not common.quiet:
            click.echo(f"note: nothing of --planes is there: {parts.missed}", err=True)
        if parts.error is not None:
            # The dump says itself where and why it ends, so it is whole.
            out.keep()
            raise parts.error
