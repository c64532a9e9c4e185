"""DCT vectors: coefficient documents, bitstreams that use every word, and the tolerances that go with them."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator
from strategies_dct import check_plainly

from snhc.reference_impl.face.coefficients import parse_document
from snhc.reference_impl.face.dct_comparison import first_mismatch
from snhc.reference_impl.face.dct_transform import ac_step, inverse_transform
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.rules import rules
from snhc.reference_impl.systems.stream import decode_planes, write_stream
from snhc.vectors.builders import intra, stream
from snhc.vectors.dct_builders import coefficients, dct_inter, dct_intra, listed
from snhc.vectors.dct_tolerance import of_document, of_planes
from snhc.vectors.manifest import SCHEMA_FILE
from snhc.vectors.recipe import RECIPES, Accept, all_recipes
from snhc.vectors.recipes import dct_coefficients


def face_planes(data: bytes) -> list[FbaPlane]:
    return [plane for plane in decode_planes(data) if isinstance(plane, FbaPlane)]


@pytest.mark.parametrize("name", dct_coefficients.RECIPES)
def test_coefficient_vector(name: str) -> None:
    recipe = dct_coefficients.RECIPES[name]
    assert recipe.description
    assert set(recipe.rules) <= set(rules())
    made = dct_coefficients.make(recipe)
    assert made == dct_coefficients.make(recipe)
    if name != "dct.coefficients.error.not-json":
        json.loads(made.data)
    assert (made.tolerance is None) == (made.fault is not None)
    if made.tolerance is not None:
        schema = json.loads(SCHEMA_FILE.read_text())["$defs"]["vector"]["properties"]["tolerance"]
        Draft202012Validator({"$defs": json.loads(SCHEMA_FILE.read_text())["$defs"], **schema}).validate(
            made.tolerance.as_json()
        )
        assert made.tolerance.bound >= 0.5


def test_a_recipe_that_the_decoder_contradicts_fails() -> None:
    recipe = dct_coefficients.RECIPES["dct.coefficients.halves"]
    wrong = dct_coefficients.CoefficientRecipe(
        "x.y",
        "t",
        "d",
        "syntax",
        recipe.rules,
        "",
        lambda: dct_coefficients.document(0, (True, {3: [4]}), values={(0, 3): 2}),
    )
    with pytest.raises(AssertionError, match="declared 2"):
        dct_coefficients.make(wrong)


def test_there_are_enough() -> None:
    all_recipes()
    bitstreams = [recipe for id, recipe in RECIPES.items() if id.startswith("fap.dct.")]
    assert len(bitstreams) >= 24
    for recipe in bitstreams:
        assert "dct-p1" in recipe.tools
        assert "provisional" in recipe.notes


def test_a_plain_decoder_agrees_on_all_bitstreams() -> None:
    all_recipes()
    for id, recipe in RECIPES.items():
        build = recipe.build() if id.startswith("fap.dct.") else None
        if isinstance(build, Accept):
            check_plainly(build.stream if isinstance(build.stream, bytes) else write_stream(build.stream))


def test_every_symbol_is_in_some_vector() -> None:
    build = RECIPES["fap.dct.words.every"].build()
    assert isinstance(build, Accept) and not isinstance(build.stream, bytes)
    planes = face_planes(write_stream(build.stream))
    levels = {level for plane in planes for run in plane.faps.segment.runs for level in run.levels}  # type: ignore[union-attr]
    assert levels >= {*range(-256, 0), *range(1, 257)}


def test_tolerance_follows_the_coefficients() -> None:
    first = dct_intra({3: listed([4]), 4: listed([1, 5])})
    second = dct_inter(first, {3: coefficients(10**6, is_intra=False)})
    small = of_planes(face_planes(write_stream(stream(first))))
    large = of_planes(face_planes(write_stream(stream(first, second))))
    assert small is not None and large is not None
    assert (small.model, small.version) == ("dct-8", 1)
    assert 0.5 < small.bound < 0.51 < large.bound
    # As computed from a document of the same numbers.
    document = parse_document(json.dumps({"fap_quant": 8, "segments": [
        {"intra": True, "coefficients": {"3": [4, *[0] * 15], "4": [1, 5, *[0] * 14]}},
        {"intra": False, "coefficients": {"3": [10**6, *[0] * 15], "4": [0] * 16}},
    ]}))  # fmt: skip
    assert of_document(document) == large
    assert of_planes(face_planes(write_stream(stream(intra({3: 1}))))) is None


def test_the_bound_tells_truncation_from_rounding() -> None:
    numbers = [4, -3, 5, 0, 2, *[0] * 11]
    plane = dct_intra({3: listed(numbers)})
    tolerance = of_planes(face_planes(write_stream(stream(plane))))
    assert tolerance is not None
    unrounded = inverse_transform(numbers, ac_step(3, 8))
    decoded = [frame.faps[2] for frame in plane.frames]
    assert None not in decoded
    values = [value for value in decoded if value is not None]
    assert first_mismatch(values, values, tolerance.bound, unrounded) is None
    assert first_mismatch(values, [int(value) for value in unrounded], tolerance.bound, unrounded) is not None
