"""Hypothesis strategies for records of every ability."""

from __future__ import annotations

from typing import Any, TypeVar, get_args, get_type_hints

from hypothesis import strategies as st

from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.explanation import GoalPartReport, GoalReport, StepReport, VerdictExplanation
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.replanning_options import FeedbackLevel, ReplanningOptions
from eai.abilities.transition_modeling.verdict import OperatorReport
from eai.abilities.verdict import ErrorReport, SummaryCounts
from eai.pddl.matching import ClauseComparison
from eai.results.older_records import read_older_experiment
from eai.results.record import AnswerOrigin, Record
from eai.tasks.share import Share
from eai.world.fault import FaultKind

T = TypeVar("T")

COUNTS = st.integers(0, 9)
HALVES = st.integers(0, 9).map(lambda n: n / 2 if n % 2 else n // 2)
TEXTS = st.text(st.characters(), max_size=6)


def with_every_field(declared: type[T], **given: st.SearchStrategy[Any]) -> st.SearchStrategy[T]:
    """Return a strategy of a dataclass whose fields, also those with a default, have any value of their
    types.
    """
    hints = {name: hint for name, hint in get_type_hints(declared).items() if name not in given}
    return st.builds(declared, **{name: st.from_type(hint) for name, hint in hints.items()}, **given)


def records() -> st.SearchStrategy[Record]:
    """Return a strategy of records with any verdict, with and without explanation and origin."""
    return st.sampled_from(PAPER_ABILITIES).flatmap(_of)


def _of(ability: Ability) -> st.SearchStrategy[Record]:
    verdicts = with_every_field(get_declaration(ability).verdict)
    attempts: st.SearchStrategy[list[Attempt]] = st.just([])
    if ability is Ability.ACTION_SEQUENCING:
        attempts = st.lists(with_every_field(Attempt, verdict=verdicts), max_size=2)
    own = {"ability": st.just(ability), "verdict": verdicts, "attempts": attempts.map(tuple)}
    plain = with_every_field(Record, experiment=st.none(), summaries=st.just({}), **own)
    return plain | EXPERIMENTS.flatmap(lambda each: _varied(each, own))


def _varied(experiment: Experiment, own: dict[str, st.SearchStrategy[Any]]) -> st.SearchStrategy[Record]:
    """Return a strategy of records of an experiment, with and without summaries of its studies."""
    said = st.dictionaries(TEXTS, COUNTS | TEXTS | st.lists(COUNTS), min_size=1)
    summaries = st.fixed_dictionaries({}, optional=dict.fromkeys(experiment.study, said))
    return with_every_field(Record, experiment=st.just(experiment), summaries=summaries, **own)


st.register_type_strategy(str, TEXTS)
st.register_type_strategy(Protocol, st.sampled_from([*Protocol.list_names()]))
st.register_type_strategy(float, st.floats(allow_nan=False, allow_infinity=False))
st.register_type_strategy(Share, st.builds(Share, HALVES, COUNTS))
for kind in (
    ClauseComparison,
    OperatorReport,
    ErrorReport,
    AnswerUsage,
    StepReport,
    GoalReport,
    GoalPartReport,
):
    st.register_type_strategy(kind, with_every_field(kind))
st.register_type_strategy(
    SummaryCounts,
    with_every_field(SummaryCounts, errors=st.dictionaries(st.sampled_from(FaultKind), COUNTS)),
)
REPLANNING = with_every_field(
    ReplanningOptions,
    replans=COUNTS,
    slip=st.floats(0, 1),
    preset=st.sampled_from((None, "eai-1.0.5")),
    feedback=st.sampled_from([each for each in get_args(FeedbackLevel) if each != "state"]),
)
NAMED = st.fixed_dictionaries(
    {},
    optional={
        **dict.fromkeys(("goals_from", "subgoals_from"), st.just("a/b")),
        "prompt_name": st.just("base"),
        "scene": st.just("image"),
        "harness": st.just("react"),
        "effort": st.just("high"),
        "rules": st.just("until-goal"),
    },
)
EXPERIMENTS = st.builds(read_older_experiment, NAMED, REPLANNING).filter(lambda each: each != Experiment())
st.register_type_strategy(Experiment, EXPERIMENTS)
for kind in (VerdictExplanation, AnswerOrigin):
    st.register_type_strategy(kind, with_every_field(kind))
