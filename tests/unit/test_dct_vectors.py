"""DCT vectors: coefficient documents, bitstreams that use every word, and the tolerances that go with them."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from strategies_dct import check_plainly

from snhc.reference_impl.face.coefficients import parse_document
from snhc.reference_impl.face.dct_comparison import first_mismatch
from snhc.reference_impl.face.dct_transform import ac_step, inverse_transform
from snhc.reference_impl.face.records import FbaPlane
from snhc.reference_impl.systems.stream import decode_planes, write_stream
from snhc.vectors.builders import intra, stream
from snhc.vectors.dct_builders import coefficients, dct_inter, dct_intra, listed
from snhc.vectors.dct_tolerance import of_document, of_planes
from snhc.vectors.making import RecipeFault, make
from snhc.vectors.manifest import SUITE, load
from snhc.vectors.recipe import RECIPES, Accept, Document, all_recipes
from snhc.vectors.recipes import dct_coefficients


def face_planes(data: bytes) -> list[FbaPlane]:
    return [plane for plane in decode_planes(data) if isinstance(plane, FbaPlane)]


def test_coefficient_vectors_have_a_bound_and_faults_a_path() -> None:
    entries = [entry for entry in load().entries if entry.media == "dctcoef"]
    assert len(entries) >= 30
    for entry in entries:
        if entry.kind == "invalid":
            assert entry.tolerance is None
        else:
            assert entry.tolerance is not None and entry.tolerance.model == "dct-8" and entry.tolerance.bound >= 0.5


def test_bitstreams_with_coefficients_have_a_bound() -> None:
    entries = [entry for entry in load().entries if "dct-p1" in entry.tools and entry.kind != "invalid"]
    for entry in entries:
        data = [plane.faps for plane in face_planes((SUITE / entry.file).read_bytes()) if plane.faps is not None]
        coded = any(faps.segment is not None and faps.segment.runs for faps in data)
        assert (entry.tolerance is not None) == coded, entry.id


def test_a_recipe_that_the_decoder_contradicts_fails() -> None:
    recipe = all_recipes()["dct.coefficients.halves"]
    source = dct_coefficients.document(0, (True, {3: [4]}))
    with pytest.raises(RecipeFault, match="declared 2"):
        make(replace(recipe, build=lambda: Accept(source, values={(0, 3): 2})))


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
            assert not isinstance(build.stream, Document)
            check_plainly(build.stream if isinstance(build.stream, bytes) else write_stream(build.stream))


def test_every_symbol_is_in_some_vector() -> None:
    build = RECIPES["fap.dct.words.every"].build()
    assert isinstance(build, Accept) and isinstance(build.stream, list)
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
