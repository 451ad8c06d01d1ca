"""Measures of the paper's examples from cleaning a refrigerator, and of words in its pictures."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from itertools import product

from claim import Finding, by_degree
from evidence import AS, GPT_4O, PLANS, SD, B, Evidence, Suite, V
from measures_rates import GRAMMAR
from rates import all_of, if_so

from eai.abilities.explanation import StepReport
from eai.abilities.protocol import Ability, Protocol
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic import formula as f
from eai.results.lines import PlanStepTableLine
from eai.tasks.task import GoalKind, Task
from eai.world.execution import execute_plan

FRIDGE = "cleaning_up_refrigerator"
STATES = (
    "nextto(rag.0, sink.82)",
    "toggledon(sink.82)",
    "soaked(rag.0)",
    "not toggledon(sink.82)",
    "open(fridge.97)",
    "not stained(fridge.97)",
)
"""The states that the paper's plan for the fridge is to run through."""

ACTIONS = (
    "RIGHT_GRASP(rag_0)",
    "RIGHT_PLACE_NEXTTO(sink_82)",
    "TOGGLE_ON(sink_82)",
    "SOAK(rag_0)",
    "TOGGLE_OFF(sink_82)",
    "OPEN(fridge_97)",
    "CLEAN(fridge_97)",
)
"""The actions that the paper prints for these states."""

CLOTH = ("soaked(rag.0)", "holds_rh(rag.0)", "not stained(fridge.97)")
"""The subgoals of the paper's figure; a place for the agent is no state of subgoals."""

CABINET = "open(bottom_cabinet_no_top.80)"
"""The state that lets the rag be taken out in the released task."""

BROWSING = (
    "ONTOP({character}, {chair})",
    "HOLDS_RH({character}, {mouse}) and HOLDS_LH({character}, {keyboard})",
    "FACING({character}, {computer})",
)
"""The states of the paper's plan for browsing the internet."""

TABLE = "breakfast_table_20"
"""The table of the meal in the released task."""

NAMED = ("fridge_97", "tray_1", "bowl_1", "rag_0", "sink_82")
"""The objects that the paper names for the instruction."""


_SOAK_NEEDS = ("holding", "next_to", "toggled_on")
"""The predicates of the paper's precondition of SOAK."""


def example_states(evidence: Evidence) -> Finding:
    plain, opened = _steps(evidence, STATES), _steps(evidence, (CABINET, *STATES))
    done = [step.action for step in plain if step.outcome == "executed"]
    return if_so(
        done == list(ACTIONS),
        f"in the released {FRIDGE} they {_end_of(plain)}; with the cabinet opened first "
        f"they {_end_of(opened)}",
    )


def example_subgoals(evidence: Evidence) -> Finding:
    plain, opened = _steps(evidence, CLOTH), _steps(evidence, (CABINET, *CLOTH))
    return if_so(
        all(step.outcome == "executed" for step in plain),
        f"in the released {FRIDGE} they {_end_of(plain)}; with the cabinet opened first "
        f"they {_end_of(opened)}",
    )


def browsing_plan(evidence: Evidence) -> Finding:
    """Try the paper's states with all objects of their kinds, in each task of browsing."""
    suite = open_suite(V, Ability.SUBGOAL_DECOMPOSITION, Protocol("eai-1.0.5"), source=evidence.published)
    tasks = [t for t in find_benchmark(V).tasks(evidence.published).values() if t.title == "Browse internet"]
    run = met = 0
    for task in tasks:
        verdicts = [
            suite.assess(task.id, json.dumps({"actions_to_include": [], "output": states})).verdict
            for states in _browsing_states(task)
        ]
        run += any(verdict.executable for verdict in verdicts)
        met += any(verdict.success for verdict in verdicts)
    return if_so(
        0 < met == len(tasks),
        f"of {len(tasks)} tasks “Browse internet” it can be executed in {run} and reaches the goals in {met}",
        in_part=run > 0,
    )


def sink_switched_on(evidence: Evidence) -> Finding:
    before, after = (_steps(evidence, (CABINET, *STATES[:number])) for number in (1, 2))
    between = [step.action for step in after[len(before) :]]
    return if_so(len(between) == 2, f"one state leads to the other by {', '.join(between)} alone")


def objects_of_the_fridge(evidence: Evidence) -> Finding:
    objects = _fridge(evidence).scene.index
    known = [name for name in NAMED if name in objects]
    lacking = ", ".join(name for name in NAMED if name not in objects)
    bowls = ", ".join(sorted(name for name in objects if name.startswith("bowl")))
    return all_of(
        (len(known), len(NAMED)),
        text=f"{len(known)} of {len(NAMED)} are in the released {FRIDGE}, {lacking or 'none'} is not; "
        f"its bowls: {bowls}",
    )


