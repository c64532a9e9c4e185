"""The command `snhc`: one verb per module, imported when it is called and not before.

Rules: CNF-19 (exit codes).

A verb is one line in `VERBS` and a module of this folder with a click command named `command`. Verbs are thin: they
turn options into arguments, call into a room, and leave faults to `failures`.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Final

import click

# Name -> what the list of verbs says; the same words begin the verb's own help.
VERBS: Final = {
    "decode": "Decode a face or mesh stream to frames.",
    "encode": "Encode FAP text, a mesh document, pictures or a dump as a stream.",
    "render": "Draw a face or mesh stream as a picture or an animation.",
    "fit": "Fill frames by a FAP interpolation table.",
    "fat": "Move a model by its face animation tables.",
    "dct": "Decode quantised DCT coefficients to frames.",
    "check": "Print the findings of an input.",
    "diff": "Show what differs between two streams or decodes.",
    "stats": "Sum up a stream: planes, rates, bits, masks, ranges.",
    "plot": "Plot the FAP curves and bit rates of a stream.",
    "dump": "Show what every bit of a stream is.",
    "browse": "Look at a stream in the terminal.",
    "generate": "Make the suite's vectors, check or export them, or list changes.",
    "coverage": "Show what the suite covers, and its holes.",
    "run": "Run decoders against the suite.",
    "minimize": "Shrink an input while a decoder still fails on it in the same way.",
    "doctor": "Walk an adapter through every step and say what is wrong.",
    "report": "Render saved results, and join those of several runs.",
    "rules": "Print the rules, ambiguities and findings.",
}


class LazyGroup(click.Group):
    """A group that knows its verbs by name and imports a verb's module when it is invoked. Rules: CNF-19."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            return None
        command = import_module(f"{__name__}.{cmd_name}").command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))

    def invoke(self, ctx: click.Context) -> None:
        from .failures import guarded

        guarded(ctx, super().invoke)


def _print_version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        from .version import version_line

        click.echo(version_line())
        ctx.exit()


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_print_version,
    help="Show version and form (pure or compiled) and exit.",
)  # fmt: skip
def snhc() -> None:
    """Conformance suite, bitstream analyzer and reference decoder for MPEG-4 face animation and 2D meshes.

    Data goes to standard output, all else to standard error. Exit codes: 0 good, 1 conformance failure, 2 usage,
    3 input or I/O, 4 the stream does not decode, 5 adapter or protocol fault, 70 internal error.
    """


def main() -> None:
    """The entry point of the command. Rules: CNF-19."""
    from .failures import exit_code, heed_signals, open_streams, unwritten

    open_streams()
    heed_signals()
    try:
        snhc(prog_name="snhc")
    except KeyboardInterrupt as error:
        sys.exit(exit_code(error))
    except OSError as error:
        # Help and version are printed before any verb is there.
        sys.exit(unwritten(error))
