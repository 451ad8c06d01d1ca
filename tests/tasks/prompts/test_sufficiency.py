"""A prompt states all that its gold plan needs: the plan works in a world made of the text alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import islice, product
from pathlib import Path
from typing import TypeAlias

import pytest

from benchmarks.generator.worlds import generator
from by_path import ROOT, TESTS
from eai.abilities.protocol import Ability
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules, View
from eai.base.store import DataPackStore
from eai.benchmarks.behavior_1k.benchmark import UNTOLD
from eai.benchmarks.behavior_1k.conventions import HEADING, describe_unobservable_facts
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import GeneratedTask, TaskKind
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, make_benchmark_with_other_tasks
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import find_plan
from eai.tasks.prompts.prompt import VARIANTS, Prompt, PromptSet
from eai.tasks.source import Source, use_tasks
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.execution import execute_plan
from sweeps import every, swept
from tasks.prompts.long_form import write_long_form
from tasks.prompts.official_readers import official_reader_of
from tasks.prompts.readers import reader_of
from tasks.prompts.sufficiency import insufficiency

PromptOf: TypeAlias = Callable[[Benchmark, Task], str]
SHORT: Sequence[PromptSet] = ("short", "facts")
"""Sets of prompts that list facts in a shorter form."""

PLANS = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
INSUFFICIENT = Path(__file__).parent / "golden" / "official_insufficient.tsv"
"""Tasks whose published prompt lacks a fact that the published plan needs: benchmark, task and reason."""

FOLDER = TESTS / "pddl" / "domains"


@pytest.fixture(scope="module")
def fetched(data_store: DataPackStore, activity_store: DataPackStore) -> Source:
    """The data of the paper's households and of BEHAVIOR-1K."""
    return Source(data_store)


def gold_plan(benchmark: Benchmark, task: Task) -> Sequence[Action]:
    """Return a plan that reaches all goals in the true world; empty if no plan can."""
    if task.unplannable_reason is not None or task.has_no_plan:
        return ()
    plan = task.script or find_plan(task, Planner(benchmark.domain), Limits(10_000)).plan
    trajectory = execute_plan(benchmark.domain, task.initial, plan)
    taken = [action.operator for action in trajectory.executed_actions]
    assert trajectory.failure is None, task.id
    assert all(GoalTest(task).evaluate_each_goal(trajectory.final_state, taken, trajectory)), task.id
    return plan


def insufficient(
    benchmark: Benchmark, ability: Ability, tasks: Iterable[Task], prompt_of: PromptOf
) -> dict[str, str]:
    """Return why gold plans fail in the worlds of their prompts, by task."""
    reasons = {}
    for task in tasks:
        plan = gold_plan(benchmark, task)
        if plan:
            reader = reader_of(benchmark, ability, task)
            reasons[task.id] = insufficiency(reader, prompt_of(benchmark, task), task, plan)
    assert reasons
    return {task_id: reason for task_id, reason in reasons.items() if reason is not None}


@lru_cache(maxsize=6)
def own_prompts(reference: str, ability: Ability, source: Source, prompts: PromptSet) -> Mapping[str, Prompt]:
    """Return the prompts of one of our sets, and keep the last six sets for other tests."""
    return PromptLibrary(prompts, None, source).open(find_benchmark(reference), ability)


def own_prompt(ability: Ability, source: Source, prompts: PromptSet = "eai") -> PromptOf:
    """Return the function that gives the prompt of a task from one of our sets, in the long form."""

    def prompt_of(benchmark: Benchmark, task: Task) -> str:
        if benchmark.reference:
            question = own_prompts(benchmark.reference, ability, source, prompts)[task.id].user
        else:
            question = PromptLibrary(prompts, None, source).open(benchmark, ability)[task.id].user
        return in_long_form(question, prompts)

    return prompt_of


def in_long_form(question: str, prompts: PromptSet) -> str:
    """Return a question in the form that readers of prompts know."""
    return write_long_form(question) if prompts in SHORT else question


