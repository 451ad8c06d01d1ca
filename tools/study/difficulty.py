"""Claims on what makes tasks hard."""

from __future__ import annotations

from collections.abc import Sequence

from claim import Claim, Finding, Row, Status, by_degree
from evidence import (
    AS,
    GI,
    GPT_4O,
    NAMED,
    PLANS,
    B,
    Evidence,
    Suite,
    V,
    below_zero,
    rate,
    rho,
    rho_of_means,
    told,
)

from eai.benchmarks.registry import find_benchmark
from eai.results.lines import AnswerLine, compute_contribution_to_main_score, compute_goal_share
from eai.results.table import Estimate

SUITE = Suite(B, AS)
PLACE = "appendix, “Correlation with Action Length and Goal Complexity”"
SUCCESS_BY_LENGTH = {0: 0.70, 10: 0.50, 20: 0.14, 30: 0.17, 40: 0.50, 60: 0.00}
"""The figure's values, by the minimum number of steps."""


def _success(answer: AnswerLine) -> float | None:
    return None if answer.success is None else float(answer.success)


def _executed(answer: AnswerLine) -> float | None:
    return None if answer.executable is None else float(answer.executable)


def _score(answer: AnswerLine) -> float | None:
    share = compute_contribution_to_main_score(answer)
    return share.numerator / share.denominator if share.denominator else None


def _goals(answer: AnswerLine) -> float | None:
    share = compute_goal_share(answer)
    return share.numerator / share.denominator if share.denominator else None


