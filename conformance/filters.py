"""Which vectors are run: `--filter EXPR`.

Rules: CNF-8, CNF-15.

An expression is one or more terms separated by blanks; all of them must hold. A term is `field=glob`, or a bare glob
for the id; `!` before it turns it around; `|` in a glob separates alternatives. Fields: id, tier, kind, rule, feature,
class (value class), tool. A field with several values holds where one of them fits.

    fap.arith.*             tier=error rule=FBA-25            !tier=stress kind=valid|ambiguous
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from typing import Final

from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import Entry

_FIELDS: Final[dict[str, Callable[[Entry], Iterable[str]]]] = {
    "id": lambda entry: (entry.id,),
    "tier": lambda entry: (entry.tier,),
    "kind": lambda entry: (entry.kind,),
    "rule": lambda entry: entry.rules,
    "feature": lambda entry: entry.features,
    "class": lambda entry: entry.value_classes,
    "tool": lambda entry: entry.tools,
}

MOST_GLOB: Final = 200


def long_glob(globs: str) -> bool:
    """Whether one of the patterns between `|` is too long: what has many `[` takes time by the square of them.

    Rules: CNF-15.
    """
    return any(len(glob) > MOST_GLOB for glob in globs.split("|"))


def selector(expression: str) -> Callable[[Entry], bool]:
    """The test that an expression makes. Rules: CNF-15. Raises InputFormat for a field that there is not,
    and for patterns of more than `MOST_GLOB` characters."""
    terms: list[tuple[bool, Callable[[Entry], Iterable[str]], list[str]]] = []
    for word in expression.split():
        wanted = not word.startswith("!")
        name, separator, globs = word.removeprefix("!").partition("=")
        if not separator:
            name, globs = "id", name
        if name not in _FIELDS:
            raise InputFormat("CNF-15", "filter", value=word, allowed=f"terms with {', '.join(_FIELDS)}")
        if long_glob(globs):
            raise InputFormat(
                "CNF-15", "filter", value=word, allowed=f"patterns of at most {MOST_GLOB} characters between |"
            )
        terms.append((wanted, _FIELDS[name], globs.split("|")))

    def holds(entry: Entry) -> bool:
        return all(
            any(fnmatchcase(value, glob) for value in values(entry) for glob in globs) == wanted
            for wanted, values, globs in terms
        )

    return holds