def with_known_conventions(text: str, task: Task) -> str:
    """Return a prompt that hides conventions, read as by a person who knows the conventions."""
    _, heading, known = describe_unobservable_facts(task).partition(HEADING)
    before, start, after = text.rpartition("\n\nInitial state:\n")
    return f"{before}\n\n{heading}{known}{start}{after}"


def chosen(benchmark: Benchmark, ability: Ability, source: Source, step: int) -> list[Task]:
    """Return a regular sample of an ability's tasks."""
    return list(benchmark.tasks_for(ability, source).values())[::step]


@every(25)
@pytest.mark.parametrize("prompts", ["eai", *SHORT])
@pytest.mark.parametrize("ability", PLANS)
@pytest.mark.parametrize(
    "name",
    [
        *("virtualhome", "behavior", "behavior-1k"),
        *swept("behavior-1k-challenge-2025", "behavior-1k-challenge-2026", "behavior-1k-behavior-100"),
    ],
)
def test_gold_plans_work_in_the_worlds_of_our_prompts(
    fetched: Source, name: str, ability: Ability, prompts: PromptSet, every: int
) -> None:
    benchmark = find_benchmark(name)
    tasks = chosen(benchmark, ability, fetched, every)
    assert insufficient(benchmark, ability, tasks, own_prompt(ability, fetched, prompts)) == {}


@every(25)
@pytest.mark.parametrize("prompts", ["eai", *SHORT])
@pytest.mark.parametrize("name", ["virtualhome", "behavior", "behavior-1k"])
def test_the_rest_of_gold_plans_works_in_the_worlds_of_prompts_about_later_states(
    fetched: Source, name: str, prompts: PromptSet, every: int
) -> None:
    """Leave out plans that put an object back, because no fact of a state says where it was."""
    household = find_benchmark(name)
    tasks = []
    for task in chosen(household, Ability.ACTION_SEQUENCING, fetched, every):
        plan = gold_plan(household, task)
        states = execute_plan(household.domain, task.initial, plan).states
        number = next((i for i, action in enumerate(plan, 1) if "GR" in action.operator), 0)  # GRAB, GRASP
        rest = tuple(plan[number:])
        by_history = any(goal.kind is GoalKind.ACTION for goal in task.goals) or any(
            action.operator == "PUTOBJBACK" for action in rest
        )
        if number and rest and not by_history:
            tasks.append(replace(task, initial=states[number], script=rest))
    later = make_benchmark_with_other_tasks(household, "later", use_tasks(*tasks))
    opened = PromptLibrary(prompts, None, fetched).open(later, Ability.ACTION_SEQUENCING)

    def prompt_of(benchmark: Benchmark, task: Task) -> str:
        return in_long_form(opened[task.id].user, prompts)

    assert insufficient(later, Ability.ACTION_SEQUENCING, tasks, prompt_of) == {}


@every(50)
@pytest.mark.parametrize("prompts", [name for name in VARIANTS if name not in SHORT])
@pytest.mark.parametrize("name", ["virtualhome", "behavior", *swept("behavior-1k")])
def test_gold_plans_work_in_the_worlds_of_variants_of_our_prompts(
    fetched: Source, name: str, prompts: PromptSet, every: int
) -> None:
    benchmark = find_benchmark(name)
    opened = PromptLibrary(prompts, None, fetched).open(benchmark, Ability.ACTION_SEQUENCING)
    tasks = chosen(benchmark, Ability.ACTION_SEQUENCING, fetched, every)

    def prompt_of(benchmark: Benchmark, task: Task) -> str:
        return opened[task.id].user

    assert insufficient(benchmark, Ability.ACTION_SEQUENCING, tasks, prompt_of) == {}


