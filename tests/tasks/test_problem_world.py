from __future__ import annotations

import random
import shutil
from itertools import product
from pathlib import Path

import pytest

from by_path import TESTS
from eai.abilities.protocol import Ability
from eai.base.errors import DataError, InputError
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.execute import PddlPlanExecutor, PlanStep
from eai.pddl.export import export_domain_and_problem
from eai.pddl.fast_downward import FastDownward
from eai.pddl.files import read_domain_text, read_problem_file, read_text
from eai.pddl.model import PddlDomain
from eai.pddl.planning import PlannerOutcome, PlanningTask
from eai.pddl.val import VALID, find_val_program, run_val
from eai.planning.planner import Planner
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.planning import find_plan
from eai.tasks.problem_world import open_pddl, open_pddl_folder
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action, Fault
from eai.world.conformance import check_domain
from eai.world.domain import Domain
from eai.world.execution import attempt_action, describe_fault, execute_plan
from eai.world.fault import FaultKind
from eai.world.history import History

FOLDER = TESTS / "pddl" / "domains"
NAMES = sorted(path.name for path in FOLDER.iterdir())
PROBLEMS = [
    (path.parent.name, path.stem) for path in sorted(FOLDER.glob("*/*.pddl")) if path.stem != "domain"
]


def domain_of(file: Path) -> PddlDomain:
    return read_domain_text(read_text(file), file)


def opened(name: str) -> tuple[Domain, dict[str, Task]]:
    domain, tasks = open_pddl(FOLDER / name / "domain.pddl", FOLDER / name)
    return domain, dict(tasks)


def reaches_the_goal(domain: Domain, task: Task, plan: tuple[Action, ...]) -> bool:
    trajectory = execute_plan(domain, task.initial, plan)
    return trajectory.failure is None and all(
        domain.holds(goal.formula, trajectory.final_state) for goal in task.goals
    )


@pytest.mark.parametrize("name", NAMES)
def test_an_imported_domain_conforms(name: str) -> None:
    domain, tasks = opened(name)
    assert check_domain(domain, [task.initial for task in tasks.values()]) == ()
    assert len(tasks) >= 2


@pytest.mark.parametrize(("name", "problem"), PROBLEMS)
def test_the_built_in_planner_solves_imported_tasks(name: str, problem: str) -> None:
    domain, tasks = opened(name)
    plan = find_plan(tasks[problem], Planner(domain)).plan
    assert plan
    assert reaches_the_goal(domain, tasks[problem], plan)


@pytest.mark.parametrize(("name", "problem"), PROBLEMS)
def test_fast_downward_solves_the_files_and_what_they_are_exported_as_again(name: str, problem: str) -> None:
    try:
        planner = FastDownward.find_installed(cpu_seconds=60)
    except DataError as error:
        pytest.skip(str(error))
    domain, tasks = opened(name)
    task = tasks[problem]
    source = domain_of(FOLDER / name / "domain.pddl")
    as_written = read_problem_file(FOLDER / name / f"{problem}.pddl", source).problem
    found = planner.solve(PlanningTask(source, as_written))
    assert found.outcome is PlannerOutcome.SOLVED, found.detail
    index = task.scene.index
    plan = tuple(Action(step.action, tuple(index[name] for name in step.arguments)) for step in found.plan)
    assert reaches_the_goal(domain, task, plan)
    exported = export_domain_and_problem(domain, task.initial, [goal.formula for goal in task.goals])
    again = planner.solve(PlanningTask(exported.domain, exported.problem))
    assert again.outcome is PlannerOutcome.SOLVED, again.detail
    assert reaches_the_goal(domain, task, tuple(map(exported.to_action, again.plan)))


