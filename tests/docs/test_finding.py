"""Search, index and book of the docs: terms of other programs find their page, and the book its page numbers."""

import subprocess
import sys
from pathlib import Path
from runpy import run_path
from urllib.parse import quote

import pytest
from helpers.browser import executable, visit

DOCS = Path(__file__).parents[2] / "docs"
SEARCHES = {
    "gripper": "examples/gripper",
    "Grashof": "how/loops",
    "eigenfrequency": "how/small_motions",
    "Jupyter": "how/see",
    "widget": "how/see",
    "PID": "examples/cart_pole_pid",
    "PSD": "how/spectra",
    "conveyor": "examples/shaken_conveyor",
    "crank slider": "examples/crank_slider",
    "scissor lift": "examples/scissor_lift",
    "door closer": "examples/door_closer",
    "overhead crane": "examples/overhead_crane",
    "counterweight": "examples/counterweight",
    "backlash": "how/play",
    "Weld": "api/joints",
    "HingeJoint": "api/joints",
    "Motor": "api/drivers",
}


def test_terms_of_other_programs_are_in_the_index_of_their_page():
    finding = run_path(str(DOCS / "finding.py"))
    topics, names = finding["topics"](), finding["names"]()
    for term, page in SEARCHES.items():
        assert page in {place for place, _ in (*topics.get(term, ()), *names.get(term, ()))}, term
    for found in (*topics.values(), *names.values()):
        for page, _ in found:
            assert (DOCS / f"{page}.md").exists() or (DOCS.parent / f"{page}.py").exists(), page


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The docs as `make docs` builds them."""
    folder = tmp_path_factory.mktemp("docs")
    subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", str(DOCS), str(folder)], check=True)
    return folder


@pytest.mark.slow
def test_the_search_of_a_file_finds_each_page_in_its_first_five_with_an_excerpt(site, chromium):
    for term, page in SEARCHES.items():
        with visit(chromium, site / "search.html", query=f"?q={quote(term)}") as seen:
            seen.wait("document.querySelectorAll('ul.search p.context').length > 0")
            seen.wait("/finished/.test(document.querySelector('.search-summary').innerText)")
            links = seen.run("[...document.querySelectorAll('ul.search li > a')].slice(0, 5).map((x) => x.href)")
            assert any(f"/{page}.html" in link for link in links), (term, links)
            assert not seen.complaints


@pytest.mark.slow
def test_cards_of_examples_and_gallery_lead_to_pages_with_code_and_downloads(site, chromium):
    for name, count, first in (("examples", 30, "crank_slider"), ("gallery", 60, "heavy_top")):
        with visit(chromium, site / f"{name}.html") as seen:
            links = seen.run("[...document.querySelectorAll('.cards a:has(img)')].map((x) => x.href)")
            assert len(links) >= count and any(link.endswith(f"/{name}/{first}.html") for link in links)
            assert seen.run("[...document.querySelectorAll('.cards img')].every((x) => x.src)")
            assert not seen.complaints
    page = (site / "examples" / "crank_slider.html").read_text(encoding="utf-8")
    downloads = {path.name for path in (site / "_downloads").rglob("*")}
    assert {"crank_slider.py", "crank_slider.ipynb"} <= downloads and "shaking force on the frame up to" in page


@pytest.mark.slow
def test_contents_and_index_of_the_book_have_the_pages_of_the_print(tmp_path):
    pypdf = pytest.importorskip("pypdf", reason="the extra `docs` is not installed")
    soup = pytest.importorskip("bs4", reason="the extra `docs` is not installed")
    executable()  # skips where there is no browser
    making = run_path(str(DOCS / "make_book.py"))
    pages = [f'<section style="break-before: page"><h1 id="old-{k}">Chapter {k}</h1>at {k}</section>' for k in range(3)]
    html = f'<div role="main"><span id="document-a"></span><span id="old-9"></span>{"".join(pages)}</div>'
    found = {"parts": {"Part": ["a"]}, "titles": {"a": "Title"}, "index": {"Weld": ["document-a"]}}
    numbers = {}
    for _ in range(2):
        pdf = making["printed"](making["book"](soup.BeautifulSoup(html, "lxml"), found, numbers), tmp_path)
        numbers = making["numbers_of"](pdf)
    texts = [page.extract_text() for page in pypdf.PdfReader(pdf).pages]
    listed = "".join(next(text for text in texts if "Contents" in text).split())
    for k in range(3):
        (there,) = (n + 1 for n, text in enumerate(texts) if f"at {k}" in text)
        assert numbers[f"heading-{k}"] == there and f"Chapter{k}{there}" in listed
    assert f"Weld {numbers['document-a']}" in texts[-1]
