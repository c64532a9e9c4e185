"""What all verbs share: options, and findings on standard error. Input and output are in `files`, faults in `failures`.

Rules: CNF-19, CNF-23, CNF-24, CNF-25, CNF-26.
"""

from __future__ import annotations

import errno
import functools
import json
import os
import re
import stat
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Final, Literal

import click

from .failures import Invocation
from .files import Output, colour_allowed, open_binary, open_input, progress

if TYPE_CHECKING:
    from snhc.reference_impl.bitstream.findings import Finding
    from snhc.reference_impl.bitstream.limits import Limits
    from snhc.reference_impl.entropy.profile import EntropyProfile
    from snhc.reference_impl.syntax.element import Readings
    from snhc.reference_impl.systems.stream import Options

__all__ = [
    "REPORT_FORMATS", "REPORT_SUFFIXES", "Common", "FindingReport", "InputPath", "Output", "colour_allowed",
    "common_options", "format_of", "near", "open_binary", "open_input", "parse_limits", "parse_planes",
    "parse_readings", "progress",
]  # fmt: skip

# Of reports; here, so that the help of a verb imports no report.
REPORT_FORMATS: Final = ("terminal", "html", "markdown", "junit", "sarif", "json")
REPORT_SUFFIXES: Final = {
    ".txt": "terminal", ".html": "html", ".htm": "html", ".md": "markdown", ".xml": "junit", ".sarif": "sarif",
    ".json": "json",
}  # fmt: skip
# Findings of one id that are printed; the others are counted.
SHOWN_PER_ID: Final = 100


class FindingReport:
    """Findings as lines on standard error, as they come. Rules: CNF-23.

    After SHOWN_PER_ID of the same id they are only counted; `close` says how many. With `as_json` each is a JSON
    line, told from the error by its `id`.
    """

    def __init__(self, quiet: bool = False, as_json: bool = False) -> None:
        self._quiet = quiet
        self._as_json = as_json
        self._counts: dict[str, int] = {}

    def __call__(self, finding: Finding) -> None:
        if self._quiet:
            return
        count = self._counts.get(finding.id, 0) + 1
        self._counts[finding.id] = count
        if count <= SHOWN_PER_ID:
            if self._as_json:
                click.echo(json.dumps(finding.as_json(), ensure_ascii=False), err=True)
            else:
                click.echo(str(finding), err=True)

    def close(self) -> None:
        """Say how many more there were. Rules: CNF-23."""
        for id, count in self._counts.items():
            more = count - SHOWN_PER_ID
            if more > 0:
                message = f"... and {more} more `{id}`"
                text = json.dumps({"id": id, "more": more, "message": message}) if self._as_json else message
                click.echo(text, err=True)
        self._counts.clear()


@dataclass(frozen=True, slots=True)
class Common:
    """The options that all verbs share. Rules: CNF-19, CNF-23, CNF-24, CNF-26.

    `dct_tables`: a folder. `output`: as given to -o, None for standard output. `report`: takes findings. `progress`:
    bars may be shown.
    """

    draft: bool
    strict: bool
    quiet: bool
    readings: Readings
    limits: Limits
    output: str | None
    keep_partial: bool
    json_errors: bool
    progress: bool
    dct_tables: str | None
    report: FindingReport

    def options(self, object_number: int = 0) -> Options:
        """How a stream is to be read. Rules: CNF-24, CNF-26."""
        from snhc.reference_impl.systems.stream import Options

        return Options(
            draft=self.draft,
            strict=self.strict,
            object_number=object_number,
            limits=self.limits,
            readings=self.readings,
            profile=self.entropy_profile(),
        )

    def entropy_profile(self) -> EntropyProfile | None:
        """The entropy tables of --dct-tables, None for the shipped ones. Rules: DCT-1, DCT-3, DCT-4."""
        if self.dct_tables is None:
            return None
        from snhc.reference_impl.entropy.profile import load_profile

        return load_profile(Path(self.dct_tables))


