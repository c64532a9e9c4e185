"""The branches of the decoder: found in its source, and watched while vectors are decoded.

Rules: CNF-8. The library `coverage` watches the lines; which jumps between lines are branches, and what they are
called, is read from the source here: module, function, the text of the branch, its direction. Line numbers are not
part of a name, so that a name stays while code around it moves.

Counted are the statements if, while, for and except inside functions. Not counted: conditions inside expressions.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Final

from snhc import reference_impl

PACKAGE: Final = reference_impl.__name__
_LONGEST: Final = 90
_RULES: Final = re.compile(r"\bRules:\s*(.*?)(?:\.(?=\s|$)|\n\s*\n|$)", re.DOTALL)
_ID: Final = re.compile(r"(?<!AMB-)\b([A-Z]{3})-(\d+)(?:\.\.(?:[A-Z]{3}-)?(\d+))?")

Targets = frozenset[int]
_LEAVES: Final = -1  # a jump out of the function


@dataclass(frozen=True, slots=True)
class Branch:
    """One direction of one branch.

    Rules: CNF-8. `module`: below `reference_impl`; `function`: with its classes; `text`: of the statement, in one
    line; `direction`: `yes`, `no`, `body`, `end`, `caught`. `line`: where it is; `to`: the lines that it leads to.
    `rules`: of the function, else of its class or module.
    """

    module: str
    function: str
    text: str
    direction: str
    rules: tuple[str, ...]
    line: int
    to: Targets

    @property
    def key(self) -> str:
        """The cell's name."""
        return f"branch/{self.module}/{self.function}/{self.text}/{self.direction}"


@dataclass(frozen=True, slots=True)
class Source:
    """A module's branches. `firsts`: line -> first line of its statement; `file`: its real path."""

    module: str
    file: str
    branches: tuple[Branch, ...]
    firsts: Mapping[int, int]
    errors: frozenset[tuple[str, str]]


def modules() -> list[str]:
    """The modules of the codec by their names below `reference_impl`, sorted. Rules: CNF-8."""
    found = [info.name for info in walk_packages(reference_impl.__path__, f"{PACKAGE}.") if not info.ispkg]
    return sorted(name.removeprefix(f"{PACKAGE}.") for name in found)


def read_source(module: str, error_classes: Iterable[str]) -> Source:
    """The branches and the raised errors (class, rule) of a module. Rules: CNF-7, CNF-8."""
    loaded = import_module(f"{PACKAGE}.{module}")
    assert loaded.__file__ is not None
    # A compiled module's file is no source; beside it lies the one that it was compiled from.
    path = Path(loaded.__file__)
    while path.suffix:
        path = path.with_suffix("")
    path = path.with_suffix(".py").resolve()
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    finder = _Finder(module, text.splitlines())
    finder.block(tree, (), rules_in(ast.get_docstring(tree) or ""))
    classes = frozenset(error_classes)
    return Source(module, str(path), tuple(finder.found), _first_lines(tree), frozenset(_errors(tree, classes)))


def rules_in(docstring: str) -> tuple[str, ...]:
    """The rules that a docstring names in `Rules: ...`, ranges expanded. Rules: CNF-8."""
    out: dict[str, None] = {}
    for sentence in _RULES.findall(docstring):
        for area, first, last in _ID.findall(sentence):
            out |= dict.fromkeys(f"{area}-{number}" for number in range(int(first), int(last or first) + 1))
    return tuple(out)


