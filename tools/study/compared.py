"""Checks that compare rates, look for steps and errors, or look for words: one function for many statements.

The rest of a check after its kind is read here:

    rates: most strong: V/SD/parsing = 0           in how many models a comparison holds
    rates: GPT-4o: V/SD/state_goal > 90            in one model
    clearly: all models: V/AS/task_success > B/AS/task_success
    clearly: all models: V/SD/affordance of Llama 3 8B > V/SD/affordance
    strength: V/SD/relation_goal                   whether a rate rises with success
    step: V/SD/wrong_order/PLUGIN light            steps that failed, by a pattern
    missed: V/SD/DRINK                             goals that executed answers miss, by a pattern
    error: B/SD/argument_number/nextto takes       errors, by a pattern
    asked: all B/SD: open .* first                 questions that hold a pattern
    checks: no B/SLICE/both_hands                  checks of an action in the simulator, by a pattern
    gold: V/read/effect/^\\(\\)$                      annotated operators, by a pattern
    alone: V/object_affordance/grab/1.0            problems solved with one operator of GPT-4o
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from math import hypot
from typing import NamedTuple

from claim import Finding, Status, by_degree
from evidence import GPT_4O, NAMED, Evidence, Suite
from measures_rates import OPEN_MODELS, STRONG
from rates import ABILITIES, WORLDS, column_of, if_so, measured_rates, printed_rates

from eai.abilities.protocol import Ability
from eai.abilities.verdict import EMPTY_SHARE
from eai.benchmarks.registry import find_benchmark
from eai.results.certainty import TaskRateContribution
from eai.results.comparison import compare_metric
from eai.results.paper_tables import map_files_to_paper_models
from eai.results.record import Record
from eai.results.summary import compute_metric_contributions_by_task, find_task_name
from eai.results.table import Estimate
from eai.studies.cofactors.effects import compute_rank_correlation
from eai.tasks.share import Share
from eai.world.operator import Operator

SIGNS: Mapping[str, Callable[[float, float], bool]] = {
    "<": lambda left, right: left < right - 1e-9,
    ">": lambda left, right: left > right + 1e-9,
    "=": lambda left, right: abs(left - right) < 0.05,
}
P_LIMIT = 0.05
MAX_NAMED = 4
"""Maximum number of exceptions that are named."""

ALL_SUITES = tuple(f"{world}/{ability}" for world in WORLDS for ability in ABILITIES)

_NUMBER = re.compile(r"[\d.]+")


class Comparison(NamedTuple):
    """A comparison of two rates in models.

    Attributes:
        share: ``all``, ``most``, or empty for one model.
        group: the models.
        left: the first rate, as a check writes it.
        sign: how they compare.
        right: the second rate or a number.
    """

    share: str
    group: str
    left: str
    sign: str
    right: str


def read_comparison(text: str) -> Comparison:
    """Read a comparison such as ``most strong: V/SD/parsing = 0``."""
    who, _, what = text.partition(": ")
    share, _, group = who.partition(" ")
    left, sign, right = re.split(r" ([<>=]) ", what)
    one = share not in ("all", "most")
    return Comparison("" if one else share, who if one else group, left, sign, right)


def rates(evidence: Evidence, text: str) -> Finding:
    """Count the models in which a comparison holds, by the paper's tables and by the public answers."""
    asked = read_comparison(text)
    shown, counts = [], []
    for name, printed in (("table", True), ("public answers", False)):
        left, right = (_rates(evidence, side, printed=printed) for side in (asked.left, asked.right))
        models = [model for model in _members(evidence, asked.group) if model in left and model in right]
        if not models:
            continue
        wrong = [model for model in models if not SIGNS[asked.sign](left[model], right[model])]
        counts.append((len(models) - len(wrong), len(models)))
        shown.append(f"{name} {_shown(asked, left, right, wrong, len(models))}")
    return Finding(_degree(asked.share, counts), f"{_words(asked)}: {'; '.join(shown)}")


