from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.attempt import AnswerUsage
from eai.abilities.declaration import get_declaration
from eai.abilities.explanation import AtomOrAction, GoalPartReport, GoalReport, StepReport, VerdictExplanation
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.transition_modeling.verdict import (
    OperatorComparisonStatus,
    OperatorReport,
    OperatorVerdict,
)
from eai.abilities.verdict import (
    AnswerSpan,
    AnswerSpanKind,
    ConfusionCounts,
    ErrorReport,
    PlanVerdict,
    SummaryCounts,
    Verdict,
)
from eai.base.errors import InputError
from eai.pddl.check import PddlFinding, PddlViolationKind
from eai.pddl.matching import ClauseComparison
from eai.pddl.planning import PlannerOutcome
from eai.results.codec import (
    COMMON_FIELDS,
    SCHEMA,
    hash_text,
    record_from_json,
    record_to_json,
    verdict_to_record_fields,
)
from eai.results.record import AnswerOrigin, Record
from eai.tasks.share import Share, TalliesByGoalKind
from eai.world.fault import FaultKind
from results.random_records import records

GOALS = TalliesByGoalKind(Share(1, 2), Share(0.5, 1), Share(0, 0))
PLAN = PlanVerdict(
    error=ErrorReport(
        FaultKind.WRONG_ORDER,
        3,
        "the character is not next to soap.1002",
        "the_character_is_not_next_to",
        ("soap.1002",),
    ),
    repairs=("code_fence", "single_quotes"),
    spans=(AnswerSpan(8, 40, AnswerSpanKind.REPAIRED),),
    executable=False,
    success=False,
    additional_steps=2,
    goals=GOALS,
    goals_satisfied=(True, False, False),
    counted=SummaryCounts(False, GOALS, {FaultKind.WRONG_ORDER: 1, FaultKind.ADDITIONAL_STEP: 2}),
)
SIDE = ClauseComparison(("closed",), ("near",), ("can_open",))
OPERATORS = OperatorVerdict(
    success=False,
    counts={"precondition": {"object_states": ConfusionCounts(1, 0, 2)}, "effect": {}},
    literals={"precondition": ConfusionCounts(2, 0, 3)},
    planner=PlannerOutcome.UNSOLVABLE,
    operators=(
        OperatorReport(
            "open",
            OperatorComparisonStatus.COMPARED,
            SIDE,
            offences=(PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, "near", "precondition"),),
        ),
    ),
)
HEAD = ("schema", "protocol", "domain", "ability", "model", "task_id", "response_sha256", "data_sha256")
FIRST = (*HEAD, "status", "excluded_reason", *COMMON_FIELDS, "repairs")


def record(verdict: Verdict, ability: Ability = Ability.ACTION_SEQUENCING) -> Record:
    return Record(Protocol.STRICT, "lamps", ability, "m", "27_2", '{"WALK": ["sofa"]}', "0" * 64, verdict)


@given(records())
def test_a_record_reads_as_it_was_written(written: Record) -> None:
    line = json.dumps(record_to_json(written))
    read = record_from_json(json.loads(line))
    assert read == written
    assert type(read.verdict) is type(written.verdict)
    assert json.dumps(record_to_json(read)) == line


@given(records(), st.dictionaries(st.text(max_size=3).map("x_".__add__), st.integers(), max_size=2))
def test_unknown_fields_of_a_record_are_ignored(written: Record, more: dict[str, int]) -> None:
    assert record_from_json({**record_to_json(written), **more}) == written


def test_a_record_of_schema_2_is_read() -> None:
    atoms = {
        "not lit(lamp_1)": AtomOrAction("lit", ("lamp_1",), positive=False),
        "OPEN": AtomOrAction("OPEN", None),
    }
    step = StepReport("GO(box)", "executed", call=AtomOrAction("GO", ("box",)))
    written = record(SubgoalVerdict(tried_actions=7), Ability.SUBGOAL_DECOMPOSITION)
    written = replace(written, explanation=VerdictExplanation(steps=(step,), atoms=atoms))
    old: dict[str, Any] = json.loads(json.dumps(record_to_json(written)))
    old["attempts"] = old.pop("tried_actions")
    old["explanation"]["steps"][0]["call"] = ["GO", ["box"], True]
    old["explanation"]["atoms"] = {
        "not lit(lamp_1)": ["lit", ["lamp_1"], False],
        "OPEN": ["OPEN", None, True],
    }
    read = record_from_json(old)
    assert read == written
    assert read.explanation is not None
    assert (read.explanation.atoms, read.explanation.steps[0].call) == (atoms, step.call)


