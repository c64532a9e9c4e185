"""Documents that are out of form, or reach a limit: tables, models, faces, coefficients, and lines of frames.

Rules: CNF-1, CNF-22, CNF-25. One fault each, named by its path, its line, or both.
"""

from __future__ import annotations

from typing import Any, Final

from snhc.reference_impl.bitstream.errors import (
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)

from ..document_builders import (
    HEADER,
    JsonTable,
    compact,
    deformation,
    fat,
    fat_table,
    fit,
    fit_table,
    frame,
    frames,
    linear,
    moves,
)
from ..manifest import DCT_COEFFICIENTS, FACE, FAT, FIT, DecodeOptions
from ..recipe import Accept, Document, Reject, family, vector

_RANGE: Final = RangeViolation
_LIST: Final = InconsistentSemantics
_FORM: Final = InputFormat
_Case = tuple[Any, type[SnhcError], str, str]
"""What is put in, class, rule, path."""

# -- coefficients ------------------------------------------------------------------------------------------------------

_SEGMENT: Final[JsonTable] = {"intra": True, "coefficients": {"3": [1] * 16}}
_COEFFICIENTS: Final[JsonTable] = {"fap_quant": 1, "segments": [_SEGMENT]}


def _dct(value: object) -> Document:
    return Document(DCT_COEFFICIENTS, compact(value))


@family(
    {
        "intra missing": ({**_COEFFICIENTS, "segments": [{"coefficients": {}}]}, _FORM, "DCT-1", "segments[0]"),
        "segments no array": ({**_COEFFICIENTS, "segments": {}}, _FORM, "DCT-1", "segments"),
        "segment no object": ({**_COEFFICIENTS, "segments": ["x"]}, _FORM, "DCT-1", "segments[0]"),
        "intra no flag": ({**_COEFFICIENTS, "segments": [{**_SEGMENT, "intra": 1}]}, _FORM, "DCT-1",
                          "segments[0].intra"),
        "quant a text": ({**_COEFFICIENTS, "fap_quant": "1"}, _FORM, "DCT-5", "fap_quant"),
        "quant true": ({**_COEFFICIENTS, "fap_quant": True}, _FORM, "DCT-5", "fap_quant"),
        "quant null": ({**_COEFFICIENTS, "fap_quant": None}, _FORM, "DCT-5", "fap_quant"),
    },
    id="dct.coefficients.error.form.{case}", title="Coefficients: {case}", tier="error", tools=("dctcoef",),
    rules=["DCT-1", "CNF-25"],
)  # fmt: skip
def coefficients(case: _Case) -> Reject:
    """A value of the document has another type than the form wants: {case}."""
    value, error, rule, path = case
    return Reject(_dct(value), error, rule, path=path)


@vector(id="dct.coefficients.error.limit", title="Coefficients past the limit of a document", tier="error",
        tools=("dctcoef",), rules=["CNF-22"], options=DecodeOptions(limits={"json_bytes": 80}))  # fmt: skip
def coefficients_limit() -> Reject:
    """The limit is lowered to 80 bytes; the document is longer."""
    return Reject(_dct(_COEFFICIENTS), ResourceLimit, "CNF-22", line=1)


@vector(id="dct.coefficients.limit.reached", title="Coefficients at the limit of a document", tier="stress",
        tools=("dctcoef",), rules=["CNF-22"],
        options=DecodeOptions(limits={"json_bytes": len(compact(_COEFFICIENTS))}))  # fmt: skip
def coefficients_limit_reached() -> Accept:
    """The limit is lowered to the length of the document, which is taken."""
    return Accept(_dct(_COEFFICIENTS), lines=16)


