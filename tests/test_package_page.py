"""Tests that README as a package page has no links to files of the repository."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import pytest

from by_path import module_at
from test_readme import LINK

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent


PACKAGES = [Path(), *sorted(path.parent.relative_to(ROOT) for path in ROOT.glob("packages/*/pyproject.toml"))]
"""Folders of the published packages."""

ADDRESS = "https://example.org/eai"


def page_of(folder: Path) -> str:
    settings = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))
    text = (folder / "README.md").read_text(encoding="utf-8")
    for each in settings["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["substitutions"]:
        text = re.sub(each["pattern"], each["replacement"], text)
    return text


@pytest.mark.parametrize("package", PACKAGES, ids=str)
def test_no_link_is_relative(package: Path) -> None:
    assert LINK.search((ROOT / package / "README.md").read_text(encoding="utf-8"))
    assert LINK.findall(page_of(ROOT / package)) == []


def test_what_is_not_a_relative_link_stays() -> None:
    page = page_of(ROOT)
    assert "[Inspect](https://inspect.aisi.org.uk)" in page
    assert "The public names." in page
    assert "![" not in page


def test_the_address_of_the_repository_is_written_wherever_it_belongs(tmp_path: Path) -> None:
    """The tool runs twice: the second address replaces the first."""
    names = [package / name for package in PACKAGES for name in ("pyproject.toml", "README.md")]
    for name in [*names, Path("CITATION.cff")]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    write = module_at("tools/address.py").write
    write(tmp_path, "https://example.org/old")
    write(tmp_path, ADDRESS)
    for package in PACKAGES:
        settings = tomllib.loads((tmp_path / package / "pyproject.toml").read_text(encoding="utf-8"))
        assert settings["project"]["urls"]["Repository"] == ADDRESS
        assert LINK.findall(page_of(tmp_path / package)) == []
    assert f"]({ADDRESS}/raw/main/docs/images/explorer.png)\n\n" in page_of(tmp_path)
    assert f"[The public names]({ADDRESS}/blob/main/docs/api.md)" in page_of(tmp_path)
    openenv = Path("packages/eai-openenv")
    assert f"({ADDRESS}/blob/main/packages/eai-openenv/../../README.md)" in page_of(tmp_path / openenv)
    citation = (tmp_path / "CITATION.cff").read_text(encoding="utf-8")
    assert citation.count("repository-code") == 1
    assert f'repository-code: "{ADDRESS}"' in citation


def test_distributions_have_not_the_name_of_the_authors_package() -> None:
    settings = [
        tomllib.loads((ROOT / each / "pyproject.toml").read_text(encoding="utf-8")) for each in PACKAGES
    ]
    names = [each["project"]["name"] for each in settings]
    assert names[0] == "eai-bench"
    assert all(name.startswith("eai-bench") for name in names)


@pytest.mark.parametrize("name", ["AGENTS.md", "llms.txt"])
def test_what_coding_agents_read_leads_to_files_that_are_there(name: str) -> None:
    links = re.findall(r"\]\(([^)]+)\)", (ROOT / name).read_text(encoding="utf-8"))
    assert len(links) > 2
    assert [link for link in links if not (ROOT / link).is_file()] == []
