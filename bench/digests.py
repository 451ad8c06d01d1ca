"""Compare the digests of all verdicts on the oracle's answers with digests.json.

A change of code that must change no verdict leaves the digests equal.

    python -m bench digests              compares with digests.json; the exit status is 1 if they differ
    python -m bench digests --write      writes digests.json
    python -m bench digests --rows DIR   also writes every verdict, one a line, to compare with `diff`
    python -m bench digests --only behavior/action_sequencing
    python -m bench digests --only /plan       planners alone

The digests of verdicts do not depend on a planner. Planners have their own digests: the outcomes of the
built-in planner with the operators of all answers (gold ones too), its plans, and the plans for all tasks of
a household. Search effort is left out; the number of outcomes of each kind is printed.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

from eai.abilities.protocol import Ability, Protocol
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.planning.planner import Planner
from eai.results.codec import verdict_to_record_fields
from eai.tasks.planning import find_plan
from eai.tasks.source import Source

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))  # if called as a file

from differential.oracle_answers import answer_files, oracle_answers, require_oracle

DIGESTS = Path(__file__).with_name("digests.json")

FIELDS = (
    "status",
    "excluded_reason",
    "executable",
    "success",
    "error",
    "additional_steps",
    "category",
    "goals",
    "counts",
    "planner",
    "repairs",
)
"""Fields of every verdict that a digest covers."""

ERROR_FIELDS = ("kind", "step", "detail")
"""Fields of an error that a digest covers. Fields added later are not covered."""

REWORDED = (
    (re.compile(r"(?<= takes 1 )(object|argument)(?=,)"), r"\1s"),
    (
        re.compile(r"no hand holds a cleaning tool, and (\S+) is in no running sink or dishwasher"),
        r"there is no cleaning tool, running sink or dishwasher for \1",
    ),
    (
        re.compile(r"no hand holds a soaked cleaning tool or detergent, and (\S+) is in no running sink"),
        r"there is no soaked cleaning tool, detergent or running sink for \1",
    ),
    (re.compile(r"(?<=an action and an object was found): step .*"), ""),
    (
        re.compile(r"(?<=actions: )the states in between must be subgoals, too"),
        "what lies between is a subgoal, too",
    ),
)
"""Reworded details, with the words that are hashed: those in use when the digests were first taken."""

SUITE_FIELDS: Mapping[str, tuple[str, ...]] = {
    "virtualhome/action_sequencing": (),
    "behavior/action_sequencing": ("goals_satisfied",),
    "virtualhome/subgoal_decomposition": ("errors", "offences", "search", "attempts"),
    "behavior/subgoal_decomposition": ("errors", "goals_satisfied", "search", "attempts"),
    "virtualhome/goal_interpretation": ("predicted", "ill_formed", "hallucinated"),
    "behavior/goal_interpretation": ("predicted", "ill_formed", "hallucinated", "unknown_predicates"),
    "virtualhome/transition_modeling": ("task_categories", "operators", "literals"),
    "behavior/transition_modeling": ("task_categories", "operators", "literals"),
}
"""Further fields of a suite's verdicts that a digest covers."""


RENAMED = {"attempts": "tried_actions"}
"""Present names of renamed fields, by the names under which they are hashed."""