@every(100)
@pytest.mark.parametrize("ability", PLANS)
def test_who_knows_the_conventions_needs_no_more_than_prompts_without_them(
    fetched: Source, ability: Ability, every: int
) -> None:
    benchmark, plain = find_benchmark(UNTOLD), own_prompt(ability, fetched)
    tasks = chosen(benchmark, ability, fetched, every)

    def prompt_of(benchmark: Benchmark, task: Task) -> str:
        return with_known_conventions(plain(benchmark, task), task)

    assert insufficient(benchmark, ability, tasks, prompt_of) == {}


@every(25)
@pytest.mark.parametrize("prompts", ["eai", *SHORT])
@pytest.mark.parametrize(
    ("name", "view"),
    [  # in VirtualHome, a view of the scene shows some relations of the agent alone, as it says
        ("virtualhome", "task"),
        *product(("behavior", "behavior-1k"), ("task", "scene")),
    ],
)
def test_gold_plans_work_in_the_worlds_of_openings(
    fetched: Source, name: str, view: View, prompts: PromptSet, every: int
) -> None:
    benchmark = find_benchmark(name)
    rules = GameRules(view=view, until="done", prompts=prompts)
    tasks = [
        t
        for t in chosen(benchmark, Ability.ACTION_SEQUENCING, fetched, every)
        if t.unplannable_reason is None
    ]

    def opening(benchmark: Benchmark, task: Task) -> str:
        text = Game(make_setup(task, benchmark, rules)).write_manual_and_first_observation()
        return write_long_form(text) if prompts in SHORT else text

    assert insufficient(benchmark, Ability.ACTION_SEQUENCING, tasks, opening) == {}


@every(10)
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_prompts_of_the_data_sets_lack_what_a_list_says(fetched: Source, name: str, every: int) -> None:
    benchmark = find_benchmark(name)
    prompts = benchmark.official_prompts(Ability.ACTION_SEQUENCING, fetched)
    assert prompts is not None
    lacking = {}
    for task in chosen(benchmark, Ability.ACTION_SEQUENCING, fetched, every):
        plan = gold_plan(benchmark, task)
        if plan:
            reader = official_reader_of(benchmark, task)
            lacking[task.id] = insufficiency(reader, prompts[task.id].user, task, plan) or ""
    rows = [line.split("\t") for line in INSUFFICIENT.read_text(encoding="utf-8").splitlines()]
    listed = {task_id: reason for of, task_id, reason in rows if of == name}
    assert lacking == {task_id: listed.get(task_id, "") for task_id in lacking}


@pytest.mark.parametrize("prompts", ["eai", *SHORT])
@pytest.mark.parametrize("name", sorted(path.name for path in FOLDER.iterdir()))
def test_gold_plans_work_in_the_worlds_of_prompts_about_pddl(name: str, prompts: PromptSet) -> None:
    benchmark = find_benchmark(f"pddl:{FOLDER / name / 'domain.pddl'},{FOLDER / name}")
    for ability in PLANS:
        tasks = benchmark.tasks_for(ability, Source()).values()
        assert insufficient(benchmark, ability, tasks, own_prompt(ability, Source(), prompts)) == {}


@pytest.mark.parametrize(
    ("like", "kind", "seeds"),
    [
        *(
            ("behavior", TaskKind.PLAIN, 4),
            ("virtualhome", TaskKind.PLAIN, 6),
            ("behavior", TaskKind.HAZARDS, 41),
        ),
        *swept(*product(("virtualhome", "behavior"), TaskKind, (40,))),
    ],
)
def test_gold_plans_work_in_the_worlds_of_prompts_about_generated_tasks(
    fetched: Source, like: str, kind: TaskKind, seeds: int
) -> None:
    made = generator(like, kind=kind)
    outcomes = [made.generate_task(seed) for seed in islice(make_seeds("sufficient", 1), seeds)]
    tasks = [each.task for each in outcomes if isinstance(each, GeneratedTask)]
    tasks += [
        each.paired.task for each in outcomes if isinstance(each, GeneratedTask) and each.paired is not None
    ]
    benchmark = make_benchmark_with_other_tasks(find_benchmark(like), "made", use_tasks(*tasks))
    asked = list(benchmark.tasks_for(Ability.ACTION_SEQUENCING, fetched).values())
    sets: Sequence[PromptSet] = ("eai", *SHORT)
    for prompts in sets if asked else ():
        prompt_of = own_prompt(Ability.ACTION_SEQUENCING, fetched, prompts)
        assert insufficient(benchmark, Ability.ACTION_SEQUENCING, asked, prompt_of) == {}
    assert asked or seeds == 40, "no seed gives a task"