def clearly(evidence: Evidence, text: str) -> Finding:
    """Count the models in which a difference is clear.

    Two rates of one suite differ clearly if p < 0.05 in a paired test, whose units are names of tasks. Rates
    of two worlds differ clearly if the 95 % interval of their difference, by Newcombe's method, excludes 0.
    """
    asked = read_comparison(text)
    column, _, leader = asked.left.partition(" of ")
    is_paired = _suite_of(column) == _suite_of(asked.right)
    hits = []
    for model in _members(evidence, asked.group):
        first = _records(evidence, column, leader or model)
        second = _records(evidence, asked.right, model)
        if first and second and model != leader:
            clear = _leads if is_paired else _is_apart
            hits.append((model, clear(first, second, column, asked.right, asked.sign)))
    wrong = [model for model, holds in hits if not holds]
    rule = f"p < {P_LIMIT}, paired" if is_paired else "95 % interval of the difference"
    number = f"{len(hits) - len(wrong)} of {len(hits)} models{_but(wrong)}"
    if not asked.share:
        number = "no" if wrong else "yes"
    return Finding(
        _degree(asked.share, [(len(hits) - len(wrong), len(hits))]),
        f"{_words(asked)}, clearly ({rule}): {number}",
    )


def strength(evidence: Evidence, text: str) -> Finding:
    """Correlate a rate with task success over models; ``falls`` in front asks for the other direction."""
    falls, column = text.startswith("falls "), text.removeprefix("falls ")
    world, ability, _ = column.split("/")
    values = _rates(evidence, column, printed=False)
    success = _rates(evidence, f"{world}/{ability}/task_success", printed=False)
    names = sorted(values.keys() & success.keys())
    found = compute_rank_correlation(
        [success[name] for name in names], [values[name] for name in names], names
    )
    low, high = found.low or 0, found.high or 0
    holds, some = (high < 0, (found.value or 0) < 0) if falls else (low > 0, (found.value or 0) > 0)
    return if_so(
        holds,
        f"{_suite_of(column)}: rank correlation of {_metric(column)} with success over {len(names)} "
        f"models {found.value or 0:+.2f} [{low:+.2f}, {high:+.2f}]",
        in_part=some,
    )


def step(evidence: Evidence, text: str) -> Finding:
    """Look for failed steps of a kind whose action, objects and reason match a pattern."""
    world, ability, outcome, pattern = text.split("/", 3)
    suite = Suite(WORLDS[world], ABILITIES[ability])
    models = [
        line.model
        for line in evidence.of(evidence.tables.steps, suite)
        if line.outcome == outcome and re.search(pattern, f"{line.operator} {line.objects} {line.reason}")
    ]
    return _occurs(models, f"{suite}: steps with {outcome.replace('_', ' ')} like “{_plain(pattern)}”")


def missed(evidence: Evidence, text: str) -> Finding:
    """Look for goals that match a pattern and that executed answers do not reach."""
    world, ability, pattern = text.split("/", 2)
    suite = Suite(WORLDS[world], ABILITIES[ability])
    executed = {(each.model, each.task) for each in evidence.answers(suite) if each.executable}
    models = [
        goal.model
        for goal in evidence.of(evidence.tables.goals, suite)
        if not goal.satisfied and (goal.model, goal.task) in executed and re.search(pattern, goal.text)
    ]
    return _occurs(models, f"{suite}: missed goals like “{_plain(pattern)}”")


def error(evidence: Evidence, text: str) -> Finding:
    """Look for errors of a kind whose message matches a pattern."""
    world, ability, kind, pattern = text.split("/", 3)
    suite = Suite(WORLDS[world], ABILITIES[ability])
    models = [
        record.model
        for records in evidence.suites[suite].values()
        for record in records
        if (found := record.verdict.error) is not None
        and found.kind.value == kind
        and re.search(pattern, found.detail)
    ]
    return _occurs(models, f"{suite}: {kind.replace('_', ' ')} errors like “{_plain(pattern)}”")


def asked(evidence: Evidence, text: str) -> Finding:
    """Count the shipped questions that hold a pattern; ``no`` asks for none."""
    who, _, pattern = text.partition(": ")
    share, _, places = who.partition(" ")
    wanted, total, shown = 0, 0, []
    for place in ALL_SUITES if places == "suites" else places.split("+"):
        world, ability = place.split("/")
        prompts = (
            find_benchmark(WORLDS[world]).official_prompts(Ability(ABILITIES[ability]), evidence.published)
            or {}
        )
        texts = [f"{prompt.system or ''}\n{prompt.user}" for prompt in prompts.values()]
        hits = sum(re.search(pattern, each, re.DOTALL) is not None for each in texts)
        wanted += hits if share == "all" else len(texts) - hits
        total += len(texts)
        shown.append(f"{Suite(WORLDS[world], ABILITIES[ability])} {hits} of {len(texts)}")
    return if_so(
        wanted == total, f"shipped questions with “{_plain(pattern)}”: {'; '.join(shown)}", in_part=wanted > 0
    )


