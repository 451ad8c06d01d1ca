"""Findings of `eai check`: each test introduces one error."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from importlib import invalidate_caches
from pathlib import Path

import pytest

from command_line import Command
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.check import check_benchmark
from eai.benchmarks.registry import find_benchmark
from eai.logic.formula import Atom, Variable
from eai.planning.search import SearchEndReason
from eai.tasks.goal_text import make_task
from eai.tasks.source import Source, use_tasks
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.effect import Add
from eai.world.operator import Operator, additional_step, affordance
from eai.world.state import Scene
from world import toy

X = Variable("x")
LIGHT = make_task("light", "Switch the lamp on.", toy.initial(), "lit(lamp)")
GO, PRESS = Action("GO", (2,)), Action("PRESS", (5,))


def find_problems(*tasks: Task, domain: Domain = toy.DOMAIN) -> list[tuple[str, str]]:
    findings, _ = check_benchmark(Benchmark("toy", domain, use_tasks(*tasks)), Source())
    return [(finding.place, finding.problem) for finding in findings]


def test_the_check_plans_for_a_task_without_a_plan() -> None:
    planned = replace(LIGHT, id="planned", script=(GO, PRESS))
    outcome = check_benchmark(Benchmark("toy", toy.DOMAIN, use_tasks(LIGHT, planned)), Source())
    assert outcome == ([], {SearchEndReason.SOLVED: 1})


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda: replace(LIGHT, script=(GO, PRESS)), None),
        (lambda: replace(LIGHT, script=(GO,)), "plan: expected to reach goals.0"),
        (
            lambda: replace(LIGHT, script=(PRESS,)),
            "plan.0: expected a step that is possible and needed: missing_step, the robot is not beside lamp",
        ),
        (lambda: replace(LIGHT, goals=()), "the task has no goals"),
        (
            lambda: make_task("light", "", toy.initial(), "at(robot, hall)"),
            "goals: expected a goal that does not hold at the start",
        ),
        (lambda: replace(LIGHT, goals=(goal(Atom("lit", ())),)), "goals.0: lit takes 1 argument, not 0"),
        (lambda: make_task("light", "", toy.initial(), "at(lamp, hall)"), "no plan reaches its goals"),
    ],
)
def test_a_task_with_a_false_statement_is_a_finding(change: Callable[[], Task], problem: str | None) -> None:
    assert find_problems(change()) == ([] if problem is None else [("light", problem)])


def test_a_kind_without_objects_is_a_finding() -> None:
    bulb = Operator("DIM", (X,), (affordance(is_a(X, "lump"), "{x} is no lump"),), ())
    problem = "operator DIM: no task has an object of the kind lump; did you mean lamp?"
    assert find_problems(LIGHT, domain=toy.DOMAIN.replace_operators(bulb)) == [("toy", problem)]


def test_a_defect_in_random_walks_is_a_finding() -> None:
    dull = Operator("DIM", (X,), (additional_step(~toy.lit(X) & toy.lit(X), "dim"),), (Add(toy.holding(X)),))
    problems = find_problems(LIGHT, domain=toy.DOMAIN.replace_operators(dull))
    assert problems == [("toy", "DIM: an additional step that would bring about holding(x)")]


@pytest.mark.parametrize(
    ("declare", "problem"),
    [
        (lambda: make_task("", "", toy.initial()), "expected the id of a task as a text, found ''"),
        (lambda: make_task(7, "", toy.initial()), "expected the id of a task as a text, found 7"),
        (
            lambda: make_task("light", "", toy.initial(), ["lit(lamp)"]),
            "task light, goal 1: expected a text or a formula, found list",
        ),
        (
            lambda: Scene(toy.VOCABULARY, {"lamp": None}),
            "an object's name and kind must be texts, found 'lamp' and None",
        ),
        (
            lambda: Operator("DIM", (X,), (affordance(is_a(X, "lamp"), "{x is no lamp"),), ()),
            "reason '{x is no lamp': expected '}' before end of string; "
            "write {{ and }} for braces in the text",
        ),
        (
            lambda: Operator("DIM", (X,), (affordance(is_a(X, "lamp"), "{} is no lamp"),), ()),
            "operator DIM: the reason of a check mentions {}, which is no parameter of the operator",
        ),
        (
            lambda: toy.initial().scene.state(["lit(the-lamp)"]),
            "'lit(the-lamp)': line 1, column 8: expected ')' or ','",
        ),
        (lambda: use_tasks(LIGHT, LIGHT), "two tasks are called light: give each task an id of its own"),
        (lambda: use_tasks([LIGHT]), "eai.use_tasks: expected Task, found list"),
        (
            lambda: Benchmark("toy", toy.DOMAIN, [LIGHT]),
            "benchmark toy: expected a function that returns tasks, such as eai.use_tasks(task, ...), "
            "found a value of the type list",
        ),
    ],
)
def test_a_wrong_declaration_of_a_benchmark_is_an_error(declare: Callable[[], object], problem: str) -> None:
    with pytest.raises(InputError) as error:
        declare()
    assert str(error.value) == problem


def test_an_error_in_a_module_names_file_and_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "spoilt_world.py").write_text("from eai.world import *\n\nVocabulary((Predicate('at', 2)))\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"^spoilt_world\.py: line 3: predicates: expected a tuple"):
        find_benchmark("spoilt_world:world")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"x = 1\nbox = Vocab()", "broken_world.py: line 2: NameError: name 'Vocab' is not defined"),
        (b"import eai\n\neai.mak_task()", "broken_world.py: line 3: AttributeError: module 'eai' has no "),
        (b"from eai import Nothing", "broken_world.py: line 1: ImportError: cannot import name 'Nothing'"),
        (
            b"import no_such_package",
            "broken_world.py: line 1: ModuleNotFoundError: No module named 'no_such_",
        ),
        (b"box = (\n    1,", "broken_world.py: line 1: SyntaxError: '(' was never closed"),
        (b"box = 1\n\tbox = 2", "broken_world.py: line 2: IndentationError: unexpected indent"),
        (b"box = 'caf\xe9'", "broken_world.py: line 1: SyntaxError: (unicode error) 'utf-8' codec can't "),
        ("box = 1".encode("utf-16"), "broken_world:world: SyntaxError: source code "),
        (b"", "broken_world:world: broken_world has no object 'world'"),
        (
            b"import sys\nsys.exit()",
            "broken_world.py: line 2: the import calls sys.exit(None); only a program may do so",
        ),
    ],
)
def test_an_exception_in_a_module_names_file_and_line(
    content: bytes, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken_world.py").write_bytes(content)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    sys.modules.pop("broken_world", None)
    invalidate_caches()
    with pytest.raises(InputError) as error:
        find_benchmark("broken_world:world")
    assert str(error.value).startswith(message)


def test_a_module_in_the_folder_of_its_name_gets_a_hint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "nested_world").mkdir()
    (tmp_path / "nested_world" / "nested_world.py").write_text("nested_world = 1")
    monkeypatch.chdir(tmp_path)
    invalidate_caches()
    with pytest.raises(
        InputError, match=r"it is a folder: run the command in the folder of nested_world\.py"
    ):
        find_benchmark("nested_world:nested_world")


def test_an_exception_below_a_module_names_the_line_of_the_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "small_world.py").write_text("import a_small_world")
    (tmp_path / "a_small_world.py").write_text("x = 1\nbox = Vocab()")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    invalidate_caches()
    with pytest.raises(InputError, match=r"^small_world\.py: line 1: NameError: "):
        find_benchmark("small_world:world")


@pytest.mark.parametrize(
    "reference",
    ["world.py", "world.py:world", "../worlds/world:world", "./world.py:world", ":world", "a..b:c"],
)
def test_a_file_is_no_module(reference: str) -> None:
    with pytest.raises(InputError, match=r": expected a module without folder and \.py, as in lamps:lamps$"):
        find_benchmark(reference)


def test_a_scene_without_an_agent_that_the_domain_needs_is_an_error() -> None:
    scene = Scene(toy.VOCABULARY, toy.initial().scene.objects)
    task = make_task("light", "", scene.state([]), "lit(lamp)")
    with pytest.raises(InputError, match="the scene has no agent, but the domain needs one"):
        find_problems(task)


def test_a_kind_that_contains_itself_names_file_and_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = ["from eai.world import *", "", "Vocabulary((), parents={'cup': 'cap', 'cap': 'cup'})"]
    (tmp_path / "round_world.py").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        InputError, match=r"^round_world\.py: line 3: parents: the kind cup contains itself: remove a parent"
    ):
        find_benchmark("round_world:world")


def test_goals_and_checks_may_be_about_a_wider_kind() -> None:
    vocabulary = replace(toy.VOCABULARY, parents={"lamp": "device"})
    start = Scene(vocabulary, toy.initial().scene.objects, toy.initial().scene.agent).state(
        [(name, arguments) for name, arguments in toy.initial().facts()]
    )
    press = Operator("DIM", (X,), (affordance(is_a(X, "device"), "{x} is no device"),), ())
    domain = replace(toy.DOMAIN, vocabulary=vocabulary).replace_operators(press)
    task = make_task("light", "", start, "forall d: device. (lit(d))")
    assert find_problems(task, domain=domain) == []
    with pytest.raises(InputError, match=r"no object of the category devise; did you mean device\?"):
        make_task("light", "", start, "forall d: devise. (lit(d))")


DOMAIN = "(define (domain d) (:predicates (p ?x) (q)) (:action a :parameters (?x) :effect (p ?x)))"
PROBLEM = "(define (problem one) (:domain d) (:objects b) (:init) (:goal (p b)))"


def test_only_changed_pddl_files_are_read_again(tmp_path: Path) -> None:
    domain, problems = tmp_path / "domain.pddl", tmp_path / "problems"
    problems.mkdir()
    domain.write_text(DOMAIN)
    (problems / "one.pddl").write_text(PROBLEM)
    reference = f"pddl:{domain},{problems}"
    first = find_benchmark(reference)
    assert find_benchmark(reference) is first
    (problems / "two.pddl").write_text(PROBLEM.replace("one", "two").replace("b)", "b c)", 1))
    second = find_benchmark(reference)
    assert [*second.tasks(Source())] == ["one", "two"]
    domain.write_text(DOMAIN.replace(":effect (p ?x)", ":effect (and (p ?x) (q))"))
    assert len(find_benchmark(reference).domain.operators[0].effects) == 2
    assert [*first.tasks(Source())] == ["one"]


WIDE = """(define (domain wide) (:predicates (p ?x) (r ?x) (q ?x ?y) (never ?x))
 (:action make :parameters (?a ?b ?c ?d ?e ?f ?g ?h)
  :precondition (and (p ?a) (p ?b) (p ?c) (p ?d) (p ?e) (p ?f) (p ?g) (p ?h)) :effect (and (q ?a ?h) (r ?b)))
 (:action end :parameters (?a ?b) :precondition (and (q ?a ?b) (not (p ?a)) (r ?b)) :effect (never ?a)))
