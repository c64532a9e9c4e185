"""From exceptions to one line on standard error and an exit code, for all verbs.

Rules: CNF-19, CNF-25.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import sys
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, Final

import click

from snhc.reference_impl.bitstream.errors import one_line

if TYPE_CHECKING:
    from .common import FindingReport

INPUT_OUTPUT: Final = 3
INTERNAL: Final = 70
# 128 + the number of the signal, as shells count.
_SIGNALLED: Final = 128
INTERRUPTED: Final = _SIGNALLED + signal.SIGINT
BROKEN_PIPE: Final = 141
# What a file would have to be, by the number of the system's error; 0: any other.
_ALLOWED: Final = {
    errno.ENOENT: "a file that is there", errno.EISDIR: "a file, no folder", errno.ENOTDIR: "a path of folders",
    errno.EACCES: "a file that may be opened", errno.EROFS: "a place that can be written",
    errno.ENOSPC: "a place with room", errno.EFBIG: "a place with room", errno.EEXIST: "a place that is free",
    0: "a file that can be read or written",
}  # fmt: skip


class Terminated(KeyboardInterrupt):
    """A signal asks the program to end; all is put in order as after Ctrl-C. Rules: CNF-19, CNF-20."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.code = _SIGNALLED + number


def exit_code(error: KeyboardInterrupt) -> int:
    """What a program that was interrupted ends with. Rules: CNF-19."""
    return error.code if isinstance(error, Terminated) else INTERRUPTED


def heed_signals() -> None:
    """Have SIGTERM and SIGHUP end the program in good order: a CI job that is cancelled, a terminal that is closed.

    Rules: CNF-19, CNF-20. What is ignored already stays so (nohup).
    """

    def end(number: int, frame: FrameType | None) -> None:
        # Those who end a process often tell it twice, and once more with its group.
        for other in numbers:
            signal.signal(other, signal.SIG_IGN)
        raise Terminated(number)

    wanted = (getattr(signal, name, None) for name in ("SIGTERM", "SIGHUP"))
    numbers = [number for number in wanted if number is not None and signal.getsignal(number) == signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, end)


class Invocation:
    """What the error handling has to know of the running verb. Rules: CNF-19."""

    def __init__(self) -> None:
        self.json_errors = False
        self.report: FindingReport | None = None

    def close(self) -> None:
        """Say how many findings were held back. Rules: CNF-23."""
        if self.report is not None:
            self.report.close()
            self.report = None

    def fail(self, error: object, fields: dict[str, object]) -> None:
        """Print one line: `fields` as JSON under --json-errors, else the error. Rules: CNF-25."""
        self.close()
        text = json.dumps(fields, ensure_ascii=False) if self.json_errors else f"snhc: {_joined(str(error))}"
        click.echo(text, err=True)


def _joined(text: str) -> str:
    """A text without line ends: of usage, click says some things on several lines. Rules: CNF-19."""
    return one_line(" ".join(text.splitlines()))


def guarded(ctx: click.Context, invoke: Callable[[click.Context], object]) -> None:
    """Run a verb; faults become one line and an exit code. Rules: CNF-19, CNF-25."""
    from snhc.reference_impl.bitstream.errors import SnhcError

    invocation = Invocation()
    ctx.obj = invocation
    words = tuple(ctx.args)
    try:
        invoke(ctx)
        invocation.close()
        sys.stdout.flush()
        code = 0
    except click.exceptions.Exit as error:
        invocation.close()
        code = error.exit_code
    except click.ClickException as error:
        # A verb's options may not have been read yet when one of them is wrong.
        if not (invocation.json_errors or "--json-errors" in words):
            raise
        invocation.json_errors = True
        invocation.fail(error, _usage_fields(error))
        code = error.exit_code
    except click.Abort:
        raise
    except SnhcError as error:
        invocation.fail(error, error.as_json())
        code = error.exit_code
    except KeyboardInterrupt as error:
        code = exit_code(error)
    except OSError as error:
        code = _system_error(invocation, error)
    except Exception as error:  # noqa: BLE001 (the last line of defence: a bug is reported, not printed as a traceback)
        if os.environ.get("SNHC_DEBUG") == "1":
            import traceback

            traceback.print_exc()
        message = f"internal error: {type(error).__name__}: {error}; please report it (SNHC_DEBUG=1 shows where)"
        invocation.fail(message, _fields("Internal", "", message))
        code = INTERNAL
    _settle_stdout()
    ctx.exit(code)


def _usage_fields(error: click.ClickException) -> dict[str, object]:
    parameter = getattr(error, "param", None)
    named = ""
    if isinstance(parameter, click.Option):
        named = parameter.opts[0]
    elif isinstance(parameter, click.Parameter):
        named = parameter.human_readable_name
    return _fields("Usage", str(getattr(error, "param_hint", None) or named), error.format_message())


def _fields(kind: str, element: str, message: str) -> dict[str, object]:
    """What is printed for faults that are none of an input. Rules: CNF-19."""
    return {
        "class": kind, "rule": "CNF-19", "element": element, "value": None, "allowed": "", "message": _joined(message),
    }  # fmt: skip


def _system_error(invocation: Invocation, error: OSError) -> int:
    if error.errno == errno.EPIPE:
        return BROKEN_PIPE
    name = error.filename if isinstance(error.filename, str) else ""
    text = error.strerror or str(error)
    message = f"{name}: {text}" if name else text
    fields = {**_fields("InputOutput", name, message), "allowed": _ALLOWED.get(error.errno or 0, _ALLOWED[0])}
    invocation.fail(message, fields)
    return INPUT_OUTPUT


def _settle_stdout() -> None:
    """Make sure that the interpreter does not fail again at exit on output that nobody takes."""
    try:
        sys.stdout.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def open_streams() -> None:
    """Open the standard streams that the caller has closed, before another file takes their number. Rules: CNF-19.

    What is written to them then fails as any other output: standard output is open for reading only.
    """
    for number, name, flags, mode in (
        (0, "stdin", os.O_RDONLY, "r"), (1, "stdout", os.O_RDONLY, "w"), (2, "stderr", os.O_WRONLY, "w")
    ):  # fmt: skip
        if getattr(sys, name) is not None:
            continue
        nowhere = os.open(os.devnull, flags)
        if nowhere != number:
            os.dup2(nowhere, number)
            os.close(nowhere)
        stream = open(number, mode, encoding="utf-8", closefd=False)  # noqa: SIM115 (as long as the process)
        setattr(sys, name, stream)


def unwritten(error: OSError) -> int:
    """Say that output could not be written; the exit code. Rules: CNF-19."""
    _settle_stdout()
    if error.errno == errno.EPIPE:
        return BROKEN_PIPE
    click.echo(f"snhc: {error.strerror or error}", err=True)
    return INPUT_OUTPUT
