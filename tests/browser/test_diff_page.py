"""The page of `snhc diff`."""

from __future__ import annotations

from pathlib import Path

from conftest import Page
from selenium.webdriver.common.by import By

from snhc.analyzer.diff.compare import compare
from snhc.analyzer.diff.html import html_text
from snhc.reference_impl.bitstream.source import BytesSource
from snhc.reference_impl.systems.stream import write_stream
from snhc.vectors.builders import inter, intra, stream


def test_the_page(page: Page, tmp_path: Path) -> None:
    data = []
    for quant in (1, 8):
        first = intra({3: 5, 48: 7, 61: 8}, quant=quant, rate=(25, 0, 0))
        planes = [first, *(inter(first, {3: n % 7, 48: -(n % 5), 61: 1}) for n in range(1, 60))]
        data.append(BytesSource(write_stream(stream(*planes))))
    file = tmp_path / "diff.html"
    file.write_text(html_text(compare(*data, curves=True)), encoding="utf-8")
    browser = page.open(file)
    assert "First divergence" in browser.find_element(By.TAG_NAME, "body").text
    assert "fap.fap_quant: A 1 at bits [51, 56), B 8" in browser.find_element(By.CLASS_NAME, "first").text
    curves = browser.find_elements(By.CSS_SELECTOR, "figure svg")
    assert [curve.get_attribute("aria-label") for curve in curves] == [
        f"FAP {name}: A and B over time" for name in ("48 head_pitch", "3 open_jaw", "61 stretch_l_nose")
    ]
    assert all(path.size["width"] > 100 for path in browser.find_elements(By.CSS_SELECTOR, "figure svg path"))
    assert page.shot("diff").stat().st_size > 10_000
