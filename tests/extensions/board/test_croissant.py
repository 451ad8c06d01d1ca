from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.board.croissant import (
    make_operator_rows,
    make_row_id,
    make_task_rows,
    write_croissant_files,
)
from eai.tasks.source import Source

mlcroissant = pytest.importorskip("mlcroissant", reason="needs the extra croissant")
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of what it reads graphs with
TABLES = {"tasks": make_task_rows, "operators": make_operator_rows}


def plain(value: object) -> object:
    """Return the values of the library as they are written in the files."""
    return value.decode() if isinstance(value, bytes) else [plain(part) for part in list(value)]  # type: ignore[call-overload]


@pytest.fixture(scope="module")
def published(data_store: DataPackStore) -> list[Benchmark]:
    return [find_benchmark(name) for name in ("virtualhome", "behavior")]


@pytest.fixture(scope="module")
def written(
    data_store: DataPackStore, published: list[Benchmark], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("croissant")
    write_croissant_files(published, Source(data_store), folder)
    return folder


@pytest.fixture(scope="module")
def read(written: Path) -> Any:
    return mlcroissant.Dataset(written / "croissant.json")


def test_the_metadata_is_valid(read: Any) -> None:
    assert not read.metadata.issues.errors
    assert not read.metadata.issues.warnings


def test_a_benchmark_without_operator_tasks_has_no_rows_of_operators(data_store: DataPackStore) -> None:
    assert list(make_operator_rows(find_benchmark("obfuscated:behavior"), Source(data_store))) == []


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
@pytest.mark.parametrize("kind", TABLES)
def test_every_field_of_every_row_reads_back(
    data_store: DataPackStore, published: list[Benchmark], read: Any, name: str, kind: str
) -> None:
    (benchmark,) = [each for each in published if each.name == name]
    rows = list(TABLES[kind](benchmark, Source(data_store)))
    back = [
        {field.partition("/")[2]: plain(value) for field, value in row.items()}
        for row in read.records(f"{name}_{kind}")
    ]
    assert back == rows
    assert len(rows) == {"virtualhome": (342, 33), "behavior": (100, 30)}[name][kind == "operators"]


def test_the_same_data_are_the_same_bytes(
    data_store: DataPackStore, published: list[Benchmark], written: Path, tmp_path: Path
) -> None:
    for file in write_croissant_files(published, Source(data_store), tmp_path):
        assert file.read_bytes() == (written / file.name).read_bytes()


def test_no_row_id_reads_as_a_number() -> None:
    assert make_row_id("27_2") == "scene_1_27_2"
    assert make_row_id("tidy_1") == "tidy_1"
