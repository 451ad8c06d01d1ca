"""Measures of statements about the data set and the declarations."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping

from claim import Finding, by_degree
from compared import list_check_ids
from evidence import GI, NAMED, SD, B, Evidence, Suite, V
from rates import DIGIT, NEAR, RateColumn, all_of, if_so, measured_rates, most_of

from eai.abilities.protocol import Ability, Protocol
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.errata import load_all_errata
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic import formula as f
from eai.logic.ltl import parse
from eai.results.data_set import compute_data_set_statistics
from eai.results.lines import AnswerTableLine
from eai.results.paper_tables import read_paper_protocol_and_tables, read_paper_table
from eai.results.totals import RunTotals
from eai.tasks.operator_task import OperatorLibrary
from eai.tasks.task import GoalKind, Task
from eai.world.execution import execute_plan

BROWSE = (
    "ontop(character, chair) then holds_rh(character, mouse) and holds_lh(character, keyboard) "
    "then facing(character, computer)"
)
RAG = (
    ("RIGHT_GRASP", "rag_0"),
    ("RIGHT_PLACE_NEXTTO", "sink_82"),
    ("TOGGLE_ON", "sink_82"),
    ("SOAK", "rag_0"),
    ("TOGGLE_OFF", "sink_82"),
    ("OPEN", "fridge_97"),
    ("CLEAN", "fridge_97"),
)
"""The paper's example of a plan for cleaning a fridge."""

CLOSED_CHECK = "is_inside_something_that_is_closed"

_FLOOR = f.Variable("f")

STATES = {
    V: "CLOSED OPEN ON OFF SITTING DIRTY CLEAN LYING PLUGGED_IN PLUGGED_OUT ONTOP INSIDE BETWEEN "
    "NEXT_TO FACING HOLDS_RH HOLDS_LH",
    B: "cooked dusty frozen open sliced soaked stained toggled_on inside onfloor ontop under nextto",
}
"""The states of the paper's tables; BEHAVIOR's two kinds of tools are abilities, not states, in the data."""

PRINTED_TASKS = 518
"""The sum of the numbers of tasks that the paper prints beside VirtualHome's names."""

CONNECTIVES = ("and", "or", "not", "when", "exists", "forall")


def formulas(evidence: Evidence) -> Finding:
    """Parse VirtualHome's formulas; BEHAVIOR's goals come in another language, and are read as formulas."""
    texts = [task.temporal_goal for task in _tasks(evidence, V).values() if task.goals]
    read = [text for text in texts if text and parse(text)]
    others = [task for task in _tasks(evidence, B).values() if task.goals]
    number = len(_tasks(evidence, B))
    return all_of(
        (len(read), len(texts)),
        (len(others), number),
        text=f"`eai` reads the formulas of {len(read)} of {len(texts)} VirtualHome tasks "
        "with a goal, and the "
        f"goals of {len(others)} of {number} BEHAVIOR tasks",
    )


def goals_over_time(evidence: Evidence) -> Finding:
    ordered, number, of_states = _ordered(evidence)
    return if_so(
        ordered > 0 and of_states > 0,
        f"{ordered} of VirtualHome's {number} formulas have “then”, none of BEHAVIOR's {of_states} goals",
    )


def order_of_actions(evidence: Evidence) -> Finding:
    ordered, number, _ = _ordered(evidence)
    several = sum(
        sum(goal.kind is GoalKind.ACTION for goal in task.goals) > 1
        for task in _tasks(evidence, V).values()
        if " then " in (task.temporal_goal or "")
    )
    return Finding(
        by_degree(ordered > number / 2, ordered > 0),
        f"{ordered} of {number} formulas put something in order by “then”; {several} of "
        "them name two actions",
    )


