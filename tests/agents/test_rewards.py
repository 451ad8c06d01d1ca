"""Reward functions for training libraries, called as those libraries call them."""

from __future__ import annotations

import ast
import inspect
import pickle
import subprocess
import sys
from collections.abc import Callable
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import eai
from eai import Ability
from eai.abilities.protocol import PAPER_ABILITIES
from eai.agents.rewards import (
    SkyRlTask,
    TrlEnvironment,
    TrlReward,
    compute_score,
    extract_answer,
    reward_func,
)
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.reward import METRICS

HOUSEHOLDS = ("virtualhome", "behavior")
ABILITIES = [(name, ability) for name in HOUSEHOLDS for ability in PAPER_ABILITIES]
PROMPT = "<|im_start|>user\nWash the clothes.<|im_end|>\n<|im_start|>assistant\n"


@pytest.fixture(autouse=True)
def there(data_store: DataPackStore) -> None:
    """Skip the tests of this module if the households' data is missing."""


@cache
def gold(name: str, ability: Ability) -> tuple[str, str]:
    """Return a task with something to earn, by its name, and its gold answer."""
    suite = eai.open(name, ability)
    book = open_gold_answers(suite.benchmark, ability)
    task_id = suite.task_ids[3]
    return suite.reference(task_id), book[task_id].text


@pytest.mark.parametrize(
    ("completion", "answer"),
    [
        ("[1]", "[1]"),
        ("<think>[2]</think>[1]", "[1]"),
        ("[2]</think>[1]", "[1]"),
        ("<think>a</think><think>b</think>[1]", "[1]"),
        ("<think>[2], or rather", ""),
        ("", ""),
        ([], ""),
        ([{"role": "assistant", "content": "[1]"}], "[1]"),
        ([{"role": "assistant", "content": "[2]"}, {"role": "assistant", "content": None}], ""),
        ([{"role": "assistant", "tool_calls": []}], ""),
        ([{"content": "[1]"}], "[1]"),
        ([{"role": "assistant", "content": "?"}, {"role": "tool", "content": "such as [1]"}], ""),
    ],
)
def test_thoughts_are_not_part_of_an_answer(completion: Any, answer: str) -> None:
    assert extract_answer(completion) == answer


@pytest.mark.parametrize(
    ("completion", "message"),
    [
        (3, "expected an output as text or list of messages, not int"),
        (b"[1]", "expected an output as text or list of messages, not bytes"),
        ({"role": "assistant", "content": "[1]"}, "expected an output as text or list of messages, not dict"),
        (["[1]"], "expected a message as a mapping with role and content, not str"),
        ([[{"content": "[1]"}]], "expected a message as a mapping with role and content, not list"),
        ([{"content": 3}], "expected the content of a message as text or parts, not int"),
        ([{"content": b"[1]"}], "expected the content of a message as text or parts, not bytes"),
    ],
)
def test_an_output_of_another_form_is_an_error_of_the_trainer(completion: Any, message: str) -> None:
    with pytest.raises(TypeError) as error:
        extract_answer(completion)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("pay", "lengths"),
    [
        (lambda: TrlReward()(completions=["[]"], task=["a", "b"]), "2 task, 1 completions"),
        (lambda: TrlReward()(completions=["[]"], task="lamps"), "5 task, 1 completions"),
        (lambda: reward_func(["p"], ["p"], ["a", "b"]), "1 queries, 1 prompts, 2 labels"),
        (
            lambda: eai.Reward(eai.open("virtualhome", "action_sequencing")).batch(["27_2"], []),
            "1 task_ids, 0 texts",
        ),
    ],
)
def test_a_batch_with_unequal_lengths_names_them(pay: Callable[[], object], lengths: str) -> None:
    message = f"^expected lists with one item for each answer, so of equal length; found {lengths}$"
    with pytest.raises(ValueError, match=message):
        pay()


def test_an_output_that_is_none_is_an_empty_answer() -> None:
    assert extract_answer(None) == ""


@pytest.mark.parametrize("task", [None, 27, ["27_2"]])
def test_a_reference_that_is_no_text_is_an_error(task: Any) -> None:
    with pytest.raises(eai.InputError, match="is not a task: expected BENCHMARK/ABILITY/TASK"):
        TrlReward()(completions=["[]"], task=[task])


