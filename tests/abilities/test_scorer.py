"""An answer whose scorer raises an exception fails alone, in every ability."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import pytest

from agents.switches import SWITCHES
from eai.abilities.declaration import AnswerOutcome, get_declaration
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import RAISED, Verdict
from eai.agents.setting import ACTING
from eai.base.errors import DataError, InputError
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import Scoring
from eai.results.responses import Response
from eai.results.summary import find_answer_outcome
from eai.results.totals import RunTotals
from eai.tasks.source import Source, TaskSet

BOOM = "BOOM"


class _Raising(Scorer):
    """A scorer that raises an exception for some answers.

    Args:
        scorer: scores the other answers.
        raises: the exception.
        always: whether it raises for every answer.
    """

    def __init__(self, scorer: Scorer, raises: Exception, *, always: bool = False) -> None:
        self._scorer, self._raises, self._always = scorer, raises, always

    def assess(self, text: str) -> Assessment:
        if self._always or BOOM in text:
            raise self._raises
        return self._scorer.assess(text)

    def score_missing_answer(self) -> Verdict:
        return super().score_missing_answer() if self._always else self._scorer.score_missing_answer()


def suite_of(ability: Ability, wrap: Callable[[Scorer], Scorer]) -> Suite:
    suite = open_suite(SWITCHES, ability, source=Source(planner=PlannerChoice.BUILT_IN))
    known = suite.scorers
    return replace(suite, scorers=TaskSet(known, lambda task: wrap(known[task]), known.sha256))


def raising(ability: Ability, error: Exception, *, always: bool = False) -> Suite:
    return suite_of(ability, lambda scorer: _Raising(scorer, error, always=always))


@pytest.mark.parametrize("ability", [*PAPER_ABILITIES, ACTING], ids=str)
@pytest.mark.parametrize(
    "error", [OverflowError("too large"), RecursionError(), MemoryError(), InputError("an odd answer")]
)
def test_an_answer_fails_if_its_scorer_raises(ability: Ability, error: Exception) -> None:
    suite, declared = raising(ability, error), get_declaration(ability)
    task_id = suite.task_ids[0]
    responses = [Response(task, BOOM if task == task_id else "[]") for task in suite.task_ids]
    records = [*Scoring().score_records(suite, "m", responses, explanations=True)]
    plain = open_suite(SWITCHES, ability, source=suite.source)
    assert [r.verdict for r in records[1:]] == [plain.score(task, "[]") for task in suite.task_ids[1:]]
    (verdict, found) = records[0].verdict, records[0].verdict.error
    assert found is not None
    assert (verdict.excluded, found.check, find_answer_outcome(records[0])) == (
        None,
        RAISED,
        AnswerOutcome.UNCATEGORISED,
    )
    assert found.detail.startswith(f"the scorer raised {type(error).__name__} (test_scorer.py:")
    assert found.detail.endswith(f": {error}" if str(error) else ")")
    assert records[0].explanation == VerdictExplanation((found.detail,))
    empty, failed = map(declared.contributions, (suite.score_missing_answer(task_id), verdict))
    assert [share.denominator for share in failed.values()] == [s.denominator for s in empty.values()]
    assert {name for name in failed if failed[name].numerator} <= {"uncategorised"}
    coverage = RunTotals.from_records(records).coverage
    assert (coverage.raised, coverage.answered) == (1, len(records))
    assert "1 failed because the scorer raised an exception" in str(coverage.remark_on_missing_answers)


@pytest.mark.parametrize(
    "ability", [Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION, ACTING], ids=str
)
def test_an_answer_to_a_task_whose_scorer_always_raises_fails_too(ability: Ability) -> None:
    suite, declared = raising(ability, ValueError(), always=True), get_declaration(ability)
    verdict = suite.score(suite.task_ids[0], "[]")
    assert verdict.excluded is None
    assert declared.contributions(verdict)[next(iter(declared.overview_headings))] == (0, 1)


def test_a_verdict_stands_if_its_explanation_raises(caplog: pytest.LogCaptureFixture) -> None:
    plain = open_suite(SWITCHES, Ability.ACTION_SEQUENCING)

    class Mute(_Raising):
        def assess(self, text: str) -> Assessment:
            def refuse(*_: object) -> VerdictExplanation:
                raise KeyError("word")

            return Assessment(plain.score("both", text), refuse, refuse)  # type: ignore[arg-type]

    suite = suite_of(Ability.ACTION_SEQUENCING, lambda scorer: Mute(scorer, KeyError()))
    verdict, explain, look_back = suite.assess("both", "[]")
    assert look_back is not None
    with caplog.at_level(logging.WARNING):
        assert explain() == VerdictExplanation(notes=("empty: the answer is empty: it holds no words",))
        assert (look_back(10), verdict) == (verdict, plain.score("both", "[]"))
    assert [record.getMessage().count("KeyError (test_scorer.py:") for record in caplog.records] == [1, 1]


def test_an_exception_that_is_not_about_the_answer_is_raised() -> None:
    suite = raising(Ability.ACTION_SEQUENCING, DataError("the data set is missing"))
    with pytest.raises(DataError):
        suite.score("both", BOOM)