def rewards_of_states(evidence: Evidence) -> Finding:
    counts = {}
    for domain in (V, B):
        tasks = [task for task in _tasks(evidence, domain).values() if task.goals]
        counts[domain] = (
            sum(all(goal.kind is not GoalKind.ACTION for goal in task.goals) for task in tasks),
            len(tasks),
        )
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in counts.items())
    return all_of(
        *counts.values(),
        text=f"tasks whose goals a single state decides, since they ask for no action: {text}",
    )


def browse_internet(evidence: Evidence) -> Finding:
    return if_so(isinstance(parse(BROWSE), f.Then), "`eai` reads it as three parts in order")


def priorities(evidence: Evidence) -> Finding:
    bare = parse("not a(x) and b(x) or c(x) then d(x)")
    bracketed = parse("(((not a(x)) and b(x)) or c(x)) then d(x)")
    return if_so(
        bare == bracketed,
        "`eai` reads “not a and b or c then d” in this order; implication, which the paper's list lacks, "
        "binds weaker than “or”",
    )


def parts_of_tasks(evidence: Evidence) -> Finding:
    counts = {domain: _whole_tasks(evidence, domain) for domain in (V, B)}
    text = ", ".join(
        f"{NAMED[domain]} {whole} of {number}, with a formula in LTL {formulas}"
        for domain, (whole, formulas, number) in counts.items()
    )
    return all_of(
        *((hits, number) for *parts, number in counts.values() for hits in parts),
        text=f"tasks with name, instruction, goal, plan and operators: {text}",
    )


def parts_in_virtualhome(evidence: Evidence) -> Finding:
    whole, formulas, number = _whole_tasks(evidence, V)
    return all_of(
        (whole, number),
        (formulas, number),
        text=f"{whole} of {number} tasks have all of these but for the formula, {formulas} the formula",
    )


def complete_tasks(evidence: Evidence) -> Finding:
    counts = {domain: [bool(task.goals) for task in _tasks(evidence, domain).values()] for domain in (V, B)}
    text = ", ".join(f"{NAMED[domain]} {sum(each)} of {len(each)}" for domain, each in counts.items())
    return all_of(*((sum(each), len(each)) for each in counts.values()), text=f"tasks with a goal: {text}")


def names_share_tasks(evidence: Evidence) -> Finding:
    plans: dict[str, set[str]] = {}
    for task in _tasks(evidence, V).values():
        if task.script:
            plans.setdefault(task.title, set()).add(" ".join(action.operator for action in task.script))
    several = sum(len(each) > 1 for each in plans.values())
    return most_of(
        (several, len(plans)), text=f"{several} of {len(plans)} names have plans with different actions"
    )


def goals_share_tasks(evidence: Evidence) -> Finding:
    plans: dict[tuple[str, ...], set[str]] = {}
    for task in _tasks(evidence, V).values():
        if task.goals:
            goals = tuple(sorted(str(goal.formula) for goal in task.goals))
            steps = " ".join(f"{action.operator} {action.arguments}" for action in task.script)
            plans.setdefault(goals, set()).add(steps)
    several = sum(len(each) > 1 for each in plans.values())
    return if_so(several > 0, f"{several} of VirtualHome's {len(plans)} sets of goals have several plans")


def names_of_virtualhome(evidence: Evidence) -> Finding:
    names = Counter(task.title for task in _tasks(evidence, V).values() if task.goals)
    return if_so(
        sum(names.values()) == PRINTED_TASKS,
        f"the printed numbers add up to {PRINTED_TASKS}; {sum(names.values())} tasks with "
        "a goal are released "
        f"under {len(names)} names",
        in_part=len(names) == 26,
    )


def long_names(evidence: Evidence) -> Finding:
    longest: dict[str, int] = {}
    for task in _tasks(evidence, V).values():
        if task.goals:
            longest[task.title] = max(longest.get(task.title, 0), len(task.script))
    hits = sum(steps > 10 for steps in longest.values())
    return if_so(
        abs(100 * hits / len(longest) - 80.7) < 0.1,
        f"{hits} of {len(longest)}: {100 * hits / len(longest):.1f} %",
    )