@pytest.mark.parametrize(("name", "problem"), PROBLEMS)
def test_engine_and_pddl_agree_on_random_walks(name: str, problem: str) -> None:
    domain, tasks = opened(name)
    task = tasks[problem]
    source = domain_of(FOLDER / name / "domain.pddl")
    executor = PddlPlanExecutor(source, read_problem_file(FOLDER / name / f"{problem}.pddl", source).problem)
    exported = export_domain_and_problem(domain, task.initial, ())
    declared = {predicate.name for predicate in source.predicates}
    rng = random.Random(problem)
    past, state, taken = History(task.initial), executor.initial_state, 0
    for number in range(4_000):
        operator = rng.choice(domain.operators)
        action = Action(
            operator.name, tuple(rng.randrange(len(task.scene.objects)) for _ in operator.parameters)
        )
        if number % 20 == 0:
            possible = [*generate_applicable_actions_of_operator(domain, operator, past.state, task.relevant)]
            action = rng.choice(possible or [action])
        names = tuple(task.scene.objects[i].name for i in action.arguments)
        outcome = attempt_action(domain, past, action)
        after = executor.execute_step(state, PlanStep(operator.name, names))
        assert isinstance(outcome, Fault) is isinstance(after, str), action
        if isinstance(outcome, Fault):
            assert describe_fault(outcome, domain, action, task.scene)
            continue
        assert not isinstance(after, str)
        assert {atom for atom in exported.export_state(outcome) if atom.predicate in declared} == after
        past = past.extend(outcome)
        state, taken = after, taken + 1
    assert taken > 3


MUTANTS = 20
"""Number of mutated plans for each plan that reaches its goals."""


def mutated(plan: tuple[Action, ...], task: Task, rng: random.Random) -> tuple[Action, ...]:
    """The plan with a step left out, put elsewhere, or about another object."""
    steps = list(plan)
    step = steps.pop(rng.randrange(len(steps)))
    match rng.choice(("dropped", "moved", "other")):
        case "moved":
            steps.insert(rng.randrange(len(steps) + 1), step)
        case "other" if step.arguments:
            objects = list(step.arguments)
            objects[rng.randrange(len(objects))] = rng.randrange(len(task.scene.objects))
            steps.insert(rng.randrange(len(steps) + 1), step._replace(arguments=tuple(objects)))
    return tuple(steps)


@pytest.mark.parametrize(("name", "problem"), PROBLEMS)
def test_val_agrees_on_plans_and_mutants_of_them(name: str, problem: str) -> None:
    try:
        program = find_val_program()
    except DataError as error:
        pytest.skip(str(error))
    domain, tasks = opened(name)
    task, rng = tasks[problem], random.Random(problem)
    source = domain_of(FOLDER / name / "domain.pddl")
    as_written = read_problem_file(FOLDER / name / f"{problem}.pddl", source).problem
    found = tuple(find_plan(task, Planner(domain)).plan)
    assert found
    for plan in (found, *(mutated(found, task, rng) for _ in range(MUTANTS))):
        names = [tuple(task.scene.objects[i].name for i in action.arguments) for action in plan]
        steps = [PlanStep(action.operator, each) for action, each in zip(plan, names, strict=True)]
        verdict = run_val(program, source, as_written, steps)
        assert verdict in (VALID, "not valid")
        assert (verdict == VALID) is reaches_the_goal(domain, task, plan), plan


def test_a_planner_s_plan_is_an_answer_in_any_case() -> None:
    gripper = FOLDER / "gripper"
    suite = open_suite(f"pddl:{gripper / 'domain.pddl'},{gripper}", Ability.ACTION_SEQUENCING)
    task = suite.tasks["two-balls"]
    names = [thing.name for thing in task.scene.objects]
    plan = find_plan(task, Planner(suite.benchmark.domain)).plan
    lines = [f"({' '.join([action.operator, *(names[i] for i in action.arguments)])})" for action in plan]
    written = "\n".join([*lines, f"; cost = {len(lines)} (unit cost)"])
    for text in (written, written.upper()):
        assert suite.score(task.id, text).success
    assert not suite.score(task.id, "\n".join(lines[1:])).success


