"""Measures of statements that data, questions or the paper's own tables decide."""

from __future__ import annotations

import re
from collections import Counter
from itertools import pairwise
from statistics import fmean

from claim import Finding, by_degree, fisher
from evidence import GI, NAMED, TM, B, Evidence, Suite, V
from rates import all_of, if_so, most_of

from eai.abilities.protocol import PAPER_ABILITIES
from eai.benchmarks.registry import find_benchmark
from eai.logic import formula as f
from eai.logic.traversal import walk_subformulas
from eai.results.paper_tables import read_paper_table
from eai.tasks.task import GoalKind

SIMPLE = re.compile(r"\b(or|exists|forall|forn|not)\b")
"""A word that a formula of actions in order and a conjunction of facts does not have."""

NOT_SPATIAL = ("HOLDS_RH", "HOLDS_LH", "FACING")
"""VirtualHome's binary predicates that say nothing of a place."""

REPLANNED = 305
"""Number of tasks of the table on replanning: its figures are shares of 305."""

_ENDS = re.compile(r"[.!?]\s")
"""The end of a sentence before another."""

_EXAMPLE_GOALS = {
    "a clean cup": "CLEAN cup",
    "a television that is on": "ON television",
    "the character next to the cat": "NEXT_TO character cat",
    "a cup on the table": "ONTOP cup table",
    "the character on the couch": "ONTOP character couch",
    "touch, beside a remote control": "TOUCH remote_control",
}
"""The examples of goals in the appendix, in the names of VirtualHome."""

_WORD = re.compile(r"action='(\w+)'")
_SCENE = re.compile(r"_\d+_([A-Z]\w*_int)_")
"""The scene in an identifier, as in _0_Wainscott_0_int_0."""

_NAME_IN_GOAL = re.compile(r"(?:predicate|action)='(\w+)'")
"""The name of a predicate or action in a goal."""


def simple_formulas(evidence: Evidence) -> Finding:
    texts = [t.temporal_goal for t in find_benchmark(V).tasks(evidence.published).values() if t.temporal_goal]
    simple = sum(SIMPLE.search(text) is None for text in texts)
    return if_so(
        simple == len(texts),
        f"{simple} of {len(texts)} VirtualHome formulas have neither a disjunction nor a quantifier",
        in_part=simple > len(texts) / 2,
    )


def alternative_formulas(evidence: Evidence) -> Finding:
    texts = [t.temporal_goal for t in find_benchmark(V).tasks(evidence.published).values() if t.temporal_goal]
    hits = sum(" or " in text for text in texts)
    return if_so(hits > 0, f"{hits} of {len(texts)} VirtualHome formulas have “or”")


def options_in_general(evidence: Evidence) -> Finding:
    several, number, text = _options(evidence)
    return most_of((several, number), text=text)


def options_at_times(evidence: Evidence) -> Finding:
    several, _, text = _options(evidence)
    return if_so(several > 0, text)


def _options(evidence: Evidence) -> tuple[int, int, str]:
    """Return how many tasks of BEHAVIOR have several goal options, the number of tasks, and a text."""
    lines = {each.task: each for each in evidence.of(evidence.tables.answers, Suite(B, GI))}.values()
    several = sum((each.goal_options or 1) > 1 for each in lines)
    largest = max(each.goal_options or 1 for each in lines)
    return (
        several,
        len(lines),
        f"{several} of {len(lines)} BEHAVIOR tasks have more than one option; one task has {largest:,}",
    )


def ground_goals_are_atomic(evidence: Evidence) -> Finding:
    """Count BEHAVIOR's goals with a negation, which ground goals keep."""
    goals = [
        str(goal.formula)
        for task in find_benchmark(B).tasks(evidence.published).values()
        for goal in task.goals
    ]
    negated = sum("Not(" in text for text in goals)
    return if_so(
        negated == 0,
        f"{negated} of {len(goals)} goals of BEHAVIOR have a negation",
        in_part=negated < len(goals) / 2,
    )


