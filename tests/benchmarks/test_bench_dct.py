"""What the DCT mode costs: prefix look-up, inverse transform, documents. Run with `--benchmark-only`."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np

from snhc.reference_impl.entropy.profile import load_profile
from snhc.reference_impl.face.coefficients import decode_document, parse_document
from snhc.reference_impl.face.dct_encode import quantise_segment, run_levels
from snhc.reference_impl.face.dct_syntax import CoefficientRun
from snhc.reference_impl.face.dct_transform import ac_step, inverse_transforms, reconstruct_values
from snhc.reference_impl.systems.stream import decode_planes, write_stream
from snhc.vectors.builders import stream
from snhc.vectors.dct_builders import coefficients, dct_inter, dct_intra
from snhc.vectors.seeded import Seeded

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


def _segment(seeded: Seeded, is_intra: bool) -> dict[int, CoefficientRun]:
    faps = {}
    for fap in range(3, 69):
        # About 2.7 of 15 AC coefficients, fewer and fewer at high indices.
        ac = {
            k: (-1) ** seeded.between(0, 1) * seeded.between(1, 6)
            for k in range(1, 16)
            if not seeded.between(0, k // 2 + 2)
        }
        faps[fap] = coefficients(seeded.between(-40, 40), ac, is_intra=is_intra)
    return faps


def stream_of_segments(least: int) -> tuple[bytes, int]:
    """A stream with at least so many coefficients that are sent (DC and AC), and their number."""
    seeded = Seeded(1)
    first = dct_intra(_segment(seeded, True), types=dict.fromkeys(range(2, 11), 3))
    planes = [first]
    count = 0
    while count < least:
        planes.append(dct_inter(first, _segment(seeded, False)))
        assert planes[-1].faps is not None and planes[-1].faps.segment is not None
        count += sum(1 + len(run.levels) for run in planes[-1].faps.segment.runs)
    return write_stream(stream(*planes)), count


def test_decode_stream_of_20000_coefficients(benchmark: Callable[..., object]) -> None:
    """All steps of decoding included."""
    data, count = stream_of_segments(20_000)
    benchmark.extra_info["coefficients"] = count  # type: ignore[attr-defined]
    benchmark(lambda: sum(1 for _ in decode_planes(data)))