def instruction_of_the_fridge(evidence: Evidence) -> Finding:
    text = _fridge(evidence).instruction
    words = [word for word in ("rag", "tray", "bowl", "refrigerator", "sink") if word in text]
    return Finding(
        by_degree(len(words) == 5 and "soap" not in text, len(words) == 5),
        f"the released instruction names {', '.join(words)}"
        + (", and soap, which the quotation lacks" if "soap" in text else ""),
    )


def conditions_of_the_fridge(evidence: Evidence) -> Finding:
    goals = _fridge(evidence).goals
    tasks = [task for task in find_benchmark(B).tasks(evidence.published).values() if len(task.goals) > 1]
    return if_so(
        len(goals) > 1, f"{FRIDGE} has {len(goals)} goals; {len(tasks)} BEHAVIOR tasks have more than one"
    )


def stains_of_the_fridge(evidence: Evidence) -> Finding:
    clean = f.Not(f.Atom("stained", (f.Constant("fridge_97"),)))
    tasks = [
        task.title
        for task in find_benchmark(B).tasks(evidence.published).values()
        if any(goal.formula == clean and goal.kind is GoalKind.STATE for goal in task.goals)
    ]
    return if_so(FRIDGE in tasks, f"a goal of {', '.join(tasks) or 'no task'}")


def needs_of_soak(evidence: Evidence) -> Finding:
    library = next(iter(find_benchmark(B).operator_tasks(evidence.published).values())).domain
    soak = library.operators["soak"]
    right = [word for word in _SOAK_NEEDS if f"({word} " in soak.precondition]
    return all_of(
        (len(right), len(_SOAK_NEEDS)),
        (int("soaked" in soak.effect), 1),
        text=f"the data set's precondition is {soak.precondition}, its effect {soak.effect}",
    )


def doubled_characters(evidence: Evidence) -> Finding:
    """Look in unreadable answers for a doubled dot in VirtualHome, a doubled bracket in BEHAVIOR."""
    first, second = (
        [
            record.response
            for records in evidence.suites[Suite(domain, SD)].values()
            for record in records
            if record.verdict.error is not None and record.verdict.error.kind.value == "parsing"
        ]
        for domain in (V, B)
    )
    counts = {
        f"a name with two dots, of {len(first)} in VirtualHome": sum(
            re.search(r"\w\.\.\w", text) is not None for text in first
        ),
        f"a subgoal with more closing than opening brackets, of {len(second)} in BEHAVIOR": sum(
            any(part.count("(") < part.count(")") for part in text.split('"')) for text in second
        ),
    }
    return _each_occurs(counts, "unreadable answers with subgoals")


def washing_of_plans(evidence: Evidence) -> Finding:
    """Look for what the example names: the sink and the soap for hands, a soaked brush for a stain."""
    washing = [
        step.reason
        for step in _failed(evidence, V, "missing_step", AS)
        if step.operator in ("WASH", "RINSE", "SCRUB") and step.objects.startswith("hands")
    ]
    having = {
        (step.model, step.task)
        for step in evidence.of(evidence.tables.steps, Suite(B, AS))
        if "brush" in step.objects
    }
    brushes = sum(
        step.operator == "CLEAN" and "no hand holds a soaked" in step.reason
        for step in _failed(evidence, B, "missing_step", AS)
        if (step.model, step.task) in having
    )
    return _each_occurs(
        {
            "washing hands far from the sink": sum("sink" in reason for reason in washing),
            "washing hands without soap": sum("soap" in reason for reason in washing),
            "CLEAN of a stain in a plan with a brush": brushes,
        },
        f"missing steps of plans (the simulator asks for the hands alone in {len(washing)} steps of washing)",
    )


def rinse_of_gpt_4o(evidence: Evidence) -> Finding:
    """Call rinsing particularly hard if most grammar errors of GPT-4o's plans name it."""
    errors = [
        record.verdict.error.detail
        for record in evidence.suites[Suite(V, AS)][GPT_4O]
        if record.verdict.error is not None and record.verdict.error.kind.value in GRAMMAR
    ]
    hits = sum("RINSE" in detail.upper() for detail in errors)
    return if_so(
        hits > len(errors) / 2,
        f"{hits} of {len(errors)} grammar errors of GPT-4o's plans in VirtualHome name RINSE "
        f"({'; '.join(dict.fromkeys(errors)) or 'none'})",
        in_part=hits > 0,
    )