def three_to_five(evidence: Evidence) -> Finding:
    steps = _lengths(evidence, V)
    hits = sum(3 <= each <= 5 for each in steps)
    return most_of(
        (hits, len(steps)),
        text=f"{hits} of {len(steps)} annotated plans have 3 to 5 steps, "
        f"{sum(each <= 5 for each in steps)} at most 5",
    )


def ten_to_thirty(evidence: Evidence) -> Finding:
    steps = _lengths(evidence, V)
    mean = sum(steps) / len(steps)
    return if_so(10 <= mean <= 30, f"8.76 by the paper's Table 2; {mean:.2f} steps in the annotated plans")


def longer_plans(evidence: Evidence) -> Finding:
    means = {domain: sum(steps) / len(steps) for domain in (V, B) for steps in [_lengths(evidence, domain)]}
    return if_so(means[B] > means[V], f"mean length {means[B]:.1f} against {means[V]:.1f} steps")


def objects_by_world(evidence: Evidence) -> Finding:
    means = {
        domain: sum(len(task.scene.objects) for task in tasks.values()) / len(tasks)
        for domain in (V, B)
        for tasks in [_tasks(evidence, domain)]
    }
    return if_so(
        means[B] < means[V], f"objects in a scene: {means[B]:.0f} in BEHAVIOR, {means[V]:.0f} in VirtualHome"
    )


def preconditions_by_world(evidence: Evidence) -> Finding:
    means = {}
    for domain in (V, B):
        table = {
            each.label: each.value
            for each in compute_data_set_statistics(find_benchmark(domain), evidence.published)
        }
        means[domain] = table["preconditions"] / table["transition models"]
    return if_so(
        means[B] > means[V],
        f"predicates in the preconditions of an operator: {means[B]:.1f} in BEHAVIOR, {means[V]:.1f} "
        "in VirtualHome",
    )


def wiping(evidence: Evidence) -> Finding:
    plans = [
        {action.operator for action in task.script}
        for task in _tasks(evidence, V).values()
        if task.title == "Wash dishes by hand" and task.goals
    ]
    words = ("GRAB", "WIPE", "SCRUB", "WASH", "RINSE", "PUTBACK")
    counts = ", ".join(f"{word} {sum(word in plan for plan in plans)}" for word in words)
    return if_so(
        any("WIPE" in plan for plan in plans), f"{len(plans)} plans of “Wash dishes by hand”, with {counts}"
    )


def several_options(evidence: Evidence) -> Finding:
    lines = _lines(evidence, B, GI)
    several = sum(each.goal_options != 1 for each in lines)
    return if_so(several > 0, f"{several} of {len(lines)} tasks have more than one goal option")


def problems_of_behavior(evidence: Evidence) -> Finding:
    tasks = _tasks(evidence, B).values()
    whole = sum(bool(t.goals and t.relevant and next(t.initial.facts(), None)) for t in tasks)
    return if_so(
        whole == len(tasks) == 100, f"{whole} of {len(tasks)} tasks have objects, initial states and goals"
    )


def touching(evidence: Evidence) -> Finding:
    tasks = [t for t in _tasks(evidence, V).values() if t.title == "Pet cat" and t.goals]
    hits = sum(any("TOUCH" in str(goal.formula) for goal in task.goals) for task in tasks)
    effect = _library(evidence, V).operators["touch"].effect
    return all_of(
        (hits, len(tasks)),
        (int(not re.search(r"\w", effect.replace("and", ""))), 1),
        text=f"{hits} of {len(tasks)} tasks “Pet cat” ask for touching, whose annotated effect is {effect}",
    )


def no_action_goals(evidence: Evidence) -> Finding:
    actions = sum(
        goal.kind is GoalKind.ACTION for task in _tasks(evidence, B).values() for goal in task.goals
    )
    return if_so(actions == 0, f"{actions} action goals in BEHAVIOR")