HOUSEHOLDS = ("virtualhome", "behavior")
"""Households whose planners have digests."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--only", default="", help="a part of DOMAIN/ABILITY, or of DOMAIN/plans or planner")
    arguments = parser.parse_args()
    require_oracle()
    known = json.loads(DIGESTS.read_text()) if DIGESTS.exists() else {}
    found: dict[str, str] = {}
    for name, make in _list_digested().items():
        if arguments.only not in name.partition(" ")[0]:
            continue
        lines = list(make())
        found[name] = hashlib.sha256("".join(lines).encode()).hexdigest()
        same = "" if arguments.write else "equal" if known.get(name) == found[name] else "DIFFERS"
        print(f"{name:48} {len(lines):6} {found[name][:16]} {same}", flush=True)
        if "/plan" in name:
            outcomes = Counter(str(json.loads(line)[2]) for line in lines)
            print(f"    {', '.join(f'{number} {each}' for each, number in sorted(outcomes.items()))}")
        if arguments.rows:
            path = arguments.rows / f"{name.replace('/', '-').replace(' ', '-')}.jsonl"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("".join(lines))
    if arguments.write:
        DIGESTS.write_text(json.dumps({**known, **found}, indent=1) + "\n")
    elif any(known.get(name) != digest for name, digest in found.items()):
        sys.exit(1)


def _list_digested() -> dict[str, Callable[[], Iterable[str]]]:
    """Yield everything that has a digest, by name."""
    found: dict[str, Callable[[], Iterable[str]]] = {}
    for suite, protocol in product(SUITE_FIELDS, Protocol.list_names()):
        found[f"{suite} {protocol.value}"] = partial(_score_answers, suite, protocol)
    for household, protocol in product(HOUSEHOLDS, Protocol.list_names()):
        planned = partial(_plan_operators, household, protocol)
        found[f"{household}/planner {protocol.value}"] = partial(_remove_plans, planned)
        found[f"{household}/planner {protocol.value} with plans"] = planned
    return {**found, **{f"{household}/plans": partial(_find_plans, household) for household in HOUSEHOLDS}}


@cache
def _plan_operators(household: str, protocol: Protocol) -> Sequence[str]:
    """Yield the planner's outcome and plan for the operators of each answer, file by file."""
    ability, lines = Ability.TRANSITION_MODELING, []
    for path in answer_files(f"{household}/{ability.value}"):
        opened = open_suite(household, ability, protocol, source=Source(planner=PlannerChoice.BUILT_IN))
        for answer in oracle_answers(path):
            fields = verdict_to_record_fields(opened.score(answer.task_id, answer.text))
            outcome = fields.get("planner"), fields.get("success"), fields.get("plan")
            lines.append(json.dumps([path.name, answer.identifier, *outcome]) + "\n")
    return lines


def _remove_plans(planned: Callable[[], Sequence[str]]) -> Iterator[str]:
    for line in planned():
        yield json.dumps(json.loads(line)[:-1]) + "\n"


def _find_plans(household: str) -> Iterator[str]:
    """Yield the plan for each task of a household."""
    source = Source(planner=PlannerChoice.NONE)
    opened = open_suite(household, Ability.ACTION_SEQUENCING, Protocol.STRICT, source=source)
    planner = Planner(opened.benchmark.domain)
    for task_id, task in opened.tasks.items():
        found = find_plan(task, planner)
        plan = [[action.operator, *action.arguments] for action in found.plan]
        yield json.dumps([household, task_id, found.end.value, plan]) + "\n"


def _score_answers(suite: str, protocol: Protocol) -> Iterator[str]:
    """Yield the verdicts on all answers of a suite, file by file. All answers of a file are read together."""
    domain, ability = suite.split("/")
    for path in answer_files(suite):
        answers = oracle_answers(path)
        source = Source(planner=PlannerChoice.NONE)
        opened = open_suite(domain, Ability(ability), protocol, source=source)
        together = opened.choose_suite_for_answers([answer.text for answer in answers])
        for answer in answers:
            fields = _select_fields(
                suite, verdict_to_record_fields(together.score(answer.task_id, answer.text))
            )
            yield json.dumps([path.name, answer.identifier, fields], sort_keys=True) + "\n"


def _select_fields(suite: str, fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields to compare. Whole numbers lose their decimal point, and empty values are removed."""
    kept = {
        name: _remove_decimal_points(fields.get(RENAMED.get(name, name)))
        for name in (*FIELDS, *SUITE_FIELDS[suite])
    }
    if kept["error"] is not None:
        kept["error"] = {name: kept["error"][name] for name in ERROR_FIELDS}
        for pattern, before in REWORDED:
            kept["error"]["detail"] = pattern.sub(before, kept["error"]["detail"])
    return {name: value for name, value in kept.items() if value not in (None, [], {})}


def _remove_decimal_points(value: Any) -> Any:
    match value:
        case float():
            return int(value) if value.is_integer() else value
        case dict():
            return {key: _remove_decimal_points(part) for key, part in value.items()}
        case list() | tuple():
            return [_remove_decimal_points(part) for part in value]
        case _:
            return value


if __name__ == "__main__":
    main()
