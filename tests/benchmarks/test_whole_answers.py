"""Answers from reports about other readers are read completely, or refused with reason and position."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict, Unreadable, Verdict
from eai.agents.rewards import TrlReward, compute_score, extract_answer
from eai.base.store import DataPackStore
from eai.benchmarks.names import TaskReference
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.reward import open_reward
from eai.tasks.source import Source

PLANS = Ability.ACTION_SEQUENCING
GOALS = Ability.GOAL_INTERPRETATION
OPERATORS = Ability.TRANSITION_MODELING
BOTTLING = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
WASHING = "27_2"
PLAN = (
    '{"WALK": ["soap"], "GRAB": ["soap"], "WALK": ["washing_machine"], '
    '"PUTBACK": ["soap", "washing_machine"]}'
)
TASK = f"virtualhome/action_sequencing/{WASHING}"


def score(store: DataPackStore, name: str, ability: Ability, task_id: str, text: str) -> Verdict:
    source = Source(store, planner=PlannerChoice.NONE)
    return open_suite(name, ability, source=source).score(task_id, text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('[{"WALK": ["soap"]}, {"GRAB": ["soap"]}, {"WALK": ["washi', "as if the answer were cut off"),
        (
            '[{"WALK":["soap"]},{"GRAB":["soap"},{"WALK":["washing_machine"]}]',
            "line 1, column 35: this } does not close the [ of line 1, column 28",
        ),
        (f"<think>I could do {PLAN}", "the reasoning is never closed"),
        (f"{PLAN}\nGRAB soap", "'GRAB soap' looks like a part of the answer"),
        (
            '{"WALK": ["soap"], "why": ["it is far"], "steps": [{"GRAB": ["soap"]}]}',
            "there is no object or list",
        ),
        ("[]", "the plan has no steps, and not all goals hold at the start"),
        (
            'K": ["soap"]}, {"GRAB": ["soap"]}]',
            "line 1, column 13: no opening bracket of a list matches this",
        ),
        (r'\boxed{{"WALK": ["soap"]}, {"GRAB": ["soap"]}}', "the parts need a list around them"),
        ('{"plan": {"WALK": ["soap"]}, "rest": "then GRAB soap"}', "there is no object or list"),
        (
            '["soap"]}, {"GRAB": ["soap"]}, {"WALK": ["washing_machine"]}]',
            "the parts need a list around them",
        ),
        ('{"WALK": ["soap"]}, "GRAB": ["soap"]}', "looks like a part of the answer"),
        (f'{PLAN}\nAlso add "SWITCHON": ["washing_machine"].', "looks like a part of the answer"),
        (f"{PLAN}\nFinally, SWITCHON(washing_machine)", "looks like a part of the answer"),
        (
            f'{PLAN}\nand then:\n{{"OPEN": ["washing_machine"], "CLOSE": ["washing_machine"]}}',
            "stands outside",
        ),
        (f'Option A: {PLAN}\nOption B: {{"WALK": ["soap"], "GRAB": ["soap"]}}', "stands outside"),
        ('[{"WALK": ["soap"]}] + [{"GRAB": ["soap"]}]', "stands outside"),
        ('{"W\\ALK": ["soap"]}\n{"GRAB": ["soap"]}', "line 1, column 1"),
        ('{"WALK": ["soap"]}\n{"GRAB": ["soap"]}\n{S"WITCHON": ["soap"]}', "line 3, column 1"),
        (
            '[{"action": "WALK", "object": "soap", "step": {"action": "GRAB", "object": "soap"}}]',
            'step 1 has the unknown key "step"',
        ),
        ("WALK(soap)\nGRAB(soap)\nWAL", "line 3 is no step of a plan"),
        ("WALK(soap)\nGRAB(soap)\n...", "line 3 is no step of a plan"),
        ("W'ALK(soap)\nGRAB(soap)", "line 1 is no step of a plan"),
        ("1. WALK(soap)\n2. GRAB(soap)\n3.", "line 3: a list number stands without its step"),
        ("1. WALK(soap)\n2. GRAB(soap)\n3", "line 3 is no step of a plan"),
        ("9)\nWALK(soap)\nGRAB(soap)", "line 1: a list number stands without its step"),
        ("1. WALK(soap)\n3. GRAB(soap)", "line 1: the numbers of the steps have a gap"),
    ],
)
def test_an_incomplete_plan_is_a_parsing_error(data_store: DataPackStore, text: str, reason: str) -> None:
    verdict = score(data_store, "virtualhome", PLANS, WASHING, text)
    assert verdict.error is not None
    assert verdict.error.kind.value == "parsing"
    assert reason in verdict.error.detail


@pytest.mark.parametrize(
    ("name", "ability", "task_id", "text", "repairs"),
    [
        ("virtualhome", PLANS, WASHING, '[{"WALK":["soap"]},{"GRAB":"soap"}]', ("step_form",)),
        (
            "virtualhome",
            PLANS,
            WASHING,
            '[{"WALK":["soap"]},{"action":"GRAB","object":"soap"}]',
            ("step_form",),
        ),
        ("virtualhome", PLANS, WASHING, '{"WALK": ["soap",], "GRAB": ["soap"]}', ("trailing_comma",)),
        ("virtualhome", PLANS, WASHING, '[{"WALK": ["soap.1002"]}]', ()),
        ("virtualhome", PLANS, WASHING, '[{"WALK": ["soap.1002"]}, {"GRAB": ["soap", "1002"]}]', ()),
        (
            "virtualhome",
            PLANS,
            WASHING,
            '{"WALK": ["soap"], "GRAB": ["soap"]}\n\nNote: every step has the form {"ACTION": ["object"]}.',
            ("prose",),
        ),
        (
            "behavior",
            PLANS,
            BOTTLING,
            '{"thoughts": "first", "plan": [{"action":"OPEN","object":"fridge_97"}]}',
            ("wrapper_key",),
        ),
        ("behavior", PLANS, BOTTLING, '[{"action":"OPEN","object":"fridge_97"},]', ("trailing_comma",)),
        ("behavior", PLANS, BOTTLING, '[{"action":"OPEN","object":"fridge.97"}]', ()),
        (
            "behavior",
            PLANS,
            BOTTLING,
            '{"action":"OPEN","object":"fridge_97"}\n{"action":"CLOSE","object":"fridge_97"}',
            ("json_lines",),
        ),
        (
            "virtualhome",
            GOALS,
            WASHING,
            '{"node goals": [{"name": "washing_machine", "state": "ON"},], "edge goals": []}',
            ("trailing_comma",),
        ),
        (
            "virtualhome",
            GOALS,
            WASHING,
            '{"node_goals": [{"name": "washing_machine.1000", "state": "ON"}]}',
            ("section_name",),
        ),
        (
            "virtualhome",
            OPERATORS,
            WASHING,
            '{"output": "(:action grab :parameters (?char - character ?obj - object) '
            ':precondition (next_to ?char ?obj) :effect (holds_rh ?char ?obj))"}\n'
            'The form is {"output": "..."}.',
            ("prose",),
        ),
    ],
)
def test_an_answer_in_another_form_is_read_completely(
    data_store: DataPackStore, name: str, ability: Ability, task_id: str, text: str, repairs: tuple[str, ...]
) -> None:
    verdict = score(data_store, name, ability, task_id, text)
    assert verdict.error is None
    assert verdict.repairs == repairs


@pytest.mark.parametrize(
    "words",
    [
        "{}\nThen `OPEN` is not needed.",
        "{}\nAlso OPEN was unnecessary.",
        'The meaning of "WALK": move near.\n{}',
        '{{"activity": "Walk", "plan": {}}}',
        'Option 1: {{"WALK": ["sink"], "FIND": ["sink"]}}\nOption 2: {{"FIND": ["soap"], "GRAB": ["soap"]}}\n'
        "Final answer:\n{}",
        '{{"WALK": ["soap"], "GRAB": ["soap"],}}\nor\n{}',
    ],
)
def test_words_about_actions_are_no_steps(data_store: DataPackStore, words: str) -> None:
    plan = '{"WALK": ["soap"], "GRAB": ["soap"]}'
    verdict = score(data_store, "virtualhome", PLANS, WASHING, words.format(plan))
    alone = score(data_store, "virtualhome", PLANS, WASHING, plan)
    assert isinstance(verdict, PlanVerdict)
    assert isinstance(alone, PlanVerdict)
    assert (verdict.error, verdict.goals_satisfied) == (None, alone.goals_satisfied)
    assert any(alone.goals_satisfied)


@pytest.mark.parametrize(
    ("text", "last"),
    [
        ('["lamp"] is the object.\n{"node goals": [{"name": "lamp", "state": "on"}]}', "on"),
        (
            '{"node goals": [{"name": "washing_machine", "state": "ON"}]}\nCorrection:\n'
            '{"node goals": [{"name": "washing_machine", "state": "SWITCHED_ON"}]}',
            "SWITCHED_ON",
        ),
        ('{"node goals": [{"name": "lamp", "state": "ON"}]}\nFinal answer:\n{"node goals": []}', None),
    ],
)
def test_a_final_answer_counts_even_if_it_names_nothing_known(
    data_store: DataPackStore, text: str, last: str | None
) -> None:
    suite = open_suite("virtualhome", GOALS, source=Source(data_store))
    assert suite.score(WASHING, text).error is None
    written = suite.benchmark.notation.goals.read(text)
    assert not isinstance(written, Unreadable)
    assert [goal.predicate for goal in written.goals] == ([last] if last else [])


def test_a_misspelt_section_of_goals_is_read_or_named_in_the_error(data_store: DataPackStore) -> None:
    goal = '[{"name": "washing_machine", "state": "ON"}]'
    right = score(data_store, "virtualhome", GOALS, WASHING, f'{{"node goals": {goal}}}')
    assert (
        score(data_store, "virtualhome", GOALS, WASHING, f'{{"NODE-GOALS": {goal}}}').counts == right.counts
    )  # type: ignore[attr-defined]
    unknown = score(data_store, "virtualhome", GOALS, WASHING, f'{{"knot goals": {goal}, "edge goals": []}}')
    assert unknown.error is not None
    assert unknown.error.detail.endswith('there is no section "knot goals"')


DOMAIN = """(define (domain two) (:requirements :strips) (:predicates (p ?x) (r ?x))
 (:action mk :parameters (?x) :precondition () :effect (p ?x))
 (:action un :parameters (?x) :precondition (p ?x) :effect (r ?x)))"""


@pytest.mark.parametrize(
    ("initial", "text", "success", "kind"),
    [
        ("(r a)", "; cost = 0 (unit cost)\n", True, None),
        ("(r a)", "[]", True, None),
        ("(r a)", "", False, "parsing"),
        ("", "[]", False, "parsing"),
        ("", "(mk a)\nun a", False, "parsing"),
        ("", "Step 1:\n(mk a)\nStep 2:\n(un a)", True, None),
        ("", "(mk a)\n(un a", False, "parsing"),
    ],
)
def test_a_pddl_plan_is_read_line_by_line(
    tmp_path: Path, initial: str, text: str, success: bool, kind: str | None
) -> None:
    (tmp_path / "domain.pddl").write_text(DOMAIN)
    problem = f"(define (problem q) (:domain two) (:objects a b) (:init {initial}) (:goal (r a)))"
    (tmp_path / "q.pddl").write_text(problem)
    reference = f"pddl:{tmp_path / 'domain.pddl'},{tmp_path / 'q.pddl'}"
    verdict = open_suite(reference, PLANS).score("q", text)
    assert isinstance(verdict, PlanVerdict)
    assert verdict.success is success
    assert (verdict.error.kind.value if verdict.error else None) == kind


@pytest.mark.parametrize("text", [f"<think>I could do {PLAN}", f"{PLAN}\n<think>or not</think>", PLAN])
def test_scores_and_rewards_of_trainers_use_the_same_answer_text(
    data_store: DataPackStore, text: str
) -> None:
    reference = TaskReference.parse(TASK)
    paid = open_reward(reference, "progress").grade(reference.task_id, text).value
    assert TrlReward("progress")(completions=[text], task=[TASK]) == [paid]
    assert compute_score("", text, TASK, shaping="progress")["score"] == paid
    parts = [[{"role": "assistant", "content": [{"type": "text", "text": text}]}]]
    assert TrlReward("progress")(completions=parts, task=[TASK]) == [paid]


def test_the_answer_is_the_text_of_a_message_or_of_its_parts() -> None:
    assert (
        extract_answer([{"role": "assistant", "content": [{"type": "image"}, {"type": "text", "text": "a"}]}])
        == "a"
    )
    assert extract_answer([{"role": "assistant", "content": None}]) == ""
    with pytest.raises(TypeError, match="not int"):
        extract_answer([{"role": "assistant", "content": 3}])