def named_pair_of_goals(evidence: Evidence) -> Finding:
    """Compare how often goals of switched-on things and of things on others are met."""
    patterns = {V: (r"ON\(", r"ONTOP\(character"), B: (r"toggled_on\(", r"ontop\(")}
    text, easier = [], []
    for suite in PLANS:
        goals = evidence.of(evidence.tables.goals, suite)
        groups = [
            [goal.satisfied for goal in goals if re.match(pattern, goal.text)]
            for pattern in patterns[suite.domain]
        ]
        shares = [100 * sum(group) / len(group) for group in groups]
        easier.append(shares[0] > shares[1])
        text.append(f"{suite} {shares[0]:.1f} against {shares[1]:.1f} %")
    chairs = sum("chair" in goal.text for goal in evidence.tables.goals if goal.domain == V)
    return all_of(
        (sum(easier), len(easier)),
        text="goals met that something is switched on against those on top (in VirtualHome of the "
        f"character; {chairs or 'none'} of them on a chair): {'; '.join(text)}",
    )


def goals_of_the_agent(evidence: Evidence) -> Finding:
    goals = [goal for task in find_benchmark(V).tasks(evidence.published).values() for goal in task.goals]
    texts = [(goal.kind, str(goal.formula)) for goal in goals]
    counts = {
        "a television that is plugged in": _count(texts, GoalKind.STATE, "PLUGGED_IN.*television"),
        "a state of the agent": _count(texts, GoalKind.STATE, "character"),
        "the agent on a chair": _count(texts, GoalKind.RELATION, "ONTOP.*character.*chair"),
    }
    shown = ", ".join(f"{words}: {number}" for words, number in counts.items())
    return all_of(
        (sum(number > 0 for number in counts.values()), len(counts)), text=f"VirtualHome's goals with {shown}"
    )


def dishes_by_hand(evidence: Evidence) -> Finding:
    """Look for actions in all plans of the task; each kind has to occur in each plan."""
    tasks = find_benchmark(V).tasks(evidence.published).values()
    plans = [
        {step.operator for step in task.script}
        for task in tasks
        if task.title == "Wash dishes by hand" and task.goals
    ]
    kinds = {"picking up": {"GRAB"}, "wiping": {"WIPE"}, "putting back": {"PUTBACK", "PUTOBJBACK"}}
    counts = {words: sum(bool(plan & names) for plan in plans) for words, names in kinds.items()}
    shown = ", ".join(f"{words} {number}" for words, number in counts.items())
    return all_of(
        *((number, len(plans)) for number in counts.values()),
        text=f"annotated plans of “Wash dishes by hand”, of {len(plans)}: {shown}",
    )


def gold_of_the_meal(evidence: Evidence) -> Finding:
    """Look for the relations and for the ids of the example in the data set's goals of serving a meal."""
    (task,) = (t for t in find_benchmark(B).tasks(evidence.published).values() if t.title == "serving_a_meal")
    relations = [_kinds_on_top(goal.formula) for goal in task.goals]
    named = [name for name in ("chicken_0", "plate_2", "table_1") if name in task.scene.index]
    both = [("chicken", "plate") in relations, ("plate", "breakfast") in relations]
    return if_so(
        all(both) and len(named) == 3,
        f"{sum(both)} of the 2 relations, chicken on plate and plate on table, are goals; the ids of the "
        f"three that the scene has: {', '.join(named) or 'none'}",
        in_part=any(both),
    )


def chicken_on_the_table(evidence: Evidence) -> Finding:
    """Execute the data set's plan for the meal: chickens lie on plates, plates on the table."""
    (task,) = (t for t in find_benchmark(B).tasks(evidence.published).values() if t.title == "serving_a_meal")
    domain = find_benchmark(B).domain
    end = execute_plan(domain, task.initial, task.script).final_state
    lie = {
        (upper, lower): domain.holds(
            p.lies_on(p.X, p.Y), end, {p.X.name: task.scene.index[upper], p.Y.name: task.scene.index[lower]}
        )
        for upper, lower in (("chicken_0", "plate_0"), ("plate_0", TABLE), ("chicken_0", TABLE))
    }
    shown = ", ".join(
        f"ontop({upper}, {lower}) is {str(holds).lower()}" for (upper, lower), holds in lie.items()
    )
    return if_so(list(lie.values()) == [True, True, False], f"after the data set's plan {shown}")


def orders_of_plans(evidence: Evidence) -> Finding:
    drinks = sum(step.operator == "DRINK" for step in _failed(evidence, V, "wrong_order", AS))
    tomatoes = sum(
        step.operator == "SLICE" and "tomato" in step.objects
        for step in _failed(evidence, B, "wrong_order", AS)
    )
    return _each_occurs({"DRINK": drinks, "SLICE of a tomato": tomatoes}, "wrong orders of plans")


