"""The goal that the paper's runs of BEHAVIOR asked for besides, against the figures that it explains."""

from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.record import Record
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.abilities.verdict import Counted, GoalTallies, PlanVerdict, Tally
from eai.reference.older_wording import TASK, as_the_paper_asked
from eai.results.paper_tables import PaperColumn, paper_models, paper_table
from eai.results.summary import summarise
from oracle import MODELS, Oracle

ALL_THREE = GoalTallies(Tally(0, 0), Tally(3, 3), Tally(0, 0))
REACHED = PlanVerdict(executable=True, success=True, goals=ALL_THREE, goals_satisfied=(True,) * 3)
PLAN = Record(Protocol.EAI_1_0_5, "behavior", Ability.ACTION_SEQUENCING, "m", TASK, "", "", REACHED)
TASK_SUCCESS = PaperColumn(Ability.ACTION_SEQUENCING.value, "task_success", "behavior")

OTHERWISE = {"claude-3-5-sonnet-20240620": 1.0, "gpt-3.5-turbo-0125": -1.0}
"""The models whose task success the goal does not explain -> how much more the paper has."""


def test_one_relation_more_is_missed() -> None:
    asked = as_the_paper_asked(PLAN).verdict
    assert isinstance(asked, PlanVerdict)
    assert (asked.success, asked.goals) == (False, ALL_THREE._replace(relation=Tally(3, 4)))
    assert (asked.executable, asked.goals_satisfied) == (True, REACHED.goals_satisfied)


def test_what_counts_in_summaries_misses_it_too() -> None:
    counting = replace(REACHED, counted=Counted(True, ALL_THREE, ()))
    asked = as_the_paper_asked(replace(PLAN, verdict=counting)).verdict
    assert isinstance(asked, PlanVerdict)
    assert asked.counted == Counted(False, ALL_THREE._replace(relation=Tally(3, 4)), ())


@pytest.mark.parametrize(
    "record",
    [
        replace(PLAN, protocol=Protocol.STRICT),
        replace(PLAN, task_id="another"),
        replace(PLAN, domain="virtualhome"),
        replace(PLAN, ability=Ability.SUBGOAL_DECOMPOSITION, verdict=SubgoalVerdict(success=True)),
        replace(PLAN, verdict=PlanVerdict(excluded="why not")),
    ],
)
def test_all_other_records_stay_as_they_are(record: Record) -> None:
    assert as_the_paper_asked(record) is record


@pytest.mark.parametrize("model", MODELS)
def test_with_it_task_success_is_the_paper_s(model: str, oracle: Oracle) -> None:
    rows = oracle("behavior", "action_sequencing", model)["records"]
    records = [
        replace(
            PLAN, task_id=row["identifier"], verdict=replace(REACHED, success=row["verdict"]["task_success"])
        )
        for row in rows
    ]
    verdicts = [as_the_paper_asked(record).verdict for record in records]
    ours = summarise(verdicts, Ability.ACTION_SEQUENCING)["task_success"].percent
    printed = paper_table("action_sequencing_trajectory").figure(paper_models()[model], TASK_SUCCESS)
    assert ours is not None
    assert printed is not None
    assert printed - ours == pytest.approx(OTHERWISE.get(model, 0.0))
