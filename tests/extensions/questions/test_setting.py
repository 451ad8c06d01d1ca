"""The worlds that questions are about, by the example of lamps: what is shown, and the way through it."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace

import pytest

import eai.world as w
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions import setting as settings
from eai.extensions.questions.setting import (
    QuestionSetting,
    draw_sample_keeping_order,
    explore_states,
    find_texts_with_shared_operator,
    format_list,
    format_numbered_list,
    make_question_setting,
)
from eai.logic.formula import Always, Atom, Constant, Not
from eai.planning.planner import Planner
from eai.tasks.rules import DomainRulesInPrompts
from eai.tasks.source import Source
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.state import Fact

WAY = "GO lamp_1; PRESS lamp_1; GO lamp_2; PRESS lamp_2"


@pytest.fixture
def light(lamps: Benchmark) -> Task:
    return lamps.tasks(Source())["light"]


@pytest.fixture
def opened(lamps: Benchmark) -> Callable[[Task], QuestionSetting]:
    return lambda task: make_question_setting(
        task, DomainRulesInPrompts(lamps.domain), Planner(lamps.domain), "0"
    )


def steps(task: Task, way: str) -> tuple[Action, ...]:
    words = (step.split() for step in way.split("; ") if step)
    return tuple([Action(name, tuple([task.scene.index[each] for each in about])) for name, *about in words])


def texts(setting: QuestionSetting) -> str:
    names = setting.scene.objects
    return "; ".join(" ".join([name, *(names[i].name for i in about)]) for name, about in setting.path)


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
def test_the_path_is_the_tasks_own_plan(
    light: Task, opened: Callable[[Task], QuestionSetting], script: str, way: str
) -> None:
    setting = opened(replace(light, script=steps(light, script)))
    assert texts(setting) == way
    assert len(setting.states) == len(setting.path) + 1


def test_a_missing_plan_is_searched_for_in_sixty_states(
    light: Task, opened: Callable[[Task], QuestionSetting], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = settings.find_plan
    limits = []
    monkeypatch.setattr(
        settings,
        "find_plan",
        lambda task, planner, limit: limits.append(limit) or found(task, planner, limit),
    )
    setting = opened(light)
    assert sorted(name for name, _ in setting.path) == ["GO", "GO", "PRESS", "PRESS"]
    assert setting.has_path_from_unmet_to_met_goals
    assert [limit.states for limit in limits] == [60]
    assert len(opened(replace(light, goals=())).path) == 6, "at random"
    assert len(limits) == 1


def test_a_path_works_if_it_reaches_goals_that_did_not_hold(
    light: Task, opened: Callable[[Task], QuestionSetting]
) -> None:
    assert opened(replace(light, script=steps(light, WAY))).has_path_from_unmet_to_met_goals
    assert not opened(replace(light, script=steps(light, "GO lamp_1"))).has_path_from_unmet_to_met_goals
    lit = light.scene.state([Fact("lit", (light.scene.index[name],)) for name in ("lamp_1", "lamp_2")])
    assert not opened(
        replace(light, initial=lit, script=steps(light, "GO lamp_1"))
    ).has_path_from_unmet_to_met_goals


def test_goals_over_time_are_left_out(light: Task, opened: Callable[[Task], QuestionSetting]) -> None:
    never = goal(Always(Not(Atom("is_open", (Constant("box"),)))))
    setting = opened(replace(light, goals=(*light.goals, never)))
    assert setting.goals == opened(light).goals
    assert setting.has_path_from_unmet_to_met_goals


def test_the_scene_has_only_shown_and_used_objects(
    light: Task, opened: Callable[[Task], QuestionSetting]
) -> None:
    few = opened(replace(light, relevant=(2,), script=steps(light, "GO ball"), goals=()))
    assert [thing.name for thing in few.scene.objects] == ["robot", "lamp_2", "ball"]
    assert few.non_agent_object_indices == (1, 2)
    assert few.scene.agent == 0


def test_what_is_asked_of_a_step(light: Task, opened: Callable[[Task], QuestionSetting]) -> None:
    setting = opened(replace(light, script=steps(light, WAY)))
    start, there, lit = setting.states[:3]
    press = Action("PRESS", (setting.scene.index["lamp_1"],))
    assert setting.find_next_state(start, press) is None
    assert setting.find_next_state(there, press) == lit
    assert (
        setting.list_unmet_requirement_numbers(start, press),
        setting.list_unmet_requirement_numbers(there, press),
        setting.list_unmet_requirement_numbers(lit, press),
    ) == (
        (3,),
        (),
        (2,),
    )
    ball = Action("PRESS", (setting.scene.index["ball"],))
    assert setting.list_unmet_requirement_numbers(start, ball) == (1, 3)
    assert setting.format_changes(there, lit) == ("lit(lamp_1)",)
    assert setting.format_changes(lit, there) == ("not lit(lamp_1)",)
    assert setting.format_changes(start, there) == ("at(robot, lamp_1)",)
    assert setting.is_same_state(lit, lit)
    assert not setting.is_same_state(there, lit)
    assert not setting.is_same_state(lit, there)
    assert list(map(setting.format_fact_or_action, setting.list_changeable_facts(lit))) == [
        "lit(lamp_1)",
        "at(robot, lamp_1)",
    ]
    assert setting.format_fact_or_action(press) == "PRESS(lamp_1)"
    assert setting.evaluate_goals(lit) == (False,)


def test_random_actions_use_all_operators_equally_and_rarely_unsuitable_objects(
    light: Task, opened: Callable[[Task], QuestionSetting]
) -> None:
    setting, rng = opened(light), random.Random(0)
    start = setting.states[0]
    possible = [setting.draw_action(rng, start, possible=True) for _ in range(50)]
    assert {action.operator for action in possible if action} == {"GO"}
    assert all(action and setting.find_next_state(start, action) is not None for action in possible)
    assert setting.draw_action(rng, start, possible=True, operators=["PRESS"]) is None
    impossible = [setting.draw_action(rng, start, possible=False, operators=["PRESS"]) for _ in range(400)]
    assert all(action and setting.find_next_state(start, action) is None for action in impossible)
    on_lamps = sum(
        setting.scene.objects[action.arguments[0]].category == "lamp" for action in impossible if action
    )
    assert on_lamps / 400 == pytest.approx(2 / (2 + 2 / 4), abs=0.06)  # of what is no lamp one in four
    operators = {
        each.operator for each in (setting.draw_action(rng, start, possible=False) for _ in range(99)) if each
    }
    assert operators == {"PRESS", "OPEN", "TAKE", "PUT"}


def test_texts_that_have_a_counterpart_with_the_other_answer() -> None:
    right, wrong = ["a 1", "a 2", "b 1"], ["a 3", "c 1"]
    assert find_texts_with_shared_operator(right, wrong, lambda text: text[0]) == {"a 1", "a 2", "a 3"}


def test_drawn_elements_keep_their_order() -> None:
    rng, letters = random.Random(0), list("abcdef")
    assert draw_sample_keeping_order(rng, letters, 6) == letters
    found = {tuple(draw_sample_keeping_order(rng, letters, 5)) for _ in range(60)}
    assert found == {tuple(letters[:i] + letters[i + 1 :]) for i in range(6)}


def test_lists_are_numbered_from_one_or_have_dashes() -> None:
    assert format_numbered_list(["x", "y"]) == "1. x\n2. y"
    assert format_list(["x", "y"]) == "- x\n- y"


PUT = """\
PUT(x, y)
  requirement 1: is_a(y, box)   [otherwise "y is no box"]
  requirement 2: holds(agent, x)   [otherwise "the robot does not hold x"]
  requirement 3: at(agent, y)   [otherwise "the robot is not at y"]
  requirement 4: is_open(y)   [otherwise "y is closed"]
  becomes false: holds(agent, x)
  becomes true: inside(x, y)"""


def test_the_rules_of_an_operator_match_its_declaration(lamps: Benchmark) -> None:
    assert DomainRulesInPrompts(lamps.domain).write_rules({"PUT"}) == PUT


def test_rules_of_operators_keep_the_order_of_the_declaration(lamps: Benchmark) -> None:
    text = DomainRulesInPrompts(lamps.domain).write_rules({"PUT", "GO"})
    assert text.splitlines()[0] == "GO(x)"
    assert text.endswith(PUT)


x, y = w.Variable("x"), w.Variable("y")
on, near = w.Predicate("on", 1), w.Predicate("near", 2)
hidden, tag = w.Predicate("hidden", 1, visible=False), w.Predicate("tag", 1, static=True, visible=False)
ready = w.DefinedPredicate("ready", (x,), ~on(x) & w.Exists(y, near(x, y)))
counted = w.ComputedPredicate("counted", 1, lambda state, things: True, ("on",))
OPERATORS = (
    w.Operator(
        "START",
        (x,),
        (w.missing_step(ready(x), "{x} is not ready"),),
        (
            w.Add(on(x)),
            w.Add(hidden(x)),
            w.When(tag(x), (w.Add(hidden(x)),)),
            w.When(
                tag(x), (w.Delete(near(x, w.ANYTHING)), w.Delete(near(w.ANYTHING, x))), (w.Add(near(x, x)),)
            ),
            w.ForEach(y, near(x, y), (w.Let(x, near(x, y), (w.Add(on(x)),)),)),
        ),
        "make it run",
    ),
    w.Operator("RECALL", (x,), (w.missing_step(hidden(x), "{x} is not hidden"),), (w.Add(on(x)),)),
    w.Operator("COUNT", (x,), (w.missing_step(counted(x), "{x} does not count"),), ()),
    w.Operator("TRY", (x,), (), (), alternatives=(w.OperatorAlternative(on(x), (), (w.Delete(on(x)),)),)),
    w.Operator("LOOK", (), (), ()),
)
WORLD = DomainRulesInPrompts(
    w.Domain("world", w.Vocabulary((on, near, hidden, tag), (ready, counted)), OPERATORS)
)


def test_rules_leave_out_inexpressible_operators() -> None:
    assert [operator.name for operator in WORLD.operators] == ["START", "LOOK"]
    assert WORLD.changeable_hidden_predicates == {"hidden"}
    assert WORLD.changeable_visible_predicates == {"on", "near"}
    assert WORLD.changed_predicates_by_operator["START"] == {"on", "near"}
    assert WORLD.find_used_predicates({"START"}) == {"on", "near", "tag"}
    assert WORLD.find_used_predicates({"LOOK"}) == frozenset()
    assert WORLD.find_used_predicates({"LOOK"}, [ready(x)]) == {"on", "near"}


def test_rules_state_conditions_of_effects_and_each_definition_once() -> None:
    assert WORLD.write_rules({"START", "LOOK"}) == (
        "START(x): make it run\n"
        '  requirement 1: ready(x)   [otherwise "x is not ready"]\n'
        "  becomes true: on(x)\n"
        "  if tag(x):\n"
        "    becomes false: near(x, *), near(*, x)\n"
        "  if not tag(x):\n"
        "    becomes true: near(x, x)\n"
        "  for each y with near(x, y):\n"
        "    for the first x with near(x, y):\n"
        "      becomes true: on(x)\n"
        "LOOK()\n"
        "  changes nothing\n"
        "ready(x) means: not on(x) and exists y. (near(x, y))"
    )


@pytest.mark.parametrize(("domain", "left_out"), [("virtualhome", {"PUTOBJBACK"}), ("behavior", {"CLEAN"})])
def test_one_operator_of_households_is_inexpressible(domain: str, left_out: set[str]) -> None:
    rules = DomainRulesInPrompts(find_benchmark(domain).domain)
    assert set(rules.domain.operator_arities) - rules.operator_names == left_out
    text = rules.write_rules(rules.operator_names)
    assert not any(name in text for name in rules.changeable_hidden_predicates)


ROBOT, LAMP_1, LAMP_2, BALL, BOX = range(5)
TO_LAMP_1, TO_LAMP_2 = Action("GO", (LAMP_1,)), Action("GO", (LAMP_2,))
PRESS_1, PRESS_2 = Action("PRESS", (LAMP_1,)), Action("PRESS", (LAMP_2,))


def setting(lamps: Benchmark, task: str = "light") -> QuestionSetting:
    rules, planner = DomainRulesInPrompts(lamps.domain), Planner(lamps.domain)
    return make_question_setting(lamps.tasks(Source())[task], rules, planner, "0")


def test_all_reachable_states_are_found_in_order_of_distance(lamps: Benchmark) -> None:
    world = setting(lamps)
    ways = explore_states(world, world.states[0], [TO_LAMP_1, PRESS_1, PRESS_2], 100)
    assert ways is not None
    assert [world.list_changeable_facts(state) for state in ways.states[1:]] == [
        [("at", (ROBOT, LAMP_1))],
        [("lit", (LAMP_1,)), ("at", (ROBOT, LAMP_1))],
    ]
    assert ways.depths == (0, 1, 2)
    assert ways.edges == (((0, 1),), ((1, 2),), ())


def test_a_restricted_graph_equals_the_graph_of_its_actions(lamps: Benchmark) -> None:
    world = setting(lamps)
    actions = [TO_LAMP_1, PRESS_2, TO_LAMP_2, PRESS_1]
    at_a_lamp = world.find_next_state(world.states[0], TO_LAMP_1)
    assert at_a_lamp is not None
    for start in (at_a_lamp, world.states[0]):  # to the first of them one may come back
        ways = explore_states(world, start, actions, 100)
        assert ways is not None
        for kept in ([], [0], [0, 3], [1, 2], [0, 1, 2, 3], [0, 2, 3]):
            alone = explore_states(world, start, [actions[n] for n in kept], 100)
            assert ways.restrict_to_actions(kept) == alone
    assert ways is not None
    assert ways.reachable_facts == {
        Fact("lit", (LAMP_1,)),
        Fact("lit", (LAMP_2,)),
        Fact("at", (ROBOT, LAMP_1)),
        Fact("at", (ROBOT, LAMP_2)),
    }


def test_distances_with_all_and_without_one_action(lamps: Benchmark) -> None:
    world = setting(lamps)
    ways = explore_states(world, world.states[0], [TO_LAMP_1, TO_LAMP_2, PRESS_1, PRESS_2], 100)
    assert ways is not None

    both_lit = [n for n, state in enumerate(ways.states) if state.mask("lit").bit_count() == 2]
    assert ways.depths[both_lit[0]] == 4
    fewer = [ways.restrict_to_actions([other for other in range(4) if other != n]) for n in range(4)]
    assert not any(state.mask("lit").bit_count() == 2 for each in fewer for state in each.states)
    left = ways.find_distances_to_goal_states(both_lit)
    assert left[0] == 4
    assert {left[n] for n in both_lit} == {0}
    assert {left[target] for _, target in ways.edges[0]} == {3}
    assert ways.find_distances_to_goal_states([]) == {}


def test_a_graph_with_too_many_states_is_refused(lamps: Benchmark) -> None:
    world = setting(lamps)
    assert explore_states(world, world.states[0], [TO_LAMP_1, PRESS_1], 3) is not None
    assert explore_states(world, world.states[0], [TO_LAMP_1, PRESS_1], 2) is None


def test_a_setting_without_a_plan_of_its_own_takes_what_search_finds(lamps: Benchmark) -> None:
    world = setting(lamps, "pack")
    assert world.has_path_from_unmet_to_met_goals
    assert [action.operator for action in world.path] == ["GO", "OPEN", "GO", "TAKE", "GO", "PUT"]
    assert len(world.states) == len(world.path) + 1
