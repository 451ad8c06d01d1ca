from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from eai.base.errors import EaiError, InputError
from eai.results.parquet import read_columns

COLUMNS = ("identifier", "llm_output")


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "m_outputs.parquet"
    parquet.write_table(pyarrow.table({"identifier": ["27_2"], "more": [1]}), file)
    with pytest.raises(InputError, match=r'm_outputs\.parquet: the column "llm_output" is missing'):
        list(read_columns(file, COLUMNS))
    assert [*read_columns(file, ["identifier"])] == [{"identifier": "27_2"}]


@pytest.mark.parametrize("content", [b"", b"PAR1", b"[]", b"PAR1" + b"\0" * 100 + b"PAR1"])
def test_a_file_that_is_not_parquet_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    pytest.importorskip("pyarrow")
    file = tmp_path / "m_outputs.parquet"
    file.write_bytes(content)
    with pytest.raises(InputError, match="expected a Parquet file") as caught:
        list(read_columns(file, COLUMNS))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("output", [["x"], {"x": "y"}, [{"x": ["y"]}]])
def test_a_column_of_lists_or_objects_is_refused(tmp_path: Path, output: object) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    file = tmp_path / "m_outputs.parquet"
    pyarrow.parquet.write_table(pyarrow.table({"identifier": ["a"], "llm_output": [output]}), file)
    with pytest.raises(InputError, match=r'the column "llm_output" has lists or objects'):
        list(read_columns(file, COLUMNS))
    assert [*read_columns(file, ["identifier"])] == [{"identifier": "a"}]


def test_two_columns_of_one_name_are_refused(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    file = tmp_path / "m_outputs.parquet"
    columns = [pyarrow.array([text]) for text in "abc"]
    pyarrow.parquet.write_table(pyarrow.Table.from_arrays(columns, ["identifier", *COLUMNS]), file)
    with pytest.raises(InputError, match='two columns are named "identifier"'):
        list(read_columns(file, COLUMNS))


@pytest.mark.parametrize(
    "name", ["MemoryError", "ArrowTypeError", "ArrowNotImplementedError", "ArrowKeyError"]
)
def test_every_error_of_the_reader_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "m_outputs.parquet"
    file.touch()

    def fail(_: Path) -> None:
        raise getattr(pyarrow, name, MemoryError)

    monkeypatch.setattr(parquet, "read_metadata", fail)
    with pytest.raises(InputError, match=f"expected a Parquet file .{name}"):
        list(read_columns(file, COLUMNS))


def test_a_missing_pyarrow_is_reported_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.delitem(sys.modules, "pyarrow.parquet", raising=False)
    with pytest.raises(EaiError, match=r"Parquet needs pyarrow: pip install .*\[analysis\]"):
        list(read_columns(tmp_path / "m_outputs.parquet", COLUMNS))


def bomb(folder: Path, kind: str, texts: list[str]) -> Path:
    """Write a small Parquet file that unpacks to many bytes."""
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    names = [str(number) for number in range(len(texts))]
    table = pyarrow.table({"identifier": names, "llm_output": texts})
    shared = {"use_dictionary": False, "column_encoding": {"llm_output": "DELTA_BYTE_ARRAY"}}
    how = {"dictionary": {}, "compression": {"use_dictionary": False}, "shared prefixes": shared}[kind]
    file = folder / "m_outputs.parquet"
    parquet.write_table(table, file, compression="zstd", write_statistics=False, **how)
    assert file.stat().st_size < 10_000
    return file


MEASURED = """
import resource, sys
from pathlib import Path
from eai.results.parquet import read_columns
import pyarrow.parquet
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
read = sum(len(row["llm_output"]) for row in read_columns(Path(sys.argv[1]), ["identifier", "llm_output"]))
print(read, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is measured in kilobytes on Linux alone")
@pytest.mark.parametrize("kind", ["dictionary", "shared prefixes"])
def test_a_text_shared_by_rows_of_a_parquet_file_is_in_memory_once(tmp_path: Path, kind: str) -> None:
    file = bomb(tmp_path, kind, ["x" * 1_000_000] * 100)
    command = [sys.executable, "-c", MEASURED, str(file)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    read, kilobytes = map(int, printed.split())
    assert read == 100_000_000
    assert kilobytes < 60_000


def test_a_parquet_file_that_unpacks_to_too_much_is_refused_unread(tmp_path: Path) -> None:
    file = bomb(tmp_path, "compression", ["x" * 50_000_000])
    with pytest.raises(InputError, match=r"expected at most 32,\d{3},\d{3} bytes .*found 50,000,\d{3} by"):
        list(read_columns(file, COLUMNS))


@pytest.mark.parametrize("kind", ["dictionary", "shared prefixes", "compression"])
def test_rows_of_every_parquet_encoding_are_read_unchanged(tmp_path: Path, kind: str) -> None:
    texts = [f"{'step ' * (number % 7)}{number % 3}" for number in range(2_500)]
    rows = list(read_columns(bomb(tmp_path, kind, texts[:400]), COLUMNS))
    assert rows == [{"identifier": str(i), "llm_output": text} for i, text in enumerate(texts[:400])]


def test_a_missing_value_of_a_parquet_file_is_none(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "m_outputs.parquet"
    parquet.write_table(pyarrow.table({"identifier": ["a", "b"], "llm_output": ["x", None]}), file)
    assert [row["llm_output"] for row in read_columns(file, COLUMNS)] == ["x", None]