def test_a_record_that_was_written_without_evidence_is_read() -> None:
    old: dict[str, Any] = record_to_json(record(PLAN))
    old["error"] = {name: old["error"][name] for name in ("kind", "step", "detail")}
    error = record_from_json(old).verdict.error
    assert error is not None
    assert (error.kind, error.check, error.objects) == (FaultKind.WRONG_ORDER, None, ())
    goals = GoalVerdict(matched=("lit(lamp_1)",), wrong=("lit(lamp_9)",), missing=("at(robot, lamp_1)",))
    old = record_to_json(record(goals, Ability.GOAL_INTERPRETATION))
    for name in ("matched", "wrong", "missing"):
        assert old.pop(name)
    assert record_from_json(old).verdict == GoalVerdict()


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_every_ability_has_the_fields_of_the_contract_first(ability: Ability) -> None:
    line = record_to_json(record(get_declaration(ability).verdict(), ability))
    assert tuple(line)[: len(FIRST)] == FIRST
    assert list(line)[-1] == "response"
    assert line["schema"] == SCHEMA


def test_a_record_of_a_plan_has_these_fields() -> None:
    assert verdict_to_record_fields(PLAN) == {
        "status": "scored",
        "excluded_reason": None,
        "executable": False,
        "success": False,
        "error": {
            "kind": "wrong_order",
            "step": 3,
            "detail": "the character is not next to soap.1002",
            "check": "the_character_is_not_next_to",
            "objects": ["soap.1002"],
        },
        "additional_steps": 2,
        "category": None,
        "goals": {"state": [1, 2], "relation": [0.5, 1], "action": [0, 0]},
        "counts": None,
        "planner": None,
        "repairs": ["code_fence", "single_quotes"],
        "spans": [{"start": 8, "end": 40, "kind": "repaired"}],
        "goals_satisfied": [True, False, False],
        "counted": {
            "success": False,
            "goals": {"state": [1, 2], "relation": [0.5, 1], "action": [0, 0]},
            "errors": {"wrong_order": 1, "additional_step": 2},
        },
    }


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [
        (PlanVerdict(), {"status": "scored", "excluded_reason": None, "error": None, "repairs": []}),
        (PlanVerdict(excluded="no goal"), {"status": "excluded", "excluded_reason": "no goal"}),
        (GoalVerdict(counts={"state": ConfusionCounts(1, 2, 3)}), {"counts": {"state": [1, 2, 3]}}),
        (GoalVerdict(hallucinated=("sofaa",)), {"hallucinated": ["sofaa"], "category": None}),
        (SubgoalVerdict(category=SubgoalAnswerCategory.RUNTIME), {"category": "runtime", "counts": None}),
        (SubgoalVerdict(errors=(FaultKind.AFFORDANCE,)), {"errors": ["affordance"]}),
        (
            OPERATORS,
            {
                "counts": {"precondition": {"object_states": [1, 0, 2]}, "effect": {}},
                "literals": {"precondition": [2, 0, 3]},
                "planner": "unsolvable",
                "operators": [
                    {
                        "name": "open",
                        "status": "compared",
                        "precondition": {
                            "matched": ["closed"],
                            "additional": ["near"],
                            "missing": ["can_open"],
                        },
                        "effect": {"matched": [], "additional": [], "missing": []},
                        "offences": [
                            {"offence": "unknown_predicate", "name": "near", "place": "precondition"}
                        ],
                    }
                ],
            },
        ),
    ],
)
def test_a_verdict_is_written_as_json_fields(verdict: Verdict, expected: dict[str, Any]) -> None:
    fields = verdict_to_record_fields(verdict)
    assert {key: fields[key] for key in expected} == expected
    assert json.loads(json.dumps(fields)) == fields


def test_repairs_made_before_scoring_stand_first_and_are_distinguished() -> None:
    origin = AnswerOrigin(
        "0" * 64, stop_reason="stop", usage=AnswerUsage(1, 2), answer_repairs=("reasoning",)
    )
    written = replace(record(PLAN), origin=origin)
    line = record_to_json(written)
    assert line["repairs"] == ["reasoning", "code_fence", "single_quotes"]
    assert line["answer_repairs"] == ["reasoning"]
    assert written.all_answer_repairs == ("reasoning", "code_fence", "single_quotes")
    assert record_from_json(line) == written


