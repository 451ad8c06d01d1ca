"""Scenes of questions: pictures of one's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.studies.perception.scenes import read_images


def test_a_users_picture_belongs_to_the_task_with_the_longest_matching_id(tmp_path: Path) -> None:
    for name in ("1_1.png", "1_1_left.jpg", "1_10.png", "1_1.txt", "2_1b.png"):
        (tmp_path / name).write_bytes(name.encode())
    found = read_images(tmp_path, ["1_1", "1_10"])
    assert {task_id: [image.data.decode() for image in shown] for task_id, shown in found.items()} == {
        "1_1": ["1_1.png", "1_1_left.jpg"],
        "1_10": ["1_10.png"],
    }
    assert found["1_1"][1].media_type == "image/jpeg"
    with pytest.raises(InputError, match=r"no picture of 1 of 2 tasks \(2_1\)"):
        read_images(tmp_path, ["1_1", "2_1"])
