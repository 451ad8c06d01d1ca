from __future__ import annotations

import pytest

import eai
from eai import Reward
from eai.abilities.protocol import Protocol
from eai.base.errors import InputError


def test_no_repair_is_paid() -> None:
    suite = eai.open("virtualhome", "action_sequencing", protocol=Protocol("eai-1.0.5"))
    scored = next(task_id for task_id in suite.task_ids if suite.score(task_id, "").excluded is None)
    with pytest.raises(InputError, match="only under the protocol strict"):
        Reward(suite, "repair")(scored, '{"WALK": ["soap"]}')
