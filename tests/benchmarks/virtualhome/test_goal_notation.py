from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.virtualhome.household import make_task
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import Verdict
from eai.benchmarks.virtualhome import domain
from eai.benchmarks.virtualhome.notation import VirtualHomeGoalNotation
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.results.codec import dataclass_to_json, verdict_to_record_fields
from eai.world.fault import FaultKind

TASK = make_task(
    goals=(
        "state OPEN fridge.10",
        "relation ONTOP cup.13 bed.20",
        "relation ONTOP cup.40 bed.20",
        "action LOOKAT|WATCH",
        "action TYPE",
    ),
    more_objects=("cup.40",),
)
DOMAIN = domain.make_domain_with_checks_in_paper_order()
STRICT = GoalInterpretationScorer(TASK, DOMAIN, VirtualHomeGoalNotation())

OPEN = {"name": "fridge", "state": "OPEN"}
ON_BED = {"from_name": "cup", "relation": "ON", "to_name": "bed"}


def answer(states: object = (), relations: object = (), actions: object = (), description: str = "d") -> str:
    if isinstance(actions, list):
        actions = [{"action": a, "description": description} if isinstance(a, str) else a for a in actions]
    return json.dumps({"node goals": states, "edge goals": relations, "action goals": actions})


def counts(verdict: Verdict) -> tuple[object, ...]:
    assert verdict.counts is not None
    return tuple(tuple(verdict.counts[kind]) for kind in ("state", "relation", "action"))


COUNTS = [
    (answer([OPEN], [ON_BED, ON_BED], ["WATCH", "TYPE"]), [(1, 0, 0), (2, 0, 0), (2, 0, 0)]),
    # The data set has two cups on the bed.
    (answer(relations=[ON_BED]), [(0, 0, 1), (1, 0, 1), (0, 0, 2)]),
    (
        answer(relations=[ON_BED] * 3),
        [(0, 0, 1), (2, 0, 0), (0, 0, 2)],
    ),
    # Unknown objects and missing fields.
    (
        answer([{"name": "yacht", "state": "ON"}, {"name": "fridge"}, {}]),
        [(0, 0, 1), (0, 0, 2), (0, 0, 2)],
    ),
    (
        answer([{"name": "fridge", "state": "SHINY"}], [{**ON_BED, "relation": "UNDER"}]),
        [(0, 0, 1), (0, 0, 2), (0, 0, 2)],
    ),
    # An action goal is met once.
    (
        answer(actions=["watch", "LOOKAT", "FLY"]),
        [(0, 0, 1), (0, 0, 2), (1, 1, 1)],
    ),
    (
        answer(actions=[{"action": "TYPE", "description": d} for d in "abc"]),
        [(0, 0, 1), (0, 0, 2), (1, 0, 1)],
    ),
    # An unreadable answer misses all goals.
    ("The fridge should be open.", [(0, 0, 1), (0, 0, 2), (0, 0, 2)]),
    ("Sure! " + answer([OPEN]), [(1, 0, 0), (0, 0, 2), (0, 0, 2)]),
    ("```json\n" + answer([OPEN]) + "\n```", [(1, 0, 0), (0, 0, 2), (0, 0, 2)]),
    (answer([OPEN]) + "}", [(1, 0, 0), (0, 0, 2), (0, 0, 2)]),
    ('{"node goals": null}', [(0, 0, 1), (0, 0, 2), (0, 0, 2)]),
    ('{"node goals": "open"}', [(0, 0, 1), (0, 0, 2), (0, 0, 2)]),
    ("{'node goals': [{'name': 'fridge', 'state': 'OPEN'}]}", [(1, 0, 0), (0, 0, 2), (0, 0, 2)]),
]


@pytest.mark.parametrize(("text", "expected"), COUNTS)
def test_an_answer_has_its_counts_of_goals(text: str, expected: list[object]) -> None:
    assert counts(STRICT.score(text)) == tuple(expected)


@pytest.fixture
def scorer() -> Scorer:
    """Return the scorer under `strict`. Tests of other protocols override this fixture."""
    return STRICT


def test_an_unreadable_answer_is_a_parsing_error(scorer: Scorer) -> None:
    error = scorer.score("no goals here").error
    assert error is not None
    assert error.kind is FaultKind.PARSING


UNKNOWN_NAMES = answer(
    [{"name": "yacht", "state": "ON"}, {"name": "fridge", "state": "SHINY"}],
    [{**ON_BED, "to_name": "moon"}, {**ON_BED, "relation": "UNDER"}],
    ["FLY", "TYPE"],
)


def test_unknown_names_are_reported_as_hallucinated() -> None:
    verdict = STRICT.score(UNKNOWN_NAMES)
    assert isinstance(verdict, GoalVerdict)
    assert verdict.hallucinated == ("yacht", "SHINY", "moon", "UNDER", "FLY")
    assert verdict.unknown_predicates == ("SHINY", "UNDER")
    assert (verdict.predicted, verdict.ill_formed) == (6, 0)


def test_a_relation_in_the_section_of_states_is_ill_formed() -> None:
    verdict = STRICT.score(answer([{"name": "fridge", "state": "INSIDE"}]))
    assert isinstance(verdict, GoalVerdict)
    assert (verdict.ill_formed, verdict.hallucinated) == (1, ())
    assert counts(verdict) == ((0, 0, 1), (0, 0, 2), (0, 0, 2))


def test_repeated_goals_are_predicted_once() -> None:
    verdict = STRICT.score(
        answer([OPEN, OPEN, {"name": "fridge"}, {"name": "fridge"}], actions=["FLY", "FLY"])
    )
    assert isinstance(verdict, GoalVerdict)
    assert (verdict.predicted, verdict.ill_formed, verdict.hallucinated) == (3, 1, ("FLY",))