@pytest.mark.parametrize("answer", [None, 3, b"[]", [{"role": "assistant", "content": "[]"}]])
def test_an_answer_that_is_no_text_is_no_wrong_answer(answer: Any) -> None:
    suite = eai.open("virtualhome", "action_sequencing")
    reward = eai.Reward(suite, "progress")
    for score in (suite.score, reward, reward.grade):
        with pytest.raises(eai.InputError, match="expected an answer to 27_2 as a text, found "):
            score("27_2", answer)


@pytest.mark.parametrize("command", [None, 3, ["WALK", "soap"], b"WALK(soap)"])
def test_a_command_that_is_no_text_is_a_wrong_action(command: Any, caplog: pytest.LogCaptureFixture) -> None:
    household = TrlEnvironment()
    household.reset(task="virtualhome/action_sequencing/27_2")
    assert household.act(command).startswith(("Failed (parsing): ", "Failed (hallucination): "))
    assert not caplog.records


@pytest.mark.parametrize(("name", "ability"), ABILITIES)
def test_every_library_pays_the_same(name: str, ability: Ability) -> None:
    task, text = gold(name, ability)
    for answer, worth in ((text, 1), ("I do not know.", 0)):
        message = [{"role": "assistant", "content": answer}]
        assert TrlReward("goals")(completions=[message, answer], task=[task, task]) == [worth, worth]
        scored = compute_score("eai", answer, task, {}, shaping="goals")
        assert scored["score"] == worth
        asked = [f"{PROMPT}{answer}<|im_end|>\n"], [PROMPT], [task]
        paid = reward_func(*asked, shaping="goals")
        assert (paid["rewards"], paid["scores"]) == (worth, worth)
        assert paid["extra_logs"].pop("prompt_not_found") == 0
        assert {**scored, "score": 0} == {"score": 0, **paid["extra_logs"]}
        stepped = SkyRlTask(None, {"reward_spec": {"ground_truth": task}, "shaping": "goals"}).step(answer)
        assert (stepped["reward"], stepped["done"], stepped["metadata"]) == (worth, True, paid["extra_logs"])


def test_an_answer_of_many_blanks_is_read_at_once() -> None:
    """Each blank used to be compared with all later ones, which took minutes."""
    name, ability = ABILITIES[0]
    task, _ = gold(name, ability)
    asked = [f"{PROMPT}I{' ' * 400_000}see<|im_end|>\n"], [PROMPT], [task]
    assert reward_func(*asked)["rewards"] == 0


def test_a_task_that_cannot_be_earned_has_no_reward_or_zero() -> None:
    suite = eai.open("virtualhome", "action_sequencing")
    task = suite.reference(next(i for i in suite.task_ids if not suite.tasks[i].goals))
    assert TrlReward()(completions=["{}"], task=[task]) == [None]
    assert compute_score("eai", "{}", task)["score"] == 0
    assert reward_func([PROMPT], [PROMPT], [task])["rewards"] == 0


def test_several_answers_of_openrlhf_come_as_lists() -> None:
    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    paid = reward_func([f"{PROMPT}{text}", PROMPT], [PROMPT] * 2, [task] * 2)
    assert paid["rewards"] == [1, 0]
    assert paid["extra_logs"]["fault.parsing"] == [0, 1]


def test_an_answer_of_openrlhf_follows_the_first_occurrence_of_the_prompt() -> None:
    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    assert reward_func([text], [""], [task])["rewards"] == 1
    assert reward_func([f"<s>{PROMPT}{text}"], [PROMPT], [task])["rewards"] == 1
    thought = f"{PROMPT}<think>I was asked: {PROMPT}{text}"
    assert reward_func([thought], [PROMPT], [task])["rewards"] == 0


def test_a_query_without_its_prompt_earns_nothing_and_is_counted() -> None:
    """The decoded query differs from the prompt, so the answer cannot be separated."""
    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    prompt = f"Answer  as this one does: {text}\n"
    decoded = prompt.replace("  ", " ")
    with pytest.warns(UserWarning, match="1 of 2 queries do not contain their prompt: their reward is 0"):
        paid = reward_func([decoded, f"{prompt}{text}"], [prompt] * 2, [task] * 2)
    assert (paid["rewards"], paid["scores"]) == ([0, 1], [0, 1])
    assert paid["extra_logs"]["prompt_not_found"] == [1, 0]
    with pytest.warns(UserWarning, match="1 of 1"):
        paid = reward_func([f"{decoded}{text}"], [prompt], [task])
    assert (paid["rewards"], paid["extra_logs"]["prompt_not_found"]) == (0, 1)


