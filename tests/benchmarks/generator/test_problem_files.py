"""Problems in BDDL and PDDL, read as tasks; problems that do not fit the world are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from by_path import ROOT
from command_line import Command
from eai.base.errors import InputError
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.benchmarks.generator.problem_files import find_problem_files, read_problems
from eai.benchmarks.registry import find_benchmark
from eai.pddl.export import ProblemToExport, export_problems
from eai.pddl.writer import write_problem
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.state import State
from logic.bddl_text import print_problem

LAMPS = ROOT / "examples" / "lamps"

OTHER_EVIDENCE = {
    "brushing_lint_off_clothing_0_Pomaria_2_int_0_2021-06-04_17-41-56",
    "cleaning_bedroom_0_Benevolence_2_int_0_2021-06-06_18-10-59",
    "cleaning_sneakers_0_Pomaria_1_int_0_2021-10-26_13-36-08",
    "putting_away_Halloween_decorations_0_Rs_int_0_2021-10-25_22-42-17",
}
"""Tasks whose problem files contradict other evidence about their scene; an import follows the file."""

KITCHEN = """\
(define (problem wipe)
  (:domain igibson)
  (:objects
    rag.n.01_1 - rag.n.01
    sink.n.01_1 - sink.n.01
    table.n.02_1 - table.n.02
    floor.n.01_1 - floor.n.01
    agent.n.01_1 - agent.n.01)
  (:init
    (dusty ?table.n.02_1)
    (ontop rag.n.01_1 table.n.02_1)
    (inroom floor.n.01_1 kitchen)
    (inroom table.n.02_1 kitchen)
    (not (soaked rag.n.01_1))
    (onfloor agent.n.01_1 floor.n.01_1))
  (:goal (and
    (not (dusty ?table.n.02_1))
    (forall (?rag.n.01 - rag.n.01) (nextto ?rag.n.01 ?sink.n.01_1)))))
"""
LAMP = """\
(define (problem evening)
  (:domain lamps)
  (:objects lamp_1 - lamp lamp_2 - lamp ball - ball box - box)
  (:init (is_open box) (at agent ball))
  (:goal (and (inside ball box) (exists (?x - lamp) (lit ?x)) (done-press))))
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Change into an empty folder from which the module of the example can be imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(LAMPS)


def read(domain: str, text: str, name: str = "p.bddl") -> Task:
    Path(name).write_text(text)
    (task,) = read_problems([Path(name)], find_benchmark(domain), Source())
    return task


def facts(state: State) -> set[tuple[str, ...]]:
    return {(name, *(state.scene.objects[i].name for i in among)) for name, among in state.facts()}


def test_the_problems_of_the_data_set_are_its_tasks(behavior_tasks: BehaviorTasks, tmp_path: Path) -> None:
    for task_id, task in behavior_tasks.items():
        (tmp_path / f"{task_id}.bddl").write_text(print_problem(task.record.problem))
    paths = [tmp_path / f"{task_id}.bddl" for task_id in behavior_tasks]
    imported = read_problems(paths, find_benchmark("behavior"), Source())
    for task, found in zip(behavior_tasks.values(), imported, strict=True):
        assert found.goals == tuple(dict.fromkeys(task.goals))
        assert found.scene.objects == task.scene.objects
        assert (facts(found.initial) == facts(task.initial)) is (task.id not in OTHER_EVIDENCE)


def test_a_problem_of_ones_own_has_objects_like_those_of_the_data_set(behavior_tasks: BehaviorTasks) -> None:
    task = read("behavior", KITCHEN)
    assert task.instruction.endswith(
        "the table is not dusty and every rag is next to the sink."  # there is one table, and one sink
    )
    found = facts(task.initial)
    assert {("is_dusty", "table.n.02_1"), ("lies_on", "rag.n.01_1", "table.n.02_1")} <= found
    assert {("soakable", "rag.n.01_1"), ("sink", "sink.n.01_1"), ("robot_on", "floor.n.01_1")} <= found
    assert ("stands_on", "table.n.02_1", "floor.n.01_1") in found
    assert ("is_soaked", "rag.n.01_1") not in found