@family(
    {
        "not UTF-8": (b'{"fap_quant":1,\n"name":"\xff","segments":[]}', 2),
        "nested": (b"[" * 100_000 + b"]" * 100_000, 1),
        "digits": (b'{"fap_quant":' + b"1" * 6_000 + b',"segments":[]}', 1),
        "Infinity": (b'{"fap_quant":\nInfinity,"segments":[]}', 2),
    },
    id="dct.coefficients.error.text.{case}", title="Coefficients: {case}", tier="error", tools=("dctcoef",),
    rules=["DCT-1", "CNF-25"],
)  # fmt: skip
def no_document(case: tuple[bytes, int]) -> Reject:
    """The text is no JSON document that can be read: {case}. The fault has its line."""
    data, line = case
    return Reject(Document(DCT_COEFFICIENTS, data), InputFormat, "DCT-1", line=line)


# -- interpolation tables ----------------------------------------------------------------------------------------------


def _table() -> JsonTable:
    return fit_table([[3], [10]], [(0, 1, [linear(2.0)])])


@vector(id="fit.error.limit.links", title="More links than the limit", tier="error", tools=("fit",),
        rules=["CNF-22"], options=DecodeOptions(limits={"fit_links": 1}))  # fmt: skip
def too_many_links() -> Reject:
    """Two links where one is allowed: the fault is the first number of the second link."""
    table = fit_table([[3], [10], [11]], [(0, 1, [linear(2.0)]), (0, 2, [linear(2.0)])])
    return Reject(fit(table, frame({3: 5})), ResourceLimit, "CNF-22", path="Graph[2]")


@vector(id="fit.order.two-parents", title="A set that waits for two others", tier="semantic", tools=("fit",),
        rules=["FIT-6"])  # fmt: skip
def two_parents() -> Accept:
    """F3 gives F10 and F11 by 2 and 3; F10 + F11 gives F16, which is listed first: it waits until both are there."""
    table = fit_table(
        [[3], [10], [11], [10, 11], [16]],
        [(3, 4, [linear(1.0, 1.0)]), (0, 1, [linear(2.0)]), (0, 2, [linear(3.0)])],
    )
    return Accept(fit(table, frame({3: 7})), values={(0, 10): 14, (0, 11): 21, (0, 16): 35})


@vector(id="fit.limit.reached", title="Sets and links at their limits", tier="stress", tools=("fit",),
        rules=["CNF-22"], options=DecodeOptions(limits={"fit_sets": 2, "fit_links": 1}))  # fmt: skip
def fit_limits() -> Accept:
    """Two sets and one link, and that many are allowed."""
    return Accept(fit(_table(), frame({3: 5})), values={(0, 10): 10})


def _line(text: str) -> Document:
    return Document(FIT, compact(_table()), text.encode())


_GOOD: Final = compact({"index": 0, "time": "0/1", **frame({3: 5})}).decode()


@family(
    {
        "no lines": ("", _FORM, "", 1),
        "only blanks": (" \n\n", _FORM, "", 1),
        "no header": (_GOOD, _FORM, "format", 1),
        "kind mesh": (HEADER.replace('"fba"', '"mesh"') + _GOOD, _FORM, "kind", 1),
        "version 2": (HEADER.replace(":1,", ":2,") + _GOOD, _FORM, "version", 1),
        "no object": (HEADER + "[]\n", _FORM, "", 2),
        "no JSON": (HEADER + "{\n", _FORM, "", 2),
        "intra a number": (HEADER + _GOOD.replace("true", "1"), _FORM, "intra", 2),
        "index negative": (HEADER + _GOOD.replace('"index":0', '"index":-1'), _RANGE, "index", 2),
        "fap huge": (HEADER + _GOOD.replace("5", "1" + "0" * 400, 1), _FORM, "faps[2]", 2),
        "fap a fraction": (HEADER + _GOOD.replace("5", "5.5", 1), _FORM, "faps[2]", 2),
        "viseme a list": (HEADER + _GOOD.replace('"viseme":null', '"viseme":[]'), _FORM, "viseme", 2),
        "select missing": (HEADER + _GOOD.replace('"viseme":null', '"viseme":{}'), _FORM, "viseme.select1", 2),
        "state null": (HEADER + _GOOD.replace('"state":"', '"state":null,"was":"'), _FORM, "state", 2),
        "viseme T and null": (HEADER + _GOOD.replace('"state":"U', '"state":"T'), _LIST, "state[0]", 2),
    },
    id="fit.error.frames.form.{case}", title="Frames: {case}", tier="error", tools=("fit",), rules=["CNF-1", "CNF-25"],
)  # fmt: skip
def frame_line(case: tuple[str, type[SnhcError], str, int]) -> Reject:
    """The frames are out of form ({case}): the fault has the line, and the path inside it."""
    text, error, path, line = case
    return Reject(_line(text), error, "CNF-1", path=path, line=line)