def tasks_with_quantifiers(evidence: Evidence) -> Finding:
    counts = {
        domain: (sum(bool(each.quantified_goals) for each in lines), len(lines))
        for domain in (V, B)
        for lines in [_lines(evidence, domain, SD)]
    }
    return most_of(
        counts[B],
        text=f"tasks with a quantifier: {counts[B][0]} of {counts[B][1]} in BEHAVIOR, {counts[V][0]} "
        f"of {counts[V][1]} in VirtualHome",
    )


def goals_at_the_start(evidence: Evidence) -> Finding:
    shares = {}
    for domain in (V, B):
        lines = _lines(evidence, domain, SD)
        shares[domain] = (
            sum(each.goals_at_start or 0 for each in lines),
            sum(each.goals or 0 for each in lines),
        )
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in shares.items())
    return most_of((shares[B][1] - shares[B][0], shares[B][1]), text=f"goals that hold at the start: {text}")


def light_goals(evidence: Evidence) -> Finding:
    tasks = [t for t in _tasks(evidence, V).values() if t.title == "Turn on light"]
    alone = sum({_name(goal.formula) for goal in task.goals} == {"ON"} for task in tasks)
    return all_of(
        (alone, len(tasks)),
        text=f"{alone} of {len(tasks)} tasks “Turn on light” ask for ON alone, most also for PLUGGED_IN",
    )


def bottling_fruit(evidence: Evidence) -> Finding:
    (task,) = (t for t in _tasks(evidence, B).values() if t.title == "bottling_fruit")
    steps = [
        (step.operator, [task.scene.objects[index].name for index in step.arguments]) for step in task.script
    ]
    wanted = (("GRASP", "peach"), ("SLICE", "peach"), ("PLACE_INSIDE", "jar"))
    hits = sum(
        any(operator.endswith(verb) and any(thing in name for name in names) for operator, names in steps)
        for verb, thing in wanted
    )
    used = ", ".join(sorted({f"{operator}({', '.join(names)})" for operator, names in steps}))
    return all_of((hits, len(wanted)), text=f"its plan has {len(steps)} steps: {used}")


def example_1057_1(evidence: Evidence) -> Finding:
    task = _tasks(evidence, V)["1057_1"]
    return if_so(
        task.title == "Watch TV" and len(task.script) == 9,
        f"“{task.title}”, {len(task.script)} steps, {len(task.goals)} goals",
    )


def example_high_chair(evidence: Evidence) -> Finding:
    (task,) = (t for t in _tasks(evidence, B).values() if t.title == "cleaning_high_chair")
    steps = [action.operator for action in task.script]
    return if_so(
        steps == ["OPEN", "RIGHT_GRASP", "LEFT_GRASP", "CLEAN"] and len(task.goals) == 1,
        f"{', '.join(steps)}; {len(task.goals)} goal",
    )