def test_an_explanation_is_a_field_of_the_record() -> None:
    explanation = VerdictExplanation(
        ("read with repair: prose",),
        (
            StepReport(
                "WALK(bed.1)",
                "executed",
                added=("NEXT_TO(me.65, bed.1)",),
                call=AtomOrAction("WALK", ("bed.1",)),
            ),
        ),
        (GoalReport("state", "ON(light.2)", True, predicates=("ON",)),),
        (GoalPartReport("ON(light.2) and TOUCH(x.3)", None, ("TOUCH(x.3)",)),),
    )
    line = record_to_json(replace(record(PLAN), explanation=explanation))
    assert record_from_json(line).explanation == explanation
    assert line["explanation"] == {
        "notes": ["read with repair: prose"],
        "steps": [
            {
                "action": "WALK(bed.1)",
                "outcome": "executed",
                "reason": "",
                "earlier": "",
                "added": ["NEXT_TO(me.65, bed.1)"],
                "removed": [],
                "hidden_changes": 0,
                "call": {"name": "WALK", "arguments": ["bed.1"], "positive": True},
            }
        ],
        "goals": [
            {"kind": "state", "goal": "ON(light.2)", "satisfied": True, "why": "", "predicates": ["ON"]}
        ],
        "parts": [
            {
                "part": "ON(light.2) and TOUCH(x.3)",
                "met_after": None,
                "missing": ["TOUCH(x.3)"],
                "met_at": None,
            }
        ],
        "atoms": None,
    }
    assert "explanation" not in record_to_json(record(PLAN))


def test_different_texts_have_different_digests() -> None:
    texts = ["", "a", "\ud800", "\udc00", "\ufffd", "?"]
    assert len({hash_text(text) for text in texts}) == len(texts)


def changed(**fields: object) -> dict[str, Any]:
    """Return a valid record with other fields; a field is left out if its value is `...`."""
    line = {**record_to_json(record(PLAN)), **fields}
    return {key: value for key, value in line.items() if value is not ...}


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        (changed(task_id=...), "field task_id: is missing"),
        (changed(task_id=3), "field task_id"),
        (changed(protocol="lenient"), "field protocol"),
        (changed(ability="cooking"), "field ability"),
        (changed(ability=...), "field ability: is missing"),
        (changed(success=...), "field success: is missing"),
        (changed(counts=...), "field counts: is missing"),
        (changed(status="lost"), "field status"),
        (changed(status="excluded"), "field status"),
        (changed(excluded_reason="why"), "field status"),
        (changed(error={"kind": "unlucky", "step": None, "detail": ""}), "field error.kind"),
        (changed(error={"kind": "parsing"}), "field error.step"),
        (changed(goals={"state": [1, 2]}), "field goals.relation"),
        (changed(goals={"state": [1], "relation": [0, 0], "action": [0, 0]}), "field goals.state.1"),
        (
            changed(goals={"state": [1, 2], "relation": [0, 0], "action": [0, 0], "x": [0, 0]}),
            "field goals.x",
        ),
        (changed(ability="goal_interpretation", counts={"state": [1, 2]}), "field counts.state"),
        (changed(ability="transition_modeling", operators=[{"name": "o"}]), "field operators.0.status"),
        (changed(additional_steps="many"), "field additional_steps"),
        (changed(counted={"success": True}), "field counted.goals"),
        (changed(repairs=[1]), "field repairs.0"),
        (changed(answer_repairs="no list"), "field answer_repairs"),
        (changed(explanation={"steps": 3}), "field explanation.steps"),
        (changed(usage={"input_tokens": "many"}), "field usage.input_tokens"),
        (changed(response="another"), "expected the response that was scored"),
        (changed(response_sha256="0" * 64), "expected the response that was scored"),
        (changed(response_sha256=...), "field response_sha256: is missing"),
        (changed(response=""), "expected the response that was scored"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_invalid_record_is_refused_with_the_name_of_its_field(
    values: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(InputError) as caught:
        record_from_json(values)
    assert str(caught.value).startswith(complaint)
    assert "\n" not in str(caught.value)


def test_a_record_without_its_response_is_read() -> None:
    assert record_from_json(changed(response=...)).response == ""
