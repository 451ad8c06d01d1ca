from __future__ import annotations

import sys
from pathlib import Path

import pytest

from eai.data.parquet import read_columns
from eai.errors import EaiError, InputError

COLUMNS = ("identifier", "llm_output")


def test_a_column_that_is_missing_is_named(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "m_outputs.parquet"
    parquet.write_table(pyarrow.table({"identifier": ["27_2"], "more": [1]}), file)
    with pytest.raises(InputError, match=r'm_outputs\.parquet: the column "llm_output" is missing'):
        read_columns(file, COLUMNS)
    assert read_columns(file, ["identifier"]) == [{"identifier": "27_2"}]


@pytest.mark.parametrize("content", [b"", b"PAR1", b"[]", b"PAR1" + b"\0" * 100 + b"PAR1"])
def test_a_file_of_another_kind_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    pytest.importorskip("pyarrow")
    file = tmp_path / "m_outputs.parquet"
    file.write_bytes(content)
    with pytest.raises(InputError, match="expected a Parquet file") as caught:
        read_columns(file, COLUMNS)
    assert "\n" not in str(caught.value)


def test_without_pyarrow_its_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(EaiError, match=r"Parquet needs pyarrow: pip install .*\[analysis\]"):
        read_columns(tmp_path / "m_outputs.parquet", COLUMNS)