def example_of_the_rag(evidence: Evidence) -> Finding:
    plan = json.dumps([{"action": action, "object": thing} for action, thing in RAG])
    suite = open_suite(B, Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"), source=evidence.published)
    (task_id,) = (t for t, task in suite.tasks.items() if task.title == "cleaning_up_refrigerator")
    verdict = suite.score(task_id, plan)
    error = verdict.error
    stop = "runs" if error is None else f"stops at {RAG[error.step or 0][0]}: {error.detail}"
    return if_so(bool(verdict.executable), f"in cleaning_up_refrigerator the plan {stop}")


def relations_of_three(evidence: Evidence) -> Finding:
    most = {
        domain: max((len(p.parameters), p.name) for p in _library(evidence, domain).header.predicates)
        for domain in (V, B)
    }
    return if_so(
        most[V][0] == 3 and most[B][0] == 2,
        f"VirtualHome's “{most[V][1]}” has {most[V][0]} arguments, BEHAVIOR's predicates at most "
        f"{most[B][0]}",
    )


def behavior_actions(evidence: Evidence) -> Finding:
    number = len(find_benchmark(B).domain.operators)
    return if_so(number == 30, f"{number} actions are declared")


def usable_objects(evidence: Evidence) -> Finding:
    """Count the actions of BEHAVIOR that refuse an object inside something closed."""
    operators = find_benchmark(B).domain.operators
    others = [each.name for each in operators if CLOSED_CHECK not in list_check_ids(each)]
    return if_so(
        not others,
        f"{len(operators) - len(others)} of {len(operators)} actions refuse what is inside something closed"
        f"; not {', '.join(others) or 'one'}",
        in_part=len(others) < len(operators) / 2,
    )


def contents_that_move(evidence: Evidence) -> Finding:
    """Execute BEHAVIOR's annotated plans, and look at what lies in things that are grasped and put down."""
    domain, containers, contents, moved = find_benchmark(B).domain, 0, 0, 0
    beside = f.Exists(_FLOOR, p.floor_below(p.X, _FLOOR) & p.floor_below(p.Y, _FLOOR))
    for task in find_benchmark(B).tasks(evidence.source).values():
        grasped = _filled_then_grasped(task)
        end = execute_plan(domain, task.initial, task.script).final_state
        for container, things in grasped.items():
            containers += 1
            contents += len(things)
            moved += sum(
                domain.holds(p.lies_in(p.X, p.Y) & beside, end, {p.X.name: thing, p.Y.name: container})
                for thing in things
            )
    return all_of(
        (moved, contents),
        text=f"annotated plans fill and then grasp {containers} containers; at the end {moved} of their "
        f"{contents} contents lie in them, on the same floor",
    )


def _filled_then_grasped(task: Task) -> Mapping[int, set[int]]:
    """Return the objects that a plan puts into things which it grasps later, by thing.

    Sliced objects are left out: their halves take over their place.
    """
    held: dict[str, int] = {}
    filled: dict[int, set[int]] = {}
    grasped: dict[int, set[int]] = {}
    for action in task.script:
        hand, _, kind = action.operator.partition("_")
        if kind == "GRASP":
            (held[hand],) = action.arguments
            if filled.get(held[hand]):
                grasped[held[hand]] = filled[held[hand]]
        elif kind == "PLACE_INSIDE":
            filled.setdefault(action.arguments[0], set()).add(held[hand])
        elif hand == "SLICE":
            for things in filled.values():
                things.difference_update(action.arguments)
    return grasped


def virtualhome_actions(evidence: Evidence) -> Finding:
    number = len(find_benchmark(V).domain.operators)
    return if_so(
        number == 42,
        f"{number} actions are declared, three of which only data use; the printed table lists 40",
        in_part=number >= 42,
    )


def behavior_states(evidence: Evidence) -> Finding:
    return _states(evidence, B, 15, extra=2)


def virtualhome_states(evidence: Evidence) -> Finding:
    return _states(evidence, V, 17)


def without_effect(evidence: Evidence) -> Finding:
    operators = _library(evidence, V).operators
    none = [name for name, text in operators.items() if not re.search(r"\w", text.effect.replace("and", ""))]
    return if_so(
        len(none) in (9, 10, 11),
        f"{len(none)} of {len(operators)} operators: {', '.join(none)}",
        in_part="read" in none,
    )


def connectives(evidence: Evidence) -> Finding:
    used = Counter(
        word
        for domain in (V, B)
        for text in _library(evidence, domain).operators.values()
        for word in set(re.findall(r"\((\w+)", f"{text.precondition} {text.effect}"))
    )
    return all_of(
        (sum(bool(used[word]) for word in CONNECTIVES), len(CONNECTIVES)),
        text=f"operators with {', '.join(f'{word} {used[word]}' for word in CONNECTIVES)}",
    )


def needs_of_tools(evidence: Evidence) -> Finding:
    operators = _library(evidence, B).operators
    needs = {
        "soak": ("toggled_on",),
        "slice": ("holding",),
        "clean_stained_rag": ("holding", "soaked"),
        "clean_dusty_rag": ("holding",),
    }
    right = sum(all(word in operators[name].precondition for word in words) for name, words in needs.items())
    return all_of(
        (right, len(needs)),
        text=f"by the data set's operators {right} of {len(needs)}: "
        f"{'; '.join(f'{name}: {operators[name].precondition}' for name in list(needs)[:1])}",
    )


def tools_checked(evidence: Evidence) -> Finding:
    wash = _library(evidence, V).operators["wash"].precondition
    clean = _library(evidence, B).operators["clean_stained_rag"].precondition
    return if_so("hold" not in wash and "holding" in clean, f"wash: {wash}; clean_stained_rag: {clean}")


def affordances_of_examples(evidence: Evidence) -> Finding:
    task = next(
        t for t in _tasks(evidence, V).values() if {"computer.417", "mouse.413"} <= t.scene.index.keys()
    )
    plugs = [task.initial.has("HAS_PLUG", task.scene.index[name]) for name in ("computer.417", "mouse.413")]
    scenes = _tasks(evidence, B).values()
    heavy = [
        t.initial.has("ungraspable", t.scene.index["fridge_97"])
        for t in scenes
        if "fridge_97" in t.scene.index
    ]
    knives = [
        t.initial.has("sliceable", index)
        for t in scenes
        for name, index in t.scene.index.items()
        if "knife" in name
    ]
    return all_of(
        (plugs.count(False), 2),
        (int(any(heavy)), 1),
        (knives.count(False), len(knives)),
        text=f"{plugs.count(False)} of the two have no plug; fridge_97 cannot be grasped in "
        f"{sum(heavy)} of {len(heavy)} scenes; {sum(knives)} of {len(knives)} knives can be sliced",
    )


def gold_plans(evidence: Evidence) -> Finding:
    """Under `strict`: the package executes no VirtualHome plan that equals the annotated one."""
    counts = {}
    for domain in (V, B):
        source = evidence.published
        book = open_gold_answers(find_benchmark(domain), Ability.ACTION_SEQUENCING, source)
        suite = open_suite(domain, Ability.ACTION_SEQUENCING, Protocol.STRICT, source=source)
        texts = {task_id: book[task_id].text for task_id in suite.task_ids}
        judge = suite.choose_suite_for_answers(list(texts.values()))
        verdicts = [judge.score(task_id, text) for task_id, text in texts.items()]
        scored = [each for each in verdicts if each.excluded is None]
        counts[domain] = sum(bool(each.success) for each in scored), len(scored)
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in counts.items())
    return all_of(
        *counts.values(), text=f"annotated plans that succeed under `strict`, without errata: {text}"
    )


