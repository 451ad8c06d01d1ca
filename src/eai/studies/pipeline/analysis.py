"""Pipelines against single abilities (paper, "Pipeline-based vs modularized"): where the loss comes from.

Two runs are compared on the same tasks: modular, where questions state the goals of the task, and the
pipeline, where they state those that a model interpreted itself. Tasks are distinguished by how right these
are; where they are right, nothing is lost to interpretation. What a perfect second stage would make of them
is found by search.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import share_of_one
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_planned_book, replace_goals
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.planning.search import Limits
from eai.results.certainty import Case, Cases
from eai.results.comparison import compare
from eai.results.lines import SuiteKey
from eai.results.paper_tables import read_paper_models, read_paper_table
from eai.results.rate import rate_of
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import cases_of, name_of
from eai.results.table import Estimate, Row, Table, make_table
from eai.studies.pipeline.operator_chain import analyze_operators
from eai.studies.pipeline.stage_one import STUDY, read_interpretations
from eai.studies.records import Records
from eai.studies.study import Analysis, paper_remarks, suite_title
from eai.tasks.source import Source

_EFFORT = 400
"""How much a perfect second stage may search; contradictory goals would use up any limit."""

_NOT_SHOWN = ("p", "only modular", "only pipeline")
"""The columns that are in the files alone."""

_KINDS = ("exactly right", "all, and others", "some missing", "no answer")
"""How right the goals are that a question states."""

_GOALS = "goals"
"""The kind of a pipeline that states goals and no subgoals."""

_COMPARED = ("modular", "pipeline", "difference", "p")
_PAPER = ("paper modular", "paper pipeline")
_PERFECT = "perfect stage 2"


def _kind_of(record: Record) -> str:
    """The kind of the stated goals: all that is stated besides the task's is one of the others."""
    if STUDY not in record.summaries:
        return "no answer"
    _, others, missed = record.summaries[STUDY]["goal_counts"]
    return "some missing" if missed else "all, and others" if others else "exactly right"