def test_a_problem_may_declare_its_rooms(behavior_tasks: BehaviorTasks) -> None:
    declared = read("behavior", KITCHEN.replace("agent.n.01)", "agent.n.01\n    kitchen - room)"))
    assert facts(declared.initial) == facts(read("behavior", KITCHEN).initial)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "rag.n.01_1 - rag.n.01\n",
            "rag.n.01_1 - ragg.n.01\n",
            "line 4, column 18: expected a declared type, not",
        ),
        ("(dusty ?table", "(dirty ?table", "line 10, column 6: expected a declared predicate, not dirty"),
        (
            "(ontop rag.n.01_1 table",
            "(ontop table",
            "line 11, column 6: expected ontop with as many arguments",
        ),
        (
            "inroom table.n.02_1 kitchen",
            "inroom chair.n.01_1 kitchen",
            "line 13, column 13: expected a declared obj",
        ),
        (
            "(nextto ?rag.n.01 ?sink.n.01_1)",
            "(nextto ?rag.n.01 ?zink.n.01_1)",
            "line 18, column 54: expected a declared object, not zink.n.01_1 (goal); did you mean sink",
        ),
        (
            "(not (dusty ?table.n.02_1))\n    (f",
            "(dusty ?rag.n.01_1 ?table.n.02_1)\n    (f",
            "line 17, column 6: expected dusty with as many arguments",
        ),
        ("(not (dusty", "(not dusty", "line 17, column 10: expected "),
        (
            "(not (soaked rag.n.01_1))",
            "(or (soaked rag.n.01_1) (dusty rag.n.01_1))",
            "line 14: expected a fact, not soaked",
        ),
        (
            "(not (soaked rag.n.01_1))",
            "(not (dusty table.n.02_1))",
            "line 14: not dusty(table.n.02_1) is stated, but is false",
        ),
        (
            "(not (soaked rag.n.01_1))",
            "(not ; it is clean\n (dusty ; as it says\n table.n.02_1))",
            "line 14: not dusty(table.n.02_1) is stated, but is false",
        ),
        ("(:init", "(:start", "line 9, column 4: expected "),
        ("(onfloor agent", "(ontop agent", "line 15: there is no object agent.n.01_1"),
        ("(not (soaked rag.n.01_1))", "(dusty agent.n.01_1)", "line 14: there is no object agent.n.01_1"),
        ("(not (dusty ?table.n.02_1))", "(dusty agent.n.01_1)", "line 16: there is no object agent.n.01_1"),
        (
            "(:goal (and\n    (not (dusty ?table.n.02_1))",
            "( :goal (and\n    (dusty agent.n.01_1)",
            "line 16: there is no object agent.n.01_1",
        ),
    ],
)
def test_a_problem_of_another_world_is_refused(
    behavior_tasks: BehaviorTasks, old: str, new: str, message: str
) -> None:
    assert old in KITCHEN
    with pytest.raises(InputError) as caught:
        read("behavior", KITCHEN.replace(old, new))
    assert str(caught.value).startswith(f"p.bddl: {message}")


def test_bddl_is_for_any_declaration() -> None:
    text = LAMP.replace(" (done-press)", "").replace("(exists (?x - lamp)", "(forn (1) (?x - lamp)")
    objects = text.replace("box - box)", "box - box agent - robot)")
    task = read("lamps:lamps", objects)
    assert [str(goal.kind.value) for goal in task.goals] == ["relation", "state"]
    assert ("at", "robot", "ball") in facts(task.initial)


def test_a_problem_in_pddl_need_not_declare_the_agent() -> None:
    task = read("lamps:lamps", LAMP, "p.pddl")
    assert task.scene.agent == 0
    assert task.scene.objects[0].name == "robot"
    assert [goal.kind.value for goal in task.goals] == ["relation", "state", "action"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("box - box", "box - boxx", "line 3, column 59: expected a declared type, not boxx"),
        ("(lit ?x)", "(bright ?x)", "expected a declared predicate, not bright"),
        ("(at agent ball)", "(at agent bell)", "expected a declared object, not bell"),
        ("(is_open box)", "(is-lamp box)", "line 4: is-lamp(box) is stated, but is false"),
        (
            "(:init (is_open box)",
            "; (is-lamp box)\n  (:init (is-lamp ; a (is-lamp box)\n  box)",
            "line 5: is-lamp(box) is stated, but is false",
        ),
    ],
)
def test_pddl_of_another_domain_is_refused(old: str, new: str, message: str) -> None:
    assert old in LAMP
    with pytest.raises(InputError, match=r"^p\.pddl: ") as caught:
        read("lamps:lamps", LAMP.replace(old, new), "p.pddl")
    assert message in str(caught.value)


def test_another_domain_name_is_reported_only_with_further_errors() -> None:
    other = LAMP.replace("(:domain lamps)", "(:domain lights)")
    assert read("lamps:lamps", other, "p.pddl").id == read("lamps:lamps", LAMP, "p.pddl").id
    with pytest.raises(InputError, match=r"expected \(:domain lamps\)"):
        read("lamps:lamps", other.replace("(lit ?x)", "(bright ?x)"), "p.pddl")


@pytest.mark.parametrize(("domain", "every"), [("lamps:lamps", 1), ("behavior", 20), ("virtualhome", 80)])
def test_exports_are_imported_as_the_same_tasks(
    domain: str, every: int, request: pytest.FixtureRequest
) -> None:
    if domain != "lamps:lamps":
        request.getfixturevalue("data_store")
    benchmark = find_benchmark(domain)
    tasks = list(benchmark.tasks(Source()).values())[::every]
    paths = [Path(f"{number}.pddl") for number in range(len(tasks))]
    for path, task in zip(paths, tasks, strict=True):
        path.write_text(exported(task, domain))
    for path, task, found in zip(paths, tasks, read_problems(paths, benchmark, Source()), strict=True):
        kept = {task.scene.objects[i].name for i in about(task)}
        assert facts(found.initial) == {each for each in facts(task.initial) if kept.issuperset(each[1:])}
        goals = tuple(goal.formula for goal in found.goals)
        (again,) = export_problems(benchmark.domain, [ProblemToExport("it", found.initial, goals)])
        assert words(write_problem(again.problem)) == words(path.read_text())