def test_checks_tell_what_an_object_is_from_what_has_not_been_done() -> None:
    domain, _ = opened("logistics")
    drive = domain.compiled_operators["drive"].operator
    kinds = [(check.fault, check.reason) for check in drive.checks]
    assert kinds == [
        (FaultKind.AFFORDANCE, "{t} is no truck"),
        (FaultKind.AFFORDANCE, "{from} is no place"),
        (FaultKind.AFFORDANCE, "{to} is no place"),
        (FaultKind.MISSING_STEP, "at({t}, {from}) does not hold"),
        (
            FaultKind.AFFORDANCE,
            "(exists (?c - city) (and (part-of {from} ?c) (part-of {to} ?c))) does not hold",
        ),
    ]
    blocks = opened("blocksworld")[0].compiled_operators["stack"].operator
    assert blocks.checks[-1].reason == "{x} and {y} are the same"


def test_goals_are_split_and_have_kinds() -> None:
    task = opened("library")[1]["light"]
    assert [goal.kind for goal in task.goals] == [GoalKind.STATE, GoalKind.RELATION, GoalKind.STATE]


def test_problems_of_one_name_are_known_by_their_files(tmp_path: Path) -> None:
    text = (FOLDER / "blocksworld" / "tower.pddl").read_text()
    for name in ("one", "two"):
        (tmp_path / f"{name}.pddl").write_text(text)
    _, found = open_pddl(FOLDER / "blocksworld" / "domain.pddl", tmp_path)
    assert list(found) == ["one", "two"]
    (single,) = open_pddl(FOLDER / "blocksworld" / "domain.pddl", tmp_path / "one.pddl")[1]
    assert single == "tower"
    (tmp_path / "two.pddl").write_text(text.replace("(on a b)", "(on a c)"))
    assert open_pddl(FOLDER / "blocksworld" / "domain.pddl", tmp_path)[1].sha256 != found.sha256


def test_problems_and_files_of_one_name_are_refused(tmp_path: Path) -> None:
    shutil.copy(FOLDER / "blocksworld" / "domain.pddl", tmp_path)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        shutil.copy(FOLDER / "blocksworld" / "tower.pddl", tmp_path / name)
    with pytest.raises(InputError, match=r"b.tower\.pddl: the name 'tower' is taken by .*tower\.pddl"):
        open_pddl_folder(tmp_path)


