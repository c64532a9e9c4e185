"""Putting a mutant into the reference decoder of this process, and taking it out again.

Rules: CNF-8.

A function is changed by swapping its code object: whoever imported it by name gets the change. What the decoder has
computed once and kept (models of parameters, prefix tables) is forgotten both ways; the tables of the standard, whose
rows a mutant changes in place, are not. Works on the pure form only: compiled code has no source to change.
"""

from __future__ import annotations
import __future__

import ast
import inspect
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property
from importlib import import_module
from types import CodeType, FunctionType, ModuleType
from typing import Any, Final

from .mutant import Edit, Mutant, MutantFault, Value

ROOT: Final = "snhc.reference_impl"
# Data files: mutants change their rows in place, and reading them again takes long.
_KEPT: Final = (f"{ROOT}.tables", f"{ROOT}.rules")
_PATH: Final = re.compile(r"\.?([A-Za-z_]\w*)|\[(-?\d+)\]|\['([^']*)'\]|(\(\))")


@contextmanager
def applied(mutant: Mutant) -> Iterator[None]:
    """The decoder with a mutant in it, for as long as the block runs.

    Rules: CNF-8. Raises MutantFault for a mutant that no longer fits, and for a compiled decoder; nothing is changed
    then.
    """
    with ExitStack() as undo:
        undo.callback(forget)
        try:
            for change in mutant.changes:
                if isinstance(change, Value):
                    undo.callback(_set(change))
            edits = [change for change in mutant.changes if isinstance(change, Edit)]
            for target in dict.fromkeys(change.target for change in edits):
                undo.callback(_swap(target, [change for change in edits if change.target == target]))
        except MutantFault as fault:
            raise MutantFault(f"{mutant.id}: {fault}") from fault
        forget()
        yield


def forget() -> None:
    """Drop what the decoder has computed from its code and tables and kept. Rules: CNF-8."""
    for name, module in list(sys.modules.items()):
        if name.startswith(f"{ROOT}.") and not name.startswith(_KEPT):
            for thing in list(vars(module).values()):
                clear = getattr(thing, "cache_clear", None)
                home = getattr(thing, "__module__", "")
                if callable(clear) and home.startswith(f"{ROOT}.") and not home.startswith(_KEPT):
                    clear()


def _module(target: str) -> tuple[ModuleType, str]:
    name, _, path = target.partition(":")
    module = import_module(f"{ROOT}.{name}")
    file = getattr(module, "__file__", None) or ""
    if not file.endswith(".py"):
        raise MutantFault(f"{module.__name__} is compiled; mutants need the pure form: set SNHC_PURE=1")
    return module, path


# -- source text -------------------------------------------------------------------------------------------------------


def _function(target: str) -> FunctionType:
    module, path = _module(target)
    found: Any = module
    for name in path.split("."):
        # Not getattr: a class method must be found, not bound.
        if name not in vars(found):
            raise MutantFault(f"there is no {target}")
        found = vars(found)[name]
    if isinstance(found, property | cached_property):
        found = found.fget if isinstance(found, property) else found.func
    found = getattr(found, "__func__", found)
    found = getattr(found, "__wrapped__", found)
    if not isinstance(found, FunctionType):
        raise MutantFault(f"{target} is no function in Python")
    return found


def changed_code(target: str, edits: Sequence[Edit]) -> CodeType:
    """The code of a function with all its edits. Rules: CNF-8. Raises MutantFault where an old text does not fit."""
    function = _function(target)
    source = inspect.getsource(function)
    for change in edits:
        count = source.count(change.old)
        if count != 1:
            raise MutantFault(f"{target} holds {change.old!r} {count} times, not once")
        source = source.replace(change.old, change.new)
    # A method keeps its indentation, so that texts are those of the file.
    indented = source[:1].isspace()
    try:
        tree = ast.parse(f"if True:\n{source}" if indented else source)
    except SyntaxError as error:
        raise MutantFault(f"{target} with {edits[-1].new!r} is no Python: {error}") from error
    definition = tree.body[0].body[0] if indented else tree.body[0]  # type: ignore[attr-defined]
    assert isinstance(definition, ast.FunctionDef)
    definition.decorator_list = []
    tree.body = [definition]
    ast.increment_lineno(tree, function.__code__.co_firstlineno - 1 - indented)
    flags = function.__code__.co_flags & __future__.annotations.compiler_flag
    scope = dict(function.__globals__)
    exec(compile(tree, function.__code__.co_filename, "exec", flags=flags, dont_inherit=True), scope)
    made = scope[definition.name]
    assert isinstance(made, FunctionType)
    if made.__code__.co_freevars != function.__code__.co_freevars:
        raise MutantFault(f"{target} uses names of the scope around it: it cannot be compiled alone")
    return made.__code__


def _swap(target: str, edits: Sequence[Edit]) -> Callable[[], None]:
    function = _function(target)
    code = function.__code__
    function.__code__ = changed_code(target, edits)

    def undo() -> None:
        function.__code__ = code

    return undo


# -- objects -----------------------------------------------------------------------------------------------------------


def _steps(path: str) -> list[tuple[str, str | int]]:
    out: list[tuple[str, str | int]] = []
    at = 0
    while at < len(path):
        match = _PATH.match(path, at)
        if match is None:
            raise MutantFault(f"{path} is no path")
        name, index, key, _ = match.groups()
        if name is not None:
            out.append(("name", name))
        elif index is not None:
            out.append(("item", int(index)))
        elif key is not None:
            out.append(("item", key))
        else:
            out.append(("call", ""))
        at = match.end()
    return out


def _set(change: Value) -> Callable[[], None]:
    module, path = _module(change.target)
    holder: Any = module
    *steps, (kind, last) = _steps(path)
    try:
        for step, name in steps:
            holder = holder() if step == "call" else getattr(holder, str(name)) if step == "name" else holder[name]
        found = getattr(holder, str(last)) if kind == "name" else holder[last]
    except (AttributeError, LookupError, TypeError) as error:
        raise MutantFault(f"there is no {change.target}: {error}") from error
    if type(found) is not type(change.old) or found != change.old:
        raise MutantFault(f"{change.target} is {found!r}, not {change.old!r}")

    def put(what: object) -> None:
        if kind == "item":
            holder[last] = what
        elif isinstance(holder, ModuleType):
            setattr(holder, str(last), what)
        else:
            # Records are frozen; this is what thaws them.
            object.__setattr__(holder, str(last), what)

    put(change.new)
    return lambda: put(change.old)