def one_sentence(evidence: Evidence) -> Finding:
    counts = {}
    for domain in (V, B):
        texts = [task.instruction for task in find_benchmark(domain).tasks(evidence.published).values()]
        counts[domain] = (
            sum(len(_ENDS.findall(text.strip().rstrip(".!?"))) == 0 for text in texts),
            len(texts),
        )
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"instructions of one sentence: {text}")


def pairs_of_jars(evidence: Evidence) -> Finding:
    goals = [
        str(goal.formula)
        for task in find_benchmark(B).tasks(evidence.published).values()
        for goal in task.goals
    ]
    pairs = [text for text in goals if text.startswith("ForPairs")]
    jars = [text for text in goals if "apple" in text and "jar" in text]
    return if_so(
        bool(jars), f"{len(pairs)} goals of BEHAVIOR are about pairs, {len(jars)} name an apple and a jar"
    )


def action_goals_without_effect(evidence: Evidence) -> Finding:
    """Ask whether the operators of VirtualHome's action goals have an empty annotated effect."""
    benchmark = find_benchmark(V)
    library = next(iter(benchmark.operator_tasks(evidence.published).values())).domain
    effects = {name.replace("_", ""): text.effect for name, text in library.operators.items()}
    names = Counter(
        name.lower()
        for task in benchmark.tasks(evidence.published).values()
        for goal in task.goals
        if goal.kind is GoalKind.ACTION
        for name in _WORD.findall(str(goal.formula))[:1]
    )
    known = {name: number for name, number in names.items() if name in effects}
    empty = sum(n for name, n in known.items() if not re.search(r"\w", effects[name].replace("and", "")))
    others = [
        f"{name} {n}" for name, n in names.most_common() if re.search(r"\w{4}", effects.get(name, "none"))
    ]
    return most_of(
        (empty, names.total()),
        text=f"{empty} of {names.total()} action goals are of operators without an annotated effect; not "
        f"{', '.join(others) or 'any'}",
    )


def action_goals_in_short_tasks(evidence: Evidence) -> Finding:
    tasks = [t for t in find_benchmark(V).tasks(evidence.published).values() if t.goals]
    groups = [
        [len(t.script) for t in tasks if any(g.kind is GoalKind.ACTION for g in t.goals) == has]
        for has in (True, False)
    ]
    means = [sum(each) / len(each) for each in groups]
    return if_so(
        means[0] < means[1],
        f"plans of {len(groups[0])} tasks with an action goal have {means[0]:.1f} steps on average, of "
        f"{len(groups[1])} others {means[1]:.1f}",
    )


def binary_goals(evidence: Evidence) -> Finding:
    names = Counter(
        re.match(r"Atom\(predicate='(\w+)'", str(goal.formula))[1]  # type: ignore[index]
        for task in find_benchmark(V).tasks(evidence.published).values()
        for goal in task.goals
        if goal.kind is GoalKind.RELATION
    )
    other = sum(names[name] for name in NOT_SPATIAL)
    text = ", ".join(f"{name} {number}" for name, number in names.most_common())
    return if_so(
        other == 0,
        f"{other} of VirtualHome's {names.total()} distinct goals on relations are of holding or facing: "
        f"{text}",
        in_part=other < names.total() / 2,
    )


def arguments_of_goals(evidence: Evidence) -> Finding:
    """Count the objects that the facts of each goal name, on states and on relations."""
    counts: dict[GoalKind, Counter[int]] = {GoalKind.STATE: Counter(), GoalKind.RELATION: Counter()}
    for domain in (V, B):
        for task in find_benchmark(domain).tasks(evidence.published).values():
            for goal in task.goals:
                if goal.kind in counts:
                    facts = [part for part in walk_subformulas(goal.formula) if isinstance(part, f.Atom)]
                    counts[goal.kind].update({len(fact.arguments) for fact in facts})
    text = "; ".join(
        f"{kind.value} "
        + ", ".join(f"{number:,} about {objects}" for objects, number in sorted(counts[kind].items()))
        for kind in counts
    )
    wanted = {GoalKind.STATE: 1, GoalKind.RELATION: 2}
    return all_of(
        *((counts[kind][number], counts[kind].total()) for kind, number in wanted.items()),
        text=f"goals of both worlds by the number of objects: {text}",
    )


