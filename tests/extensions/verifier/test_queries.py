"""Queries return the verdicts, plans and effects that the library computes, and refuse wrong calls."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

import eai
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.extensions.verifier.queries import answer_query
from eai.results.codec import dataclass_to_json, verdict_to_record_fields

WORLDS = Path(__file__).parents[2] / "worlds"
SOLUTIONS = {
    "blocks": ("(unstack b a)", "(stack b c)", "(pick-up a)", "(stack a b)"),
    "briefcase": ("(put-in paper home)", "(move home office)", "(take-out paper)", "(move office home)"),
    "ferry": (
        *("(board big home)", "(sail home north)", "(debark big north)"),
        *("(board red north)", "(sail north south)", "(debark red south)"),
    ),
    "gate": ("(distract)", "(unlock)", "(push)", "(enter)"),
}
NAMES = (*SOLUTIONS,)
NONSENSE = (
    "",
    "(",
    "(fly away)",
    "I would rather not.",
    '[{"action": 3}]',
    "(pick-up)",
    "\0",
    "(pick-up a a a a)",
)


def refer_to(name: str) -> str:
    return f"pddl:{WORLDS / name}.pddl,{WORLDS / name}-1.pddl"


def open_world(name: str) -> Suite:
    return eai.open(refer_to(name), "action_sequencing")


def draw_action(suite: Suite, task: str, draw: random.Random) -> str:
    """Return the text of a random action. Most are impossible in the initial state."""
    operator = draw.choice(suite.benchmark.domain.operators)
    names = [thing.name for thing in suite.tasks[task].scene.objects]
    return f"({' '.join([operator.name, *draw.choices(names, k=len(operator.parameters))])})"


def draw_plan(suite: Suite, task: str, draw: random.Random) -> str:
    """Return a random plan: nonsense, random actions, or the beginning of a solution and random actions."""
    if draw.random() < 0.1:
        return draw.choice(NONSENSE)
    steps = SOLUTIONS[suite.domain]
    start = steps[: draw.randint(0, len(steps))]
    return "\n".join([*start, *[draw_action(suite, task, draw) for _ in range(draw.randint(0, 2))]])


def draw_call(name: str, draw: random.Random) -> tuple[Suite, dict[str, str]]:
    suite = open_world(name)
    task = suite.task_ids[0]
    return suite, {"benchmark": refer_to(name), "task": task, "plan": draw_plan(suite, task, draw)}


def test_1000_random_calls_equal_the_verdicts_of_the_library() -> None:
    draw, successes = random.Random(7), 0
    for number in range(1000):
        suite, call = draw_call(NAMES[number % len(NAMES)], draw)
        expected = suite.score(call["task"], call["plan"])
        successes += expected.success
        assert answer_query("check_plan", call) == verdict_to_record_fields(expected)
    assert 50 < successes < 950


def test_random_explanations_equal_those_of_the_library() -> None:
    draw, repaired = random.Random(8), 0
    for number in range(60):
        suite, call = draw_call(NAMES[number % len(NAMES)], draw)
        result = {**answer_query("explain_plan", call)}
        repaired += result.pop("repair", None) is not None
        explanation = suite.assess(call["task"], call["plan"]).explain()
        assert result.pop("explanation") == dataclass_to_json(explanation)
        assert result == verdict_to_record_fields(suite.score(call["task"], call["plan"]))
    assert repaired > 10


@pytest.mark.parametrize("name", NAMES)
def test_a_found_plan_succeeds(name: str) -> None:
    suite = open_world(name)
    result = answer_query("plan", {"benchmark": refer_to(name), "task": suite.task_ids[0]})
    assert result["success"]
    assert suite.score(suite.task_ids[0], str(result["plan"])).success


def test_a_task_without_a_plan_gets_the_reason(tmp_path: Path) -> None:
    problem = tmp_path / "locked.pddl"
    problem.write_text("(define (problem locked) (:domain gate) (:init) (:goal (and (locked) (inside))))")
    call = {"benchmark": f"pddl:{WORLDS}/gate.pddl,{problem}", "task": "locked"}
    assert answer_query("plan", call) == {"plan": None, "why_none": "no plan exists"}


def test_predictions_equal_the_last_step_of_an_explained_plan() -> None:
    draw, outcomes = random.Random(9), set()
    for number in range(200):
        suite = open_world(NAMES[number % len(NAMES)])
        task = suite.task_ids[0]
        steps = SOLUTIONS[suite.domain]
        after = steps[: draw.randint(0, len(steps) - 1)]
        action = draw.choice([draw_action(suite, task, draw), *steps])
        call = {"benchmark": refer_to(NAMES[number % len(NAMES)]), "task": task, "action": action}
        result = answer_query("predict", call | {"after": "\n".join(after)})
        last = suite.assess(task, "\n".join([*after, action])).explain().steps[-1]
        assert result == dataclass_to_json(last)
        outcomes.add(result["outcome"])
    assert len(outcomes) > 2


BLOCKS = {"benchmark": refer_to("blocks"), "task": "swap"}


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("fly", {}, "there is no tool 'fly': expected one of check_plan, explain_plan, plan, predict"),
        ("plan", {"task": "x"}, "plan needs the argument 'benchmark'"),
        ("plan", {"benchmark": 3, "task": "x"}, "benchmark: expected a text, found int"),
        ("plan", {**BLOCKS, "tusk": "x"}, "plan has no argument 'tusk'; did you mean task?"),
        ("plan", {**BLOCKS, "task": "moon"}, "blocks action_sequencing has no task 'moon'"),
        ("predict", {**BLOCKS, "action": ""}, "action: "),
        ("predict", {**BLOCKS, "action": "(fly)"}, "action: "),
        ("plan", {"benchmark": "kitchens", "task": "x"}, "'kitchens' is not a benchmark"),
        ("plan", {"benchmark": "os:system", "task": "x"}, "Python objects are refused"),
        ("plan", {"benchmark": "obfuscated:os:system", "task": "x"}, "Python objects are refused"),
        ("plan", {"benchmark": "pddl:/none.pddl,/none.pddl", "task": "x"}, "/none.pddl"),
    ],
)
def test_a_wrong_call_gets_a_message(name: str, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        answer_query(name, arguments)
    assert message in str(caught.value)


def test_a_malformed_plan_is_a_failed_verdict() -> None:
    for plan in NONSENSE:
        suite = open_world("blocks")
        result = answer_query("check_plan", {**BLOCKS, "task": suite.task_ids[0], "plan": plan})
        assert not result["success"]
        assert result["error"] is not None


@pytest.mark.parametrize("prefix", ["", "obfuscated:"])
def test_a_task_file_cannot_run_the_module_of_its_base(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, prefix: str
) -> None:
    (tmp_path / "evil.py").write_text("raise SystemExit('this module was imported')")
    line = {
        "base": "evil:BENCHMARK",
        "id": "a",
        "instruction": "a",
        "objects": {},
        "facts": {},
        "goals": ["a"],
    }
    (tmp_path / "tasks.jsonl").write_text(f"{json.dumps(line)}\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"the import calls sys\.exit\('this module was imported'\)"):
        eai.find_benchmark(f"{prefix}tasks.jsonl")
    with pytest.raises(InputError, match=r"'evil:BENCHMARK'.*Python objects are refused"):
        answer_query("plan", {"benchmark": f"{prefix}tasks.jsonl", "task": "a"})
