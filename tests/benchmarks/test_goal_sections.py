"""Goal sections of official prompts, and prompts with other goals."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from eai.abilities.notation.goal_lexicon import read_stated_goals
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.tasks.prompts.prompt import BelievedTask, GoalSection
from eai.tasks.source import Source
from eai.tasks.task import Task
from oracle import PIPELINE_MODELS, Oracle
from suites import official_prompts
from sweeps import examples

STAGE_TWO = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"


def make_belief(answer: str, task: Task, benchmark: Benchmark) -> BelievedTask:
    read = read_stated_goals(answer, task, benchmark.domain, benchmark.notation.goals)
    return BelievedTask(replace(task, goals=read.goals), answer)


def find_section(section: GoalSection, question: str) -> str:
    """Return the text of a question that a goal section replaces."""
    start = question.rindex(section.before) + len(section.before)
    return question[start : question.index(section.after, start)]


def test_true_goals_reproduce_the_plan_prompts_of_virtualhome(
    virtualhome_tasks: VirtualHomeTasks, data_store: DataPackStore
) -> None:
    """One published prompt states a relation twice."""
    section = find_benchmark("virtualhome").data.goal_sections[Ability.ACTION_SEQUENCING]
    prompts = dict(official_prompts("virtualhome", Ability.ACTION_SEQUENCING, data_store))
    twice = "character is FACING to phone\n"
    assert prompts["540_1"].user.count(twice) == 2
    prompts["540_1"] = replace(prompts["540_1"], user=prompts["540_1"].user.replace(twice, "", 1))
    assert len(prompts) == 342
    for task_id, prompt in prompts.items():
        assert (
            section.replace_goals_in_question(prompt.user, BelievedTask(virtualhome_tasks[task_id], ""))
            == prompt.user
        )


def test_true_goals_reproduce_the_subgoal_prompts_of_virtualhome(
    virtualhome_tasks: VirtualHomeTasks, data_store: DataPackStore
) -> None:
    """In 21 published prompts, relations have the order of a Python set."""
    section = find_benchmark("virtualhome").data.goal_sections[Ability.SUBGOAL_DECOMPOSITION]
    prompts = official_prompts("virtualhome", Ability.SUBGOAL_DECOMPOSITION, data_store)
    reordered = 0
    for task_id, prompt in prompts.items():
        published = find_section(section, prompt.user)
        ours = section.write(BelievedTask(virtualhome_tasks[task_id], ""))
        reordered += published != ours
        assert sorted(published.splitlines()) == sorted(ours.splitlines())
    assert (len(prompts), reordered) == (338, 21)


@pytest.mark.parametrize("model", PIPELINE_MODELS)
def test_models_goals_reproduce_the_published_goal_sections(
    model: str, oracle: Oracle, behavior_tasks: BehaviorTasks, data_store: DataPackStore
) -> None:
    """The goals come from the authors' files, and from the model's answers.

    Left out are one task, whose prompt is of another demonstration, and one answer without goals.
    """
    section = find_benchmark("behavior").data.goal_sections[Ability.SUBGOAL_DECOMPOSITION]
    prompts = official_prompts("behavior", Ability.SUBGOAL_DECOMPOSITION, data_store)
    answers = {
        row["identifier"]: row["response"]
        for row in oracle("behavior", "goal_interpretation", model)["records"]
    }
    rows = oracle("behavior", "pipeline_subgoal_decomposition", model)["tasks"]
    rows_with_section = [row for row in rows if row["goal_section"] is not None]
    assert len(rows_with_section) == (98 if model == "cohere-command-r" else 99)
    for row in rows_with_section:
        task_id = row["identifier"]
        for answer in (json.dumps(row["goals_used"]), answers[task_id]):
            question = section.replace_goals_in_question(
                prompts[task_id].user, BelievedTask(behavior_tasks[task_id], answer)
            )
            assert find_section(section, question) == row["goal_section"]


@pytest.mark.parametrize(
    ("entry", "plan", "subgoal"),
    [
        (["Open", "jar.n.01_1"], "['open', 'jar_0']", "open(jar.0)"),
        (["not", ["open", "jar.n.01_1"]], "['not', 'open', 'jar_0']", "not open(jar.0)"),
        (["ToggledOn", "jar.n.01_1"], "['toggled_on', 'jar_0']", "toggledon(jar.0)"),
        (
            ["forall", ["jar.n.01", "-", "jar.n.01"], ["not", ["open", "jar.n.01"]]],
            "['forall', 'jar.n.01', '-', 'jar.n.01', 'not', 'open', 'jar.n.01']",
            "forall(jar_n_01, (not open(jar_n_01)))",
        ),
        (
            ["fornpairs", ["2"], ["?jar.n.01", "-", "jar.n.01"], "sky", ["inside", "sky", "jar.n.01"]],
            "['fornpairs', '2', 'jar.n.01', '-', 'jar.n.01', 'sky', 'inside', 'sky', 'jar.n.01']",
            "fornpairs(2, jar_n_01, sky, inside(sky, jar_n_01))",
        ),
        (
            ["or", ["and", ["open", "jar.n.01_1"], ["open", "jar.n.01_2"]], ["not", ["open", "jar.n.01_1"]]],
            "['or', 'and', 'open', 'jar_0', 'open', 'jar_1', 'not', 'open', 'jar_0']",
            "(open(jar.0) and open(jar.1)) or (not open(jar.0))",
        ),
        (["or", [["open", "jar.n.01_1"]]], "['or', 'open', 'jar_0']", "open(jar.0)"),
        (["on", "a.n.02_2", "jar.n.01_9"], "['on', 'a.n.02_2', 'jar.n.01_9']", "on(a_n_02.2, jar_n_01.9)"),
        (["next_to", "jar.n.01_1", "sky"], "['next_to', 'jar_0', 'sky']", "next.to(jar.0, sky)"),
        (["not", "open", "jar.n.01_1"], "['not', 'open', 'jar_0']", "not o(p, e, n)"),
    ],
)  # fmt: skip
def test_an_entry_of_an_answer_is_written_into_prompts(
    entry: object, plan: str, subgoal: str, behavior_tasks: BehaviorTasks
) -> None:
    sections = find_benchmark("behavior").data.goal_sections
    belief = BelievedTask(behavior_tasks[JARS], json.dumps({"edge goals": [entry], "node goals": []}))
    assert sections[Ability.ACTION_SEQUENCING].write(belief) == plan
    assert sections[Ability.SUBGOAL_DECOMPOSITION].write(belief) == subgoal


@pytest.mark.parametrize(
    "entry", [3, None, {}, [], [[]], ["not"], ["not", 3], ["and"], ["or", 3], ["open", 3], ["forall", []]]
)
def test_meaningless_entries_are_left_out_of_prompts(entry: object, behavior_tasks: BehaviorTasks) -> None:
    sections = find_benchmark("behavior").data.goal_sections
    answer = json.dumps({"node goals": [entry, ["open", "jar.n.01_1"]]})
    belief = BelievedTask(behavior_tasks[JARS], answer)
    assert sections[Ability.SUBGOAL_DECOMPOSITION].write(belief) == "open(jar.0)"
    assert sections[Ability.ACTION_SEQUENCING].write(belief).endswith("['open', 'jar_0']")


@pytest.mark.parametrize("name", ["behavior", "virtualhome"])
@pytest.mark.parametrize("ability", STAGE_TWO)
def test_replacing_goals_leaves_the_rest_of_a_prompt_unchanged(
    name: str, ability: Ability, data_store: DataPackStore
) -> None:
    """An unreadable answer gives an empty section."""
    benchmark = find_benchmark(name)
    tasks, section = benchmark.tasks(Source(data_store)), benchmark.data.goal_sections[ability]
    true = official_prompts(name, ability, data_store)
    beliefs = {task_id: make_belief("no idea", tasks[task_id], benchmark) for task_id in true}
    opened = PromptLibrary("official", None, Source(data_store)).open(benchmark, ability, beliefs)
    for task_id, prompt in true.items():
        before, after = prompt.user.rsplit(find_section(section, prompt.user), 1)
        question = opened[task_id]
        assert (question.system, question.stop) == (prompt.system, prompt.stop)
        assert question.user.startswith(before)
        assert question.user.endswith(after)
        assert find_section(section, question.user) == section.write(beliefs[task_id])


def test_our_prompts_state_the_believed_goals(
    behavior_tasks: BehaviorTasks, data_store: DataPackStore
) -> None:
    """The example in the prompt keeps the goals that its answer reaches."""
    benchmark = find_benchmark("behavior")
    library = PromptLibrary("eai", None, Source(data_store))
    answer = (
        '{"node goals": [["open", "jar.n.01_1"], ["not", "open", "jar.n.01_1"], ["shiny", "jar.n.01_3"]]}'
    )
    belief = make_belief(answer, behavior_tasks[JARS], benchmark)
    for ability, lines in (
        (Ability.ACTION_SEQUENCING, "open(jar_0)\nshiny(jar.n.01_3)"),
        (Ability.SUBGOAL_DECOMPOSITION, "open(jar.0)\nshiny(jar.n.01_3)"),
    ):
        plain = library.open(benchmark, ability)
        opened = library.open(benchmark, ability, {JARS: belief})
        assert {task_id for task_id in plain if plain[task_id] != opened[task_id]} == {JARS}
        before, _, after = opened[JARS].user.rpartition(lines)
        assert before.rpartition("Your task")[2] in plain[JARS].user
        assert plain[JARS].user.endswith(after)


def test_a_users_prompts_need_a_section_for_goals(
    behavior_tasks: BehaviorTasks, data_store: DataPackStore, tmp_path: Path
) -> None:
    benchmark, ability = find_benchmark("behavior"), Ability.SUBGOAL_DECOMPOSITION
    beliefs = {JARS: make_belief("", behavior_tasks[JARS], benchmark)}
    file = tmp_path / "behavior_subgoal_decomposition.json"
    rows = [{"identifier": JARS, "llm_prompt": "Mine.\n## Goal States\nx\n\n## Output"}]
    file.write_text(json.dumps(rows), encoding="utf-8")
    official = PromptLibrary("official", tmp_path, Source(data_store))
    assert official.open(benchmark, ability, beliefs)[JARS].user == "Mine.\n## Goal States\n\n\n## Output"
    with pytest.raises(
        InputError, match="lacks the goals or the scene that a model gave in an earlier answer"
    ):
        PromptLibrary("eai", tmp_path, Source(data_store)).open(benchmark, ability, beliefs)
    rows[0]["llm_prompt"] = "Mine."
    file.write_text(json.dumps(rows), encoding="utf-8")
    with pytest.raises(InputError, match="the prompt has no section of goals between"):
        official.open(benchmark, ability, beliefs)


WORDS = st.sampled_from(
    ["not", "or", "and", "forall", "forn", "open", "jar.n.01_1", "jar.n.01", "-", "", "?"]
)
ENTRIES = st.recursive(
    WORDS | st.none() | st.booleans() | st.integers(-1, 3) | st.dictionaries(WORDS, WORDS, max_size=1),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=12,
)


@given(st.lists(ENTRIES, max_size=3), st.sampled_from(["node goals", "edge goals", "action goals", "x"]))
@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(150), deadline=None
)
def test_any_answer_can_be_written_into_every_prompt(
    behavior_tasks: BehaviorTasks, virtualhome_tasks: VirtualHomeTasks, entries: list[object], key: str
) -> None:
    answer = json.dumps({key: entries})
    for name, task in (("behavior", behavior_tasks[JARS]), ("virtualhome", virtualhome_tasks["27_2"])):
        benchmark = find_benchmark(name)
        belief = make_belief(answer, task, benchmark)
        for ability, section in benchmark.data.goal_sections.items():
            section.write(belief)
            benchmark.wording(ability).describe_goals(belief.task)