@vector(id="fit.frames.blank-lines", title="Blank lines among the frames", tier="syntax", tools=("fit",),
        rules=["CNF-1"])  # fmt: skip
def blank_lines() -> Accept:
    """Blank lines are passed over, also with CR LF; the time may be an integer, intra may be left out."""
    second = _GOOD.replace('"index":0', '"index":1').replace('"time":"0/1"', '"time":1').replace('"intra":true,', "")
    return Accept(_line("\r\n" + HEADER + "\n" + _GOOD + " \r\n" + second), values={(1, 10): 10}, lines=2)


@family(
    {"passed": 0, "reached": 1},
    id="fit.frames.limit.{case}", title="A line of frames, its limit {case}", tier="error", tools=("fit",),
    rules=["CNF-22"], options=DecodeOptions(limits={"text_line_bytes": len(_GOOD) - 1}),
)  # fmt: skip
def line_limit(less: int) -> Reject | Accept:
    """The limit is lowered to the length of the first frame's line; {case}: the second is one byte longer, or not."""
    second = _GOOD if less else _GOOD.replace("}", " }", 1)
    document = _line(HEADER + _GOOD + second)
    if less:
        return Accept(document, lines=2)
    return Reject(document, ResourceLimit, "CNF-22", line=3, lines=1)


# -- animation tables --------------------------------------------------------------------------------------------------

_MOVE: Final = moves(6, deformation([0, 1], [(1.0, 0.0, 0.0)]))


def _model(**changes: object) -> JsonTable:
    return {**fat_table([_MOVE]), **changes}


_NODE: Final[JsonTable] = {"meshes": ["M"]}
_MESH: Final[JsonTable] = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}