def errata(evidence: Evidence) -> Finding:
    entries = load_all_errata().entries
    return if_so(not entries, f"{len(entries)} [errata](errata.md) are known")


def micro_averages(evidence: Evidence) -> Finding:
    right = number = 0
    for domain in (V, B):
        for records in evidence.suites[Suite(domain, GI)].values():
            rates = RunTotals.from_records(records).rates
            kinds = sum(rates[f"{kind}.f1"].numerator for kind in ("state", "relation", "action"))
            right += kinds == rates["overall.f1"].numerator
            number += 1
    return all_of(
        (right, number), text=f"overall counts are the sums over kinds of goals in {right} of {number} runs"
    )


def cells_that_come_out(evidence: Evidence) -> Finding:
    near = exact = number = 0
    for name in read_paper_protocol_and_tables().names_of_tables_with_all_models:
        table = read_paper_table(name)
        for column in table.columns:
            if name == "overview" or not column.ability:
                continue
            ours = measured_rates(evidence, RateColumn(column.domain, column.ability, column.metric))
            for model, figures in table.rows.items():
                printed = figures[column]
                if printed is None or model not in ours:
                    continue
                number += 1
                near += abs(ours[model] - printed) <= NEAR + DIGIT
                exact += abs(ours[model] - printed) <= DIGIT
    return Finding(
        by_degree(near == number, near > number / 2),
        f"of {number:,} cells of the full tables {exact:,} come out of public answers to the digit, "
        f"{near:,} within a point",
    )


