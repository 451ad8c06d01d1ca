"""What the data set says of a task beside an answer to it, where it is at hand; nothing is fetched for it."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.explanation import action_text
from eai.abilities.planning import find_plan
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.task import Task
from eai.abilities.verdict import ErrorReport, PlanVerdict, Unreadable
from eai.benchmark.gold_answers import open_answer_book
from eai.benchmark.registry import registered
from eai.benchmark.suite import Suite, open_suite
from eai.data import dataset
from eai.data.store import Store
from eai.errors import EaiError
from eai.households.packs import published_packs
from eai.planning.planner import Planner
from eai.tasks.source import ErrataChoice, Source


@dataclass(frozen=True, slots=True)
class TaskBackground:
    """What the data set says of the task of a record.

    Attributes:
        instruction: the task in words.
        gold: the steps of a plan that solves it, as texts.
        source: whose plan that is.
        rest: those of the answer's steps that were not tried any more.
    """

    instruction: str
    gold: tuple[str, ...] = ()
    source: str = ""
    rest: tuple[str, ...] = ()


def background_of(record: Record, store: Store) -> TaskBackground | None:
    """What the data set says of a record's task; None where it is not at hand, or another than was used."""
    if record.domain not in registered():
        return None
    if any(status.problem for status in dataset.info(store, packs=published_packs())):
        return None
    try:
        opened_with = Source(store, errata=ErrataChoice.CURRENT if record.errata else ErrataChoice.NONE)
        suite = open_suite(record.domain, record.ability, record.protocol, source=opened_with)
        task = suite.tasks.get(record.task_id)
        if task is None or suite.data_sha256 != record.data_sha256:
            return None
        gold, source = _gold(suite, task)
        return TaskBackground(task.instruction, gold, source, _rest(suite, record))
    except EaiError:
        return None


def _gold(suite: Suite, task: Task) -> tuple[tuple[str, ...], str]:
    """A plan that solves a task, as steps or as subgoals, and whose it is; none for other abilities."""
    if suite.ability is Ability.SUBGOAL_DECOMPOSITION:
        book = open_answer_book(suite.benchmark, suite.ability, suite.source)
        return book.gold(task.id).parts, "gold subgoals"
    if suite.ability is not Ability.ACTION_SEQUENCING:
        return (), ""
    if task.script:
        return tuple(action_text(action, task.scene) for action in task.script), "the data set's plan"
    found = find_plan(task, Planner(suite.benchmark.domain)).plan or ()
    return tuple(action_text(action, task.scene) for action in found), "a plan by eai/planner"


def _rest(suite: Suite, record: Record) -> tuple[str, ...]:
    """The steps of a plan that come after the one that ended it."""
    verdict, scorer = record.verdict, suite.scorer(record.task_id)
    if record.explanation is None or not isinstance(verdict, PlanVerdict) or verdict.executable:
        return ()
    if not isinstance(scorer, ActionSequencing):
        return ()
    plan = scorer.notation.read(record.response)
    actions = None if isinstance(plan, Unreadable) else scorer.resolve(plan)
    if actions is None or isinstance(actions, ErrorReport):
        return ()
    tried = len(record.explanation.steps)
    return tuple(action_text(action, scorer.task.scene) for action in actions[tried:])
