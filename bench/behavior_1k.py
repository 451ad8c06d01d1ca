"""Compare BEHAVIOR-1K's goals with bddl's own evaluation, and its gold plans with VAL.

    python -m bench behavior_1k goals FOLDER    goals on the states of gold plans (FOLDER: bddl 3.6.0)
    python -m bench behavior_1k walks FOLDER    goals on the states of random walks near gold plans
    python -m bench behavior_1k mutations       gold plans with one inserted fault, and the kinds found
    python -m bench behavior_1k val             gold plans on exported problems (needs the extra 'val')
    python -m bench behavior_1k prompts         the length of prompts in characters and tokens

`--every N` takes every Nth activity, `--benchmark NAME` the activities of another benchmark. Failures are
printed, and then the exit status is 1.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import sys
import types
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import eai.logic.formula as f
from bench.record import add_write_option, write_figures, write_rows
from bench.result import Figure
from differential.mutations import Dice
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.benchmark import CHALLENGE_2026, behavior_1k
from eai.benchmarks.behavior_1k.challenge import load_activities_of_challenge_2026
from eai.benchmarks.behavior_1k.kinds import get_lemma
from eai.benchmarks.behavior_1k.scene import ANY_OTHER
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.traversal import walk_subformulas
from eai.pddl.export import export_domain_and_problem
from eai.pddl.val import VALID, find_val_program, run_val
from eai.planning.search import SearchEffort, SearchNode
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.fault import FaultKind
from eai.world.state import State
from eai.world.vocabulary import Predicate

CHARACTERS_A_TOKEN = 3.5

MAX_BINDINGS = 1_000_000
"""Maximum number of parameter values that a random walk tries in one state."""


def main() -> int:
    """Run the check that the command line names."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("goals", "walks", "mutations", "val", "prompts"))
    parser.add_argument("folder", type=Path, nargs="?", help="the unpacked source distribution of bddl 3.6.0")
    parser.add_argument("--benchmark", default="behavior-1k")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--steps", type=int, default=21, help="actions of each random walk")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--each", type=int, default=1, help="mutations of a kind for each gold plan")
    parser.add_argument("--show", type=int, default=20)
    add_write_option(parser)
    arguments = parser.parse_args()
    benchmark = find_benchmark(arguments.benchmark)
    tasks = benchmark.tasks(Source())
    chosen = list(tasks)[:: arguments.every]
    definitions = load_activities_of_challenge_2026(None)[0] if arguments.benchmark == CHALLENGE_2026 else {}
    match arguments.what:
        case "goals":
            return compare_goals(
                arguments.folder, tasks, chosen, benchmark.domain, definitions, list_plan_states
            )
        case "walks":
            walk = partial(walk_at_random, arguments.seed, arguments.steps)
            return compare_goals(
                arguments.folder, tasks, chosen, benchmark.domain, definitions, walk, write=arguments.write
            )
        case "mutations":
            return judge_mutations(chosen, arguments)
        case "val":
            return validate(tasks, chosen, benchmark.domain)
        case _:
            return measure_prompts(chosen, write=arguments.write)


# Goals beside bddl's own evaluation.


class BddlObject(NamedTuple):
    """An object in the form that bddl's conditions expect."""

    name: str


class BddlAtomReader:
    """Answers bddl's questions about atoms from a state of `eai`."""

    def __init__(self, domain: Domain, state: State) -> None:
        self.state = state
        self._readings = FormulaEvaluator(domain.vocabulary)
        self._known = domain.vocabulary

    def __call__(self, predicate: str, *things: BddlObject) -> bool:
        """Return whether an atom holds."""
        variables = [f.Variable(f"v{place}") for place in range(len(things))]
        index = self.state.scene.index
        scope = {f"v{place}": index[get_lemma(thing.name)] for place, thing in enumerate(things)}
        if predicate == "future":
            return not self("real", *things)
        return self._readings.holds(f.Atom(predicate, tuple(variables)), scope, self.state)