if TYPE_CHECKING:
    _ToPath = click.ParamType[Path]
else:
    # Of older versions of click it cannot be asked what it converts to.
    _ToPath = click.ParamType


class InputPath(_ToPath):
    """A file, or a folder, that has to be there. Rules: CNF-19. One that is not is a fault of input, not of usage."""

    name = "path"

    def __init__(self, folder: bool = False) -> None:
        self._folder = folder

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path = Path(value)
        is_folder = stat.S_ISDIR(path.stat().st_mode)
        if is_folder != self._folder:
            code = errno.EISDIR if is_folder else errno.ENOTDIR
            raise OSError(code, os.strerror(code), str(path))
        return path


# -- options -----------------------------------------------------------------------------------------------------------


def _json_errors(ctx: click.Context, param: click.Parameter, value: bool) -> bool:
    invocation = ctx.find_root().obj
    if isinstance(invocation, Invocation):
        invocation.json_errors = value
    return value


def parse_readings(values: tuple[str, ...]) -> dict[str, str]:
    """`AMB-FBA-6=before` -> {"AMB-FBA-6": "before"}, without those that are followed anyway.

    Rules: CNF-24. Raises click.BadParameter for what the register does not hold or the decoder cannot switch.
    """
    if not values:
        return {}
    from snhc.reference_impl.rules import ambiguities

    chosen: dict[str, str] = {}
    for text in values:
        id, separator, key = text.partition("=")
        if not separator:
            raise click.BadParameter(f"{text!r} is not of the form ID=KEY")
        entry = ambiguities().get(id)
        if entry is None:
            raise click.BadParameter(f"unknown ambiguity {id!r}{near(id, ambiguities())}")
        if key not in entry.readings:
            raise click.BadParameter(f"{id} has no reading {key!r}; it has {', '.join(entry.readings)}")
        if key != entry.followed and not entry.built:
            raise click.BadParameter(f"{id} has no switch yet; {entry.followed} is followed")
        chosen.pop(id, None)
        if key != entry.followed:
            chosen[id] = key
    return chosen


def parse_limits(values: tuple[str, ...]) -> dict[str, int]:
    """`idle_planes=10` -> {"idle_planes": 10}. Rules: CNF-26. Raises click.BadParameter."""
    if not values:
        return {}
    from snhc.reference_impl.bitstream.limits import Limits

    changes: dict[str, int] = {}
    for text in values:
        name, _, number = text.partition("=")
        if name not in Limits.names():
            raise click.BadParameter(f"unknown limit {name!r}; limits are {', '.join(Limits.names())}")
        if not (number.isascii() and number.isdigit()) or len(number) > 18:
            raise click.BadParameter(f"{text!r} is not of the form name=value with a whole number")
        changes[name] = int(number)
    return changes


def parse_planes(value: str | None) -> tuple[int, int | None] | None:
    """`A:B`, `A:`, `:B` or `A` as (first, behind the last), None for no end.

    Rules: CNF-19. Planes count from 0. Raises click.BadParameter.
    """
    if value is None:
        return None
    match = re.fullmatch(r"(\d{0,12})(:?)(\d{0,12})", value, re.ASCII)
    if match is None or not (match[1] or match[3]):
        raise click.BadParameter(f"{value!r} is not of the form A:B, A:, :B or A")
    first = int(match[1] or 0)
    last = int(match[3]) if match[3] else None if match[2] else first + 1
    if last is not None and last <= first:
        raise click.BadParameter(f"{value!r} holds no plane")
    return first, last


def near(word: str, known: Iterable[str]) -> str:
    """`; did you mean FBA-26, FBA-2?`, or nothing. Rules: CNF-19."""
    import difflib

    matches = difflib.get_close_matches(word, list(known), n=3, cutoff=0.6)
    return f"; did you mean {', '.join(matches)}?" if matches else ""


