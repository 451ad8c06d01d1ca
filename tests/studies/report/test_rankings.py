from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import ConfusionCounts, Verdict
from eai.agents.setting import ACTING
from eai.agents.verdict import EpisodeTurn, EpisodeVerdict
from eai.pddl.planning import PlannerOutcome
from eai.results.paper_tables import (
    NULL_AGENTS,
    NULL_MODELS,
    read_published_scores,
    read_trivial_baseline_scores,
)
from eai.results.rate import Rate
from eai.results.record import NOT_ANSWERED, Record
from eai.results.runs import Run, RunKey
from eai.studies.report.rankings import Ranking, make_ranking, make_scores_by_model
from eai.studies.report.run_summary import summarize_run
from eai.studies.report.table_specs import make_table_specs
from eai.world.fault import FaultKind
from results.verdicts import SUCCEEDED, failed, record, whole
from studies.report.samples import cell_at, rate_at

BAD = failed(FaultKind.AFFORDANCE)
SPECS = {spec.name: spec for spec in make_table_specs(())}


def run_of(verdicts: list[Verdict], ability: Ability, model: str) -> Run:
    records = [record(f"{i}_1", v, ability=ability, model=model) for i, v in enumerate(verdicts)]
    return Run(RunKey(Protocol.STRICT, "virtualhome", ability, model), whole(records))


def table(
    name: str, runs: list[Run], protocol: Protocol = Protocol.STRICT, *, with_paper: bool = False
) -> Ranking | None:
    """Return a table without its null models and their footnotes."""
    found = whole_table(name, runs, protocol, with_paper=with_paper)
    if found is None:
        return None
    rows = tuple(row for row in found.rows if row.source != "floor")
    return replace(found, rows=rows, notes=tuple(n for n in found.notes if not n.startswith("Floor")))


def whole_table(
    name: str, runs: list[Run], protocol: Protocol = Protocol.STRICT, *, with_paper: bool = False
) -> Ranking | None:
    found = [summarize_run(run) for run in runs]
    summaries = [replace(each, key=each.key._replace(protocol=protocol)) for each in found]
    return make_ranking(SPECS[name], summaries, make_scores_by_model(summaries), with_paper=with_paper)


def plans(good: int, model: str) -> Run:
    return run_of([SUCCEEDED] * good + [BAD] * (10 - good), Ability.ACTION_SEQUENCING, model)


def test_rows_are_ranked_with_shared_ranks_and_the_best_marked() -> None:
    found = table(
        "action_sequencing_trajectory", [plans(5, "b"), plans(7, "c"), plans(7, "a"), plans(2, "d")]
    )
    assert found is not None
    assert [(row.rank, row.model) for row in found.rows] == [(1, "a"), (1, "c"), (3, "b"), (4, "d")]
    assert [cell_at(row, 0).best for row in found.rows] == [True, True, False, False]
    assert rate_at(found.rows[0], 0) == Rate(7, 10)
    affordance = [column.metric for column in found.columns].index("affordance")
    assert not any(cell_at(row, affordance).best for row in found.rows)  # fewer errors are no contest


def test_a_single_run_is_not_marked_as_best() -> None:
    found = table("action_sequencing_trajectory", [plans(7, "a")])
    assert found is not None
    assert not any(cell.best for cell in found.rows[0].scores.values())


def test_a_table_without_numbers_is_left_out() -> None:
    assert table("goal_interpretation", [plans(7, "a")]) is None


def test_columns_without_numbers_are_left_out() -> None:
    found = table("goal_satisfaction", [plans(7, "a")])
    assert found is not None
    assert {column.metric for column in found.columns} == {"state_goal", "total_goal"}