def import_bddl(folder: Path) -> Any:
    """Import the module `bddl.activity` of an unpacked distribution.

    A stub replaces the package `future`, of which bddl needs one function.
    """

    def with_metaclass(meta: type, *bases: type) -> type:
        made: type = meta("Based", bases, {})
        return made

    future, utils = types.ModuleType("future"), types.ModuleType("future.utils")
    utils.with_metaclass = with_metaclass  # type: ignore[attr-defined]
    sys.modules |= {"future": future, "future.utils": utils}
    sys.path.insert(0, str(folder))
    return import_module("bddl.activity")


def make_bddl_backend(asked: BddlAtomReader) -> Any:
    """Return a backend for bddl whose predicates look up atoms in a state of `eai`."""
    base = import_module("bddl.logic_base")
    unary = {each.name for each in p.GOAL_STATES} | {"future"}

    class Backend:
        def get_predicate_class(self, name: str) -> type:
            kind = base.UnaryAtomicFormula if name in unary else base.BinaryAtomicFormula
            body = {
                "STATE_NAME": name,
                "_sample": lambda *_: None,
                "_evaluate": lambda _, *things: asked(name, *things),
            }
            return type(name, (kind,), body)

    return Backend()


def compile_conditions(bddl: Any, task_id: str, definition: str | None, asked: BddlAtomReader) -> list[Any]:
    """Return the compiled conditions of a goal. Names that end in ``_*`` stand for no object here (D13).

    The definition of the distribution is used if no other is given.
    """
    activity = bddl.Conditions(task_id, 0, "omnigibson", predefined_problem=definition)
    kinds = activity.parsed_objects
    for kind, names in kinds.items():
        kinds[kind] = [name for name in names if not name.endswith(ANY_OTHER)]
    scope = {name: BddlObject(name) for names in kinds.values() for name in names}
    found = bddl.get_goal_conditions(activity, make_bddl_backend(asked), scope, generate_ground_options=False)
    return list({str(each.body): each for each in found}.values())


def list_plan_states(domain: Domain, task: Task) -> Sequence[State]:
    """Return the states of the gold plan."""
    return execute_plan(domain, task.initial, task.script).states


def walk_at_random(seed: str, steps: int, domain: Domain, task: Task) -> Sequence[State]:
    """Return the states of a random walk, the initial state first.

    About half of the actions are the next ones of the gold plan that are possible. The others have a random
    operator, and lead to a state that the walk has not visited if there is one.
    """
    dice, planned = Dice(f"{seed} {task.id}"), list(task.script)
    generator = SuccessorGenerator(domain, task.relevant)
    states = [task.initial]
    while len(states) <= steps:
        node: PlanNode = SearchNode(states[-1])
        after = generator.make_successor(node, planned.pop(0)) if planned and dice.chance(0.5) else None
        if after is None:
            actions = list(generator.generate_applicable_actions(node, SearchEffort(MAX_BINDINGS)))
            operators = dice.shuffled(sorted({action.operator for action in actions}))
            ordered = sorted(dice.shuffled(actions), key=lambda action: operators.index(action.operator))
            after = next(_find_unvisited(generator, node, ordered, states), None)
            after = after or generator.make_successor(node, ordered[0])
        if after is None:
            raise ValueError(f"{task.id}: the generator yields an impossible action")
        states.append(after.state)
    return states


def _find_unvisited(
    generator: SuccessorGenerator, node: PlanNode, actions: Sequence[Action], visited: Sequence[State]
) -> Iterator[PlanNode]:
    for action in actions:
        after = generator.make_successor(node, action)
        if after is not None and after.state not in visited:
            yield after