@family(
    {
        "meshes a list": (_model(meshes=[]), _FORM, "FAT-1", "meshes"),
        "mesh a list": (_model(meshes={"M": []}), _FORM, "FAT-1", "meshes.M"),
        "vertices an object": (_model(meshes={"M": {"vertices": {}}}), _FORM, "FAT-1", "meshes.M.vertices"),
        "vertex of two": (_model(meshes={"M": {**_MESH, "vertices": [[0, 0, 0], [1, 0]]}}), _LIST, "FAT-1",
                          "meshes.M.vertices[1]"),
        "vertex a text": (_model(meshes={"M": {**_MESH, "vertices": [[0, 0, 0], [1, 0, "0"]]}}), _FORM, "FAT-1",
                          "meshes.M.vertices[1][2]"),
        "vertex too large": (_model(meshes={"M": {**_MESH, "vertices": [[0, 0, 0], [1, 0, 10**400]]}}), _FORM, "FAT-1",
                             "meshes.M.vertices[1][2]"),
        "face of four": (_model(meshes={"M": {**_MESH, "faces": [[0, 1, 2, 0]]}}), _LIST, "FAT-1", "meshes.M.faces[0]"),
        "unit negative": (_model(fapu={"MW": -1.0}), _RANGE, "FAC-1", "fapu.MW"),
        "unit a text": (_model(fapu={"MW": "1"}), _FORM, "FAC-1", "fapu.MW"),
        "units of a face elsewhere": (_model(fapu={"face": "face.json"}), _FORM, "FAC-1", "fapu.face"),
        "mesh a number": (_model(tables=[{"fapID": 6, "meshes": [{"mesh": 1}]}]), _FORM, "FAT-1",
                          "tables[0].meshes[0].mesh"),
        "node a list": (_model(transforms={"node": []}), _FORM, "FAT-9", "transforms.node"),
        "translation of two": (_model(transforms={"node": {**_NODE, "translation": [0, 0]}}), _LIST, "FAT-9",
                               "transforms.node.translation"),
        "a parent that is not there": (_model(transforms={"node": {**_NODE, "parent": "neck"}}), _LIST, "FAT-11",
                                       "transforms.node.parent"),
        "a parent of itself": (_model(transforms={"node": {**_NODE, "parent": "node"}}), _LIST, "FAT-9",
                               "transforms.node.parent"),
        "a mesh of two nodes": (_model(transforms={"node": _NODE, "other": _NODE}), _LIST, "FAT-9",
                                "transforms.other.meshes[0]"),
        "a mesh of no model": (_model(transforms={"node": {"meshes": ["Q"]}}), _LIST, "FAT-11",
                               "transforms.node.meshes[0]"),
    },
    id="fat.error.form.{case}", title="Model: {case}", tier="error", tools=("fat",), rules=["FAT-1", "FAT-9", "FAT-11"],
)  # fmt: skip
def model(case: _Case) -> Reject:
    """A value of the model is out of form, or does not fit to another one: {case}."""
    value, error, rule, path = case
    return Reject(Document(FAT, compact(value), frames([frame({6: 100})])), error, rule, path=path)


@vector(id="fat.limit.reached", title="Vertices at the limit", tier="stress", tools=("fat",), rules=["CNF-22"],
        options=DecodeOptions(limits={"fat_vertices": 3}))  # fmt: skip
def fat_limit() -> Accept:
    """Three vertices, and that many are allowed."""
    return Accept(fat(fat_table([]), frame({6: 1})), lines=1)


_HUGE: Final = 1e308


@family(
    {
        "displacement": (
            fat_table([moves(6, deformation([0, 1], [(_HUGE, 0.0, 0.0)]))]), {6: 1_000}, "FAT-2", "meshes.M",
        ),
    },
    id="fat.error.overflow.{case}", title="Past the range of floats: {case}", tier="error", tools=("fat",),
    rules=["FAT-2"],
)  # fmt: skip
def overflow(case: tuple[JsonTable, dict[int, int], str, str]) -> Reject:
    """Displacements of 1e308 for each step, and 1,000 steps: there is no such vertex."""
    table, faps, rule, path = case
    return Reject(fat(table, frame(faps)), RangeViolation, rule, path=path)


@vector(id="fat.transforms.chain", title="Nodes in nodes", tier="semantic", tools=("fat",), rules=["FAT-9"])
def chain() -> Accept:
    """A node inside a node: the inner scale applies first, then the outer translation moves by 0.5 for each unit.

    FAP 6 is counted in MW, which is 1: 2 steps scale x by 1 + 2 = 3, FAP 7 moves by 2 * 0.5.
    """
    tables = [
        moves(6, transforms=[("inner", "scale", (1.0, 0.0, 0.0))]),
        moves(7, transforms=[("outer", "translation", (0.5, 0.0, 0.0))]),
    ]
    nodes: dict[str, JsonTable] = {"outer": {"meshes": []}, "inner": {"meshes": ["M"], "parent": "outer"}}
    points = [(1.0, 0.0, 0.0), (4.0, 2.0, 3.0), (-11.0, 0.5, 8.0)]
    return Accept(fat(fat_table(tables, transforms=nodes), frame({6: 2, 7: 2})), points={(0, "M"): points})


# -- faces -------------------------------------------------------------------------------------------------------------