def test_trl_is_told_the_metrics() -> None:
    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    told: dict[str, float] = {}
    TrlReward()(completions=[text, "?"], task=[task] * 2, log_metric=told.__setitem__)
    assert tuple(told) == tuple(f"eai/{metric}" for metric in METRICS)
    assert (told["eai/success"], told["eai/fault.parsing"]) == (0.5, 0.5)


def test_processes_pay_the_same_in_order_with_the_same_metrics() -> None:
    golds = [gold(name, Ability.ACTION_SEQUENCING) for name in HOUSEHOLDS]
    pairs = [(task, answer) for task, text in golds * 2 for answer in (text, "?", f"<think>{text}</think>")]
    tasks, answers = zip(*pairs, strict=True)
    told: list[dict[str, float]] = [{}, {}]
    with eai.Scoring(workers=2) as scoring:
        paid = [
            TrlReward("goals", pool)(completions=answers, task=tasks, log_metric=metrics.__setitem__)
            for pool, metrics in zip((None, scoring), told, strict=True)
        ]
    assert paid[0] == paid[1] == [1, 0, 0] * 4
    assert told[0] == told[1]


def test_a_reward_of_trl_has_a_name_and_is_pickled() -> None:
    paid = pickle.loads(pickle.dumps(TrlReward("diagnosis")))  # noqa: S301 - its own bytes
    assert (paid, paid.__name__) == (TrlReward("diagnosis"), "eai_diagnosis")


COLUMNS = ("prompts", "completions", "completion_ids", "task")
GIVEN = ("trainer_state", "log_extra", "log_metric", "environments")
"""Arguments that TRL 1.16 passes to a reward function."""


def test_all_arguments_of_trl_are_accepted() -> None:
    inspect.signature(TrlReward()).bind(**dict.fromkeys((*COLUMNS, *GIVEN)))


def test_the_installed_trl_passes_the_known_arguments() -> None:
    """The arguments are read from TRL's code, because importing it needs a GPU library."""
    found = find_spec("trl")
    if found is None or found.origin is None:
        pytest.skip("trl is not installed")
    source = Path(found.origin).with_name("trainer") / "grpo_trainer.py"
    calls, given = [], set()
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        match node:
            case ast.Call(func=ast.Name(id="reward_func"), args=[], keywords=keywords):
                calls.append({keyword.arg for keyword in keywords})
            case ast.Assign(targets=[ast.Subscript(ast.Name(id="reward_kwargs"), ast.Constant(name))]):
                given.add(name)
    assert {"prompts", "completions", "completion_ids", None} in calls
    assert given == set(GIVEN)


def test_a_household_of_trl_is_won_action_by_action() -> None:
    """The environment has the members that TRL needs, and each tool describes its arguments."""
    members = inspect.getmembers(TrlEnvironment, predicate=inspect.isfunction)
    assert [name for name, _ in members if not name.startswith("_")] == ["act", "get_reward", "reset"]
    assert "Args:\n    command: " in (inspect.getdoc(TrlEnvironment.act) or "")
    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    suite = eai.open("behavior", "action_sequencing")
    plan = suite.benchmark.notation.plans.read(text)
    household = partial(TrlEnvironment, "progress")()
    opening = household.reset(task=task, prompt=[])
    assert suite.tasks[task.rpartition("/")[2]].instruction in opening
    assert household.get_reward() == 0
    assert "Failed (parsing)" in household.act("I sit down.")
    for step in plan.steps:
        household.act(f"{step.action}({', '.join(map(str, step.objects))})")
    assert household.get_reward() == 1
    assert household.act("I wave.") == "The episode is over."
    household.reset(task=task)
    assert household.get_reward() == 0


def test_a_task_of_skyrl_is_mixed_into_its_base_class() -> None:
    class Base:
        """A stand-in for the base class of SkyRL."""

        def __init__(self) -> None:
            self.turns = 0

    class Household(SkyRlTask, Base):
        pass

    task, text = gold("behavior", Ability.ACTION_SEQUENCING)
    household = Household(extras={"reward_spec": {"method": "rule", "ground_truth": task}})
    assert household.turns == 0
    assert household.get_metrics() == {}
    assert household.step(text)["reward"] == 1
    assert household.get_metrics()["success"] == 1


def test_no_library_is_imported() -> None:
    code = (
        "import sys, eai.agents.rewards; "
        "print([name for name in ('trl', 'verl', 'openrlhf', 'skyrl_gym', 'torch') if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