"""


def test_a_check_of_an_operator_with_many_parameters_ends_and_reports_its_limit(
    tmp_path: Path, eai: Command
) -> None:
    (tmp_path / "domain.pddl").write_text(WIDE)
    names = [f"o{i}" for i in range(40)]
    facts = " ".join(f"(p {name})" for name in names)
    problem = f"(:domain wide) (:objects {' '.join(names)}) (:init {facts}) (:goal (never o0))"
    (tmp_path / "problem.pddl").write_text(f"(define (problem x) {problem})")
    outcome = eai("check", f"pddl:{tmp_path}")
    assert outcome.out == (
        "wide: 2 operators and 1 task; nothing is wrong; "
        "the planner solves 0 of the 1 without a plan, and gives up 1 at its limit\n"
    )


def test_a_benchmark_without_a_reference_is_checked_in_this_process() -> None:
    def fail(work: object, items: object) -> list[object]:
        raise AssertionError

    _, ends = check_benchmark(Benchmark("toy", toy.DOMAIN, use_tasks(LIGHT)), Source(), fail)
    assert ends.total() == 1


def test_any_number_of_workers_finds_the_same_mistakes(eai: Command, tmp_path: Path) -> None:
    (tmp_path / "domain.pddl").write_text(WIDE)
    for number in range(20):
        goal, fact = "(never a)" if number % 3 else "(p b)", "(p b)" if number % 2 else ""
        problem = f"(:domain wide) (:objects a b) (:init (p a) {fact}) (:goal {goal})"
        (tmp_path / f"problem{number}.pddl").write_text(f"(define (problem x{number}) {problem})")
    alone, together = [eai("check", f"pddl:{tmp_path}", "--workers", workers, "--json") for workers in (1, 2)]
    assert (alone.status, alone.out) == (together.status, together.out)
    assert alone.status == 2