def compare_goals(
    folder: Path,
    tasks: TaskSet[Task],
    chosen: Sequence[str],
    domain: Domain,
    definitions: Mapping[str, str],
    list_states: Callable[[Domain, Task], Sequence[State]],
    *,
    write: bool = False,
) -> int:
    """Compare each condition of each goal in each listed state, and count the different states."""
    bddl = import_bddl(folder)
    seen: Counter[str] = Counter()
    different: Counter[tuple[str, str]] = Counter()
    readings = FormulaEvaluator(domain.vocabulary)
    for task_id in chosen:
        task = tasks[task_id]
        asked = BddlAtomReader(domain, task.initial)
        with contextlib.redirect_stdout(io.StringIO()):
            theirs = compile_conditions(bddl, task_id, definitions.get(task_id), asked)
        ours = [goal.formula for goal in task.goals]
        seen["activities"] += 1
        seen["conditions that bddl leaves out"] += len(ours) - len(theirs)
        states = list_states(domain, task)
        seen["states"] += len(states)
        seen["different states"] += len(set(states))
        for state in states:
            asked.state = state
            for formula, condition in zip(ours, theirs, strict=False):
                seen["conditions"] += 1
                holds = readings.holds(formula, {}, state)
                if holds != bool(condition.evaluate()):
                    pairs = any(isinstance(part, f.ForPairs) for part in walk_subformulas(formula))
                    different[task_id, "forpairs" if pairs else str(formula)] += 1
                seen["conditions that hold"] += holds
    print(dict(seen))
    print(f"{sum(different.values())} differences")
    for (task_id, shown), times in different.items():
        print(f"  {task_id}, {times} times: {shown}")
    if write:
        agreed = f"{seen['conditions'] - different.total():,} of {seen['conditions']:,}"
        figure = f"{agreed}, {seen['different states']:,} states"
        write_figures("behavior_1k", {"Conditions on which it agrees in random walks": figure})
    return int(any(shown != "forpairs" for _, shown in different))


# Mutated plans.


class Mutant(NamedTuple):
    """A plan with one inserted fault.

    Attributes:
        steps: Names of its steps, each an action and its objects.
        kinds: Kinds that the fault may have; `UNMET` if no step fails and the goal is not reached.
        place: Number of the step that fails, or of the first step that may fail.
        later: Whether the fault may show in a later step.
    """

    steps: list[tuple[str, list[str]]]
    kinds: frozenset[str]
    place: int
    later: bool = False


UNMET, SAME = "goal not reached", "means the same"
ADDITIONAL = frozenset({FaultKind.ADDITIONAL_STEP.value})
WRONG_ORDER = frozenset({FaultKind.WRONG_ORDER.value})
LATE = frozenset({FaultKind.MISSING_STEP.value, FaultKind.WRONG_ORDER.value})
AFFORDANCE = frozenset({FaultKind.AFFORDANCE.value})
HALLUCINATION = frozenset({FaultKind.HALLUCINATION.value})
ARGUMENT_NUMBER = frozenset({FaultKind.ARGUMENT_NUMBER.value})

ALREADY = ("GRASP", "OPEN", "CLOSE", "TOGGLE_ON", "TOGGLE_OFF", "FOLD", "UNFOLD", "IGNITE", "WIPE", "RINSE")
"""Actions that are unnecessary if their effect holds already."""

TAKES_FOR: dict[str, tuple[int, Predicate]] = {
    "SLICE": (1, p.slicer),
    "DICE": (1, p.slicer),
    "STIR": (1, p.mixing_tool),
    "IGNITE": (1, p.lighter),
    "HEAT": (1, p.heat_source),
    "FREEZE": (1, p.cold_source),
    "RINSE": (1, p.sink),
    "WIPE": (1, p.absorbent),
    "SOAK": (0, p.absorbent),
    "PLACE_INSIDE": (1, p.container),
    "POUR": (1, p.fillable),
    "FOLD": (0, p.foldable),
    "OPEN": (0, p.openable),
    "CLOSE": (0, p.openable),
    "TOGGLE_ON": (0, p.toggleable),
    "TOGGLE_OFF": (0, p.toggleable),
    "WASH": (0, p.washer),
    "RUN": (0, p.mixer),
}
"""By action, the position of an object and the kind that it needs, such as a tool or a container."""

Mutate: TypeAlias = Callable[[Dice, Task, "list[tuple[str, list[str]]]"], "Mutant | None"]