def objects_of_work(evidence: Evidence) -> Finding:
    """Compare the relevant objects and the objects in scenes of tasks “Work” with those of other tasks."""
    tasks = [task for task in find_benchmark(V).tasks(evidence.published).values() if task.goals]
    text, more = [], []
    for name, counts in (
        ("objects in the scene", {task.id: len(task.scene.objects) for task in tasks}),
        ("relevant objects", {task.id: len(task.relevant) for task in tasks}),
    ):
        work = [counts[task.id] for task in tasks if task.title == "Work"]
        others = [counts[task.id] for task in tasks if task.title != "Work"]
        more.append(fmean(work) > fmean(others))
        text.append(f"{name} {fmean(work):.1f} against {fmean(others):.1f} in other tasks")
    return if_so(all(more), f"mean of tasks “Work”: {', '.join(text)}", in_part=any(more))


def example_goals(evidence: Evidence) -> Finding:
    """Count the tasks with each example; a goal on an action names no object, so relevant objects count."""
    tasks: Counter[str] = Counter()
    for task in find_benchmark(V).tasks(evidence.published).values():
        relevant = {_class_of(task.scene.objects[index].name) for index in task.relevant}
        parts = [part for goal in task.goals for part in walk_subformulas(goal.formula)]
        facts = {
            " ".join((part.predicate, *(_class_of(term.name) for term in part.arguments)))
            for part in parts
            if isinstance(part, f.Atom)
        }
        actions = {part.action for part in parts if isinstance(part, f.Occurs)}
        tasks.update(facts | {f"{action} {name}" for action in actions for name in relevant})
    counts = {words: tasks[fact] for words, fact in _EXAMPLE_GOALS.items()}
    shown = ", ".join(f"{words}: {number}" for words, number in counts.items())
    return all_of(
        (sum(number > 0 for number in counts.values()), len(counts)),
        text=f"VirtualHome's tasks with {shown}",
    )


def facing_is_a_state(evidence: Evidence) -> Finding:
    kinds = Counter(
        goal.kind.value
        for task in find_benchmark(V).tasks(evidence.published).values()
        for goal in task.goals
        if "'FACING'" in str(goal.formula)
    )
    text = ", ".join(f"{kind} {number}" for kind, number in kinds.items())
    return if_so(
        kinds["state"] > 0 and not kinds["relation"],
        f"VirtualHome's goals of facing count as: {text or 'nothing'}",
    )


def shelves_are_closed_to_opening(evidence: Evidence) -> Finding:
    tasks = find_benchmark(V).tasks(evidence.published).values()
    shelves = [
        task.initial.has("CAN_OPEN", index)
        for task in tasks
        for index, thing in enumerate(task.scene.objects)
        if "shelf" in thing.name
    ]
    return if_so(
        not any(shelves),
        f"{sum(shelves):,} of {len(shelves):,} shelves in VirtualHome's scenes can be opened",
        in_part=not all(shelves),
    )


def goal_of_the_fridge(evidence: Evidence) -> Finding:
    (task,) = (
        t
        for t in find_benchmark(B).tasks(evidence.published).values()
        if t.title == "cleaning_up_refrigerator"
    )
    goals = [str(goal.formula) for goal in task.goals]
    fridge = any(g.startswith("Not") and "stained" in g and "fridge_97" in g for g in goals)
    inside = any(g.startswith("ForAll") and "tray" in g and "inside" in g and "fridge_97" in g for g in goals)
    trays = sum(g.startswith("Not") and "stained" in g and "tray_" in g for g in goals) > 1
    text = [
        f"{name} {'is' if hit else 'is not'} there"
        for name, hit in (
            ("a fridge without stains", fridge),
            ("all trays in the fridge", inside),
            ("all trays without stains", trays),
        )
    ]
    return Finding(
        by_degree(fridge and inside and trays, fridge or inside), f"its {len(goals)} goals: {', '.join(text)}"
    )


