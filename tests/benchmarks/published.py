"""A package index in a folder on disk, with the made-up data set."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks.synthetic import build_wheel, packs_from
from eai.base.source import PackageArchive
from eai.base.store import DataPackStore
from eai.benchmarks.packs import DataPack


@pytest.fixture
def index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the only folder that pip searches."""
    folder = tmp_path / "index"
    folder.mkdir()
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(folder))
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    return folder


@pytest.fixture
def wheel(index: Path) -> PackageArchive:
    return build_wheel(index)


@pytest.fixture
def packs(wheel: PackageArchive) -> Sequence[DataPack]:
    return packs_from(wheel)


@pytest.fixture
def store(tmp_path: Path) -> DataPackStore:
    return DataPackStore(tmp_path / "store")