@pytest.mark.parametrize("prompts", ["eai", *SHORT])
def test_tasks_of_an_own_world_are_sufficient(prompts: PromptSet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    lamps = find_benchmark("lamps:lamps")
    for ability in PLANS:
        tasks = lamps.tasks_for(ability, Source()).values()
        assert insufficient(lamps, ability, tasks, own_prompt(ability, Source(), prompts)) == {}


@pytest.mark.parametrize(
    ("task_id", "line"),
    [
        ("clean_a_baseball_glove", "- sink_1 gives water_1, while it is switched on."),
        ("clean_a_baseball_glove", "contains(disinfectant__bottle_1, disinfectant_1)"),
        ("cook_corn", "- stove_1 works while switched on; it cooks all food here and melts butter_1."),
        ("adding_chemicals_to_lawn", "- fertilizer__atomizer_1 always holds fertilizer_1."),
        ("setting_mousetraps", "- floor_1 is the floor of sink_1 and cabinet_1."),
    ],
)
def test_a_prompt_without_a_fact_that_the_gold_plan_needs_is_noticed(
    fetched: Source, task_id: str, line: str
) -> None:
    benchmark = find_benchmark("behavior-1k")
    task = benchmark.tasks(fetched)[task_id]
    text = own_prompt(Ability.ACTION_SEQUENCING, fetched)(benchmark, task)
    reader, plan = reader_of(benchmark, Ability.ACTION_SEQUENCING, task), gold_plan(benchmark, task)
    assert insufficiency(reader, text, task, plan) is None
    before, found, after = text.rpartition(f"{line}\n")
    assert found
    assert insufficiency(reader, before + after, task, plan) is not None


@pytest.mark.parametrize("prompts", SHORT)
@pytest.mark.parametrize(
    "line",
    [
        "- sink_1 gives water_1, while it is switched on.",
        "sink_1: fixed, container, fillable, toggleable, sink",
        "contains(disinfectant__bottle_1, disinfectant_1)",
    ],
)
def test_a_short_prompt_without_a_needed_line_is_noticed(
    fetched: Source, line: str, prompts: PromptSet
) -> None:
    benchmark = find_benchmark("behavior-1k")
    task = benchmark.tasks(fetched)["clean_a_baseball_glove"]
    question = own_prompts("behavior-1k", Ability.ACTION_SEQUENCING, fetched, prompts)[task.id].user
    reader, plan = reader_of(benchmark, Ability.ACTION_SEQUENCING, task), gold_plan(benchmark, task)
    assert insufficiency(reader, write_long_form(question), task, plan) is None
    before, found, after = question.rpartition(f"{line}\n")
    assert found
    assert insufficiency(reader, write_long_form(before + after), task, plan) is not None


def test_a_line_that_nobody_understands_is_noticed(fetched: Source) -> None:
    benchmark = find_benchmark("behavior-1k")
    task = benchmark.tasks(fetched)["cook_corn"]
    text = own_prompt(Ability.ACTION_SEQUENCING, fetched)(benchmark, task)
    reader = reader_of(benchmark, Ability.ACTION_SEQUENCING, task)
    with pytest.raises(ValueError, match="not understood: - sink_1 leaks"):
        reader.world(text.replace("- sink_1 gives", "- sink_1 leaks"))