def outdated_food(evidence: Evidence) -> Finding:
    tasks = find_benchmark(V).tasks(evidence.published).values()
    hits = [task.title for task in tasks if "outdated" in task.instruction]
    return if_so(
        bool(hits), f"released VirtualHome instructions with “outdated”: {len(hits)} of {len(tasks)}"
    )


def formula_of_1057_1(evidence: Evidence) -> Finding:
    task = find_benchmark(V).tasks(evidence.published)["1057_1"]
    formula = task.temporal_goal or ""
    parts = (
        "LOOKAT(x0) or WATCH(x0)",
        "ON(television.410)",
        "PLUGGED_IN(television.410)",
        "FACING(character.65, television.410)",
    )
    hits = [part for part in parts if part in formula]
    operators = [step.operator for step in task.script]
    printed = ["WALK", "WALK", "FIND", "SIT", "FIND", "FIND", "SWITCHON", "TURNTO", "WATCH"]
    return Finding(
        by_degree(len(hits) == len(parts) and operators == printed, bool(hits)),
        f"its formula has {len(hits)} of {len(parts)} printed parts; its plan: {', '.join(operators)}",
    )


def tasks_with_operators(evidence: Evidence) -> Finding:
    counts = {}
    for domain in (V, B):
        benchmark = find_benchmark(domain)
        tasks, operators = benchmark.tasks(evidence.published), benchmark.operator_tasks(evidence.published)
        counts[domain] = (
            sum(bool(t.goals and t.script and t.id in operators) for t in tasks.values()),
            len(tasks),
        )
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"tasks with a goal, a plan and operators: {text}")


def identifiers(evidence: Evidence) -> Finding:
    counts = {}
    for domain in (V, B):
        tasks = find_benchmark(domain).tasks(evidence.published)
        counts[domain] = sum(_SCENE.search(name) is not None for name in tasks), len(tasks)
    (v, n), (b, m) = counts.values()
    return if_so(
        v == n and b == m,
        f"identifiers that name a scene: {b} of {m} in BEHAVIOR, {v} of {n} in VirtualHome, such as 1057_1",
        in_part=b == m,
    )


def scenes_of_behavior(evidence: Evidence) -> Finding:
    tasks = find_benchmark(B).tasks(evidence.published)
    scenes = Counter(match[1] for name in tasks if (match := _SCENE.search(name)))
    text = ", ".join(f"{scene} {number}" for scene, number in scenes.most_common(3))
    return if_so(
        scenes.total() == len(tasks) and len(scenes) > 1,
        f"{len(scenes)} scenes in the identifiers of {len(tasks)} tasks, most often {text}",
    )


def common_goals(evidence: Evidence) -> Finding:
    """Compare goals of VirtualHome's tasks of one name by their predicates and actions, without objects."""
    forms: dict[str, list[set[str]]] = {}
    for task in find_benchmark(V).tasks(evidence.published).values():
        words = {" ".join(_NAME_IN_GOAL.findall(str(goal.formula))) for goal in task.goals}
        forms.setdefault(task.title, []).append(words)
    several = [sets for sets in forms.values() if len(sets) > 1]
    shared = sum(bool(set.intersection(*sets)) for sets in several)
    same = sum(all(each == sets[0] for each in sets) for sets in several)
    return all_of(
        (shared, len(several)),
        (same, len(several)),
        text=f"of {len(several)} names with several tasks {shared} have a goal in common, objects aside, and "
        f"{same} have the same goals in all tasks",
    )