def figures_of_tables(evidence: Evidence) -> Finding:
    """Compare the figures of each model and rate that several of the paper's tables print."""
    names = (*read_paper_protocol_and_tables().names_of_tables_with_all_models, "transition_modeling_summary")
    tables = [read_paper_table(name) for name in names]
    gaps = {}
    for column in {column for table in tables for column in table.columns if column.ability}:
        for model in evidence.names:
            figures = [
                each for table in tables if (each := table.find_printed_number(model, column)) is not None
            ]
            if len(figures) > 1:
                gaps[model, column] = max(figures) - min(figures)
    equal = sum(gap <= DIGIT for gap in gaps.values())
    wide = sum(gap > NEAR + DIGIT for gap in gaps.values())
    return all_of(
        (equal, len(gaps)),
        text=f"of {len(gaps)} figures that several tables print {equal} are equal in all of them; "
        f"{wide} differ by more than a point, by {max(gaps.values()):.1f} at most",
    )


def _ordered(evidence: Evidence) -> tuple[int, int, int]:
    """Return how many VirtualHome formulas have an order, their number, and that of BEHAVIOR's goals."""
    formulas = [task.temporal_goal for task in _tasks(evidence, V).values() if task.temporal_goal]
    of_states = sum(not goal.is_temporal for task in _tasks(evidence, B).values() for goal in task.goals)
    return sum(" then " in text for text in formulas), len(formulas), of_states


def _whole_tasks(evidence: Evidence, domain: str) -> tuple[int, int, int]:
    """Return the number of tasks with all parts but the formula, with the formula, and in all."""
    tasks, operators = _tasks(evidence, domain), find_benchmark(domain).operator_tasks(evidence.published)
    whole = sum(
        bool(t.title and t.instruction and t.goals and t.script and t.id in operators) for t in tasks.values()
    )
    return whole, sum(bool(t.temporal_goal) for t in tasks.values()), len(tasks)


def _tasks(evidence: Evidence, domain: str) -> Mapping[str, Task]:
    return find_benchmark(domain).tasks(evidence.published)


def _library(evidence: Evidence, domain: str) -> OperatorLibrary:
    return next(iter(find_benchmark(domain).operator_tasks(evidence.published).values())).domain


def _lines(evidence: Evidence, domain: str, ability: str) -> list[AnswerTableLine]:
    """Return a line for each task of a suite."""
    suite = Suite(domain, ability)
    lines = {each.task: each for each in evidence.of(evidence.tables.answers, suite)}
    return list(lines.values())


def _lengths(evidence: Evidence, domain: str) -> list[int]:
    return [len(task.script) for task in _tasks(evidence, domain).values() if task.goals]


def _states(evidence: Evidence, domain: str, number: int, extra: int = 0) -> Finding:
    known = {predicate.name for predicate in find_benchmark(domain).domain.vocabulary.predicates}
    known |= {p.name for p in _library(evidence, domain).header.predicates}
    words = STATES[domain].split()
    found = [word for word in words if word in known]
    named = f"{len(found)} of {len(words)} listed states are predicates of the data"
    return all_of(
        (len(found), len(words)),
        (len(words) + extra, number),
        text=named + (f", {extra} are abilities of objects" if extra else ""),
    )


def _name(formula: f.Formula) -> str:
    return formula.predicate if isinstance(formula, f.Atom) else type(formula).__name__