def leave_out_step(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant | None:
    """Return a mutant without one step: a later step fails, or the goal is not reached.

    Return None if the plan has a single step.
    """
    if len(steps) == 1:
        return None
    place = dice.below(len(steps))
    return Mutant(steps[:place] + steps[place + 1 :], LATE | {UNMET}, place, later=True)


def exchange_steps(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant | None:
    """Return a mutant with a step exchanged with the next one; None if no two such steps share an object."""
    places = [i for i in range(len(steps) - 1) if set(steps[i][1]) & set(steps[i + 1][1])]
    if not places:
        return None
    place = dice.one(places)
    steps[place : place + 2] = steps[place + 1], steps[place]
    return Mutant(steps, LATE | {UNMET}, place, later=True)


def repeat_step(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant:
    """Return a mutant with a repeated step: it is unnecessary, or its precondition has been used up."""
    place = dice.below(len(steps))
    steps.insert(place, steps[place])
    return Mutant(steps, ADDITIONAL if steps[place][0] in ALREADY else WRONG_ORDER, place + 1)


def replace_by_unsuitable_object(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant | None:
    """Return a mutant with an object of the wrong kind in the role of a tool, a container or a target.

    Return None if no step has such a role, or no object of the wrong kind is known.
    """
    places = [i for i, (action, _) in enumerate(steps) if action in TAKES_FOR]
    if not places:
        return None
    place = dice.one(places)
    action, names = steps[place]
    argument, ability = TAKES_FOR[action]
    able = task.initial.mask(ability.name)
    things = [task.scene.objects[i].name for i in task.relevant if not able >> i & 1]
    things = [name for name in things if name not in names]
    if not things:
        return None
    steps[place] = action, [dice.one(things) if i == argument else name for i, name in enumerate(names)]
    return Mutant(steps, AFFORDANCE, place)


def misspell_name(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant | None:
    """Return a mutant with an unknown name of an action or an object; None if the drawn name is known."""
    place = dice.below(len(steps))
    action, names = steps[place]
    if names and dice.chance(0.7):
        chosen = dice.below(len(names))
        wrong = dice.one((f"{names[chosen]}9", names[chosen].upper(), names[chosen].partition("_")[0]))
        names = [wrong if i == chosen else name for i, name in enumerate(names)]
        if wrong in task.scene.index:
            return None
    else:
        action = dice.one((f"{action}S", action.lower(), action[:-1]))
    steps[place] = action, names
    return Mutant(steps, HALLUCINATION, place)


def change_argument_number(dice: Dice, task: Task, steps: list[tuple[str, list[str]]]) -> Mutant:
    """Return a mutant with one object too many or too few in a step."""
    place = dice.below(len(steps))
    action, names = steps[place]
    more = dice.chance(0.5) or not names
    name = task.scene.objects[dice.one(task.relevant)].name
    steps[place] = action, [*names, name] if more else names[:-1]
    return Mutant(steps, ARGUMENT_NUMBER, place)


MUTATIONS: dict[str, Mutate] = {
    "step left out": leave_out_step,
    "steps exchanged": exchange_steps,
    "step repeated": repeat_step,
    "wrong thing": replace_by_unsuitable_object,
    "misspelt name": misspell_name,
    "number of objects": change_argument_number,
}


def judge_mutations(chosen: Sequence[str], arguments: argparse.Namespace) -> int:
    """Count the kinds of fault found, for each kind of mutation."""
    suite = open_suite(behavior_1k(), Ability.ACTION_SEQUENCING)
    found: dict[str, Counter[str]] = {how: Counter() for how in MUTATIONS}
    right: Counter[str] = Counter()
    shown, rows = 0, list[list[Figure]]()
    for task_id in chosen:
        for how, mutant in make_mutants(suite.tasks[task_id], arguments.seed, arguments.each):
            verdict = suite.score(task_id, write_mutant_answer(mutant))
            kind, place = find_fault_kind(verdict)
            found[how][kind] += 1
            as_put_in = kind in mutant.kinds and (
                place is None or place == mutant.place or (mutant.later and place > mutant.place)
            )
            right[how] += as_put_in
            if not as_put_in and kind != SAME and shown < arguments.show:
                shown += 1
                print(f"{task_id}, {how} at step {mutant.place}: {kind} at {place}, {verdict.error}")
                print("   ", write_mutant_answer(mutant))
    for how, kinds in found.items():
        number = kinds.total() - kinds[SAME]
        print(f"{how}: {right[how]} of {number}; {dict(kinds.most_common())}")
        counts = [f"{kind} {times}" for kind, times in kinds.most_common() if kind != SAME]
        rows.append([how, number, ", ".join(counts).replace("_", " "), f"{100 * right[how] / number:.0f} %"])
    if arguments.write:
        write_rows("behavior_1k_faults", rows)
    number = sum(kinds.total() - kinds[SAME] for kinds in found.values())
    share = right.total() / number
    print(f"{number} mutations, {share:.2%} as put in")
    return int(share < 0.98)


def make_mutants(task: Task, seed: str, each: int) -> Iterator[tuple[str, Mutant]]:
    """Return the mutants of a task's gold plan."""
    names = [thing.name for thing in task.scene.objects]
    for how, mutate in MUTATIONS.items():
        for number in range(each if task.script else 0):
            dice = Dice(f"{seed} {task.id} {how} {number}")
            steps = [(step.operator, [names[i] for i in step.arguments]) for step in task.script]
            mutant = mutate(dice, task, steps)
            if mutant is not None:
                yield how, mutant


def write_mutant_answer(mutant: Mutant) -> str:
    """Return the plan as the text of an answer."""
    steps = [json.dumps({"action": action, "object": ", ".join(names)}) for action, names in mutant.steps]
    return f"[{', '.join(steps)}]"


def find_fault_kind(verdict: Verdict) -> tuple[str, int | None]:
    """Return the kind of fault found, and the number of its step, or None for a fault without a step."""
    if verdict.error is not None:
        return verdict.error.kind.value, verdict.error.step
    if not isinstance(verdict, PlanVerdict):
        raise TypeError(f"expected a verdict on a plan, found {type(verdict).__name__}")
    if verdict.additional_steps:
        return FaultKind.ADDITIONAL_STEP.value, None
    return (SAME if verdict.success else UNMET), None


# Gold plans by VAL, and the length of prompts.


def validate(tasks: TaskSet[Task], chosen: Sequence[str], domain: Domain) -> int:
    """Judge gold plans with VAL on exported problems, and the same plans without their last step."""
    program = find_val_program()
    verdicts: Counter[str] = Counter()
    for task in map(tasks.__getitem__, chosen):
        if task.script:
            exported = export_domain_and_problem(domain, task.initial, [goal.formula for goal in task.goals])
            steps = [exported.to_pddl_step(action) for action in task.script]
            whole = run_val(program, exported.domain, exported.problem, steps)
            verdicts[f"gold plan: {whole}"] += 1
            without = ""
            if whole == VALID:
                without = run_val(program, exported.domain, exported.problem, steps[:-1])
                verdicts[f"without its last step: {without}"] += 1
            if whole != VALID or without == VALID:
                print(task.id, whole, without, exported.unsupported)
    print(dict(verdicts))
    return int(set(verdicts) != {f"gold plan: {VALID}", "without its last step: not valid"})


def measure_prompts(chosen: Sequence[str], *, write: bool) -> int:
    """Print the length of prompts in tokens: the median, the 95th percentile and the longest."""
    library, rows = PromptLibrary("eai"), list[list[Figure]]()
    for ability in PAPER_ABILITIES:
        prompts = library.open(behavior_1k(), ability)
        lengths = [
            (len(prompts[task_id].user) + len(prompts[task_id].system or "")) / CHARACTERS_A_TOKEN
            for task_id in chosen
            if task_id in prompts
        ]
        lengths.sort()
        at = [lengths[min(int(share * len(lengths)), len(lengths) - 1)] for share in (0.5, 0.95, 1)]
        print(f"{ability.value}: {len(lengths)} prompts, tokens {[round(each) for each in at]}")
        rows.append([ability.value.replace("_", " "), *map(round, at)])
    if write:
        write_rows("behavior_1k", rows)
    return 0
