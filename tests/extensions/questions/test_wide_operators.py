from __future__ import annotations

from random import Random

from eai.benchmarks.benchmark import Benchmark
from eai.extensions.questions import one_step
from eai.extensions.questions.setting import make_question_setting
from eai.planning.planner import get_planner
from eai.tasks.rules import DomainRulesInPrompts
from eai.tasks.source import Source
from eai.world.action import Action
from planning.test_wide_operators import wide

SHARED = (wide,)
"""The fixture of a world with too many actions."""


def test_a_question_about_too_many_actions_is_not_asked(wide: Benchmark) -> None:
    setting = make_question_setting(
        wide.tasks(Source())["one"], DomainRulesInPrompts(wide.domain), get_planner(wide.domain), "1"
    )
    state, action = setting.states[0], Action("wide", tuple(range(1, 9)))
    changed = {"r", "w", "p"}
    asked = one_step._make_which_action_question(
        setting, Random(1), state, action, changed, lambda _: True, {}
    )
    assert asked is None
