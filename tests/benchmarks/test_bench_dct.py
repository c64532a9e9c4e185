"""What the DCT mode costs: prefix look-up, inverse transform, documents. Run with `--benchmark-only`."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np

from snhc.reference_impl.face.coefficients import decode_document, parse_document
from snhc.reference_impl.face.dct_encode import quantise_segment, run_levels
from snhc.reference_impl.face.dct_transform import ac_step, inverse_transforms, reconstruct_values
from snhc.reference_impl.entropy.profile import load_profile

SPARSE = [70, -12, 5, 0, 2, 0, 0, -1] + [0] * 8
DENSE = [70, -12, 5, 3, 2, 7, -1, -1, 4, 3, -2, 1, 1, -1, 2, 1]
SEGMENTS = 1000


def test_lookup_1000_ac_words(benchmark: Callable[..., object]) -> None:
    table = load_profile().ac
    # Words as often as their lengths say: mostly short ones, some behind the direct part.
    windows = [i * 7919 % (1 << table.max_length) for i in range(1000)]
    lookup = table.lookup
    benchmark(lambda: [lookup(window) for window in windows])


def test_inverse_sparse_segment(benchmark: Callable[..., object]) -> None:
    step = ac_step(3, 8)
    benchmark(lambda: reconstruct_values(SPARSE, step))


def test_inverse_dense_segment(benchmark: Callable[..., object]) -> None:
    step = ac_step(3, 8)
    benchmark(lambda: reconstruct_values(DENSE, step))


def test_inverse_1000_dense_segments_in_arrays(benchmark: Callable[..., object]) -> None:
    array = np.array([DENSE] * SEGMENTS, dtype=np.int64)
    steps = [ac_step(3, 8)] * SEGMENTS
    benchmark(lambda: inverse_transforms(array, steps))


def test_quantise_segment(benchmark: Callable[..., object]) -> None:
    step = ac_step(3, 1)
    values = reconstruct_values(DENSE, step)
    benchmark(lambda: run_levels(quantise_segment(values, step)))


def test_document_of_10_segments_with_20_faps(benchmark: Callable[..., object]) -> None:
    coefficients = {str(fap): SPARSE for fap in range(3, 23)}
    segments = [{"intra": i == 0, "coefficients": coefficients} for i in range(10)]
    data = json.dumps({"fap_quant": 8, "segments": segments})
    benchmark(lambda: sum(1 for _ in decode_document(parse_document(data))))