def words(problem: str) -> list[str]:
    """Return the words of a problem without its name, with the agent as first object."""
    lines = [line for line in problem.splitlines()[1:] if "precedes" not in line]
    return sorted(" ".join(lines).split())


def about(task: Task) -> set[int]:
    agent = set() if task.scene.agent is None else {task.scene.agent}
    return {*task.relevant, *agent}


def exported(task: Task, domain: str) -> str:
    """Return the task in PDDL, with relevant objects only."""
    mask = sum(1 << i for i in about(task))
    goals = [goal.formula for goal in task.goals]
    source = ProblemToExport(task.id, task.initial, tuple(goals), mask)
    (made,) = export_problems(find_benchmark(domain).domain, [source])
    return write_problem(made.problem)


def test_the_command_writes_a_sound_task_file(eai: Command) -> None:
    Path("problems").mkdir()
    Path("problems/evening.pddl").write_text(LAMP)
    Path("problems/domain_lamps.pddl").write_text("(define (domain lamps))")
    outcome = eai("export", "tasks", "problems", "--domain", "lamps:lamps", "--out", "t.jsonl")
    assert (outcome.status, outcome.out) == (0, "1 task written to t.jsonl\n")
    assert eai("check", "t.jsonl").status == 0
    assert find_benchmark(str(Path("t.jsonl").resolve())).tasks(Source())["evening"].goals


def test_problems_of_one_name_are_known_by_their_files(tmp_path: Path) -> None:
    for name in ("one", "two"):
        Path(f"{name}.pddl").write_text(LAMP)
    lamps = find_benchmark("lamps:lamps")
    assert [task.id for task in read_problems(find_problem_files([tmp_path]), lamps, Source())] == [
        "one",
        "two",
    ]
    Path("more").mkdir()
    Path("more/one.pddl").write_text(LAMP)
    with pytest.raises(InputError, match="the name 'one' is taken by"):
        read_problems(find_problem_files([tmp_path]), lamps, Source())


ACTIVITY = """\
(define (problem mine-0)
 (:domain igibson)
 (:objects
  apple.n.01_1 - apple.n.01
  floor.n.01_1 - floor.n.01
  cabinet.n.01_1 - cabinet.n.01
  agent.n.01_1 - agent.n.01
 )
 (:init
  (onfloor apple.n.01_1 floor.n.01_1)
  (inroom floor.n.01_1 kitchen)
  (inroom cabinet.n.01_1 kitchen)
  (onfloor agent.n.01_1 floor.n.01_1)
 )
 (:goal (and (inside ?apple.n.01_1 ?cabinet.n.01_1)))
)
"""


@pytest.mark.usefixtures("behavior_tasks")
def test_a_domain_file_in_a_folder_of_activities_is_skipped(eai: Command) -> None:
    Path("activities/mine").mkdir(parents=True)
    domain = "; no problem\n(define (domain igibson) (:requirements :strips) (:predicates (cooked ?x)))"
    Path("activities/domain_igibson.bddl").write_text(domain)
    Path("activities/mine/problem0.bddl").write_text(ACTIVITY)
    outcome = eai("export", "tasks", "activities", "--domain", "behavior", "--out", "t.jsonl")
    assert (outcome.status, outcome.out) == (0, "1 task written to t.jsonl\n")


@pytest.mark.usefixtures("behavior_tasks")
def test_all_bad_files_of_a_folder_are_named_with_their_places(eai: Command) -> None:
    Path("typo").mkdir()
    Path("typo/a.bddl").write_text(ACTIVITY.replace("?apple", "?aple"))
    Path("typo/b.bddl").write_text(ACTIVITY)
    Path("typo/c.bddl").write_text(ACTIVITY + ")")
    outcome = eai("export", "tasks", "typo", "--domain", "behavior", "--out", "t.jsonl")
    wrong = "expected a declared object, not aple.n.01_1 (goal); did you mean apple.n.01_1?"
    lines = [
        f"eai: typo/a.bddl: line 15, column 22: {wrong}",
        "typo/c.bddl: line 17, column 1: expected the end",
    ]
    assert (outcome.status, outcome.err.splitlines()) == (2, lines)
    assert not Path("t.jsonl").exists()


def test_a_path_without_problems_is_refused(eai: Command) -> None:
    Path("empty").mkdir()
    with pytest.raises(InputError, match=r"expected problems in files \*\.bddl or \*\.pddl"):
        find_problem_files([Path("empty")])
    with pytest.raises(InputError, match="expected a problem in a file"):
        find_problem_files([Path("tasks.json")])
    outcome = eai("export", "tasks", "p.pddl", "--domain", "pddl:d.pddl,p.pddl", "--out", "t.jsonl")
    assert outcome.status == 2
    assert "leave out the argument PROBLEMS to export them" in outcome.err
