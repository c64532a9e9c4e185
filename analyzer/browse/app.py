"""The terminal browser (Textual): tree on the left, bytes and details on the right.

Rules: CNF-17, CNF-21.
"""

from __future__ import annotations

from typing import ClassVar, Final

from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual import work
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.reactive import reactive
from textual.widgets import Footer, Header, Input, Static, Tree
from textual.widgets.tree import TreeNode

from snhc.analyzer.tree import Node, build_tree

from .document import SYMBOL, SYMBOLS, Document, Place

BATCH: Final = 100
_MARKED: Final = Style(reverse=True, bold=True)
_PART: Final = Style(bold=True)
_DIM: Final = Style(dim=True)

# Bytes on a line: as many as the panel holds.
_PER_LINE: Final = (16, 8, 4)

Data = Place | Node
"""What a node of the tree stands for: a place, or a level of the path inside a part."""


class Hex(Static):
    """The bytes around the place that is looked at, its bits marked. Rules: CNF-21."""

    def __init__(self, document: Document) -> None:
        super().__init__(id="hex")
        self._document = document
        self._span = (0, 0)

    def show(self, span: tuple[int, int]) -> None:
        """Look at bits [start, end)."""
        self._span = span
        self.update(self._drawn())

    def on_resize(self) -> None:
        self.show(self._span)

    def _drawn(self) -> Text:
        start, end = self._span
        bits = self._bits(start, end)
        per_line = next((count for count in _PER_LINE if _width(count) <= self.size.width), _PER_LINE[-1])
        # An empty line and the single bits are below.
        height = max(4, self.size.height - 1 - (max(1, len(bits))))
        first = max(0, (start >> 3) // per_line - height // 3) * per_line
        out = Text(no_wrap=True)
        for offset, data in self._document.hex_lines(first, height, per_line):
            out.append(f"{offset:08x}  ", _DIM)
            for place, byte in enumerate(data):
                at = 8 * (offset + place)
                inside = max(start, at) < min(end, at + 8)
                out.append(f"{byte:02x}", _MARKED if inside else "")
                out.append(" " if place % 8 != 7 else "  ")
            out.append(" " * (_columns(per_line) - 3 * len(data) - len(data) // 8))
            for place, byte in enumerate(data):
                at = 8 * (offset + place)
                inside = max(start, at) < min(end, at + 8)
                out.append(chr(byte) if 32 <= byte < 127 else "·", _MARKED if inside else _DIM)
            out.append("\n")
        for line in bits:
            out.append("\n")
            out.append_text(line)
        return out

    def _bits(self, start: int, end: int) -> list[Text]:
        """The bytes of a short span as bits, those outside it dim; as many lines as it takes."""
        if not 0 < end - start <= 64:
            return []
        first, last = start >> 3, (end + 7) >> 3
        data = self._document.source.read_at(first, last - first)
        title = f"bit {start}: "
        per_line = max(1, (self.size.width - len(title)) // 9)
        lines = []
        for at in range(0, len(data), per_line):
            out = Text(title if at == 0 else " " * len(title), _DIM, no_wrap=True)
            for place, byte in enumerate(data[at : at + per_line], first + at):
                for bit in range(8):
                    inside = start <= 8 * place + bit < end
                    out.append(str(byte >> (7 - bit) & 1), _MARKED if inside else _DIM)
                out.append(" ")
            lines.append(out)
        return lines


def _columns(count: int) -> int:
    """Of the hexadecimal digits of so many bytes, in groups of eight."""
    return 3 * count + max(1, count // 8)


def _width(count: int) -> int:
    """Of a line of so many bytes: offset, digits, characters."""
    return 10 + _columns(count) + count


class Browser(App[None]):
    """`snhc browse`. Rules: CNF-17."""

    TITLE = "snhc browse"
    CSS = """
    #tree { width: 42%; border-right: solid $panel; }
    #hex { height: 40%; min-height: 8; padding: 0 1; border-bottom: solid $panel; }
    #details { padding: 0 1; }
    #ask { dock: bottom; display: none; }
    #ask.shown { display: block; }
    #status { height: 1; padding: 0 1; color: $text-muted; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q", "quit", "Quit"),
        Binding("slash", "ask('search')", "Search"),
        Binding("n", "again(False)", "Next"),
        Binding("N", "again(True)", "Previous"),
        Binding("b", "ask('bit')", "Bit"),
        Binding("p", "ask('plane')", "Plane"),
        Binding("e", "trouble", "Finding"),
        Binding("right", "open", "Open", show=False),
        Binding("left", "close", "Close", show=False),
        Binding("escape", "cancel", "Cancel", show=False),
        Binding("d", "theme", "Light/dark"),
    ]
    _PROMPTS: ClassVar[dict[str, str]] = {
        "search": "words of name, path, rule; name=value (Enter)",
        "bit": "bit number, or byte:bit (Enter)",
        "plane": "plane number (Enter)",
    }
    status: reactive[str] = reactive("")

    def __init__(self, document: Document, name: str) -> None:
        super().__init__()
        self.document = document
        self.sub_title = name
        self._asked = ""
        self._words = ""
        self._place: Place | None = None
        self._part_nodes: list[TreeNode[Data]] = []

    def compose(self) -> ComposeResult:
        yield Header()
        tree: Tree[Data] = Tree("stream", id="tree")
        tree.show_root = False
        tree.guide_depth = 2
        with Horizontal():
            yield tree
            with Vertical():
                yield Hex(self.document)
                with VerticalScroll(can_focus=False):
                    yield Static(id="details")
        yield Static(id="status")
        yield Input(id="ask")
        yield Footer()

    def on_mount(self) -> None:
        self._tree.focus()
        self.load()

    @property
    def _tree(self) -> Tree[Data]:
        return self.query_one("#tree", Tree)

    def watch_status(self, text: str) -> None:
        """Show the line of state."""
        if self.is_running:
            self.query_one("#status", Static).update(Text(text))

    # -- reading -------------------------------------------------------------------------------------------------------

    @work(thread=True, exclusive=True)
    def load(self) -> None:
        """Read the stream in the background, batch by batch."""
        while True:
            first = len(self.document.parts)
            new = self.document.read(BATCH)
            if new:
                self.call_from_thread(self._add, first, len(new))
            if len(new) < BATCH:
                break
        self.call_from_thread(self._loaded)

    def _add(self, first: int, count: int) -> None:
        tree = self._tree
        for index in range(first, first + count):
            part = self.document.parts[index]
            title = Text(self.document.title(index), _PART if part.plane is None else "")
            if part.error is not None:
                title.stylize("bold red")
            elif part.findings:
                title.append(f"  ! {len(part.findings)}", "yellow")
            self._part_nodes.append(tree.root.add(title, Place(index), allow_expand=len(part.trace) > 0))
        if first == 0 and self._place is None:
            self._look(Place(0))
            tree.cursor_line = 0
        self.status = f"reading ... {len(self.document.parts)} parts"

    def _loaded(self) -> None:
        document = self.document
        text = f"{len(document.parts)} parts"
        if not document.whole:
            text += "; there is more: --planes A:B shows other planes"
        if document.error is not None:
            text += f"; ends with an error: {document.error}"
        self.status = text

    # -- the tree ------------------------------------------------------------------------------------------------------

    def on_tree_node_expanded(self, event: Tree.NodeExpanded[Data]) -> None:
        """Fill a part when it is opened for the first time."""
        self._fill(event.node)

    def _fill(self, node: TreeNode[Data]) -> None:
        data = node.data
        if node.children or not isinstance(data, Place) or data.row >= 0:
            return
        part = self.document.parts[data.part]
        inside = build_tree(part.trace)
        children = inside.children
        if part.plane is not None and len(children) == 1 and isinstance(children[0], Node):
            # The part is the plane already.
            children = children[0].children
        self._children(node, data.part, children)

    def _children(self, node: TreeNode[Data], part: int, children: list[Node | int]) -> None:
        for child in children:
            if isinstance(child, int):
                node.add_leaf(Text(self.document.row_title(part, child)), Place(part, child))
            else:
                below = node.add(Text(child.name, _PART), child, expand=True)
                self._children(below, part, child.children)

    def on_tree_node_highlighted(self, event: Tree.NodeHighlighted[Data]) -> None:
        """Show what the cursor is on."""
        data = event.node.data
        if isinstance(data, Place):
            self._look(data)
        elif isinstance(data, Node):
            self._show((data.start, data.end), [("level", data.name), ("bits", f"[{data.start}, {data.end})")])

    def _look(self, place: Place) -> None:
        self._place = place
        self._show(self.document.span(place), list(self.document.details(place)))

    def _show(self, span: tuple[int, int], details: list[tuple[str, str]]) -> None:
        self.query_one(Hex).show(span)
        table = Table.grid(padding=(0, 2))
        table.add_column(style="bold", no_wrap=True)
        table.add_column()
        for label, text in details:
            columns = label in (SYMBOLS, SYMBOL)
            table.add_row(label.strip(), Text(text, no_wrap=columns, overflow="ellipsis" if columns else "fold"))
        self.query_one("#details", Static).update(table)

    def go(self, place: Place) -> None:
        """Open a place in the tree and put the cursor on it. Rules: CNF-21."""
        node = self._part_nodes[place.part]
        if place.row >= 0:
            self._fill(node)
            node.expand()
            node = _leaf(node, place) or node
        self._place = place

        def settle() -> None:
            # Only now do the lines of what was opened exist.
            self._tree.move_cursor(node, animate=False)
            self._tree.scroll_to_node(node, animate=False)
            self._look(place)

        self.call_after_refresh(settle)

    # -- keys ----------------------------------------------------------------------------------------------------------

    def action_ask(self, what: str) -> None:
        """Ask for words, a bit or a plane."""
        self._asked = what
        ask = self.query_one("#ask", Input)
        ask.placeholder = self._PROMPTS[what]
        ask.value = self._words if what == "search" else ""
        ask.add_class("shown")
        ask.focus()

    def action_cancel(self) -> None:
        """Close the question."""
        self.query_one("#ask", Input).remove_class("shown")
        self._tree.focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Go where the answer leads."""
        self.action_cancel()
        text = event.value.strip()
        if self._asked == "search":
            self._words = text
            self.action_again(False)
            return
        place: Place | None = None
        if self._asked == "bit":
            byte, colon, bit = text.partition(":")
            if byte.isascii() and byte.isdigit() and (not colon or bit in tuple("01234567")):
                place = self.document.at_bit(8 * int(byte) + int(bit) if colon else int(byte))
        elif text.isascii() and text.isdigit():
            place = self.document.plane(int(text))
        if place is None:
            self.status = f"no {self._asked} {text!r} in what has been read"
        else:
            self.go(place)

    def action_again(self, backwards: bool) -> None:
        """The next place that the search fits."""
        place = self.document.search(self._words, self._place, backwards) if self._words else None
        if place is None:
            self.status = f"not found: {self._words}" if self._words else "search first: /"
        else:
            self.go(place)

    def action_trouble(self) -> None:
        """The next finding or fault."""
        place = self.document.trouble(self._place)
        if place is None:
            self.status = "no findings"
        else:
            self.go(place)

    def action_open(self) -> None:
        """Open the node under the cursor."""
        node = self._tree.cursor_node
        if node is not None and node.allow_expand:
            node.expand()

    def action_close(self) -> None:
        """Close the node under the cursor, or go to its parent."""
        node = self._tree.cursor_node
        if node is None:
            return
        if node.is_expanded and node.allow_expand:
            node.collapse()
        elif node.parent is not None and node.parent is not self._tree.root:
            self._tree.move_cursor(node.parent)

    def action_theme(self) -> None:
        """Change between light and dark."""
        self.theme = "textual-light" if self.theme != "textual-light" else "textual-dark"


def _leaf(node: TreeNode[Data], place: Place) -> TreeNode[Data] | None:
    for child in node.children:
        if child.data == place:
            return child
        if isinstance(child.data, Node):
            child.expand()
            found = _leaf(child, place)
            if found is not None:
                return found
    return None