@dataclass(frozen=True, slots=True)
class _Pair:
    """A model's run of one ability alone, and the same where the goals are interpreted ones.

    Attributes:
        modular: the records of the one, at least one.
        pipeline: those of the other, of the same suite under the same protocol.
        reachable: whether a perfect second stage reaches the goals of the task, by id; empty if not known.
        asked: the predicates of the conditions that each task asks for, by its id, and whether its goals
            lack each; empty if not known.
        paper: the figures of the paper for the model, by metric: modular and pipeline.
    """

    modular: Sequence[Record]
    pipeline: Sequence[Record]
    reachable: Mapping[str, bool]
    asked: Mapping[str, Sequence[tuple[str, bool]]]
    paper: Mapping[str, tuple[float | None, float | None]]

    @property
    def suite(self) -> SuiteKey:
        """The suite of both."""
        record = self.modular[0]
        return SuiteKey(record.protocol.value, record.domain, record.ability.value)

    @property
    def chain(self) -> str:
        """The kind of the pipeline: whether subgoals are stated too, and what else its run varies."""
        experiment = self.pipeline[0].experiment or Experiment()
        rest = experiment.drop_study(STUDY)
        kind = "goals and subgoals" if "subgoals_from" in experiment.study[STUDY].options else _GOALS
        return kind if rest is None else f"{kind}, {rest.label}"

    @property
    def metric(self) -> str:
        """The metric of success."""
        return next(iter(declaration_of(self.modular[0].ability).overview_headings))

    def tables(self) -> list[Table]:
        """All tables for which there is what they need."""
        stages, goals = self._stages(), self._goals()
        made = [
            stages if self.paper else stages.drop(_PAPER),
            goals if self.reachable else goals.drop([_PERFECT]),
            self._first_stage(),
        ]
        if any("subgoals_sha256" in record.summaries.get(STUDY, {}) for record in self.pipeline):
            made.append(self._breaks())
        return [*made, self._missed()] if self.asked else made

    @make_table("chain", ("breaks at", "tasks", "share", "success"))
    def _breaks(self) -> Iterator[Row]:
        """Where the chain breaks.

        Tasks by the first ability whose answer fails: stated goals miss a goal of the task, subgoals fail
        when they are carried out, or the plan fails. `success`: the plan is right all the same.
        """
        records = self._shared(self.pipeline)
        successes = {case.task: case for case in self._cases(records)}
        places = {each.task_id: _break_of(each, successes[each.task_id]) for each in records}
        for place in (*_LINKS, "nowhere"):
            shares = [
                Case(each.task_id, name_of(each), share_of_one(places[each.task_id] == place))
                for each in records
            ]
            here = [successes[each.task_id] for each in records if places[each.task_id] == place]
            yield place, len(here), Estimate.from_cases(shares), Estimate.from_cases(here)

    @make_table("stages", ("metric", *_COMPARED, *_PAPER))
    def _stages(self) -> Iterator[Row]:
        """Modular and pipeline.

        Percent, and pipeline minus modular in points, with 95 % intervals whose units are the names of tasks;
        p is of the exact test in which the tasks of a name share a coin (McNemar's where each task has its
        own).{self._beside}
        """
        declared = declaration_of(self.modular[0].ability)
        differences = compare(self.modular, self.pipeline).differences
        before, after = (
            cases_of(self._shared(side), declared.ability) for side in (self.modular, self.pipeline)
        )
        for metric in declared.terminal_metrics:
            one, other = before.get(metric, []), after.get(metric, [])
            p_value = differences[metric].p_value if metric in differences else None
            yield (metric, *_compared(one, other), p_value, *self.paper.get(metric, (None, None)))

    @property
    def _beside(self) -> str:
        return " Beside them the paper's figures for this model." if self.paper else ""

    @make_table("goals", ("goals", "tasks", *_COMPARED, "only modular", "only pipeline", _PERFECT))
    def _goals(self) -> Iterator[Row]:
        """Where the loss comes from.

        Tasks by the goals that their questions stated, success in both runs, and how many tasks only one of
        them solves. Goals are judged under strict; others are wrong goals, ill-formed ones and such as name
        what does not exist.{self._searched}
        """
        believed = {record.task_id: _kind_of(record) for record in self._shared(self.pipeline)}
        for kind in (*_KINDS, "all"):
            tasks = {task for task, known in believed.items() if kind in (known, "all")}
            if tasks:
                modular, pipeline = self._of(self.modular, tasks), self._of(self.pipeline, tasks)
                success = next(iter(compare(modular, pipeline).differences.values()))
                only = len(success.only_first), len(success.only_second)
                one, other = self._cases(modular), self._cases(pipeline)
                perfect = [
                    case._replace(share=share_of_one(self.reachable.get(case.task, False))) for case in other
                ]
                compared = *_compared(one, other), success.p_value
                yield (kind, len(one), *compared, *only, Estimate.from_cases(perfect))

    @property
    def _searched(self) -> str:
        return (
            " A perfect stage 2 finds a plan for the stated goals by search, where there is one, and is "
            "judged under strict: a yardstick and no bound, since a model may reach goals that it did not "
            "state."
            if self.reachable
            else ""
        )

    @make_table("stage_1", ("answer", "tasks", "pipeline"))
    def _first_stage(self) -> Iterator[Row]:
        """Outcomes of the first stage.

        How many tasks had such an answer to goal interpretation, and success in the pipeline. All of them are
        in every rate above.
        """
        records = self._shared(self.pipeline)
        kinds: dict[str, Callable[[Record], bool]] = {
            "no answer": lambda record: STUDY not in record.summaries,
            "unreadable, so that no goals were stated": _states("stage_1_unreadable"),
            "names what does not exist": _states("stage_1_unknown"),
            "has ill-formed entries": _states("stage_1_left_out"),
        }
        successes = {case.task: case for case in self._cases(records)}
        for heading, is_so in kinds.items():
            found = [successes[record.task_id] for record in records if is_so(record)]
            yield heading, len(found), Estimate.from_cases(found)

    @make_table("missed", ("condition", "missing", "tasks", "modular solves", "pipeline solves"))
    def _missed(self) -> Iterator[Row]:
        """Which conditions are missing.

        Of the conditions that tasks ask for, the share that the stated goals lack; how many tasks lack at
        least one, and how many of these each run solves.
        """
        names = {record.task_id: name_of(record) for record in self._shared(self.pipeline)}
        asked = group_pairs(
            (condition, Case(task, name, share_of_one(missed)))
            for task, name in names.items()
            for condition, missed in self.asked.get(task, ())
        )
        for condition in sorted(asked, key=lambda c: (-sum(case.share.numerator for case in asked[c]), c)):
            tasks = {case.task for case in asked[condition] if case.share.numerator}
            sides = [
                rate_of(case.share for case in self._cases(self._of(side, tasks)))
                for side in (self.modular, self.pipeline)
            ]
            solved = [int(side.numerator) for side in sides]
            yield condition, Estimate.from_cases(asked[condition]), len(tasks), *solved

    def _cases(self, records: Sequence[Record]) -> Sequence[Case]:
        """The cases that records add to the metric of success."""
        return cases_of(records, self.modular[0].ability).get(self.metric, ())

    def _shared(self, side: Sequence[Record]) -> list[Record]:
        """The records of one side on the tasks that both have scored."""
        scored = [
            {record.task_id for record in records if record.verdict.excluded is None}
            for records in (self.modular, self.pipeline)
        ]
        return self._of(side, scored[0] & scored[1])

    def _of(self, side: Sequence[Record], tasks: Collection[str]) -> list[Record]:
        return [record for record in side if record.task_id in tasks]