def system_prompts(evidence: Evidence) -> Finding:
    """Count suites whose shipped questions have a system part."""
    having, number = [], 0
    for domain in (V, B):
        for ability in PAPER_ABILITIES:
            prompts = find_benchmark(domain).official_prompts(ability, evidence.published) or {}
            number += bool(prompts)
            if prompts and all(prompt.system for prompt in prompts.values()):
                having.append(str(Suite(domain, ability.value)))
    return if_so(
        len(having) == number,
        f"{len(having)} of {number} suites have shipped questions with a system part: {'; '.join(having)}",
        in_part=bool(having),
    )


def actions_by_selection(evidence: Evidence) -> Finding:
    """Compare about 300 and over 100 kinds of actions with those that are declared."""
    numbers = {domain: len(find_benchmark(domain).domain.operators) for domain in (V, B)}
    right = [abs(numbers[V] - 300) <= 30, numbers[B] > 100]
    return Finding(
        by_degree(all(right), any(right)),
        f"declared actions: {numbers[V]} in VirtualHome, {numbers[B]} in BEHAVIOR; the paper's own tables "
        "list 40 and 30",
    )


def floor_action(evidence: Evidence) -> Finding:
    names = {operator.name for operator in find_benchmark(B).domain.operators}
    found = "RIGHT_PLACE_FLOOR" in names
    return if_so(
        found, f"RIGHT_PLACE_FLOOR is {'' if found else 'not '}among BEHAVIOR's {len(names)} actions"
    )


def gains_are_significant(evidence: Evidence) -> Finding:
    table = read_paper_table("replanning")
    plain, again = (table.rows[name] for name in ("GPT-4o", "GPT-4o w/ replanning"))
    text, clear = [], []
    for column in table.columns:
        if column.metric in ("task_success", "execution_success"):
            hits = [round((row[column] or 0) * REPLANNED / 100) for row in (plain, again)]
            p = fisher(*hits, REPLANNED)
            clear.append(p < 0.05)
            text.append(
                f"{column.metric.replace('_', ' ')} {hits[0]} and {hits[1]} of {REPLANNED}, p = {p:.2g}"
            )
    return Finding(by_degree(all(clear), any(clear)), f"unpaired, {'; '.join(text)}")


def people_in_operators(evidence: Evidence) -> Finding:
    table = read_paper_table("human")
    figures = {
        name: {
            column.metric: value or 0 for column, value in table.rows[name].items() if column.ability == TM
        }
        for name in ("Human Annotation", "GPT-4o")
    }
    ahead = {
        metric: figures["GPT-4o"][metric] > value for metric, value in figures["Human Annotation"].items()
    }
    text = ", ".join(
        f"{metric.replace('_', ' ').replace('.', ' ')} {figures['GPT-4o'][metric]:.1f} against {value:.1f}"
        for metric, value in figures["Human Annotation"].items()
    )
    return Finding(by_degree(all(ahead.values()), any(ahead.values())), f"GPT-4o against people: {text}")


def growing_gains(evidence: Evidence) -> Finding:
    """Call gains generally growing if none falls and the last is above the first."""
    table = read_paper_table("replanning_stochastic")
    gains: dict[str, list[float]] = {}
    for chance in ("0.05", "0.1", "0.2"):
        plain, again = (table.rows[f"{name}, p = {chance}"] for name in ("GPT-4o", "GPT-4o w/ replanning"))
        for column in table.columns:
            gains.setdefault(column.metric, []).append((again[column] or 0) - (plain[column] or 0))
    grows = [all(a <= b for a, b in pairwise(each)) and each[0] < each[-1] for each in gains.values()]
    text = "; ".join(
        f"{name.replace('_', ' ')} {', '.join(f'{g:g}' for g in each)} points" for name, each in gains.items()
    )
    return Finding(by_degree(all(grows), any(grows)), f"by the table, of 20 episodes each: {text}")


def _class_of(name: str) -> str:
    return name.partition(".")[0]
