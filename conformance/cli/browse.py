"""`snhc browse`: a stream in the terminal.

Rules: CNF-17, CNF-19, CNF-21.
"""

from __future__ import annotations

import sys

import click

from .common import Common, common_options, open_input, parse_planes
from .extras import MissingExtra


@click.command()
@click.argument("file")
@click.option(
    "--planes", metavar="A:B", callback=lambda ctx, param, value: parse_planes(value), help="Only planes A to B-1."
)
@click.option(
    "--object", "object_number", type=click.IntRange(min=0), default=0, metavar="N",
    help="Which object --planes counts in.",
)  # fmt: skip
@click.option(
    "--most", type=click.IntRange(min=1), default=20_000, show_default=True, metavar="N",
    help="Planes and headers to keep in memory.",
)  # fmt: skip
@common_options(writes=False)
def command(file: str, planes: tuple[int, int | None] | None, object_number: int, most: int, common: Common) -> None:
    """Look at a stream in the terminal.

    Its tree, its bytes, and what each bit means.

    Keys: arrows and Enter move and open, / searches, n and N go on, b jumps to a bit, p to a plane, e to the next
    finding or fault, d changes between light and dark, q quits.
    """
    from snhc.analyzer.browse.document import Document
    from snhc.analyzer.parts import Parts, Selection
    from snhc.reference_impl.systems.stream import trace_stream

    try:
        from snhc.analyzer.browse.app import Browser
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "textual":
            raise
        raise MissingExtra("browse needs the extra snhc[browse] (textual is not installed)") from None
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise click.UsageError("browse needs a terminal; `snhc dump` prints the same")
    options = common.options(object_number)
    selection = None if planes is None else Selection(object_number, *planes)
    with open_input(file) as source:
        document = Document(source, Parts(trace_stream(source, options), selection), most)
        Browser(document, file).run()
    if document.error is not None:
        raise document.error
