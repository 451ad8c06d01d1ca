from __future__ import annotations

import pytest

from eai.errors import InputError
from eai.scoring.shards import Shard


@pytest.mark.parametrize(
    ("text", "shard"), [("1/1", Shard(1, 1)), ("2/8", Shard(2, 8)), ("8/8", Shard(8, 8))]
)
def test_shards_are_counted_from_one(text: str, shard: Shard) -> None:
    assert Shard.parse(text) == shard
    assert shard.file_name == f"records.shard-{shard.number}-of-{shard.of}.jsonl"


@pytest.mark.parametrize("text", ["", "0/3", "4/3", "1", "1/0", "-1/3", "a/b", "1/3/5"])
def test_what_is_no_shard_is_said(text: str) -> None:
    with pytest.raises(InputError, match="is no shard: expected I/N"):
        Shard.parse(text)


@pytest.mark.parametrize("of", [1, 2, 3, 10])
def test_every_item_is_in_one_shard(of: int) -> None:
    parts = [Shard(number, of).of_these(range(7)) for number in range(1, of + 1)]
    assert sorted(item for part in parts for item in part) == list(range(7))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