class _Finder:
    """Walks the functions of a module and collects their branches."""

    def __init__(self, module: str, lines: list[str]) -> None:
        self.module = module
        self.lines = lines
        self.found: list[Branch] = []
        self._seen: dict[tuple[str, str], int] = {}
        self._function = ""
        self._rules: tuple[str, ...] = ()

    def block(self, node: ast.AST, names: tuple[str, ...], rules: tuple[str, ...]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                self.block(child, (*names, child.name), rules_in(ast.get_docstring(child) or "") or rules)
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                inner = (*names, child.name)
                own = rules_in(ast.get_docstring(child) or "") or rules
                self._function, self._rules = ".".join(inner), own
                self._statements(child.body, frozenset({_LEAVES}))
                self.block(child, inner, own)
            elif not isinstance(child, ast.expr):
                self.block(child, names, rules)

    def _add(self, node: ast.stmt | ast.ExceptHandler, words: str, directions: Mapping[str, Targets]) -> None:
        key = (self._function, words)
        count = self._seen.get(key, 0) + 1
        self._seen[key] = count
        text = words if count == 1 else f"{words} #{count}"
        for direction, to in directions.items():
            self.found.append(Branch(self.module, self._function, text, direction, self._rules, node.lineno, to))

    def _words(self, word: str, node: ast.AST | None) -> str:
        if node is None:
            return word
        segment = ast.get_source_segment("\n".join(self.lines), node) or ""
        text = " ".join(f"{word} {segment}".split())
        return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."

    def _statements(self, statements: list[ast.stmt], after: Targets) -> None:
        for i, node in enumerate(statements):
            then = frozenset({_line(statements[i + 1])}) if i + 1 < len(statements) else after
            self._statement(node, then)

    def _statement(self, node: ast.stmt, then: Targets) -> None:
        if isinstance(node, ast.If):
            no = frozenset({_line(node.orelse[0])}) if node.orelse else then
            self._add(node, self._words("if", node.test), {"yes": frozenset({_line(node.body[0])}), "no": no})
            self._statements(node.body, then)
            self._statements(node.orelse, then)
        elif isinstance(node, ast.While | ast.For | ast.AsyncFor):
            end = frozenset({_line(node.orelse[0])}) if node.orelse else then
            body = frozenset({_line(node.body[0])})
            if isinstance(node, ast.While):
                # `while True` has one direction only.
                if not isinstance(node.test, ast.Constant):
                    self._add(node, self._words("while", node.test), {"body": body, "end": end})
            else:
                words = f"{self._words('for', node.target)} {self._words('in', node.iter)}"
                self._add(node, words, {"body": body, "end": end})
            self._statements(node.body, frozenset({node.lineno}))
            self._statements(node.orelse, then)
        elif isinstance(node, ast.With | ast.AsyncWith):
            # On its way out a block passes the `with` again, or not, as the version of Python has it.
            self._statements(node.body, then | {node.lineno})
        elif isinstance(node, ast.Try):
            finish = frozenset({_line(node.finalbody[0])}) if node.finalbody else then
            self._statements(node.body, frozenset({_line(node.orelse[0])}) if node.orelse else finish)
            self._statements(node.orelse, finish)
            for handler in node.handlers:
                self._add(handler, self._words("except", handler.type), {"caught": frozenset({_line(handler.body[0])})})
                self._statements(handler.body, finish)
            self._statements(node.finalbody, then)


def _line(node: ast.stmt) -> int:
    decorators: list[ast.expr] = getattr(node, "decorator_list", [])
    return min([node.lineno, *(decorator.lineno for decorator in decorators)])


def _first_lines(tree: ast.Module) -> dict[int, int]:
    out: dict[int, int] = {}
    for node in ast.walk(tree):
        if not isinstance(node, ast.stmt | ast.ExceptHandler):
            continue
        body = getattr(node, "body", None)
        end = node.end_lineno or node.lineno
        if isinstance(body, list) and body:
            end = body[0].lineno - 1
        for line in range(node.lineno, end + 1):
            # An inner statement is walked later, and knows better.
            out[line] = node.lineno
    return out


def _errors(tree: ast.Module, classes: frozenset[str]) -> Iterator[tuple[str, str]]:
    """(class, rule) of the errors whose rule stands in the source."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            name = node.func.id if isinstance(node.func, ast.Name) else ""
            rule = node.args[0].value
            if name in classes and isinstance(rule, str) and _ID.fullmatch(rule):
                yield name, rule


class Watch:
    """Watches the branches of modules while vectors are decoded, one after the other. Rules: CNF-8."""

    def __init__(self, sources: Iterable[Source]) -> None:
        # The extra `test` brings it; printing a book does not need it.
        import coverage

        self._sources = tuple(sources)
        self._library = coverage.Coverage(
            data_file=None, config_file=False, branch=True, include=[source.file for source in self._sources],
            messages=False,
        )  # fmt: skip
        # The one core that all versions of Python have; it sees every jump, also at the second vector.
        self._library.set_option("run:core", "ctrace")

    def run(self, tasks: Iterable[tuple[str, Callable[[], object]]]) -> dict[str, set[str]]:
        """Run tasks by name; branch -> names of the tasks that took it."""
        library = self._library
        library.start()
        try:
            for name, task in tasks:
                library.switch_context(name)
                task()
        finally:
            library.stop()
        data = library.get_data()
        hits: dict[str, set[str]] = {}
        names = sorted(name for name in data.measured_contexts() if name)
        leads = {source.file: _by_jump(source) for source in self._sources}
        for name in names:
            data.set_query_context(name)
            for source in self._sources:
                jumps = leads[source.file]
                for begin, to in data.arcs(source.file) or ():
                    first = source.firsts.get(begin, begin)
                    target = _LEAVES if to < 0 else source.firsts.get(to, to)
                    for key in jumps.get((first, target), ()):
                        hits.setdefault(key, set()).add(name)
        return hits


def _by_jump(source: Source) -> dict[tuple[int, int], list[str]]:
    out: dict[tuple[int, int], list[str]] = {}
    for branch in source.branches:
        for to in branch.to:
            out.setdefault((branch.line, to), []).append(branch.key)
    return out
