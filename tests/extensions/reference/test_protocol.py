"""The script of stochastic actions as a preset: where it ends attempts and trials otherwise than we do."""

from __future__ import annotations

from dataclasses import replace

import pytest

from abilities.test_trial import BOTH, LAMP, SHED, TORCH, outcome_of, plan, scorer
from eai.abilities.attempt import Attempt
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.abilities.trial import MultiAttemptTrial
from eai.abilities.verdict import PlanVerdict, SummaryCounts
from eai.base.errors import InputError
from eai.benchmarks.protocols import make_replanning_options_of_protocol
from eai.benchmarks.suite import open_suite
from eai.extensions.reference.protocol import EAI_1_0_5, TASK_WITH_REMOVED_GOAL
from eai.results.paper_tables import PaperColumn, map_files_to_paper_models, read_paper_table
from eai.results.record import Record
from eai.results.runs import Run, RunKey, recount_goals_as_in_paper
from eai.results.summary import compute_metric_rates
from eai.tasks.share import Share, TalliesByGoalKind
from oracle import MODELS, Oracle


def scripted(slip: float = 0.0) -> ReplanningOptions:
    found = make_replanning_options_of_protocol("eai-1.0.5", slip, 0, 0)
    assert found is not None
    return found


def tried(experiment: ReplanningOptions, *answers: str) -> tuple[list[Attempt], bool]:
    """The attempts, and whether the trial is over after them."""
    trial = (MultiAttemptTrial if experiment.preset is None else EAI_1_0_5.trial)(scorer(), experiment)
    for text in answers:
        trial.try_answer(text)
    return trial.attempts, trial.has_no_attempt_left


def test_the_preset_is_an_experiment_of_its_own() -> None:
    ours = ReplanningOptions(3, "continue", "state", slip=0.1, slip_seed=0, until="goal")
    assert replace(scripted(0.1), preset=None) == ours
    assert scripted(0.1).label == f"{ours.label}+as-eai-1.0.5"
    assert make_replanning_options_of_protocol("", 0.1, 0, 3) is None
    with pytest.raises(InputError, match="'eai-9' is not a preset: expected eai-1"):
        make_replanning_options_of_protocol("eai-9", 0.1, 0, 3)


def test_a_plan_that_misses_the_goal_is_not_asked_for_again() -> None:
    (attempt,), over = tried(scripted(), plan(LAMP))
    assert (outcome_of(attempt), over) == ("ran lost", True)
    assert not tried(replace(scripted(), preset=None), plan(LAMP))[1]


def test_a_step_that_is_not_needed_ends_the_attempt() -> None:
    (attempt,), over = tried(scripted(), plan(LAMP, "GO hall", SHED))
    assert (outcome_of(attempt), over) == ("additional_step lost", False)
    assert (attempt.verdict.executable, attempt.verdict.additional_steps) == (False, 1)
    (ours,), _ = tried(replace(scripted(), preset=None), plan(LAMP, "GO hall", SHED))
    assert outcome_of(ours) == "ran lost"


def test_a_slip_is_drawn_before_it_is_known_whether_the_action_is_possible() -> None:
    (attempt,), over = tried(scripted(1.0), plan(TORCH))
    assert (outcome_of(attempt), attempt.slipped_at, over) == ("slip lost", 0, False)
    (ours,), _ = tried(replace(scripted(1.0), preset=None), plan(TORCH))
    assert (outcome_of(ours), ours.slipped_at) == ("missing_step lost", None)


def test_what_else_ends_an_attempt_is_as_with_us() -> None:
    for plans in ([plan(*BOTH, TORCH)], [plan(LAMP, TORCH), plan(*BOTH[1:])], ["no plan", plan(*BOTH)]):
        theirs, over = tried(scripted(), *plans)
        ours, _ = tried(replace(scripted(), preset=None), *plans)
        assert [outcome_of(each) for each in theirs] == [outcome_of(each) for each in ours]
        assert over


ALL_THREE = TalliesByGoalKind(Share(0, 0), Share(3, 3), Share(0, 0))
REACHED = PlanVerdict(executable=True, success=True, goals=ALL_THREE, goals_satisfied=(True,) * 3)
PLAN = Record(
    Protocol("eai-1.0.5"), "behavior", Ability.ACTION_SEQUENCING, "m", TASK_WITH_REMOVED_GOAL, "", "", REACHED
)
TASK_SUCCESS = PaperColumn(Ability.ACTION_SEQUENCING.value, "task_success", "behavior")

OTHERWISE = {"claude-3-5-sonnet-20240620": 1.0, "gpt-3.5-turbo-0125": -1.0}
"""The models whose task success the goal does not explain -> how much more the paper has."""


def as_asked(record: Record) -> Record:
    run = Run(RunKey(record.protocol, record.domain, record.ability, record.model), (record,))
    return recount_goals_as_in_paper(run).records[0]


def test_one_relation_more_is_missed() -> None:
    asked = as_asked(PLAN).verdict
    assert isinstance(asked, PlanVerdict)
    assert (asked.success, asked.goals) == (False, ALL_THREE._replace(relation=Share(3, 4)))
    assert (asked.executable, asked.goals_satisfied) == (True, REACHED.goals_satisfied)


def test_what_counts_in_summaries_misses_it_too() -> None:
    counting = replace(REACHED, counted=SummaryCounts(True, ALL_THREE, {}))
    asked = as_asked(replace(PLAN, verdict=counting)).verdict
    assert isinstance(asked, PlanVerdict)
    assert asked.counted == SummaryCounts(False, ALL_THREE._replace(relation=Share(3, 4)), {})


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
    assert as_asked(record) is record


@pytest.mark.parametrize("model", MODELS)
def test_with_it_task_success_is_the_paper_s(model: str, oracle: Oracle) -> None:
    rows = oracle("behavior", "action_sequencing", model)["records"]
    records = [
        replace(
            PLAN, task_id=row["identifier"], verdict=replace(REACHED, success=row["verdict"]["task_success"])
        )
        for row in rows
    ]
    verdicts = [as_asked(record).verdict for record in records]
    ours = compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)["task_success"].percent
    printed = read_paper_table("action_sequencing_trajectory").find_printed_number(
        map_files_to_paper_models()[model], TASK_SUCCESS
    )
    assert ours is not None
    assert printed is not None
    assert printed - ours == pytest.approx(OTHERWISE.get(model, 0.0))


def test_a_benchmark_that_a_protocol_does_not_score_is_refused() -> None:
    with pytest.raises(InputError, match=r"virtualhome-rules is not scored under eai-1\.0\.5"):
        open_suite("rules:virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"))