def by_length(evidence: Evidence) -> Finding:
    answers = evidence.answers(SUITE, GPT_4O)
    rows, apart = [], []
    for low, printed in SUCCESS_BY_LENGTH.items():
        those = [each for each in answers if (each.annotated_steps or 0) // 10 * 10 == low]
        ours = rate(those, lambda each: bool(each.success))
        apart.append(abs((ours.value or 0) / 100 - printed))
        rows.append(Row(f"{low} to {low + 9} steps", f"{printed:.2f}", told(ours)))
    trend = rho(answers, "annotated_steps", _success)
    rows.append(Row("rank correlation of success with length", "", told(trend)))
    same = max(apart) <= 0.05
    return Finding(
        by_degree(same, below_zero(trend)),
        f"The plotted values come out (largest difference {max(apart):.3f}); success falls with length."
        if same
        else "The plotted values do not all come out.",
        rows,
    )


def by_goals(evidence: Evidence) -> Finding:
    answers = evidence.answers(SUITE, GPT_4O)
    few = rate([each for each in answers if (each.ground_goals or 0) < 5], lambda each: bool(each.success))
    many = rate([each for each in answers if (each.ground_goals or 0) > 10], lambda each: bool(each.success))
    first, last = few.value or 0, many.value or 0
    return Finding(
        by_degree(first >= 55 and last < 40, last < first),
        f"{first:.0f} % with fewer than five ground goals, {last:.0f} % with more than ten.",
        [
            Row("fewer than 5 ground goals", "around 60 %", told(few)),
            Row("more than 10", "below 40 %", told(many)),
        ],
    )


def _by_kind(kind: str) -> Claim:
    def find(evidence: Evidence) -> Finding:
        feature = f"ground_{kind}_goals"
        one = rho(evidence.answers(SUITE, GPT_4O), feature, _success)
        every = rho_of_means(evidence.answers(SUITE), feature, _success)
        known = below_zero(one)
        return Finding(
            Status.REPRODUCED if known else Status.NOT_SUPPORTED,
            "Success falls with their number."
            if known
            else "The correlation cannot be distinguished from zero, in GPT-4o or in the mean of the models.",
            [
                Row("rank correlation of GPT-4o's success", "", told(one)),
                Row(f"of the mean success of {len(evidence.suites[SUITE])} models", "", told(every)),
            ],
        )

    return Claim(
        {"state": "A3", "relation": "A4"}[kind],
        f"Success falls with the number of {kind} goals",
        f"In BEHAVIOR, GPT-4o's success in action sequencing falls with the number of {kind} goals.",
        PLACE,
        frozenset({SUITE}),
        "the 95 % interval of the rank correlation (ground goals, GPT-4o) is below 0",
        find,
        {
            "state": "With the length of the plan held constant nothing of it is left "
            "([adjusted effects](analyses.md)).",
            "relation": "Plans of tasks with many relation goals are long, too.",
        }[kind],
    )


def opening(evidence: Evidence) -> Finding:
    tried = [each for each in evidence.of(evidence.tables.steps, SUITE, GPT_4O) if each.operator == "OPEN"]
    ours = rate(tried, lambda step: step.outcome == "executed")
    always = ours.numerator == ours.denominator
    return Finding(
        by_degree(always, False),
        f"GPT-4o opens something {len(tried)} times, {'never' if always else 'sometimes'} in vain.",
        [Row("OPEN: steps executed of steps tried", "1.00", told(ours))],
    )


def slicing(evidence: Evidence) -> Finding:
    rates = _by_operator(evidence, GPT_4O)
    ours = rates["SLICE"]
    lowest = all((ours.value or 0) <= (other.value or 0) for other in rates.values())
    tasks = find_benchmark(B).tasks(evidence.published).values()
    needing = sum(any(step.operator == "SLICE" for step in task.script) for task in tasks)
    return Finding(
        by_degree(lowest and needing == 2 and not ours.numerator, lowest and not ours.numerator),
        f"Lowest of all, and never possible; but {needing} tasks need it, not two.",
        [
            Row("SLICE: steps executed of steps tried", "0.00", told(ours)),
            Row("tasks whose annotated plan slices", "2", str(needing)),
        ],
    )


def tools(evidence: Evidence) -> Finding:
    rates = _by_operator(evidence, GPT_4O)
    named = {name: rates[name] for name in ("SLICE", "CLEAN", "SOAK")}
    others = {name: each.value or 0 for name, each in rates.items() if name not in named}
    lowest = min(others, key=lambda name: others[name])
    lower = [name for name, each in named.items() if (each.value or 0) < others[lowest]]
    every = rate(evidence.of(evidence.tables.steps, SUITE, GPT_4O), lambda step: step.outcome == "executed")
    pooled = rate(
        [each for each in evidence.of(evidence.tables.steps, SUITE, GPT_4O) if each.operator in named],
        lambda step: step.outcome == "executed",
    )
    return Finding(
        by_degree(len(lower) == len(named), (pooled.value or 0) < (every.value or 0)),
        f"Lower than every other action are {' and '.join(lower) or 'none'}; {lowest} is lower than the "
        "rest.",
        [
            *(Row(f"{name}: steps executed of steps tried", "", told(each)) for name, each in named.items()),
            Row(f"{lowest}: likewise", "", told(rates[lowest])),
            Row("all actions", "", told(every)),
        ],
    )


def hands(evidence: Evidence) -> Finding:
    rows, ahead = [], 0
    for model in sorted(evidence.suites[SUITE], key=lambda name: name != GPT_4O):
        right, left = (_hand(evidence, model, hand) for hand in ("RIGHT", "LEFT"))
        ahead += (right.value or 0) > (left.value or 0)
        if model == GPT_4O:
            rows += [
                Row(f"GPT-4o: {name} hand", "", told(each))
                for name, each in (("right", right), ("left", left))
            ]
            apart = (right.value or 0) - (left.value or 0)
            overlap = (left.high or 100) > (right.low or 0)
    models = len(evidence.suites[SUITE])
    rows += [
        Row(f"all models: {hand.lower()} hand", "", told(_hand(evidence, None, hand)))
        for hand in ("RIGHT", "LEFT")
    ]
    rows.append(Row("models in which the right hand is ahead", "", f"{ahead} of {models}"))
    return Finding(
        by_degree(apart > 0 and not overlap, apart > 0),
        f"In GPT-4o the difference is {apart:.1f} points, with intervals that "
        f"{'overlap' if overlap else 'are apart'}; it has this direction in {ahead} of {models} models.",
        rows,
    )


def opened(evidence: Evidence) -> Finding:
    counts: dict[str, list[bool]] = {}
    goals = evidence.of(evidence.tables.goals, SUITE, GPT_4O)
    for name in sorted({name for each in goals for name in each.predicates.split()}):
        counts[name] = [each.satisfied for each in goals if name in each.predicates.split()]
    order = sorted(counts, key=lambda name: -sum(counts[name]) / len(counts[name]))
    rows = [
        Row(
            f"goals with {name}",
            "",
            told(rate([g for g in goals if name in g.predicates.split()], lambda g: g.satisfied)),
        )
        for name in order[:3]
    ]
    return Finding(
        by_degree(order[0] == "open", "open" in order[:3]),
        f"The highest is {order[0]}, {sum(counts[order[0]])} of {len(counts[order[0]])}; the intervals of "
        "the first three overlap widely.",
        rows,
    )


def trajectories(evidence: Evidence) -> Finding:
    rows, below = [], []
    for suite in PLANS:
        answers = [each for each in evidence.answers(suite) if each.annotated_steps]
        for name, value in (("execution", _executed), ("success", _success)):
            found = rho(answers, "annotated_steps", value)
            below.append(below_zero(found))
            rows.append(Row(f"{suite}: {name} with annotated length", "", told(found)))
    return Finding(
        by_degree(all(below), any(below)),
        f"Below 0 with the whole interval in {sum(below)} of {len(below)} correlations.",
        rows,
    )


def complexity(evidence: Evidence) -> Finding:
    rows, below = [], []
    for domain in (V, B):
        found = rho_of_means(evidence.answers(Suite(domain, GI)), "objects", _score)
        below.append(below_zero(found))
        rows.append(Row(f"{NAMED[domain]}: mean F1 of goal interpretation with objects", "", told(found)))
    for suite in PLANS:
        found = rho(evidence.answers(suite), "objects", _goals)
        below.append(below_zero(found))
        rows.append(Row(f"{suite}: share of goals reached with objects", "", told(found)))
    once = evidence.answers(SUITE, next(iter(evidence.suites[SUITE])))
    entangled = rho(once, "objects", lambda each: each.annotated_steps)
    rows.append(Row("tasks of BEHAVIOR: annotated length with objects", "", told(entangled)))
    return Finding(
        by_degree(all(below), any(below)),
        f"Below 0 with the whole interval in {sum(below)} of {len(below)} correlations.",
        rows,
    )


def _by_operator(evidence: Evidence, model: str) -> dict[str, Estimate]:
    steps = evidence.of(evidence.tables.steps, SUITE, model)
    return {
        name: rate([each for each in steps if each.operator == name], lambda step: step.outcome == "executed")
        for name in sorted({each.operator for each in steps})
    }


def _hand(evidence: Evidence, model: str | None, hand: str) -> Estimate:
    steps = evidence.of(evidence.tables.steps, SUITE, model)
    return rate(
        [each for each in steps if each.operator.startswith(f"{hand}_")],
        lambda step: step.outcome == "executed",
    )


CLAIMS: Sequence[Claim] = (
    Claim(
        "A1",
        "Success falls with the length of the annotated plan",
        "In BEHAVIOR, GPT-4o's success in action sequencing falls with the number of steps of the annotated"
        " plan; a figure shows it in bins of ten.",
        PLACE,
        frozenset({SUITE}),
        "every bin within 0.05 of the figure",
        by_length,
        "Of 10 to 19 steps one plan less succeeds than in the figure ([why](analyses.md)). The figure draws "
        "empty bins as 0; here they are left out. It has no intervals: six tasks are in "
        "the fourth bin, two in the fifth and one in the last.",
    ),
    Claim(
        "A2",
        "Success falls with the number of goals",
        "From around 60 % for tasks with fewer than five goals to below 40 % for tasks with more than ten.",
        "“Summary of Empirical Findings”, appendix",
        frozenset({SUITE}),
        "at least 55 % and below 40 %",
        by_goals,
        "Goals are read as ground conditions; of the conjuncts of goals only one task has more than ten.",
    ),
    _by_kind("state"),
    _by_kind("relation"),
    Claim(
        "A5",
        "Opening always succeeds",
        "GPT-4o's OPEN is executed in all cases.",
        PLACE,
        frozenset({SUITE}),
        "all steps that were tried are executed",
        opening,
    ),
    Claim(
        "A6",
        "Slicing is hardest",
        "SLICE is executed least; two tasks of BEHAVIOR need it, and GPT-4o fails in both.",
        PLACE,
        frozenset({SUITE}),
        "no step of it is executed, and two tasks need it",
        slicing,
    ),
    Claim(
        "A7",
        "Actions with tools are hard",
        "SOAK, SLICE and CLEAN are seldom executed, since they take the right tool.",
        PLACE,
        frozenset({SUITE}),
        "each of the three below every other action; in part if the three together are below the mean",
        tools,
        "That plans with tools fail more often is much firmer than this ranking: it is the strongest of the"
        " [adjusted effects](analyses.md).",
    ),
    Claim(
        "A8",
        "The right hand does better than the left",
        "Actions of the right hand are executed slightly more often than those of the left.",
        PLACE,
        frozenset({SUITE}),
        "in GPT-4o, with intervals that do not overlap; in part if it is so without that",
        hands,
        "Nothing in the benchmark treats the hands differently.",
    ),
    Claim(
        "A9",
        "Goals of opening are met most",
        "Of all predicates, goals with open are met most often.",
        PLACE,
        frozenset({SUITE}),
        "it has the highest rate in GPT-4o",
        opened,
    ),
    Claim(
        "A10",
        "The longer a plan must be, the worse its execution",
        "Trajectory evaluation falls with the length of the sequence, across simulators.",
        "introduction; results",
        frozenset(PLANS),
        "all rank correlations (all answers of all models) below 0 with their 95 % intervals",
        trajectories,
        "“Length” is that of the annotated plan. With the number of steps that were *tried* the sign is the"
        " opposite, because a failing plan ends early.",
    ),
    Claim(
        "A11",
        "The more complex the environment, the fewer goals",
        "Goal evaluation falls as the environment becomes more complex, with more objects and features.",
        "introduction; results",
        frozenset({*PLANS, Suite(V, GI), Suite(B, GI)}),
        "all rank correlations with the number of relevant objects below 0 with their 95 % intervals",
        complexity,
        "Objects and length go together: of the two taken together only length is left "
        "([adjusted effects](analyses.md)).",
    ),
)
