"""What an input is, by its first bytes: one answer for every verb.

Rules: CNF-2.
"""

from __future__ import annotations

import re
from typing import Final

HEAD_BYTES: Final = 4096

# Every repetition is possessive: an input may be made so that one which gives back is tried in as many ways as there
# are numbers of that many bits.
_NUMBER: Final = r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?"
_FDP_LINE: Final = re.compile(
    rf"[1-9]\d?\.[1-9]\d?[\s,]++{_NUMBER}[\s,]++{_NUMBER}[\s,]++{_NUMBER}(?:[\s,]++-?\d++\.-?\d++)?\s*+"
)
_FAP_LINE: Final = re.compile(r"\d++\.\d++\s++\S++\s++\d\S*+\s++\d++\s*+")
# `FIT {` or `DEF name FIT {`, behind comments; what stands between tokens may be a comma.
_NODE: Final = re.compile(r"(?:[\s,]++|#[^\n]*+\n)*+(?:DEF[\s,]++[^\s,{}\[\]\"#]++[\s,]++)?([A-Za-z_]\w*+)[\s,]*+\{")
_NODES: Final = {"FIT": "fit", "InitialObjectDescriptor": "scene"}
_PICTURES: Final = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF8", b"BM", b"II*\0", b"MM\0*", b"P5", b"P6")
_OURS: Final = re.compile(rb'"format"\s*:\s*"snhc-([a-z-]{1,20})"')

# What a JSON document may call itself.
_NAMES: Final = ("dump", "mesh", "decoded", "report", "journal")

# What it is, and the verbs that read it.
_OTHERS: Final = {
    "stream": ("a visual stream", "decode, dump and check"),
    "fap": ("FAP text", "encode, check and diff"),
    "pictures": ("a picture", "encode"),
    "zip": ("a zip archive, as .npz is", ""),
    "fdp": ("a face definition", "check"),
    "fit": ("a FAP interpolation table", "check and fit"),
    "model": ("a model with face animation tables", "check, fat and render --model"),
    "scene": ("a scene as text", ""),
    "json": ("JSON", "check, encode, fit, fat and dct"),
    "dump": ("a dump", "encode"),
    "mesh": ("a mesh document", "encode"),
    "decoded": ("the output of snhc decode", "diff"),
    "report": ("the report of a run", "report"),
    "journal": ("the journal of a run", "run --resume"),
}  # fmt: skip


def kind_of_input(head: bytes) -> str:
    """What an input is, by its first bytes: a key of the table above, `mp4`, or empty for what is none of these.

    Rules: CNF-2. `json`: any document that does not name its format.
    """
    if head[:3] == b"\0\0\1":
        return "stream"
    if head[4:8] == b"ftyp":
        return "mp4"
    if head.startswith(b"PK\x03\x04"):
        return "zip"
    if head.startswith(_PICTURES) or (head[:4] == b"RIFF" and head[8:12] == b"WEBP"):
        return "pictures"
    text = head.removeprefix(b"\xef\xbb\xbf")
    if text.lstrip()[:1] == b"{":
        named = _OURS.search(text)
        name = named[1].decode() if named is not None else ""
        return name if name in _NAMES else "json"
    if b"\0" in text:
        return ""
    return _kind_of_lines(text.decode("latin-1"))


def _kind_of_lines(text: str) -> str:
    node = _NODE.match(text)
    if node is not None:
        return _NODES.get(node[1], "model")
    lines = filter(None, (line.partition("#")[0].strip() for line in text.splitlines()))
    first = next(lines, "")
    if _FDP_LINE.fullmatch(first):
        # The name of a FAP text may be a number; behind its first line stands a mask, behind a point another point.
        is_fap = _FAP_LINE.fullmatch(first) and not _FDP_LINE.fullmatch(next(lines, first))
        return "fap" if is_fap else "fdp"
    return "fap" if _FAP_LINE.fullmatch(first) else ""


def hint(head: bytes, wanted: str = "") -> str:
    """`this is FAP text: snhc encode, check and diff read it`; "" where nothing is known, or it is what is `wanted`.

    Rules: CNF-2, CNF-25.
    """
    if not head:
        return "this is empty"
    kind = kind_of_input(head)
    what, verbs = _OTHERS.get(kind, ("", ""))
    if not what or kind == wanted:
        return ""
    reads = "read" if " and " in verbs else "reads"
    return f"this is {what}" + (f": snhc {verbs} {reads} it" if verbs else ": no verb reads it")