def gold(evidence: Evidence, text: str) -> Finding:
    """Look for a pattern in a side of an annotated operator."""
    world, name, side, pattern = text.split("/", 3)
    library = next(iter(find_benchmark(WORLDS[world]).operator_tasks(evidence.published).values())).domain
    if name not in library.operators:
        return if_so(False, f"{NAMED[WORLDS[world]]} has no operator {name}")
    words = " ".join(getattr(library.operators[name], side).split())
    return if_so(re.search(pattern, words) is not None, f"annotated {side} of {name}: {words or 'empty'}")


def checks(evidence: Evidence, text: str) -> Finding:
    """Look for a pattern in the checks of an action of the simulator; ``no`` asks for none."""
    share, _, place = text.partition(" ")
    world, name, pattern = place.split("/", 2)
    operator = find_benchmark(WORLDS[world]).domain.find_operator(name)
    hits = [id for id in list_check_ids(operator) if re.search(pattern, id)]
    shown = ", ".join(hit.replace("_", " ") for hit in dict.fromkeys(hits)) or "no such check"
    return if_so(bool(hits) == (share == "all"), f"{name} in the simulator: {shown}")


def list_check_ids(operator: Operator) -> list[str]:
    """Return the ids of an action's checks, with those of its alternatives, such as dust and stains."""
    alternatives = (check for alternative in operator.alternatives for check in alternative.checks)
    return [check.id or "" for check in (*operator.checks, *alternatives)]


def alone(evidence: Evidence, text: str) -> Finding:
    """Compare a printed share with problems solved with one operator of GPT-4o among gold ones."""
    world, category, operator, said = text.split("/")
    rate = evidence.sensitivity(WORLDS[world], [GPT_4O]).get((operator, category))
    what = f"{operator}, {category.replace('_', ' ')}"
    if rate is None or rate.share is None:
        return if_so(False, f"{what}: no problem asks for it")
    return if_so(
        abs(rate.share - float(said)) < 0.005 + 1e-9,
        f"{what}: {rate.numerator:g} of {rate.denominator:g} = {rate.share:.2f}",
    )


def _members(evidence: Evidence, group: str) -> list[str]:
    if group in ("models", "strong", "open", "closed"):
        kinds = {
            "models": evidence.names,
            "strong": STRONG,
            "open": OPEN_MODELS,
            "closed": [name for name in evidence.names if name not in OPEN_MODELS],
        }
        return list(kinds[group])
    return [group]


def _rates(evidence: Evidence, side: str, *, printed: bool) -> Mapping[str, float]:
    """Return the rate of each model; a sum of rates if metrics are joined by a plus."""
    if _NUMBER.fullmatch(side):
        return dict.fromkeys(evidence.names, float(side))
    words, _, model = side.partition(" of ")
    *place, metrics = words.split("/")
    columns = [column_of([*place, metric]) for metric in metrics.split("+")]
    parts = [printed_rates(each) if printed else measured_rates(evidence, each) for each in columns]
    sums = {name: sum(part[name] for part in parts) for name in parts[0] if all(name in p for p in parts)}
    return dict.fromkeys(evidence.names, sums[model]) if model and model in sums else sums


def _records(evidence: Evidence, column: str, model: str) -> list[Record]:
    world, ability, _ = column.split("/")
    runs = evidence.suites.get(Suite(WORLDS[world], ABILITIES[ability]), {})
    return next((records for file, records in runs.items() if map_files_to_paper_models()[file] == model), [])


def _cases(records: list[Record], column: str) -> list[TaskRateContribution]:
    metrics = column.split("/")[2].split("+")
    names = {record.task_id: find_task_name(record) for record in records if record.task}
    cases = []
    for task, shares in compute_metric_contributions_by_task(records).items():
        parts = [shares.get(metric, EMPTY_SHARE) for metric in metrics]
        share = Share(sum(part.numerator for part in parts), max(part.denominator for part in parts))
        cases.append(TaskRateContribution(task, names.get(task, task), share))
    return cases


