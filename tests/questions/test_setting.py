"""The worlds that questions are about, by the example of lamps: what is shown, and the way through it."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace

import pytest

from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.planning.planner import Planner
from eai.questions import setting as settings
from eai.questions.rules import Rules
from eai.questions.setting import Setting, listed, numbered, open_setting, some, with_counterparts
from eai.tasks.source import Source
from eai.world.execution import Action
from eai.world.state import Fact

WAY = "GO lamp_1; PRESS lamp_1; GO lamp_2; PRESS lamp_2"


@pytest.fixture
def light(lamps: Benchmark) -> Task:
    return lamps.tasks(Source())["light"]


@pytest.fixture
def opened(lamps: Benchmark) -> Callable[[Task], Setting]:
    return lambda task: open_setting(task, Rules(lamps.domain), Planner(lamps.domain), "0")


def steps(task: Task, way: str) -> tuple[Action, ...]:
    words = (step.split() for step in way.split("; ") if step)
    return tuple([Action(name, tuple([task.scene.index[each] for each in about])) for name, *about in words])


def texts(setting: Setting) -> str:
    names = setting.scene.objects
    return "; ".join(" ".join([name, *(names[i].name for i in about)]) for name, about in setting.way)


@pytest.mark.parametrize(
    ("script", "way"),
    [
        (WAY, WAY),
        ("GO lamp_1; PRESS lamp_2; PRESS lamp_1", "GO lamp_1"),  # as far as it can be carried out
        ("GO lamp_1; PRESS lamp_1 lamp_2; PRESS lamp_1", "GO lamp_1"),
        ("GO lamp_1; GO lamp_1; PRESS lamp_1", "GO lamp_1; PRESS lamp_1"),  # without what is needless
        ("; ".join(["GO lamp_1; GO lamp_2"] * 13), "; ".join(["GO lamp_1; GO lamp_2"] * 12)),
    ],
)
def test_the_way_is_the_tasks_own_plan(
    light: Task, opened: Callable[[Task], Setting], script: str, way: str
) -> None:
    setting = opened(replace(light, script=steps(light, script)))
    assert texts(setting) == way
    assert len(setting.states) == len(setting.way) + 1


def test_where_there_is_no_plan_one_is_sought_among_sixty_states(
    light: Task, opened: Callable[[Task], Setting], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = settings.find_plan
    limits = []
    monkeypatch.setattr(
        settings,
        "find_plan",
        lambda task, planner, limit: limits.append(limit) or found(task, planner, limit),
    )
    setting = opened(light)
    assert sorted(name for name, _ in setting.way) == ["GO", "GO", "PRESS", "PRESS"]
    assert setting.works
    assert [limit.states for limit in limits] == [60]
    assert len(opened(replace(light, goals=())).way) == 6, "at random"
    assert len(limits) == 1


def test_a_way_works_if_it_reaches_goals_that_did_not_hold(
    light: Task, opened: Callable[[Task], Setting]
) -> None:
    assert opened(replace(light, script=steps(light, WAY))).works
    assert not opened(replace(light, script=steps(light, "GO lamp_1"))).works
    lit = light.scene.state([Fact("lit", (light.scene.index[name],)) for name in ("lamp_1", "lamp_2")])
    assert not opened(replace(light, initial=lit, script=steps(light, "GO lamp_1"))).works


def test_nothing_is_there_but_what_is_shown_and_used(light: Task, opened: Callable[[Task], Setting]) -> None:
    few = opened(replace(light, relevant=(2,), script=steps(light, "GO ball"), goals=()))
    assert [thing.name for thing in few.scene.objects] == ["robot", "lamp_2", "ball"]
    assert few.things == (1, 2)
    assert few.scene.agent == 0


def test_what_is_asked_of_a_step(light: Task, opened: Callable[[Task], Setting]) -> None:
    setting = opened(replace(light, script=steps(light, WAY)))
    start, there, lit = setting.states[:3]
    press = Action("PRESS", (setting.scene.index["lamp_1"],))
    assert setting.after(start, press) is None
    assert setting.after(there, press) == lit
    assert (setting.failing(start, press), setting.failing(there, press), setting.failing(lit, press)) == (
        (3,),
        (),
        (2,),
    )
    ball = Action("PRESS", (setting.scene.index["ball"],))
    assert setting.failing(start, ball) == (1, 3)
    assert setting.changes(there, lit) == ("lit(lamp_1)",)
    assert setting.changes(lit, there) == ("not lit(lamp_1)",)
    assert setting.changes(start, there) == ("at(robot, lamp_1)",)
    assert setting.alike(lit, lit)
    assert not setting.alike(there, lit)
    assert not setting.alike(lit, there)
    assert list(map(setting.text_of, setting.facts(lit))) == ["lit(lamp_1)", "at(robot, lamp_1)"]
    assert setting.text_of(press) == "PRESS(lamp_1)"
    assert setting.reached(lit) == (False,)


def test_actions_at_random_are_of_each_operator_alike_and_seldom_absurd(
    light: Task, opened: Callable[[Task], Setting]
) -> None:
    setting, rng = opened(light), random.Random(0)
    start = setting.states[0]
    possible = [setting.some_action(rng, start, possible=True) for _ in range(50)]
    assert {action.operator for action in possible if action} == {"GO"}
    assert all(action and setting.after(start, action) is not None for action in possible)
    assert setting.some_action(rng, start, possible=True, operators=["PRESS"]) is None
    impossible = [setting.some_action(rng, start, possible=False, operators=["PRESS"]) for _ in range(400)]
    assert all(action and setting.after(start, action) is None for action in impossible)
    on_lamps = sum(
        setting.scene.objects[action.arguments[0]].category == "lamp" for action in impossible if action
    )
    assert on_lamps / 400 == pytest.approx(2 / (2 + 2 / 4), abs=0.06)  # of what is no lamp one in four
    operators = {
        each.operator for each in (setting.some_action(rng, start, possible=False) for _ in range(99)) if each
    }
    assert operators == {"PRESS", "OPEN", "TAKE", "PUT"}


def test_texts_that_have_a_counterpart_with_the_other_answer() -> None:
    right, wrong = ["a 1", "a 2", "b 1"], ["a 3", "c 1"]
    assert with_counterparts(right, wrong, lambda text: text[0]) == {"a 1", "a 2", "a 3"}


def test_some_of_many_keep_their_order() -> None:
    rng, letters = random.Random(0), list("abcdef")
    assert some(rng, letters, 6) == letters
    found = {tuple(some(rng, letters, 5)) for _ in range(60)}
    assert found == {tuple(letters[:i] + letters[i + 1 :]) for i in range(6)}


def test_lists_are_numbered_from_one_or_have_dashes() -> None:
    assert numbered(["x", "y"]) == "1. x\n2. y"
    assert listed(["x", "y"]) == "- x\n- y"
