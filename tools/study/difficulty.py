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
from eai.results.lines import (
    AnswerTableLine,
    compute_contribution_to_main_score,
    compute_share_of_reached_goals,
)
from eai.results.table import Estimate

SUITE = Suite(B, AS)
PLACE = "appendix, “Correlation with Action Length and Goal Complexity”"
SUCCESS_BY_LENGTH = {0: 0.70, 10: 0.50, 20: 0.14, 30: 0.17, 40: 0.50, 60: 0.00}
"""The figure's values, by the minimum number of steps."""


def _success(answer: AnswerTableLine) -> float | None:
    return None if answer.success is None else float(answer.success)


def _executed(answer: AnswerTableLine) -> float | None:
    return None if answer.executable is None else float(answer.executable)


def _score(answer: AnswerTableLine) -> float | None:
    share = compute_contribution_to_main_score(answer)
    return share.numerator / share.denominator if share.denominator else None


def _goals(answer: AnswerTableLine) -> float | None:
    share = compute_share_of_reached_goals(answer)
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
        f"The answers give the plotted values (largest difference {max(apart):.3f}). "
        "Success falls with length."
        if same
        else "The answers do not give all plotted values.",
        rows,
    )


def by_goals(evidence: Evidence) -> Finding:
    answers = evidence.answers(SUITE, GPT_4O)
    few = rate([each for each in answers if (each.ground_goals or 0) < 5], lambda each: bool(each.success))
    many = rate([each for each in answers if (each.ground_goals or 0) > 10], lambda each: bool(each.success))
    first, last = few.value or 0, many.value or 0
    return Finding(
        by_degree(first >= 55 and last < 40, last < first),
        f"Success is {first:.0f} % with fewer than five ground goals and {last:.0f} % with more than ten.",
        [
            Row("fewer than 5 ground goals", "around 60 %", told(few)),
            Row("more than 10 ground goals", "below 40 %", told(many)),
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
            f"Success falls with the number of {kind} goals."
            if known
            else "For GPT-4o, and for the mean of the models, "
            "the correlation cannot be distinguished from zero.",
            [
                Row("rank correlation of GPT-4o's success", "", told(one)),
                Row(
                    f"rank correlation of the mean success of {len(evidence.suites[SUITE])} models",
                    "",
                    told(every),
                ),
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
            "state": "With the length of the plan held constant, no effect of state goals remains "
            "([adjusted effects](../bench/README.md#analyses-of-public-answers)).",
            "relation": "Tasks with many relation goals also have long plans.",
        }[kind],
    )


def opening(evidence: Evidence) -> Finding:
    tried = [each for each in evidence.of(evidence.tables.steps, SUITE, GPT_4O) if each.operator == "OPEN"]
    ours = rate(tried, lambda step: step.outcome == "executed")
    always = ours.numerator == ours.denominator
    return Finding(
        by_degree(always, False),
        f"GPT-4o tries OPEN {len(tried)} times, and {'all' if always else 'not all'} steps are executed.",
        [Row("OPEN: executed of tried steps", "1.00", told(ours))],
    )


def slicing(evidence: Evidence) -> Finding:
    rates = _by_operator(evidence, GPT_4O)
    ours = rates["SLICE"]
    lowest = all((ours.value or 0) <= (other.value or 0) for other in rates.values())
    tasks = find_benchmark(B).tasks(evidence.published).values()
    needing = sum(any(step.operator == "SLICE" for step in task.script) for task in tasks)
    return Finding(
        by_degree(lowest and needing == 2 and not ours.numerator, lowest and not ours.numerator),
        "SLICE has the lowest rate of all actions: none of its steps is executed. "
        f"But {needing} tasks need it, not two.",
        [
            Row("SLICE: executed of tried steps", "0.00", told(ours)),
            Row("tasks whose annotated plan has SLICE", "2", str(needing)),
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
        f"The actions with lower rates than every other action are {' and '.join(lower) or 'none'}. "
        f"Of these other actions, {lowest} has the lowest rate.",
        [
            *(Row(f"{name}: executed of tried steps", "", told(each)) for name, each in named.items()),
            Row(f"{lowest}: executed of tried steps", "", told(rates[lowest])),
            Row("all actions: executed of tried steps", "", told(every)),
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
    rows.append(Row("models with a higher rate for the right hand", "", f"{ahead} of {models}"))
    return Finding(
        by_degree(apart > 0 and not overlap, apart > 0),
        f"For GPT-4o the difference is {apart:.1f} points, and the intervals "
        f"{'overlap' if overlap else 'do not overlap'}. "
        f"The rate of the right hand is higher in {ahead} of {models} models.",
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
        f"Goals with {order[0]} have the highest rate, {sum(counts[order[0]])} of {len(counts[order[0]])}. "
        "The intervals of the three highest rates overlap widely.",
        rows,
    )


def trajectories(evidence: Evidence) -> Finding:
    rows, below = [], []
    for suite in PLANS:
        answers = [each for each in evidence.answers(suite) if each.annotated_steps]
        for name, value in (("execution", _executed), ("success", _success)):
            found = rho(answers, "annotated_steps", value)
            below.append(below_zero(found))
            rows.append(Row(f"{suite}: {name} and annotated length", "", told(found)))
    return Finding(
        by_degree(all(below), any(below)),
        f"The whole interval is below 0 in {sum(below)} of {len(below)} correlations.",
        rows,
    )


def complexity(evidence: Evidence) -> Finding:
    rows, below = [], []
    for domain in (V, B):
        found = rho_of_means(evidence.answers(Suite(domain, GI)), "objects", _score)
        below.append(below_zero(found))
        what = f"{NAMED[domain]}: mean F1 of goal interpretation and number of objects"
        rows.append(Row(what, "", told(found)))
    for suite in PLANS:
        found = rho(evidence.answers(suite), "objects", _goals)
        below.append(below_zero(found))
        rows.append(Row(f"{suite}: share of goals reached and number of objects", "", told(found)))
    once = evidence.answers(SUITE, next(iter(evidence.suites[SUITE])))
    entangled = rho(once, "objects", lambda each: each.annotated_steps)
    rows.append(Row("tasks of BEHAVIOR: annotated length and number of objects", "", told(entangled)))
    return Finding(
        by_degree(all(below), any(below)),
        f"The whole interval is below 0 in {sum(below)} of {len(below)} correlations of scores.",
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
        " plan. A figure shows success in bins of ten steps.",
        PLACE,
        frozenset({SUITE}),
        "every bin is within 0.05 of the figure",
        by_length,
        "In the bin of 10 to 19 steps, one plan fewer succeeds than in the figure. "
        "The figure draws empty bins as 0; the table leaves them out. The figure has no intervals, although "
        "six tasks are in the fourth bin, two in the fifth and one in the last.",
    ),
    Claim(
        "A2",
        "Success falls with the number of goals",
        "Success falls from around 60 % for tasks with fewer than five goals to below 40 % for tasks with "
        "more than ten.",
        "“Summary of Empirical Findings”, appendix",
        frozenset({SUITE}),
        "success is at least 55 % with fewer than five goals and below 40 % with more than ten",
        by_goals,
        "Here a goal is a ground condition. If a goal were a conjunct, only one task would have more than "
        "ten.",
    ),
    _by_kind("state"),
    _by_kind("relation"),
    Claim(
        "A5",
        "Opening always succeeds",
        "GPT-4o's OPEN is executed in all cases.",
        PLACE,
        frozenset({SUITE}),
        "all OPEN steps that were tried are executed",
        opening,
    ),
    Claim(
        "A6",
        "SLICE is the hardest action",
        "SLICE has the lowest execution rate. Two tasks of BEHAVIOR need it, and GPT-4o fails in both.",
        PLACE,
        frozenset({SUITE}),
        "no SLICE step is executed, and two tasks need SLICE",
        slicing,
    ),
    Claim(
        "A7",
        "Actions with tools are hard",
        "SOAK, SLICE and CLEAN are seldom executed, because they need the right tool.",
        PLACE,
        frozenset({SUITE}),
        "the rate of each of the three is below that of every other action; in part if the joint rate of the "
        "three is below that of all actions",
        tools,
        "Plans with tools fail more often. This is much more certain than the ranking: no other "
        "[adjusted effect](../bench/README.md#analyses-of-public-answers) has an interval so far from 0.",
    ),
    Claim(
        "A8",
        "The right hand does better than the left",
        "Actions of the right hand are executed slightly more often than those of the left.",
        PLACE,
        frozenset({SUITE}),
        "GPT-4o's rate is higher for the right hand, and the two intervals do not overlap; in part if they "
        "overlap",
        hands,
        "The benchmark treats both hands alike.",
    ),
    Claim(
        "A9",
        "Goals with open are met most often",
        "Goals with open are met more often than goals with any other predicate.",
        PLACE,
        frozenset({SUITE}),
        "goals with open have the highest rate in GPT-4o's answers",
        opened,
    ),
    Claim(
        "A10",
        "Trajectory scores fall as plans get longer",
        "Trajectory scores fall with the length of the action sequence, across simulators.",
        "introduction; results",
        frozenset(PLANS),
        "the 95 % interval of every rank correlation is below 0, over all answers of all models",
        trajectories,
        "“Length” is the length of the annotated plan. With the number of steps that were *tried*, the "
        "correlation has the opposite sign, because a failing plan ends early.",
    ),
    Claim(
        "A11",
        "Goal scores fall as environments get more complex",
        "Goal scores fall as the environment gets more complex, with more objects and features.",
        "introduction; results",
        frozenset({*PLANS, Suite(V, GI), Suite(B, GI)}),
        "the 95 % interval of every rank correlation with the number of relevant objects is below 0",
        complexity,
        "Tasks with more objects have longer plans. If effects of both are estimated together, only the "
        "effect of length remains ([adjusted effects](../bench/README.md#analyses-of-public-answers)).",
    ),
)
