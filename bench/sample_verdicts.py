"""A sample of verdicts to be read as a person would: is each right, and is every sentence true?

    python bench/sample_verdicts.py --number 60 --seed 1
    python bench/sample_verdicts.py --suite behavior/action_sequencing --number 10 --protocol eai-1.0.5

Draws answers of the models in the oracle, the same for the same options: evenly from the suites, two of three
among those that do not succeed. Prints for each the answer, what the scene says at the start of the objects
that the task is about, the verdict and its explanation. No planner is asked about operators.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rich.console import Console

from digests import OWN_FIELDS
from eai.abilities.declaration import AnswerOutcome, declaration_of
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.record import Record
from eai.abilities.reports import fact_text
from eai.abilities.task import Task
from eai.benchmark.suite import Suite, open_suite
from eai.cli.explain import print_record
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source
from oracle_answers import model_files, oracle_answers, require_oracle

FAILURES = 2 / 3
"""The share of answers that do not succeed in a sample."""


class Answer(NamedTuple):
    """A model's answer to a task."""

    model: str
    task_id: str
    text: str
    succeeds: bool


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", default="1")
    parser.add_argument("--number", type=int, default=60, help="how many verdicts, over all suites")
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--protocol", type=Protocol, default=Protocol.STRICT)
    arguments = parser.parse_args()
    require_oracle()
    suites = [suite for suite in OWN_FIELDS if arguments.suite in suite]
    console = Console(width=120, highlight=False)
    for place, name in enumerate(suites):
        suite = _open(name, arguments.protocol)
        share = len(range(place, arguments.number, len(suites)))
        drawn = _draw(list(_answers(name, suite)), share, f"{arguments.seed} {name}")
        for number, answer in enumerate(drawn, 1):
            console.rule()
            console.print(f"{name} {number}: {answer.model} {answer.task_id}", style="bold", soft_wrap=True)
            _show(console, suite, answer)


def _open(name: str, protocol: Protocol) -> Suite:
    domain, ability = name.split("/")
    return open_suite(domain, Ability(ability), protocol, source=Source(planner=PlannerChoice.NONE))


def _answers(name: str, suite: Suite) -> Iterator[Answer]:
    """The scored answers of all models to a suite, model by model."""
    for path in model_files(name):
        for answer in oracle_answers(path):
            verdict = suite.score(answer.task_id, answer.text)
            if verdict.excluded is None:
                came_to = declaration_of(suite.ability).outcome(verdict)
                succeeds = came_to is AnswerOutcome.SUCCESS
                yield Answer(path.name.removesuffix(".json.gz"), answer.task_id, answer.text, succeeds)


def _draw(answers: Sequence[Answer], number: int, seed: str) -> list[Answer]:
    """So many answers: as many failures as there shall be, or as there are."""
    drawn = random.Random(seed)  # noqa: S311 - a repeatable sample
    failures = [answer for answer in answers if not answer.succeeds]
    successes = [answer for answer in answers if answer.succeeds]
    failed = min(len(failures), max(round(number * FAILURES), number - len(successes)))
    return [*drawn.sample(failures, failed), *drawn.sample(successes, min(number - failed, len(successes)))]


def _show(console: Console, suite: Suite, answer: Answer) -> None:
    scorer: Any = suite.scorer(answer.task_id)
    assessment = scorer.assess(answer.text)
    verdict, explanation = assessment.verdict, assessment.explain()
    console.print(" ".join(answer.text.split()), markup=False)
    if isinstance(scorer.task, Task):
        console.print(f"\n{scorer.task.title}: {scorer.task.instruction}", markup=False, style="italic")
        steps = [f"{step.action} {step.reason}" for step in explanation.steps]
        names = answer.text.replace(".", "_")
        words = [answer.text, names, *explanation.notes, *steps, *[goal.goal for goal in explanation.goals]]
        for line in _excerpt(scorer.task, "\n".join(words)):
            console.print(line, markup=False, style="dim")
    console.print()
    place = (suite.protocol, suite.domain, suite.ability, answer.model, answer.task_id, answer.text)
    print_record(console, Record(*place, suite.data_sha256, verdict, explanation))


def _excerpt(task: Task, words: str) -> Iterator[str]:
    """What can change and is so at the start, of the task's objects those that the words name."""
    scene = task.scene
    named = [index for index in task.relevant if scene.objects[index].name in words] + [scene.agent]
    kept = {p.name for p in scene.vocabulary.predicates if p.visible and not p.static}
    facts: dict[int | None, list[str]] = {index: [] for index in named}
    for fact in task.initial.facts():
        if fact.predicate in kept and fact.arguments and facts.keys() >= set(fact.arguments):
            facts[fact.arguments[0]].append(fact_text(fact, scene))
    for index, known in facts.items():
        if index is not None:
            yield f"  {scene.objects[index].name}: {', '.join(known) or '-'}"


if __name__ == "__main__":
    main()
