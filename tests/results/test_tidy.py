from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.data.store import Store
from eai.results.lines import AnswerLine
from eai.results.tidy import TableMaker
from eai.tasks.source import Source
from report.samples import action_run, goal_run, operator_run, subgoal_run
from studies.published import tables


def _counts(answers: list[AnswerLine], bins: list[int]) -> list[tuple[int, int]]:
    """For each bin that occurs how many of its answers succeed, and how many there are."""
    return [
        (sum(bool(a.success) for a, b in zip(answers, bins, strict=True) if b == place), bins.count(place))
        for place in sorted(set(bins))
    ]


def test_the_papers_cofactors_are_group_bys_of_the_answers() -> None:
    """Of the figures that the paper prints for GPT-4o only that of 10 to 19 steps (0.50) is another one.

    It holds ``brushing_lint_off_clothing``, which one reconstruction of its scene makes a failure, as the
    reference has it.
    """
    answers = tables("behavior", Ability.ACTION_SEQUENCING).answers
    steps = [(each.annotated_steps or 0) // 10 for each in answers]
    assert _counts(answers, steps) == [(27, 39), (17, 37), (2, 15), (1, 6), (1, 2), (0, 1)]
    ground = [
        0 if (each.ground_goals or 0) < 5 else 1 if (each.ground_goals or 0) <= 10 else 2 for each in answers
    ]
    assert _counts(answers, ground) == [(28, 43), (17, 41), (3, 16)]
    stated = [0 if (each.goals or 0) < 5 else 1 if (each.goals or 0) < 10 else 2 for each in answers]
    assert _counts(answers, stated) == [(39, 70), (9, 29), (0, 1)]


def test_what_is_not_known_is_none() -> None:
    """The made-up tasks are in no data set: all that is known of them is what their records say."""
    maker = TableMaker(Source(Store()))
    for records in (action_run(), goal_run(), subgoal_run(), operator_run()):
        maker.add(records)
    first, excluded = maker.tables.answers[0], maker.tables.answers[11]
    assert (first.success, first.hits, first.planner, first.objects) == (True, None, None, None)
    assert (first.annotated_steps, first.goals, first.steps_tried) == (3, 1, 4)
    assert (excluded.outcome, excluded.success) == ("excluded", None)
    assert not any(line.task == excluded.task for line in maker.tables.steps if line.model == "first")
    assert {atom.reason for atom in maker.tables.atoms} <= {None}
    assert {clause.verdict for clause in maker.tables.clauses} == {"matched", "additional", "missing"}
