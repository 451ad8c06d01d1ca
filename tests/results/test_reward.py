"""Rewards over all actions of four worlds: their bounds, their order, and no reward for useless actions."""

from __future__ import annotations

import json
import pickle
from collections.abc import Sequence
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import given as drawn
from hypothesis import strategies as st

import eai
from by_path import ROOT
from eai import Ability, Benchmark, InputError, Suite, Task, make_task, use_tasks
from eai.abilities.protocol import PAPER_ABILITIES
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.names import TaskReference
from eai.logic.formula import And, Or
from eai.pddl.planning import PlannerOutcome
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.results.reward import METRICS, Reward, Shaping, open_reward
from eai.tasks.goal_test import GoalTest
from eai.world import Action, Constant, Episode, State
from sweeps import examples
from threading_tests import asked_by_threads
from world import toy

ALL = tuple([shaping for shaping in Shaping if shaping is not Shaping.REPAIR])
LAMPS = ROOT / "examples" / "lamps" / "lamps.py"
HOUSEHOLDS = ("virtualhome", "behavior")
WORLDS = ("toy", "lamps", *HOUSEHOLDS)
FEW = settings(
    deadline=None, max_examples=examples(30), suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def toy_benchmark() -> Benchmark:
    """A benchmark with a lamp to light and a box to move, beside a box that is in its place."""
    red, blue, shed, lamp = map(Constant, ("red", "blue", "shed", "lamp"))
    goals = (toy.lit(lamp), toy.at(red, shed), toy.at(blue, shed))
    return Benchmark(
        "toy", toy.DOMAIN, use_tasks(make_task("tidy", "Light up, tidy.", toy.initial(), *goals))
    )


def lamps_benchmark() -> Benchmark:
    spec = spec_from_file_location("lamps_to_reward", LAMPS)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    found: Benchmark = module.lamps
    return found


@cache
def suite_of(world: str, ability: str = "action_sequencing") -> Suite:
    own = {"toy": toy_benchmark, "lamps": lamps_benchmark}
    return eai.open(own[world]() if world in own else world, ability)


@cache
def reward_for(world: str, shaping: Shaping) -> Reward:
    return Reward(suite_of(world), shaping)


def tasks_of(world: str) -> Sequence[str]:
    suite = suite_of(world)
    return [task_id for task_id in suite.task_ids if suite.tasks[task_id].unplannable_reason is None]


def written(world: str, task: Task, plan: Sequence[Action]) -> str:
    notation = suite_of(world).benchmark.notation.plans
    return notation.join(notation.write(plan, task.scene))


def worth(world: str, task_id: str, text: str) -> dict[Shaping, float]:
    """Return the reward of an answer under each shaping, for a task that pays."""
    values = {shaping: reward_for(world, shaping)(task_id, text) for shaping in ALL}
    return {shaping: value for shaping, value in values.items() if value is not None}


def possible(world: str, task: Task, state: State) -> list[Action]:
    domain = suite_of(world).benchmark.domain
    return [
        action
        for operator in domain.operators
        for action in generate_applicable_actions_of_operator(domain, operator, state, task.relevant)
    ]


def after(world: str, state: State, plan: Sequence[Action]) -> State:
    episode = Episode(suite_of(world).benchmark.domain, state)
    episode.run(plan)
    return episode.state


def reached(task: Task, state: State, plan: Sequence[Action] = ()) -> tuple[bool, ...]:
    return GoalTest(task).evaluate_each_goal(state, [action.operator for action in plan])


def held(task: Task) -> tuple[bool, ...]:
    return reached(task, task.initial)


def gains(task: Task, state: State, plan: Sequence[Action]) -> bool:
    """Whether a plan increases the share of conditions that are met."""
    test = GoalTest(task)
    start = test.find_partial_success(task.initial, (), held(task))
    end = test.find_partial_success(state, [action.operator for action in plan], reached(task, state, plan))
    return end.numerator * start.denominator > start.numerator * end.denominator


def a_task(draw: st.DrawFn, world: str) -> Task:
    return suite_of(world).tasks[draw(st.sampled_from(tasks_of(world)))]


def a_walk(draw: st.DrawFn, world: str, task: Task, length: int) -> list[Action]:
    """Return possible actions, one after the other."""
    plan: list[Action] = []
    state = task.initial
    for _ in range(length):
        actions = possible(world, task, state)
        if not actions:
            break
        plan.append(draw(st.sampled_from(actions)))
        state = after(world, state, plan[-1:])
    return plan


@pytest.fixture(autouse=True)
def there(data_store: DataPackStore) -> None:
    """Skip the tests of this module without the data of the household benchmarks."""


@pytest.mark.parametrize("world", WORLDS)
@drawn(data=st.data())
@FEW
def test_any_plan_earns_between_zero_and_one(world: str, data: st.DataObject) -> None:
    """Plans of all ground actions of a task, possible or not, in any order. Shapings are ordered, too."""
    task = a_task(data.draw, world)
    domain = suite_of(world).benchmark.domain

    def some() -> st.SearchStrategy[Action]:
        def of(name: str) -> st.SearchStrategy[Action]:
            arguments = st.sampled_from(task.relevant)
            return st.tuples(*[arguments] * domain.operator_arities[name]).map(
                lambda each: Action(name, each)
            )

        return st.sampled_from([operator.name for operator in domain.operators]).flatmap(of)

    plan = a_walk(data.draw, world, task, data.draw(st.integers(0, 4)))
    plan += data.draw(st.lists(some(), max_size=4))
    earned = worth(world, task.id, written(world, task, plan))
    assert all(0 <= value <= 1 for value in earned.values())
    assert earned[Shaping.SUCCESS] <= earned[Shaping.GOALS] <= earned[Shaping.PROGRESS]
    assert earned[Shaping.DIAGNOSIS] <= earned[Shaping.PROGRESS]
    assert earned[Shaping.SUCCESS] <= earned[Shaping.PARTIAL]
    if earned[Shaping.SUCCESS]:
        assert earned[Shaping.PROGRESS] == 1


@pytest.mark.parametrize("world", WORLDS)
def test_doing_nothing_earns_nothing(world: str) -> None:
    for task_id in tasks_of(world):
        task = suite_of(world).tasks[task_id]
        for text in ("", written(world, task, ()), "[]", "{}", '{"output": []}', "I have done it all."):
            assert set(worth(world, task_id, text).values()) == {0}


def there_and_back(world: str, task: Task, state: State) -> list[tuple[Action, Action]]:
    """Yield every possible action in a state with all actions that undo it."""
    pairs = []
    for action in possible(world, task, state):
        then = after(world, state, [action])
        back = [b for b in possible(world, task, then) if after(world, then, [b]) == state]
        pairs += [(action, undoing) for undoing in back]
    return pairs


@pytest.mark.parametrize("world", WORLDS)
def test_repeated_actions_and_their_inverses_earn_nothing(world: str) -> None:
    """From the start, and after one action, unless the first action or the pair reaches a goal."""
    found = 0
    for task_id in tasks_of(world)[::25]:
        task = suite_of(world).tasks[task_id]
        for first in ([], possible(world, task, task.initial)[:1]):
            state = after(world, task.initial, first)
            for pair in there_and_back(world, task, state):
                plan = [*first, *pair * 10]
                if reached(task, state, plan) == held(task):
                    found += 1
                    earned = worth(world, task_id, written(world, task, plan))
                    met = earned.pop(Shaping.PARTIAL)
                    assert (set(earned.values()), met > 0) == ({0}, gains(task, state, plan))
    assert found


@pytest.mark.parametrize("world", WORLDS)
@drawn(data=st.data())
@FEW
def test_a_long_plan_that_reaches_nothing_new_earns_nothing(world: str, data: st.DataObject) -> None:
    """Every action of the plan is possible and none is additional; actions that would reach a goal are left
    out.
    """
    task = a_task(data.draw, world)
    at_start, state, plan = held(task), task.initial, list[Action]()
    for _ in range(data.draw(st.integers(1, 12))):
        step = data.draw(st.sampled_from(possible(world, task, state)))
        then = after(world, state, [step])
        gained = zip(reached(task, then, [*plan, step]), at_start, strict=True)
        if not any(now and not before for now, before in gained):
            plan, state = [*plan, step], then
    earned = worth(world, task.id, written(world, task, plan))
    assert (earned.pop(Shaping.PARTIAL) > 0) == gains(task, state, plan)
    assert set(earned.values()) == {0}


@pytest.mark.parametrize("world", WORLDS)
@drawn(data=st.data())
@FEW
def test_partial_pays_for_the_final_state_and_not_for_detours(world: str, data: st.DataObject) -> None:
    """A detour that breaks conditions and restores them earns nothing."""
    task = a_task(data.draw, world)
    plan = a_walk(data.draw, world, task, data.draw(st.integers(0, 3)))
    state = after(world, task.initial, plan)
    before = worth(world, task.id, written(world, task, plan))[Shaping.PARTIAL]
    pairs = there_and_back(world, task, state)
    if not pairs:
        return
    detour = [*plan, *data.draw(st.sampled_from(pairs)) * data.draw(st.integers(1, 5))]
    if reached(task, state, detour) == reached(task, state, plan):
        assert worth(world, task.id, written(world, task, detour))[Shaping.PARTIAL] == before
    first = worth(world, task.id, written(world, task, plan[:1]))[Shaping.PARTIAL]
    assert first == 0 or gains(task, after(world, task.initial, plan[:1]), plan[:1])


@pytest.mark.parametrize("world", WORLDS)
@drawn(data=st.data())
@FEW
def test_padding_never_pays(world: str, data: st.DataObject) -> None:
    """Actions that return to the same state, added to any plan, raise no reward."""
    task = a_task(data.draw, world)
    plan = a_walk(data.draw, world, task, data.draw(st.integers(0, 5)))
    state = after(world, task.initial, plan)
    steps = [a for a in possible(world, task, state) if after(world, state, [a]) == state]
    if not steps:
        return
    padded = [*plan, *[data.draw(st.sampled_from(steps))] * data.draw(st.integers(1, 20))]
    if reached(task, state, padded) != reached(task, state, plan):
        return
    before = worth(world, task.id, written(world, task, plan))
    assert all(
        value <= before[shaping]
        for shaping, value in worth(world, task.id, written(world, task, padded)).items()
    )


def test_exchanging_a_condition_for_one_of_another_option_earns_nothing() -> None:
    """The final state, with either box in the shed and lit lamps, meets as many conditions as the start."""
    red, blue, shed, lamp = map(Constant, ("red", "blue", "shed", "lamp"))
    either = Or(
        (And((toy.at(red, shed), toy.holding(red), toy.lit(lamp))), And((toy.at(blue, shed), toy.lit(lamp))))
    )
    task = make_task("either", "Tidy.", toy.initial(), either)
    paid = Reward(
        eai.open(Benchmark("toy", toy.DOMAIN, use_tasks(task)), "action_sequencing"), Shaping.PARTIAL
    )

    def earned(*steps: tuple[str, str]) -> float | None:
        return paid("either", json.dumps([{"action": name, "object": thing} for name, thing in steps]))

    carried = (("GO", "shed"), ("LIFT", "blue"), ("GO", "hall"))  # the one condition that is met is undone
    assert earned(*carried) == 0
    swapped = (*carried, ("DROP", "blue"), ("LIFT", "red"), ("GO", "shed"))  # 2 of 3 for 1 of 2
    assert earned(*swapped) == pytest.approx(1 / 3)
    assert earned(*swapped, ("DROP", "red")) == 0
    assert earned(*swapped, ("PRESS", "lamp")) == 1


@pytest.mark.parametrize("world", HOUSEHOLDS)
def test_gold_plans_earn_what_they_reach(world: str) -> None:
    suite = suite_of(world)
    book = open_gold_answers(suite.benchmark, Ability.ACTION_SEQUENCING)
    earned = [worth(world, task_id, book[task_id].text) for task_id in tasks_of(world)]
    successes = sum(each[Shaping.SUCCESS] for each in earned)
    assert successes == {"virtualhome": 337, "behavior": 100}[world]


OPERATOR = "(:action {} :parameters () :precondition () :effect ())"


def test_an_empty_answer_earns_nothing_in_every_ability() -> None:
    """Empty answers have no goals, subgoals that already hold, or operators without a clause."""
    for world in HOUSEHOLDS:
        for ability in PAPER_ABILITIES:
            suite = suite_of(world, ability.value)
            for task_id in suite.task_ids[::20]:
                for text in _empty_answers(suite, task_id):
                    assert {Reward(suite, shaping)(task_id, text) for shaping in ALL} in ({0}, {None})


def _empty_answers(suite: Suite, task_id: str) -> list[str]:
    texts = ["", "{}", json.dumps({"output": []}), suite.benchmark.notation.goals.join(())]
    if suite.ability is Ability.TRANSITION_MODELING:
        names = suite.benchmark.operator_tasks(suite.source)[task_id].operators
        texts.append(json.dumps({"output": "".join(map(OPERATOR.format, names))}))
    return texts


HOSTILE = (
    "\0",
    "\ud800 lone",
    "{" * 20_000,
    "[" * 20_000,
    '{"output": "' + "(" * 20_000 + '"}',
    json.dumps({"output": ["not " * 2_000 + "ON(x)"]}),
    json.dumps({"output": ["(" * 2_000 + "ON(x)" + ")" * 2_000]}),
    json.dumps({"output": ["ON(x) or " * 2_000 + "ON(x)"]}),
    '{"node goals": 1e999, "edge goals": NaN, "action goals": -0}',
    '[{"action": ["OPEN"], "object": {"a": 1}}]',
    '{"WALK": [[["x"]]]}' * 2_000,
    "9" * 20_000,
    "\u202e\u0000\uffff" * 1_000,
)


@pytest.mark.parametrize("world", HOUSEHOLDS)
@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_no_text_raises(world: str, ability: Ability) -> None:
    suite = suite_of(world, ability.value)
    paid = Reward(suite, Shaping.DIAGNOSIS)
    for text in HOSTILE:
        assert paid(suite.task_ids[0], text) == 0


def test_an_answer_that_is_too_long_is_not_read() -> None:
    suite = suite_of("virtualhome")
    gold = open_gold_answers(suite.benchmark, Ability.ACTION_SEQUENCING)["27_2"].text
    exact, short = Reward(suite, limit=len(gold)), Reward(suite, limit=len(gold) - 1)
    assert (exact("27_2", gold), short("27_2", gold)) == (1, 0)
    grade = pickle.loads(pickle.dumps(short)).grade("27_2", gold)  # noqa: S301 - its own bytes
    assert grade.metrics["fault.parsing"] == 1
    assert grade.verdict.error.detail == f"it is longer than {len(gold) - 1} characters"


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
@drawn(text=st.text())
@FEW
def test_no_short_text_raises(ability: Ability, text: str) -> None:
    suite = suite_of("behavior", ability.value)
    assert Reward(suite, Shaping.PROGRESS)(suite.task_ids[0], text) == 0


def test_every_ability_has_the_same_metrics_of_grades() -> None:
    for ability in PAPER_ABILITIES:
        suite = suite_of("behavior", ability.value)
        grade = Reward(suite).grade(suite.task_ids[0], "[")
        assert tuple(grade.metrics) == METRICS
        assert grade.value == 0
        assert (grade.metrics["faults"], grade.metrics["fault.parsing"]) == (1, 1)


def test_a_task_that_pays_nothing_has_metrics_of_zero() -> None:
    suite = suite_of("virtualhome")
    excluded = next(task_id for task_id in suite.task_ids if not suite.tasks[task_id].goals)
    grade = Reward(suite, "progress").grade(excluded, "{}")
    assert (grade.value, tuple(grade.metrics), set(grade.metrics.values())) == (None, METRICS, {0.0})
    assert grade.verdict.excluded == "the task has no goals"


PLAN = '{"WALK": ["soap"], "GRAB": ["soap"], "PUTIN": ["soap", "washing_machine"]}'
"""It fails in its last step, when none of the goals is reached that did not hold at the start."""


def test_an_answer_is_rewarded_by_the_reference_of_its_task() -> None:
    task = suite_of("virtualhome").reference("27_2")
    assert task == "virtualhome/action_sequencing/27_2"
    gold = open_gold_answers(eai.find_benchmark("virtualhome"), Ability.ACTION_SEQUENCING)["27_2"].text
    assert [eai.reward(task, text, "goals") for text in (gold, PLAN)] == [1, 0]
    assert open_reward(TaskReference.parse(task), "goals") is open_reward(TaskReference.parse(task), "goals")


def test_a_batch_has_the_rewards_of_its_single_answers() -> None:
    paid = Reward(suite_of("virtualhome"), "goals")
    ids = [suite_of("virtualhome").task_ids[0], "27_2"]
    assert paid.batch(ids, [PLAN, PLAN]) == [paid(task_id, PLAN) for task_id in ids]
    with pytest.raises(ValueError, match="found 2 task_ids, 1 texts"):
        paid.batch(ids, [PLAN])


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_a_reward_is_pickled_by_name(ability: Ability) -> None:
    paid = Reward(suite_of("behavior", ability.value), "diagnosis")
    content = pickle.dumps(paid)
    twin = pickle.loads(content)  # noqa: S301 - its own bytes
    assert len(content) < 1_000
    assert (twin.shaping, twin.suite.data_sha256) == (paid.shaping, paid.suite.data_sha256)
    task_id = paid.suite.task_ids[0]
    gold = open_gold_answers(paid.suite.benchmark, ability)[task_id].text
    assert twin(task_id, gold) == paid(task_id, gold) == 1


def test_a_reward_of_an_unregistered_suite_cannot_be_pickled() -> None:
    with pytest.raises(InputError, match="toy: only a suite opened by name or module:object can be pickled"):
        pickle.dumps(Reward(suite_of("toy")))


def test_rewards_use_no_planner() -> None:
    suite = eai.open("behavior", "transition_modeling")
    grade = Reward(suite).grade(suite.task_ids[0], '{"output": "(:action x)"}')
    assert isinstance(grade.verdict, OperatorVerdict)
    assert grade.verdict.planner is PlannerOutcome.NOT_RUN


def test_rewards_are_the_same_from_threads() -> None:
    suite = suite_of("behavior")
    book = open_gold_answers(suite.benchmark, Ability.ACTION_SEQUENCING)
    answers = [(task_id, book[task_id].text) for task_id in suite.task_ids[:20]]
    paid = Reward(suite, "progress")
    alone = [paid(*answer) for answer in answers]
    fresh = Reward(eai.open("behavior", "action_sequencing"), "progress")
    assert asked_by_threads(lambda i: fresh(*answers[i % 20]) == alone[i % 20], 400)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("27_2", "'27_2' is not a task: expected BENCHMARK/ABILITY/TASK"),
        ("virtualhome/cooking/27_2", "is not a task"),
        ("action_sequencing/27_2", "is not a task"),
        ("virtualhome/action_sequencing/0_0", "virtualhome action_sequencing has no task '0_0'"),
        ("mars/action_sequencing/0_0", "'mars' is not a benchmark"),
    ],
)
def test_an_unknown_task_is_named(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        eai.reward(text, "{}")


def test_an_unknown_shaping_is_named() -> None:
    with pytest.raises(InputError, match="'dense' is no shaping: expected one of success, goals, progress"):
        eai.reward("virtualhome/action_sequencing/27_2", "{}", "dense")


@pytest.mark.parametrize(
    "benchmark",
    ["virtualhome", "lamps:lamps", "pddl:/a/domain.pddl,/a/problems", "a/action_sequencing/tasks/"],
)
@pytest.mark.parametrize("task_id", ["27_2", "a/b"])
def test_task_references_are_parsed_as_written(benchmark: str, task_id: str) -> None:
    reference = TaskReference(benchmark, Ability.GOAL_INTERPRETATION, task_id)
    assert TaskReference.parse(str(reference)) == reference
