"""The page of the coverage book: filters, links, vectors of a cell, and that it stands alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import Page
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webdriver import WebDriver
from selenium.webdriver.support.ui import Select

from snhc.vectors.coverage.book import load_book
from snhc.vectors.coverage.page import page as coverage_page


@pytest.fixture
def opened(page: Page, tmp_path: Path) -> WebDriver:
    file = tmp_path / "book.html"
    file.write_text(coverage_page(load_book()), encoding="utf-8")
    return page.open(file)


def rows(browser: WebDriver) -> list[str]:
    """The names of the cells that are shown."""
    return [cell.text for cell in browser.find_elements(By.CSS_SELECTOR, "#cells tbody td:nth-child(2)")]


def count(browser: WebDriver) -> str:
    """What the page says of the number of cells."""
    return browser.find_element(By.ID, "count").text


def test_the_page_counts_as_the_book_does(opened: WebDriver) -> None:
    share = load_book().share()
    assert count(opened).startswith(
        f"{share.total} cells, {share.covered} covered, {share.total - share.covered} holes"
    )
    assert len(rows(opened)) == 200
    assert "http" not in opened.page_source.replace("http-equiv", "")


def test_filters_hold_together(opened: WebDriver) -> None:
    book = load_book()
    opened.find_element(By.ID, "rule").send_keys("fba-26")
    assert len(rows(opened)) == min(200, len(book.select(["FBA-26"]).rows))
    opened.find_element(By.ID, "holes").click()
    assert count(opened).startswith(f"{len(book.select(['FBA-26'], holes=True).rows)} cells, 0 covered")
    opened.find_element(By.CSS_SELECTOR, "button[type=reset]").click()
    Select(opened.find_element(By.ID, "kind")).select_by_value("word")
    assert count(opened).startswith(f"{book.by_kind()['word'].total} cells")
    opened.find_element(By.ID, "text").send_keys("mvd/no word")
    assert rows(opened) == ["word/mvd/no word"]


def test_a_vector_finds_its_cells(opened: WebDriver) -> None:
    book = load_book()
    vector = "text.fap.plain"
    opened.find_element(By.ID, "text").send_keys(vector)
    assert count(opened).startswith(f"{sum(vector in row.vectors for row in book.rows.values())} cells")


def test_a_cell_shows_its_vectors(opened: WebDriver) -> None:
    opened.find_element(By.ID, "text").send_keys("element/FBA-5/is_intra/0")
    details = opened.find_element(By.CSS_SELECTOR, "#cells details")
    wanted = load_book().rows["element/FBA-5/is_intra/0"].vectors
    assert details.text == f"{len(wanted)} vectors"
    details.find_element(By.TAG_NAME, "summary").click()
    assert [item.text for item in details.find_elements(By.TAG_NAME, "li")] == list(wanted)


def test_a_share_leads_to_its_cells(opened: WebDriver) -> None:
    opened.find_element(By.CSS_SELECTOR, "a[data-rule=MSH]").click()
    wanted = load_book().select(["MSH"])
    opened.execute_async_script("setTimeout(arguments[0], 50)")
    assert count(opened).startswith(f"{len(wanted.rows)} cells")


def test_the_page_can_be_used_without_a_mouse(opened: WebDriver) -> None:
    # Every field has its label, and what is a table says what its columns are.
    for field in opened.find_elements(By.CSS_SELECTOR, "input, select"):
        assert field.accessible_name
    assert len(opened.find_elements(By.CSS_SELECTOR, "#cells th[scope=col]")) == 4
    assert opened.find_element(By.TAG_NAME, "html").get_attribute("lang") == "en"
