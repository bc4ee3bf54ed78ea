"""The documentation builds as a site with warnings as errors, and every link of it leads somewhere."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from gimbal_hil.surface import library

for package in ("material", "mkdocstrings"):
    pytest.importorskip(package, reason="the extra docs is not installed")
ROOT = Path(__file__).resolve().parent.parent.parent


def build(root: Path, out: Path) -> subprocess.CompletedProcess[str]:
    words = ["-m", "mkdocs", "build", "--strict", "-f", str(root / "docs" / "site" / "mkdocs.yml"), "-d", str(out)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, env=environment)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site") / "site"
    done = build(ROOT, out)
    assert done.returncode == 0, done.stderr[-3000:]
    return out


class Links(HTMLParser):
    """What a page leads to and loads."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.loaded: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "a" and given.get("href"):
            self.found.append(given["href"] or "")
        if tag in ("script", "img") and given.get("src"):
            self.loaded.append(given["src"] or "")
        if tag == "link" and given.get("rel") == "stylesheet":
            self.loaded.append(given["href"] or "")


def test_everything_that_the_library_gives_is_on_its_reference_page(site: Path) -> None:
    page = (site / "reference" / "library-reference" / "index.html").read_text()
    names = set(library.__all__) - {"Source"}  # a union of types, told by the signatures
    assert all(f'id="gimbal_hil.surface.library.{name}"' in page for name in names)
    assert "DataFrame" in page and "BadInputError" in page


def test_every_page_of_the_docs_is_a_page_of_the_site(site: Path) -> None:
    pages = {path.relative_to(ROOT / "docs").with_suffix("") for path in (ROOT / "docs").rglob("*.md")}
    missing = [
        str(page)
        for page in pages
        if not (site / (page.parent if page.name == "README" else page) / "index.html").exists()
    ]
    assert len(pages) > 60 and not missing
    assert all((site / "project" / name / "index.html").exists() for name in ("CONTRIBUTING", "CHANGELOG"))


def test_every_link_of_the_site_leads_to_a_file_of_it_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    lost, pages = [], 0
    for page in site.rglob("*.html"):
        links = Links()
        links.feed(page.read_text(encoding="utf-8"))
        pages += 1
        assert not [address for address in links.loaded if "://" in address], page
        for link in links.found:
            parts = urlsplit(link)
            if parts.scheme or not parts.path or page.name == "404.html":
                continue
            target = (page.parent / unquote(parts.path)).resolve()
            if not (target / "index.html").exists() and not target.is_file():
                lost.append(f"{page.relative_to(site)}: {link}")
    assert pages > 60 and not lost


def test_a_link_that_leads_nowhere_fails_the_build(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path / name)
    with (tmp_path / "docs" / "reference" / "glossary.md").open("a") as page:
        page.write("\n[nowhere](no-such-page.md)\n")
    done = build(tmp_path, tmp_path / "out")
    assert done.returncode == 1 and "no-such-page.md" in done.stderr