def affordances_of_plans(evidence: Evidence) -> Finding:
    mice = sum(
        step.operator == "TYPE" and step.objects.startswith("mouse")
        for step in _failed(evidence, V, "affordance", AS)
    )
    berries = sum("strawberry" in step.reason for step in _failed(evidence, B, "affordance", AS))
    return _each_occurs(
        {"TYPE on a mouse": mice, "a sliced strawberry": berries}, "affordance errors of plans"
    )


def additions_of_plans(evidence: Evidence) -> Finding:
    cabinets = sum(
        step.operator == "OPEN" and "cabinet" in step.objects
        for step in _failed(evidence, B, "additional_step", AS)
    )
    stands = sum(step.operator == "STANDUP" for step in _failed(evidence, V, "additional_step", AS))
    return _each_occurs({"OPEN of a cabinet": cabinets, "STANDUP": stands}, "additional steps of plans")


def cooking(evidence: Evidence) -> Finding:
    tasks = [
        task
        for task in find_benchmark(V).tasks(evidence.published).values()
        if task.title == "Cook some food" and task.goals
    ]
    counts = {
        what: sum(
            any(
                step.operator in verbs and word in task.scene.objects[index].name
                for step in task.script
                for index in step.arguments
                for word in words
            )
            for task in tasks
        )
        for what, verbs, words in (
            ("takes an ingredient", ("GRAB",), ("food", "pasta", "water")),
            ("switches an appliance on", ("SWITCHON",), ("oven", "stove", "microwave")),
            ("puts something on a table", ("PUTBACK",), ("table",)),
        )
    }
    return _each_occurs(counts, f"of {len(tasks)} annotated plans “Cook some food”")


def _each_occurs(counts: Mapping[str, int], what: str) -> Finding:
    text = ", ".join(f"{name} {number}" for name, number in counts.items())
    found = [bool(number) for number in counts.values()]
    return Finding(by_degree(all(found), any(found)), f"{what}: {text}")


def _failed(evidence: Evidence, domain: str, outcome: str, ability: str = SD) -> list[PlanStepTableLine]:
    """Return the steps of answers with an outcome."""
    return [
        step for step in evidence.of(evidence.tables.steps, Suite(domain, ability)) if step.outcome == outcome
    ]


def _missed(evidence: Evidence, domain: str) -> list[str]:
    """Return the goals that executed answers with subgoals do not reach."""
    suite = Suite(domain, SD)
    executed = {(each.model, each.task) for each in evidence.answers(suite) if each.executable}
    return [
        goal.text
        for goal in evidence.of(evidence.tables.goals, suite)
        if not goal.satisfied and (goal.model, goal.task) in executed
    ]


def _kinds_on_top(formula: f.Formula) -> tuple[str, str] | None:
    """Return the first words of the two kinds of things of a goal on top, or None of another goal."""
    if isinstance(formula, f.ForAll | f.ForPairs):
        return _kinds_on_top(formula.body)
    if isinstance(formula, f.Atom) and formula.predicate == "ontop":
        first, second = (re.split(r"[._]", argument.name)[0] for argument in formula.arguments)
        return first, second
    return None


def _browsing_states(task: Task) -> list[list[str]]:
    kinds = ("character", "chair", "mouse", "keyboard", "computer")
    objects = [each.name for each in task.scene.objects]
    choices = product(*([name for name in objects if name.split(".")[0] == kind] for kind in kinds))
    return [
        [state.format(**dict(zip(kinds, chosen, strict=True))) for state in BROWSING] for chosen in choices
    ]


def _fridge(evidence: Evidence) -> Task:
    (task,) = (t for t in find_benchmark(B).tasks(evidence.published).values() if t.title == FRIDGE)
    return task


def _steps(evidence: Evidence, states: Sequence[str]) -> Sequence[StepReport]:
    """Return the steps of an answer with these states as subgoals."""
    suite = open_suite(B, Ability.SUBGOAL_DECOMPOSITION, Protocol("eai-1.0.5"), source=evidence.published)
    return suite.assess(_fridge(evidence).id, json.dumps({"output": list(states)})).explain().steps


def _end_of(steps: Sequence[StepReport]) -> str:
    last = steps[-1]
    if last.outcome == "executed":
        return f"run as {len(steps)} actions"
    return f"stop at action {len(steps)}, {last.action}: {last.reason}"


def _count(texts: Sequence[tuple[GoalKind, str]], kind: GoalKind, pattern: str) -> int:
    return sum(other is kind and re.search(pattern, text) is not None for other, text in texts)