def test_granularity_is_the_last_column_of_the_subgoal_table() -> None:
    verdict = SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT, refined=4, added_actions=1)
    found = table("subgoal_decomposition_trajectory", [run_of([verdict], Ability.SUBGOAL_DECOMPOSITION, "a")])
    assert found is not None
    column, cell = [*found.columns][-1], cell_at(found.rows[0], -1)
    assert (column.group, column.label, cell.value) == ("Added by search", "Granularity", 25)
    assert "granularity" not in [each.metric for each in SPECS["action_sequencing_trajectory"].columns]


def test_the_papers_rows_have_notes_on_their_cells() -> None:
    found = whole_table("overview", [plans(10, "a")], Protocol("eai-1.0.5"), with_paper=True)
    assert found is not None
    assert len(found.rows) == 19 + len(NULL_MODELS)
    assert found.rows[0].model == "a"
    opus = next(row for row in found.rows if row.model == "Claude-3 Opus")
    assert opus.source == "paper"
    assert cell_at(opus, 0).value == 64.6
    (note,) = cell_at(opus, 0).texts
    assert "64.9" in note
    used = {n for notes in (*found.columns.values(), *(row.all_notes for row in found.rows)) for n in notes}
    assert used == set(found.notes)
    assert len(used) == len(found.notes)


def test_the_paper_s_figures_never_stand_beside_runs_under_another_protocol() -> None:
    found = table("overview", [plans(4, "a")], with_paper=True)
    assert found is not None
    assert {row.source for row in found.rows} == {"run", "published"}
    ours = next(row for row in found.rows if row.source == "run")
    gpt_4o = next(row for row in found.rows if row.model == "GPT-4o")
    assert (gpt_4o.rank, str(gpt_4o.coverage)) == (7, "342/342")
    assert (ours.rank, str(ours.coverage)) == (14, "10/10")
    known = (
        read_published_scores("strict")
        .suites["virtualhome/action_sequencing"]
        .find_rates("GPT-4o")["task_success"]
    )
    assert rate_at(gpt_4o, 0) == known
    told = " ".join(gpt_4o.notes)
    assert f"{len(found.rows) - 1} of the paper's 18 models" in told
    assert "Scored against other data than the runs: Action sequencing." in told


@pytest.mark.parametrize(
    ("answered", "size", "excluded", "remark"),
    [
        (8, 12, None, "only 10 of 12 tasks were asked"),
        (8, 10, NOT_ANSWERED, "2 of 10 tasks without an answer, left out"),
        (10, None, None, "do not say how many tasks"),
    ],
)
def test_a_run_that_leaves_tasks_out_is_last_without_rank_or_bold(
    answered: int, size: int | None, excluded: str | None, remark: str
) -> None:
    run = plans(10, "partial")
    lacking = replace(SUCCEEDED, excluded=excluded)
    records = [
        replace(
            r,
            suite_size=size,
            unanswered=None if i < answered else "why",
            verdict=r.verdict if i < answered else lacking,
        )
        for i, r in enumerate(run.records)
    ]
    found = table("overview", [plans(1, "a"), plans(2, "b"), replace(run, records=tuple(records))])
    assert found is not None
    assert [(row.rank, row.model) for row in found.rows] == [(1, "b"), (2, "a"), (None, "partial")]
    assert [cell_at(row, 0).best for row in found.rows] == [True, False, False]
    (note,) = found.rows[-1].notes
    assert remark in note


def test_a_run_whose_missing_answers_count_as_failures_is_ranked_with_a_note() -> None:
    run = plans(10, "partial")
    failures = [
        replace(r, unanswered="why", verdict=BAD.to_verdict_on_missing_answer()) for r in run.records[5:]
    ]
    found = table("overview", [plans(4, "a"), replace(run, records=(*run.records[:5], *failures))])
    assert found is not None
    assert [(row.rank, row.model, str(row.coverage)) for row in found.rows] == [
        (1, "partial", "5/10"),
        (2, "a", "10/10"),
    ]
    assert found.notes[0] == "Action sequencing: 5 of 10 tasks without an answer, counted as failed."