def _states(name: str) -> Callable[[Record], bool]:
    """Return whether a field of the pipeline's summary of a record is neither empty nor 0."""
    return lambda record: bool(record.summaries.get(STUDY, {}).get(name))


_LINKS = ("goal interpretation", "subgoal decomposition", "action sequencing")
"""The abilities of a chain, in order."""


def _break_of(record: Record, success: Case) -> str:
    """The first ability of a chain whose answer fails."""
    stated = record.summaries.get(STUDY)
    fails = (
        stated is None or bool(stated["goal_counts"][2]),
        stated is None or not stated["subgoals_success"],
        not success.share.numerator,
    )
    return next((link for link, is_broken in zip(_LINKS, fails, strict=True) if is_broken), "nowhere")


def _compared(one: Cases, other: Cases) -> tuple[Estimate, Estimate, Estimate]:
    """Two rates, and their difference in points."""
    return Estimate.from_cases(one), Estimate.from_cases(other), Estimate.from_difference(one, other)


def pooled(pipelines: Sequence[_Pair]) -> _Pair:
    """Several as one, in which each answer to a task is one to a task of its own, of the same name."""
    numbered = list(enumerate(pipelines))
    return _Pair(
        [_numbered(number, record) for number, each in numbered for record in each.modular],
        [_numbered(number, record) for number, each in numbered for record in each.pipeline],
        {f"{number} {task}": value for number, each in numbered for task, value in each.reachable.items()},
        {f"{number} {task}": value for number, each in numbered for task, value in each.asked.items()},
        {},
    )


def _numbered(number: int, record: Record) -> Record:
    return replace(record, task_id=f"{number} {record.task_id}")


def _conditions(scorer: Scorer, answer: str) -> Iterator[tuple[str, bool]]:
    """The conditions that are asked for, by predicate, and whether an answer lacks each."""
    assessed = scorer.assess(answer)
    if isinstance(assessed.verdict, GoalVerdict):
        atoms = assessed.explain()
        for conditions, missed in ((assessed.verdict.matched, False), (assessed.verdict.missing, True)):
            yield from ((atoms.statement(condition).signed_name, missed) for condition in conditions)


def analyze(records: Records, goals: Path | None, *, search: bool) -> Iterator[Analysis]:
    """Yield the analyses of operators, and of pipelines: those of a suite and model, and of all models.

    Args:
        records: the records.
        goals: the answers to goal interpretation, if they are at hand.
        search: whether to look for what a perfect second stage would make of them.

    Raises:
        InputError: there is no run of transition modeling under the default protocol, and no pipeline or
            none whose ability was also tried alone.
    """
    runs = list(records.runs())
    chains = list(analyze_operators(runs, records))
    yield from chains
    if chains and not any(map(_is_pipeline, runs)):
        return
    pairs = _pairs(records, runs)
    found = [_opened(*pair, records.source, goals, search=search) for pair in pairs]
    if not found and not chains:
        raise InputError("expected a pipeline beside a plain run of its model, domain, ability and protocol")
    for (suite, chain), pipelines in group_pairs(((each.suite, each.chain), each) for each in found).items():
        for each in pipelines:
            record = each.pipeline[0]
            label = "" if record.experiment is None else record.experiment.label
            folder = f"{suite.file_name}/{to_file_name(record.model)}/{label}" if len(found) > 1 else ""
            yield _analysis(each, f"{record.model}, {label}", folder)
        if len(pipelines) > 1:
            folder = f"{suite.file_name}/{to_file_name(chain)}" if chain != _GOALS else suite.file_name
            yield _analysis(pooled(pipelines), f"{len(pipelines)} pipelines", folder)