_POINTS: Final[JsonTable] = {
    "3.5": [32, 48, 10], "3.6": [-32, 48, 10], "9.15": [0, -16, 20], "2.2": [0, -48, 14], "8.3": [25, -48, 8],
    "8.4": [-25, -48, 8], "3.1": [32, 54, 10], "3.3": [32, 42, 10],
}  # fmt: skip


def _face(**changes: object) -> JsonTable:
    return {"format": "snhc-face", "version": 1, "points": _POINTS, **changes}


@family(
    {
        "format": (_face(format="other"), "FAC-2", _FORM, "format"),
        "version 2": (_face(version=2), "FAC-2", _FORM, "version"),
        "points missing": ({"format": "snhc-face"}, "FAC-2", _FORM, "points"),
        "point of two": (_face(points={**_POINTS, "2.2": [0, 1]}), "FAC-2", _LIST, "points.2.2"),
        "point without a place": (_face(points={**_POINTS, "2.2": {"vertex": 1}}), "FAC-2", _FORM,
                                  "points.2.2.position"),
        "vertex negative": (
            _face(points={**_POINTS, "2.2": {"position": [0, -48, 14], "vertex": -1}}), "FAC-2", _RANGE,
            "points.2.2.vertex",
        ),
        "eye of another side": (_face(eye_centers={"middle": [0, 0, 0]}), "FAC-3", _FORM, "eye_centers.middle"),
        "iris 0": (_face(iris_diameters={"left": 0}), "FAC-3", _RANGE, "iris_diameters.left"),
        "pupil negative": (_face(pupil_diameters={"right": -1.5}), "FAC-3", _RANGE, "pupil_diameters.right"),
        "name a number": (_face(name=5), "FAC-2", _FORM, "name"),
    },
    id="fapu.error.form.{case}", title="Face: {case}", tier="error", tools=("fapu",), rules=["FAC-1", "CNF-25"],
)  # fmt: skip
def face(case: tuple[Any, str, type[SnhcError], str]) -> Reject:
    """A value of the face definition is out of form: {case}."""
    value, rule, error, path = case
    return Reject(Document(FACE, compact(value)), error, rule, path=path)


@vector(id="fapu.with-everything", title="A face with eyes, vertices and no right iris", tier="semantic",
        tools=("fapu",), rules=["FAC-1", "FAC-3"])  # fmt: skip
def everything() -> Accept:
    """Centres of the eyeballs straight behind the pupils, diameters that fit, a point with its vertex.

    None of it changes the units; nothing speaks against the face's being neutral.
    """
    points = {
        **_POINTS, "2.2": {"position": [0, -48, 14], "mesh": "Face", "vertex": 17}, "9.15": {"position": [0, -16, 20]},
    }  # fmt: skip
    document = _face(
        points=points, eye_centers={"left": [32, 48, 0], "right": [-32, 48, 0]}, iris_diameters={"left": 12},
        pupil_diameters={"left": 4},
    )  # fmt: skip
    units = {"ES": 64 / 1024, "ENS": 64 / 1024, "MNS": 32 / 1024, "MW": 50 / 1024, "IRISD": 12 / 1024}
    return Accept(Document(FACE, compact(document)), units=units, findings=())


@family(
    {
        "gaze": _face(eye_centers={"left": [40, 48, 0]}),
        "iris": _face(iris_diameters={"left": 20}),
        "pupil": _face(pupil_diameters={"left": 8}),
        "lids": _face(points={**_POINTS, "3.5": [32, 44, 10]}),
        "lips": _face(points={**_POINTS, "2.3": [0, -54, 14]}),
    },
    id="fapu.not-neutral.{case}", title="A face that is not neutral: {case}", tier="semantic", tools=("fapu",),
    rules=["FAC-3"],
)  # fmt: skip
def not_neutral(document: JsonTable) -> Accept:
    """The eyes look aside, or iris, pupil, lids or lips are not those of a neutral face ({case}); the units stand."""
    return Accept(Document(FACE, compact(document)), lines=1)