def _leads(first: list[Record], second: list[Record], left: str, right: str, sign: str) -> bool:
    before, after = ({case.task: case for case in _cases(*side)} for side in ((first, left), (second, right)))
    tasks = [task for task in before if task in after]
    found = compare_metric([before[t] for t in tasks], [after[t] for t in tasks], yes_no=False)
    if found.percentage_points is None or found.p_value is None:
        return False
    return found.p_value < P_LIMIT and (
        found.percentage_points < 0 if sign == ">" else found.percentage_points > 0
    )


def _is_apart(first: list[Record], second: list[Record], left: str, right: str, sign: str) -> bool:
    one = Estimate.from_task_rate_contributions(_cases(first, left))
    other = Estimate.from_task_rate_contributions(_cases(second, right))
    upper, lower = (one, other) if sign == ">" else (other, one)
    if None in (upper.value, upper.low, lower.value, lower.high):
        return False
    margin = hypot((upper.value or 0) - (upper.low or 0), (lower.high or 0) - (lower.value or 0))
    return (upper.value or 0) - (lower.value or 0) > margin


def _degree(share: str, counts: list[tuple[int, int]]) -> Status:
    """Return the status of a comparison that holds in some of the models."""
    if share == "most":
        right = [hits > number / 2 for hits, number in counts]
        return by_degree(bool(right) and all(right), any(right))
    hits, number = (sum(each) for each in zip(*counts, strict=True)) if counts else (0, 1)
    return by_degree(hits == number, hits > number / 2 if share else hits > 0)


def _shown(
    asked: Comparison, left: Mapping[str, float], right: Mapping[str, float], wrong: list[str], number: int
) -> str:
    if not asked.share:
        value = f"{left[asked.group]:.1f}"
        return value if _NUMBER.fullmatch(asked.right) else f"{value} and {right[asked.group]:.1f}"
    return f"{number - len(wrong)} of {number} models{_but(wrong)}"


def _but(wrong: list[str]) -> str:
    return f" (not {', '.join(wrong)})" if 0 < len(wrong) <= MAX_NAMED else ""


def _words(asked: Comparison) -> str:
    signs = {"<": "below", ">": "above", "=": "equal to"}
    column, _, leader = asked.left.partition(" of ")
    left, right = (_metric(side) for side in (column, asked.right))
    first, second = _suite_of(column), _suite_of(asked.right)
    if leader:
        return f"{first}: {leader}'s {left} {signs[asked.sign]} that of others"
    if second in (first, None):
        who = "" if asked.share else f"{asked.group}'s "
        return f"{first}: {who}{left} {signs[asked.sign]} {right}"
    return f"{left} in {first} {signs[asked.sign]} {'that' if left == right else right} in {second}"


def _suite_of(side: str) -> Suite | None:
    """Return the suite of a column, or None of a number."""
    if _NUMBER.fullmatch(side):
        return None
    world, ability, *_ = side.partition(" of ")[0].split("/")
    return Suite(WORLDS[world], ABILITIES.get(ability, ability))


def _metric(side: str) -> str:
    """Return the words of a rate, or a number as it is."""
    if _NUMBER.fullmatch(side):
        return side
    parts = side.rpartition("/")[2].split("+")
    return " and ".join(part.replace("_", " ").replace(".", " ") for part in parts)


def _occurs(models: list[str], what: str) -> Finding:
    names = sorted({map_files_to_paper_models().get(model, model) for model in models})
    shown = ", ".join(names) if len(names) <= MAX_NAMED else f"{len(names)} models"
    return if_so(bool(models), f"{what}: {len(models)}{f', of {shown}' if models else ''}")


def _plain(pattern: str) -> str:
    """Return a pattern as a reader of the page can read it."""
    text = re.sub(r"\(\?i\)|\(\?<![^)]*\)|\(\?![^)]*\)", "", pattern).replace("(?:", "(")
    text = re.sub(r"\\[ws][*+]?|\.(\*|\{[^}]*\})|^\^|\$$", " … ", text)
    return " ".join(re.sub(r"\\(.)", r"\1", text).replace("|", " or ").split()).strip("… ")


KINDS: Mapping[str, Callable[[Evidence, str], Finding]] = {
    "rates": rates,
    "clearly": clearly,
    "strength": strength,
    "step": step,
    "missed": missed,
    "error": error,
    "asked": asked,
    "gold": gold,
    "checks": checks,
    "alone": alone,
}
"""The checks of this module, by kind."""
