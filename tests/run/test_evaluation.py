from __future__ import annotations

from pathlib import Path

import pytest

from eai.errors import InputError
from eai.run.evaluation import read_prices

PRICE = '{"input": 2.5, "output": 10, "input_cache_write": 0, "input_cache_read": 1.25}'


@pytest.mark.parametrize("text", [f'{{"a/b": {PRICE}}}', f"a/b: {PRICE}\n"], ids=["json", "yaml"])
def test_prices_are_read_by_model(tmp_path: Path, text: str) -> None:
    file = tmp_path / "prices"
    file.write_text(text)
    (price,) = read_prices(file).values()
    assert (price.input, price.output, price.input_cache_read) == (2.5, 10, 1.25)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"a/b: [", "expected YAML or JSON"),
        (b"\xff\xfe\xff", "expected YAML or JSON"),
        (b"", r"expected prices of models \(the file: expected an object"),
        (b"a/b: {input: 1}", r"expected prices of models \(a/b\.output: is missing"),
        (b"a/b: {input: much}", r"expected prices of models \(a/b\.input: expected a valid number"),
    ],
)
def test_a_file_without_prices_is_named_with_the_place(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "prices"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_prices(file)
    assert str(caught.value).startswith(str(file))
