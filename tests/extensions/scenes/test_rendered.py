"""Rendered scenes: scenes that cannot be built are skipped, and errors name missing extras."""

from __future__ import annotations

import sys
from importlib.util import find_spec

import pytest

from eai.base.errors import EaiError, InputError
from eai.extensions.scenes.rendered import render_images_of_tasks, render_task_images
from extensions.scenes.rooms import kitchen, task_of

FULL = task_of(kitchen(["lies_in(fridge_2, basket_4)"], ["stands_on(fridge_2, floor_kitchen)"]))


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "eai.extensions.scenes.pictures", None)
    with pytest.raises(EaiError, match=r"scenes with bodies need .*: pip install 'eai-bench\[physics\]'"):
        render_task_images(FULL)


@pytest.mark.skipif(find_spec("mujoco") is None, reason="the extra physics is not installed")
def test_scenes_that_cannot_be_built_have_no_pictures() -> None:
    with pytest.raises(InputError, match="no free space for fridge_2 in basket_4"):
        render_images_of_tasks({"full": FULL})
    try:
        found = render_images_of_tasks({"full": FULL, "kitchen": task_of(kitchen())})
    except EaiError as error:
        pytest.skip(str(error))
    assert [(task_id, len(images)) for task_id, images in found.items()] == [("kitchen", 2)]