HEAD = "(define (domain d)\n (:requirements :strips)\n "


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("(define (domain d)\n (:predicates (p ?x)", "line 2, column 2: expected a partner"),
        (
            f"{HEAD}(:durative-action a))",
            "line 3, column 2: expected classical planning, without durative actions",
        ),
        (
            f"{HEAD}(:predicates (p))\n (:action a :effect (and (p)\n  (q))))",
            "line 5, column 4: expected a declared",
        ),
        (
            f"{HEAD}(:predicates (p ?x))\n (:action a :effect (p ?y)))",
            "line 4, column 24: expected a variable",
        ),
        (
            f"{HEAD}(:functions (f))\n (:predicates (p))\n (:action a :precondition (> (f) 1) :effect (p)))",
            "line 5, column 27: expected classical planning, without numbers",
        ),
        (
            f"{HEAD}(:predicates (p ?x) (q ?x))\n (:derived (q ?x) (or (p ?x) (not (q ?x)))))",
            "the derived predicate q depends on its own negation",
        ),
        (
            f"{HEAD}(:predicates (p) (q)) (:derived (q) (p))\n (:action b :effect (q)))",
            "line 4: operator b: an effect changes q, which is derived",
        ),
        (
            f"; (:action b :effect (q)) is wrong\n{HEAD}(:predicates (p) (q)) (:derived (q) (p))\n"
            " (:action b :effect (q)))",
            "line 5: operator b: an effect changes q, which is derived",
        ),
        (
            f"{HEAD}(:predicates (p) (q)) (:derived (q) (p))\n (:action\t b :effect (q)))",
            "line 4: operator b: an effect changes q, which is derived",
        ),
        (
            f"{HEAD}\n(:predicates ( p) ( q))\n(:derived ( q) (or (p) (not (q)))))",
            "line 4: the derived predicate q depends on its own negation",
        ),
        (
            f"{HEAD}(:predicates ({{p))\n (:action b :precondition ({{p) :effect ({{p)))",
            "bad.pddl: reason '{p() does not hold': expected '}'",
        ),
        (
            f"{HEAD}(:types a)\n (:predicates (p ?x - b)))",
            "line 4, column 23: expected a declared type, not b",
        ),
        (
            f"{HEAD}(:types a - b b - a)\n (:predicates (p ?x - a)))",
            "line 3, column 10: expected no type above itself, as a is (:types)",
        ),
    ],
)
def test_an_error_names_file_line_and_what_was_expected(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.pddl"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        open_pddl(path, FOLDER / "blocksworld")
    assert str(error.value).startswith(f"{path}: ")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("(clear b)", "(clear x)", "line 4, column 66: expected a declared object, not x"),
        ("(on b c)", "(over b c)", "line 5, column 25: expected a declared predicate, not over"),
        ("(:goal", "(:constraints", "line 5, column 3: expected classical planning, without constraints"),
    ],
)
def test_an_error_in_a_problem_has_its_place_too(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "bad.pddl"
    path.write_text((FOLDER / "blocksworld" / "tower.pddl").read_text().replace(old, new))
    with pytest.raises(InputError) as error:
        open_pddl(FOLDER / "blocksworld" / "domain.pddl", path)
    assert str(error.value).startswith(f"{path}: ")
    assert message in str(error.value)


def test_a_mark_of_the_byte_order_and_a_length_are_read_over(tmp_path: Path) -> None:
    domain, path = tmp_path / "domain.pddl", tmp_path / "problem.pddl"
    domain.write_text((FOLDER / "blocksworld" / "domain.pddl").read_text(), encoding="utf-8-sig")
    text = (FOLDER / "blocksworld" / "tower.pddl").read_text().rstrip()
    path.write_text(f"{text[:-1]} (:length (:serial 6) (:parallel 6)))")
    assert len(open_pddl(domain, path)[1]) == 1


def test_a_problem_of_another_domain_is_refused(tmp_path: Path) -> None:
    path, domain = tmp_path / "other.pddl", FOLDER / "blocksworld" / "domain.pddl"
    path.write_text((FOLDER / "blocksworld" / "tower.pddl").read_text().replace("blocksworld", "chess"))
    with pytest.raises(InputError, match=r"line 2, column 4: expected \(:domain blocksworld\)"):
        open_pddl(domain, path)


REFUSED = {
    "durative": ("(:durative-action a)", "durative actions"),
    "numbers": ("(:action a :precondition (= (fuel) 3) :effect (p))", "numbers or object fluents"),
    "decrease": ("(:action a :effect (and (p) (decrease (fuel) 3)))", "numbers or object fluents"),
    "object fluent": ("(:action a :parameters (?x) :effect (assign (where ?x) ?x))", "numbers or object"),
    "probabilistic": ("(:action a :effect (probabilistic 0.5 (p)))", "probabilistic effects"),
    "oneof": ("(:action a :effect (oneof (p) (not (p))))", "nondeterministic effects"),
    "observe": ("(:action a :parameters () :observe (p))", "observations"),
    "preference": ("(:action a :precondition (preference q (p)) :effect (p))", "preferences"),
    "process": ("(:process a)", "processes"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_classical_is_refused_in_plain_english(tmp_path: Path, name: str) -> None:
    section, what = REFUSED[name]
    path = tmp_path / "domain.pddl"
    path.write_text(f"{HEAD}(:functions (fuel))\n(:predicates (p))\n{section})")
    with pytest.raises(InputError, match=rf"line 5, column \d+: expected classical planning, without {what}"):
        open_pddl(path, tmp_path / "none.pddl")


@pytest.mark.parametrize(
    ("part", "what"),
    [
        ("(:init (at 5 (p))) (:goal (p))", "facts that come true at a time"),
        ("(:init) (:goal (>= (fuel) 2))", "numbers"),
        ("(:init (= (fuel) 2)) (:goal (= (fuel) 2))", "numbers"),
        ("(:init) (:goal (preference q (p)))", "preferences"),
        ("(:init (oneof (p) (q))) (:goal (p))", "nondeterministic"),
    ],
)
def test_problems_that_are_not_classical_are_refused_too(tmp_path: Path, part: str, what: str) -> None:
    (tmp_path / "d.pddl").write_text(f"{HEAD}(:predicates (p) (q)) (:action a :effect (p)))")
    (tmp_path / "p.pddl").write_text(f"(define (problem x) (:domain d)\n {part})")
    with pytest.raises(InputError, match=rf"p\.pddl: line 2, column .*classical planning, without {what}"):
        open_pddl(tmp_path / "d.pddl", tmp_path / "p.pddl")


ODDITIES = """(define (domain ODD)
  (:types box crate - vessel, shelf hook - place lid)
  (:predicates (on ?x - (either vessel lid), ?p - place) (unknown ?x) (at ?p ?q - place))
  (:action Put :parameters (?x - (either crate lid), ?p - place)
    :precondition (and (not (on ?x ?p)) (at ?p DOCK)
      (forall (?y - (either box crate)) (not (on ?y ?p))))
    :effect (and (on ?x ?p) (unknown ?x))))"""
ODD_PROBLEM = """(define (problem two) (:domain odd)
  (:objects b - box c - crate l - lid s - shelf dock - hook)
  (:init (at s dock) (on b dock))
  (:goal (and (ON c s) (exists (?x - (either lid box)) (on ?x dock)))))"""


def odd(folder: Path, problem: str = ODD_PROBLEM) -> tuple[Domain, Task]:
    (folder / "d.pddl").write_text(ODDITIES)
    (folder / "p.pddl").write_text(problem)
    domain, tasks = open_pddl(folder / "d.pddl", folder / "p.pddl")
    return domain, tasks["two"]


def test_types_in_choice_constants_of_problems_commas_and_any_case_are_read(tmp_path: Path) -> None:
    domain, task = odd(tmp_path)
    b, c, lid, s, _ = range(5)
    assert reaches_the_goal(domain, task, (Action("put", (c, s)),))
    put = domain.compiled_operators["put"]
    failures = {x: put.find_failures(task.initial, put.bind(task.initial, (x, s))) for x in range(5)}
    assert [x for x, failed in failures.items() if not failed] == [c, lid]
    assert failures[b][0].check.check.reason == "{x} is no crate or lid"
    again = execute_plan(domain, task.initial, [Action("put", (lid, s)), Action("put", (c, s))])
    assert again.failure is None
    crowded = execute_plan(domain, task.initial, [Action("put", (c, s)), Action("put", (lid, s))])
    assert crowded.failure is not None  # where a box or a crate is already


def test_engine_and_pddl_agree_on_types_in_choice(tmp_path: Path) -> None:
    domain, task = odd(tmp_path)
    source = domain_of(tmp_path / "d.pddl")
    executor = PddlPlanExecutor(source, read_problem_file(tmp_path / "p.pddl", source).problem)
    names = [thing.name for thing in task.scene.objects]
    for x, y in product(range(5), repeat=2):
        outcome = attempt_action(domain, History(task.initial), Action("put", (x, y)))
        after = executor.execute_step(executor.initial_state, PlanStep("put", (names[x], names[y])))
        assert isinstance(outcome, Fault) is isinstance(after, str), (x, y)


def test_a_problem_must_declare_the_objects_that_its_domain_names(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"p\.pddl: line 1.*expected a declared object, not dock"):
        odd(tmp_path, ODD_PROBLEM.replace("dock", "dick"))


def test_no_files_and_empty_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        open_pddl(tmp_path / "none.pddl", tmp_path)
    with pytest.raises(InputError, match="expected problems"):
        open_pddl(FOLDER / "gripper" / "domain.pddl", tmp_path)


@pytest.mark.parametrize("problems", ["problems", "problems/", "problems/swap.pddl"])
def test_a_folder_of_problems_may_end_in_a_slash(
    problems: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gripper = FOLDER / "gripper"
    (tmp_path / "problems").mkdir()
    shutil.copy(gripper / "domain.pddl", tmp_path)
    shutil.copy(gripper / "swap.pddl", tmp_path / "problems")
    monkeypatch.chdir(tmp_path)
    assert find_benchmark(f"pddl:domain.pddl,{problems}").name == "gripper"