@pytest.mark.parametrize("other", ["null", '"none"', '[{"name": "tv", "state": "ON"}]'])
@pytest.mark.parametrize("is_first", [True, False])
def test_a_repeated_section_is_a_parsing_error(other: str, is_first: bool) -> None:
    first, second = (json.dumps([OPEN]), other) if is_first else (other, json.dumps([OPEN]))
    error = STRICT.score(f'{{"node goals": {first}, "node goals": {second}, "edge goals": []}}').error
    assert error is not None
    assert error.detail.endswith('the section "node goals" occurs twice')


@pytest.mark.parametrize(
    "entry",
    [
        '{"name": "fridge", "state": "CLOSED", "state": "OPEN"}',
        '{"name": "bed", "name": "fridge", "state": "OPEN"}',
        '{"name": "fridge", "name": "OPEN"}',
    ],
)
def test_a_goal_with_a_repeated_key_is_ill_formed(entry: str) -> None:
    verdict = STRICT.score(f'{{"node goals": [{entry}]}}')
    assert isinstance(verdict, GoalVerdict)
    assert (verdict.ill_formed, verdict.predicted) == (1, 1)


@pytest.mark.parametrize("relation", ["ON", "on top of"])
def test_an_example_after_the_goals_does_not_count(relation: str) -> None:
    example = answer([{"name": "OBJECT", "state": "STATE"}], [{**ON_BED, "relation": relation}])
    is_example = relation != "ON"
    verdict = STRICT.score(f"{answer([OPEN])}\nThe form is {example}")
    assert counts(verdict)[0] == ((1, 0, 0) if is_example else (0, 0, 1))


def test_a_verdict_names_the_repairs_of_its_answer() -> None:
    assert STRICT.score("Sure! " + answer([OPEN]) + " Bye.").repairs == ("prose",)


def test_an_explanation_marks_each_goal_as_met_or_unmet() -> None:
    explanation = STRICT.explain(answer([OPEN, {"name": "yacht", "state": "ON"}, {}, {"x": 1}], [ON_BED]))
    assert [goal.satisfied for goal in explanation.goals] == [True, True, False, False, False]
    assert "left out as hallucination: ON(yacht), there is no yacht" in explanation.notes
    assert "left out as ill-formed: {'x': 1}" in explanation.notes
    assert STRICT.explain("nothing").notes[0].startswith("parsing: ")


TEXTS = st.text() | st.recursive(
    st.none() | st.text(max_size=5),
    lambda v: (
        st.lists(v)
        | st.dictionaries(
            st.sampled_from(
                ["node goals", "edge goals", "action goals", "name", "state", "action", "relation"]
            ),
            v,
        )
    ),
).map(json.dumps)


def assert_has_a_verdict(scorer: Scorer, text: str) -> None:
    """Fail unless a text has an explanation, and equal verdicts when scored twice."""
    assert json.dumps(verdict_to_record_fields(scorer.score(text))) == json.dumps(
        verdict_to_record_fields(scorer.score(text))
    )
    json.dumps(dataclass_to_json(scorer.explain(text)))


@given(TEXTS)
def test_any_text_has_a_verdict(text: str) -> None:
    assert_has_a_verdict(STRICT, text)


IGNORED_ENTRIES = answer(
    [{"name": "fridge", "state": "SHINY"}, {"name": "yacht", "state": "ON"}, {"name": "cup"}]
)


def test_an_explanation_lists_ill_formed_and_hallucinated_entries() -> None:
    assert STRICT.explain(IGNORED_ENTRIES).notes[:3] == (
        "left out as ill-formed: {'name': 'cup'}",
        "left out as hallucination: SHINY(fridge), there is no SHINY",
        "left out as hallucination: ON(yacht), there is no yacht",
    )


SHUT = {"name": "fridge", "state": "CLOSED"}
WRONG_GOALS = answer([OPEN, SHUT, SHUT], [ON_BED, {**ON_BED, "relation": "UNDER"}], ["LOOKAT", "FLY"])


def get_wrong_goals(scorer: Scorer) -> list[str]:
    notes = scorer.explain(WRONG_GOALS).notes
    return [note.removeprefix("wrong: ") for note in notes if note.startswith("wrong: ")]


def test_explanations_name_each_wrong_goal_once() -> None:
    assert get_wrong_goals(STRICT) == ["CLOSED(fridge)"]


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        '{"node goals": ' + "[" * 50_000 + "]" * 50_000 + "}",
        "{'node goals': " * 10_000,
        "\ud800",
        json.dumps({str(number): [] for number in range(50_000)}),
    ],
    ids=["open brackets", "nested sections", "nested objects", "surrogate", "many sections"],
)
def test_extreme_texts_have_a_verdict(scorer: Scorer, text: str) -> None:
    assert scorer.score(text).counts is not None


def test_the_goals_of_the_data_set_score_in_full(virtualhome_tasks: VirtualHomeTasks) -> None:
    wrong = []
    notation = VirtualHomeGoalNotation()
    for task in virtualhome_tasks.values():
        text = notation.join(write_goals(task, DOMAIN, notation))
        verdict = GoalInterpretationScorer(task, DOMAIN, notation).score(text)
        total = sum(count[0] for count in counts(verdict) if isinstance(count, tuple))
        if any(count[1:] != (0, 0) for count in counts(verdict) if isinstance(count, tuple)):
            wrong.append(task.id)
        assert total == len(task.goals)
    assert wrong == []