def test_average_is_the_paper_s_mean_with_an_interval() -> None:
    goals = run_of(
        [GoalVerdict(counts={"state": ConfusionCounts(1, 0, 1)})] * 4, Ability.GOAL_INTERPRETATION, "a"
    )
    subgoals = run_of(
        [SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT)], Ability.SUBGOAL_DECOMPOSITION, "a"
    )
    operators = run_of(
        [
            OperatorVerdict(
                counts={"effect": {"object_states": ConfusionCounts(1, 1, 1)}}, planner=PlannerOutcome.SOLVED
            )
        ],
        Ability.TRANSITION_MODELING,
        "a",
    )
    found = table("overview", [goals, subgoals, plans(5, "a"), operators])
    assert found is not None
    average = cell_at(found.rows[0], -1)
    assert average.value is not None
    assert round(average.value, 6) == round((200 / 3 + 50 + 100 + (50 + 100) / 2) / 4, 6)
    assert average.low is not None
    assert average.high is not None
    assert average.low < average.value < average.high


def test_a_run_without_an_ability_has_no_average() -> None:
    found = table("overview", [plans(5, "a")])
    assert found is not None
    assert [column.metric for column in found.columns] == ["task_success", "execution_success"]


def test_the_order_of_records_does_not_change_rankings() -> None:
    def shuffled(records: tuple[Record, ...]) -> float | None:
        key = RunKey(Protocol.STRICT, "virtualhome", Ability.ACTION_SEQUENCING, "a")
        return summarize_run(Run(key, records)).rates["task_success"].percent

    run = plans(4, "a")
    assert shuffled(run.records) == shuffled(run.records[::-1]) == 40


@pytest.mark.parametrize(("known", "first"), [(True, "honest"), (False, "asserting")])
def test_the_share_of_working_plans_ranks_if_it_is_known(known: bool, first: str) -> None:
    """Planner success keeps its column. Operators that assert everything have plans, but none works."""

    def planned(plans: int, working: int, model: str) -> Run:
        verdicts: list[Verdict] = []
        for number in range(10):
            outcome = PlannerOutcome.SOLVED if number < plans else PlannerOutcome.UNSOLVABLE
            verdicts.append(OperatorVerdict(planner=outcome, plan_works=number < working if known else None))
        return run_of(verdicts, Ability.TRANSITION_MODELING, model)

    found = table("transition_modeling_planner", [planned(10, 0, "asserting"), planned(6, 5, "honest")])
    assert found is not None
    assert [row.rank for row in found.rows] == [1, 2]
    assert found.rows[0].model == first
    rates = {row.model: [rate_at(row, place) for place in range(len(row.scores))] for row in found.rows}
    assert rates["honest"] == [Rate(6, 10), *([Rate(5, 10)] if known else [])]
    assert rates["asserting"] == [Rate(10, 10), *([Rate(0, 10)] if known else [])]


def judged_by(planner: str | None, model: str) -> Run:
    verdict = OperatorVerdict(
        counts={"effect": {"object_states": ConfusionCounts(1, 0, 0)}},
        planner=PlannerOutcome.SOLVED,
        planner_name=planner,
    )
    return run_of([verdict], Ability.TRANSITION_MODELING, model)


@pytest.mark.parametrize(
    ("planners", "with_paper", "told"),
    [
        (("built-in search", "built-in search"), False, [None, None]),
        (("built-in search", "Fast Downward 1"), False, ["built-in search", "Fast Downward 1"]),
        (("built-in search", None), False, [None, None]),
        (("built-in search", "built-in search"), True, ["built-in search", "built-in search"]),
    ],
)
def test_rows_name_their_planner_if_planners_differ(
    planners: tuple[str | None, str | None], with_paper: bool, told: list[str | None]
) -> None:
    runs = [judged_by(planner, model) for planner, model in zip(planners, "ab", strict=True)]
    found = table("transition_modeling_planner", runs, with_paper=with_paper)
    assert found is not None
    own = {row.model: row for row in found.rows if row.source == "run"}
    notes = [list(own[model].notes) for model in "ab"]
    assert notes == [[f"Planner that judged operators: {name}."] if name else [] for name in told]