_STREAMS: Final = (
    click.option("--compat", type=click.Choice(["draft"]), help="Take the start codes of the drafts too."),
    click.option(
        "--reading", metavar="ID=KEY", multiple=True, callback=lambda ctx, param, value: parse_readings(value),
        help="Follow another reading of an ambiguity (see `snhc rules AMB`). Repeatable.",
    ),
)  # fmt: skip
_INPUTS: Final = (
    click.option("--strict", is_flag=True, help="Data behind the end, and every dialect of a text, is an error."),
    click.option(
        "--limit", metavar="NAME=VALUE", multiple=True, callback=lambda ctx, param, value: parse_limits(value),
        help="Change a limit, e.g. idle_planes=100. Repeatable.",
    ),
    click.option(
        "--dct-tables", metavar="DIR", help="Entropy tables of DCT segments, instead of the shipped provisional ones."
    ),
)  # fmt: skip
_WRITES: Final = (
    click.option("-o", "--output", metavar="FILE|-", help="Where the data goes; a file is left whole or not at all."),
    click.option("--keep-partial", is_flag=True, help="Keep what is complete of -o FILE when an error ends it."),
)
# A verb that reads no stream has no findings.
_QUIET: Final = {
    True: click.option("--quiet", is_flag=True, help="Do not print findings."),
    False: click.option("--quiet", is_flag=True, help="Print data and errors, nothing else."),
}
_ALWAYS: Final = (
    click.option(
        "--json-errors", is_flag=True, is_eager=True, callback=_json_errors,
        help="Error and findings as JSON lines on standard error.",
    ),
    click.option("--no-progress", is_flag=True, help="Never show a progress bar."),
)  # fmt: skip


def common_options(
    *, reads: bool | Literal["text"] = True, writes: bool = True
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the shared options to a verb, which gets them as `common`, a `Common`.

    Rules: CNF-19, CNF-24, CNF-26. `reads`: the verb reads streams, `text`: text that it encodes; `writes`: it has an
    output.
    """

    def decorate(verb: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(verb)
        def wrapper(*args: Any, **kwargs: Any) -> None:
            verb(*args, common=_collect(kwargs), **kwargs)

        wrapped: Callable[..., None] = wrapper
        streams, inputs, outputs = (
            _STREAMS if reads is True else (),
            _INPUTS if reads else (),
            _WRITES if writes else (),
        )
        for option in reversed((*streams, *inputs, *outputs, _QUIET[bool(reads)], *_ALWAYS)):
            wrapped = option(wrapped)
        return wrapped

    return decorate


def _collect(kwargs: dict[str, Any]) -> Common:
    from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS
    from snhc.reference_impl.syntax.element import Readings

    quiet = kwargs.pop("quiet")
    json_errors = kwargs.pop("json_errors")
    report = FindingReport(quiet, json_errors)
    invocation = click.get_current_context().find_root().obj
    if isinstance(invocation, Invocation):
        invocation.report = report
    return Common(
        draft=kwargs.pop("compat", None) == "draft",
        strict=kwargs.pop("strict", False),
        quiet=quiet,
        readings=Readings(kwargs.pop("reading", None)),
        limits=DEFAULT_LIMITS.with_values(kwargs.pop("limit", {})),
        output=kwargs.pop("output", None),
        keep_partial=kwargs.pop("keep_partial", False),
        json_errors=json_errors,
        dct_tables=kwargs.pop("dct_tables", None),
        progress=not kwargs.pop("no_progress") and not quiet,
        report=report,
    )


def format_of(given: str | None, output: str | None, by_suffix: dict[str, str], default: str) -> str:
    """The format: as given, else by the extension of -o, else the default.

    Rules: CNF-19. An extension that says nothing is a usage error: silence would write something unexpected.
    """
    if given is not None:
        return given
    suffix = PurePath(output).suffix.lower() if output is not None and output != "-" else ""
    if not suffix:
        return default
    if suffix not in by_suffix:
        raise click.UsageError(f"{suffix} names no format ({', '.join(by_suffix)}); give --format")
    return by_suffix[suffix]