def _pairs(records: Records, runs: Sequence[Run]) -> Iterator[tuple[Run, Run]]:
    """The ability alone and the pipeline, for each pipeline, sorted."""
    plain = {run.key: run for run in runs if not _is_pipeline(run)}
    piped = [run for run in runs if _is_pipeline(run)]
    if not piped:
        raise InputError(
            "expected records of a pipeline, which eai run --with pipeline.goals=own and eai score --goals "
            "make, or of transition modeling under strict"
        )
    for run in sorted(piped, key=lambda run: run.key.order):
        experiment = run.key.experiment
        other = None if experiment is None else experiment.drop_study(STUDY)
        alone = plain.get(run.key._replace(experiment=other))
        if alone is None:
            records.note(f"left out, as it has no modular run: {run.key}")
        else:
            yield alone, run


def _is_pipeline(run: Run) -> bool:
    """Whether the questions of a run state interpreted goals."""
    return run.key.experiment is not None and STUDY in run.key.experiment.study


def _opened(one: Run, other: Run, source: Source, goals: Path | None, *, search: bool) -> _Pair:
    key = one.key
    asked: Mapping[str, Sequence[tuple[str, bool]]] = {}
    reachable: Mapping[str, bool] = {}
    if goals is not None:
        benchmark = find_benchmark(key.domain)
        model = other.records[0].study[STUDY].options["goals_from"]
        answers = read_interpretations(goals, benchmark, source, model)[1]
        suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION, source=source)
        asked = {task: list(_conditions(suite.scorer(task), text)) for task, text in answers.items()}
        if search:
            tasks = {record.task_id for record in other.records}
            wanted = {task: text for task, text in answers.items() if task in tasks}
            reachable = dict(_reached(benchmark, wanted, source))
    return _Pair(one.records, other.records, reachable, asked, _paper_figures(key))


def _reached(benchmark: Benchmark, answers: Mapping[str, str], source: Source) -> Iterator[tuple[str, bool]]:
    """Whether a plan for the stated goals, where there is one, reaches those of the task."""
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=source)
    stated = replace_goals(benchmark, answers)
    book = open_planned_book(stated, Ability.ACTION_SEQUENCING, source, Limits(_EFFORT))
    for task_id in suite.task_ids:
        if task_id in answers:
            success = getattr(suite.score(task_id, book[task_id].text), "success", False)
            yield task_id, bool(success)


def _paper_figures(key: RunKey) -> Mapping[str, tuple[float | None, float | None]]:
    """The paper's figures for the model, by metric."""
    name = read_paper_models().get(key.model)
    paper = read_paper_table(f"pipeline_{key.ability.value}")
    columns = [column for column in paper.columns if column.domain == key.domain]
    rows = [f"{name} ({kind})" for kind in ("modular", "pipeline")]
    if not all(row in paper.rows for row in rows):
        return {}
    return {
        column.metric: (paper.figure(rows[0], column), paper.figure(rows[1], column)) for column in columns
    }


def _analysis(found: _Pair, title: str, folder: str) -> Analysis:
    tables, record = found.tables(), found.modular[0]
    heading = f"{title}, {suite_title(found.suite)}"
    goals = next(table for table in tables if table.name == "goals")
    papers = [read_paper_table(f"pipeline_{record.ability.value}")] if found.paper else []
    remarks = paper_remarks(papers, record.protocol) if papers else []
    return Analysis(tables, (), remarks, folder, [_for_screen(goals, heading)])


def _for_screen(table: Table, heading: str) -> Table:
    """The table for the screen: tasks that are solved, and the difference in points, without intervals."""
    shown = table.drop(_NOT_SHOWN)
    return replace(
        shown,
        title=f"{heading}: tasks solved, difference in points",
        rows=tuple([tuple(map(_short, row)) for row in shown.rows]),
    )


def _short(cell: object) -> str:
    if not isinstance(cell, Estimate):
        return str(cell)
    if cell.value is None:
        return "-"
    return f"{cell.value:+.1f}" if cell.numerator is None else f"{cell.numerator:g}"