@pytest.mark.parametrize("protocol", list(Protocol.list_names()))
@pytest.mark.parametrize("with_paper", [False, True])
def test_null_models_are_last_in_each_table_without_a_rank(protocol: Protocol, with_paper: bool) -> None:
    found = whole_table("overview", [plans(0, "a"), plans(1, "b")], protocol, with_paper=with_paper)
    assert found is not None
    floor = found.rows[-len(NULL_MODELS) :]
    assert [row.model for row in floor] == list(NULL_MODELS)
    assert {row.source for row in found.rows[: -len(floor)]}.isdisjoint({"floor"})
    assert not any(row.rank or cell.best for row in floor for cell in row.scores.values())
    rates = (
        read_trivial_baseline_scores(protocol.value)
        .suites["virtualhome/action_sequencing"]
        .find_rates("eai/lookup")
    )
    lookup = floor[list(NULL_MODELS).index("eai/lookup")]
    assert rate_at(lookup, 0) == rates["task_success"]
    assert (cell_at(lookup, 0).value or 0) > 30  # better than both runs, and first nowhere
    assert found.rows[0].rank == 1
    told = floor[0].notes[0]
    assert "what is earned without deciding anything" in told
    assert all(model in told for model in NULL_MODELS)


def test_tables_of_acting_end_with_the_floor_of_null_agents() -> None:
    """An agent that acts blindly recovers from some errors by chance, and wins nothing after an error."""
    fault = FaultKind.AFFORDANCE
    turns = tuple([EpisodeTurn("GO", "", True, kind, False, "1", None) for kind in (fault, None)])
    won = EpisodeVerdict(success=True, reached=True, turns=turns, shortest=2)
    runs = [summarize_run(run_of([won], ACTING, name)) for name in ("a", "eai_blind")]
    (spec,) = [spec for spec in make_table_specs([ACTING]) if spec.columns[0].ability == ACTING][-1:]
    found = make_ranking(spec, runs, make_scores_by_model(runs), with_paper=False)
    assert found is not None
    assert [(row.rank, row.model, row.source) for row in found.rows] == [
        (1, "a", "run"),
        *((None, name, "floor") for name in (*NULL_AGENTS, "eai_blind")),
    ]
    rates = read_trivial_baseline_scores("strict").suites["virtualhome/acting"].find_rates("eai/blind")
    columns = {column.metric: column for column in found.columns}
    for metric, low, high in (("recovered", 5, 40), ("won_after_fault", 0, 1)):
        assert found.rows[1].scores[columns[metric]].value == rates[metric].percent
        assert low <= (rates[metric].percent or 0) <= high
    (note,) = [note for note in found.notes if note.startswith("Floor")]
    assert all(name in note for name in NULL_AGENTS)
    assert "eai/copy" not in note


def test_a_null_model_that_was_run_has_no_rank_either() -> None:
    found = whole_table("action_sequencing_trajectory", [plans(3, "a"), plans(9, "eai_lookup")])
    assert found is not None
    assert [(row.rank, row.model) for row in found.rows] == [
        (1, "a"),
        (None, "eai/copy"),
        (None, "eai/empty"),
        (None, "eai/lookup"),
        (None, "eai/random"),
        (None, "eai_lookup"),
    ]
    assert [row.model for row in found.rows if row.source == "floor"] == [row.model for row in found.rows[1:]]
    assert not any(cell.best for row in found.rows[1:] for cell in row.scores.values())


def test_other_benchmarks_have_no_rows_of_null_models() -> None:
    run = summarize_run(plans(3, "a"))
    runs = [replace(run, key=run.key._replace(domain="lamps"))]
    found = make_ranking(SPECS["overview"], runs, make_scores_by_model(runs), with_paper=False)
    assert found is not None
    assert [row.model for row in found.rows] == ["a"]
