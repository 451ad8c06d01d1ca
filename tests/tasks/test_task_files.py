"""Task files are read or refused with file and line, and all abilities work on their tasks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from agents.switches import SWITCHES
from by_path import ROOT, TESTS
from command_line import Command
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.agents.environment import make
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.spec import GeneratedTask, TaskSpecification
from eai.benchmarks.gold_answers import open_answers_of_planner, open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source, compute_task_sha256
from eai.tasks.task_files import open_task_files, write_task_file
from eai.tasks.task_lines import make_task_line_schema, write_task_line
from processes import eai as in_own_process

LAMPS = ROOT / "examples" / "lamps"
PAGE = ROOT / "docs" / "task-files.md"
LINE: dict[str, Any] = {
    "id": "one",
    "base": "lamps:lamps",
    "instruction": "Put the ball into the box and light the lamp.",
    "objects": {"robot": "robot", "lamp_1": "lamp", "ball": "ball", "box": "box"},
    "agent": "robot",
    "facts": {"is_open": ["box"], "at": [["robot", "ball"]]},
    "goals": ["inside(ball, box)", "exists x: lamp. (lit(x))"],
    "plan": [["TAKE", "ball"], ["GO", "box"], ["PUT", "ball", "box"], ["GO", "lamp_1"], ["PRESS", "lamp_1"]],
}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Works in an empty folder in which the module of the example's base is found."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(LAMPS)


def put(path: str, *lines: object) -> Path:
    file = Path(path)
    file.parent.mkdir(exist_ok=True, parents=True)
    file.write_text("".join(f"{line if isinstance(line, str) else json.dumps(line)}\n" for line in lines))
    return file.resolve()  # benchmarks are remembered by what they were found by


def test_a_folder_is_a_benchmark() -> None:
    folder = put("tasks/a.jsonl", LINE, "", {**LINE, "id": "two"}).parent
    put("tasks/b.jsonl", {**LINE, "id": "three", "relevant": ["lamp_1"], "title": "light"})
    benchmark = find_benchmark(f"{folder}/")
    tasks = benchmark.tasks(Source())
    assert (benchmark.name, list(tasks)) == ("lamps-tasks", ["one", "two", "three"])
    assert (tasks["one"].title, tasks["three"].title, tasks["three"].relevant) == ("one", "light", (1,))
    assert tasks["one"].initial.has("at", 0, 2)
    assert find_benchmark(str(folder / "b.jsonl")).name == "lamps-b"


def test_a_relevant_object_that_is_listed_twice_counts_once() -> None:
    file = put("twice.jsonl", {**LINE, "relevant": ["box", "lamp_1", "box"]})
    assert find_benchmark(str(file)).tasks(Source())["one"].relevant == (3, 1)


CASES = [
    ("{", "line 1: expected JSON"),
    ("[]", 'expected a task as a JSON object with the string "id"'),
    ({**LINE, "goals": []}, "line 1: goals: expected a list that is not empty, found []"),
    ({**LINE, "gaols": []}, "line 1: gaols: unknown; did you mean goals?"),
    ({**LINE, "version": 2}, "line 1: version: expected 1, found 2"),
    (json.dumps(LINE)[:-1] + ', "goals": []}', "line 1: the member 'goals' occurs twice"),
    (
        {name: value for name, value in LINE.items() if name != "agent"},
        "line 1: agent: expected the object that acts, because actions of lamps mention it",
    ),
    ({**LINE, "agent": "cat"}, "agent: expected the name of an object of the task, found 'cat'"),
    ({**LINE, "facts": {"warm": ["box"]}}, "facts: predicate warm is not declared"),
    ({**LINE, "facts": {"at": ["box"]}}, "facts: at takes 2 arguments, not 1"),
    ({**LINE, "facts": {"lit": ["cat"]}}, "facts: there is no object cat"),
    ({**LINE, "goals": ["lit(lamp_1) and"]}, "goals.0: line 1, column 16: expected "),
    ({**LINE, "goals": ["warm(lamp_1)"]}, "goals.0: line 1, column 1: warm is no predicate and no action"),
    ({**LINE, "goals": ["lit(cat)"]}, "goals.0: line 1, column 5: there is no object cat"),
    ({**LINE, "goals": ["lit(lamp)"]}, "goals.0: there is no object lamp"),
    ({**LINE, "goals": ["forall x: lamp. (always lit(x))"]}, "goals.0: a temporal operator stands inside"),
    ({**LINE, "goals": ["eventually PRESS()"]}, "goals.0: PRESS takes 1 object, not 0"),
    ({**LINE, "goals": ["PRESS(lamp_1)"]}, "goals.0: a goal with actions may only join actions"),
    ({**LINE, "goals": ["PRESS() and lit(lamp_1)"]}, "goals.0: a goal with actions may only join actions"),
    ({**LINE, "plan": [["JUMP"]]}, "plan.0: expected an operator of the domain, found 'JUMP'"),
    ({**LINE, "plan": [["GO"]]}, "plan.0: GO takes 1 object, not 0"),
    (
        {**LINE, "hazards": ["shut"]},
        "hazards: expected the last 1 of `goals` to be about the whole execution, one for each hazard, after "
        "at least one other goal",
    ),
    ({**LINE, "goals": ["always is_open(box)"], "hazards": ["shut"]}, "hazards: expected the last 1 of"),
    (
        {**LINE, "goals": ["lit(lamp_1)", *["eventually is_open(box)"] * 3], "hazards": ["a", "b"]},
        "goals.2: repeats goals.1, but `hazards` names one hazard for each of the last goals",
    ),
    ({**LINE, "untold": True}, "`untold` is true, so `hazards` must list"),
    ({**LINE, "missing": [], "fits": ["ball"]}, "missing and fits: expected only one of these members"),
    (
        {
            **LINE,
            "goals": [*LINE["goals"], "always is_open(box)"],
            "hazards": ["shut"],
            "missing": ["lit(box)"],
        },
        "hazards and missing: expected only one of these members",
    ),
]


@pytest.mark.parametrize(("line", "message"), CASES)
def test_what_is_no_task_is_refused_with_file_and_line(eai: Command, line: object, message: str) -> None:
    file = put("bad.jsonl", line)
    with pytest.raises(InputError, match=r"bad\.jsonl: line 1: ") as caught:
        find_benchmark(str(file)).tasks(Source())["one"]
    assert message in str(caught.value)
    outcome = eai("check", file)
    assert outcome.status == 2
    assert message.removeprefix("line 1: ").split("column 16")[0] in outcome.out + outcome.err


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ((LINE, LINE), "line 2: the id 'one' is already used at"),
        ((LINE, {**LINE, "id": "two", "plan": LINE["plan"][1:]}), "line 2: plan.1: expected a step"),
        ((LINE, {**LINE, "id": "two", "plan": LINE["plan"][:3]}), "line 2: plan: expected to reach goals.1"),
        (
            (LINE, {**LINE, "id": "two", "goals": ["is_open(box)"]}),
            "line 2: goals: expected a goal that does not hold at the start",
        ),
        ((LINE, {**LINE, "id": "two", "base": "nowhere"}), "line 2: 'nowhere' is not a benchmark"),
        ((LINE, {**LINE, "id": "two", "missing": ["at(robot, ball)"]}), "line 2: plan: expected none"),
        (
            (LINE, {**LINE, "id": "two", "missing": ["at(robot, ball)"], "plan": []}),
            "line 2: missing: expected",
        ),
        ((LINE, {**LINE, "id": "two", "missing": [], "plan": []}), "line 2: missing: expected a plan"),
        (
            (LINE, {**LINE, "id": "two", "goals": ["lit(lamp_1)", "always not is_open(box)"], "plan": []}),
            "line 2: goals.1: no plan reaches it: the start already breaks always not is_open(box)",
        ),
        (
            (LINE, {**LINE, "id": "two", "shortest": LINE["plan"][:3]}),
            "line 2: shortest: expected to reach goals.1",
        ),
        (
            (LINE, {**LINE, "id": "two", "plan": [], "shortest": LINE["plan"][1:]}),
            "line 2: shortest.1: expected a step that is possible and needed: missing_step",
        ),
        (
            (LINE, {**LINE, "id": "two", "shortest": [["GO", "lamp_1"], ["GO", "ball"], *LINE["plan"]]}),
            "line 2: shortest: expected at most 5 steps, as in plan, found 7",
        ),
        (
            (LINE, {**LINE, "id": "two", "reference": LINE["plan"][1:]}),
            "line 2: reference.1: expected a step that is possible and needed: missing_step",
        ),
        (
            (LINE, {**LINE, "id": "two", "missing": ["lit(box)"], "plan": [], "shortest": LINE["plan"]}),
            "line 2: shortest: expected none, as the goals are out of reach",
        ),
    ],
)
def test_check_tells_what_is_not_as_it_says(eai: Command, lines: tuple[object, ...], message: str) -> None:
    outcome = eai("check", put("tasks.jsonl", *lines))
    assert outcome.status == 2
    assert message in outcome.out


def test_any_number_of_workers_finds_the_same_mistakes_in_lines(eai: Command) -> None:
    lines = [{**LINE, "id": f"task {number % 15}"} for number in range(20)]
    lines[3] |= {"plan": LINE["plan"][1:]}
    lines[7] |= {"base": "nowhere"}
    lines[9] |= {"id": 9}
    file = put("tasks.jsonl", *lines)
    alone, together = [eai("check", file, "--workers", workers) for workers in (1, 2)]
    assert (alone.status, alone.out) == (together.status, together.out)
    assert alone.status == 2
    assert alone.out.count("is already used at") == 5
    assert "line 8: 'nowhere' is not a benchmark" in alone.out


def test_a_reference_is_played_with_what_the_agent_sees(eai: Command) -> None:
    base = "agents.switches:SWITCHES"
    line = json.loads(write_task_line(find_benchmark(base).tasks(Source())["both"], base, SWITCHES.domain))
    unseen = [["PRESS", "lamp"], ["GO", "shed"], ["PRESS", "torch"]]
    outcome = eai("check", put("tasks.jsonl", {**line, "reference": unseen}))
    assert outcome.status == 2
    assert "line 1: reference.2: expected an action that is possible" in outcome.out
    assert "you have not yet seen torch" in outcome.out


def test_references_are_added_once_and_longer_ones_are_refused(eai: Command) -> None:
    file = put("tasks.jsonl", LINE, "", {**LINE, "id": "two", "about": {"é": 1.5}})
    before = [json.loads(line) for line in file.read_text().split("\n") if line]
    for workers, added in ((2, "2 tasks"), (1, "0 tasks")):
        outcome = eai("check", file, "--references", "--workers", workers)
        assert (outcome.status, f"references of {added} added" in outcome.out) == (0, True)
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    plans = {"shortest": LINE["plan"], "reference": LINE["plan"]}
    assert lines == [line | plans for line in before]
    padded = [["GO", "box"], ["GO", "ball"], *LINE["plan"]]
    put("tasks.jsonl", lines[0], lines[1] | {"plan": [], "shortest": padded, "reference": padded})
    content = file.read_bytes()
    assert eai("check", file).status == 0
    outcome = eai("check", file, "--references")
    assert (outcome.status, file.read_bytes()) == (2, content)
    for member in ("shortest", "reference"):
        assert f"line 2: {member}: expected at most 6 steps, as a search finds, found 7" in outcome.out
    assert "expected task files" in eai("check", "lamps:lamps", "--references").err


def test_check_accepts_what_is_sound(eai: Command) -> None:
    assert eai("check", put("tasks.jsonl", LINE)).status == 0


def test_a_folder_without_tasks_is_refused() -> None:
    Path("empty").mkdir()
    with pytest.raises(InputError, match="expected task files"):
        find_benchmark(str(Path("empty").resolve()))


def test_a_line_with_too_many_brackets_is_refused() -> None:
    with pytest.raises(InputError, match="line 1: expected JSON"):
        open_task_files(put("deep.jsonl", "[" * 100_000))


@pytest.mark.parametrize("name", ["v1.train.jsonl", "v1.train.jsonl.gz", "v1.train"])
def test_only_the_ending_is_left_out_of_the_name_of_a_set(name: str) -> None:
    path = Path(name)
    path = path if path.suffix in (".jsonl", ".gz") else path / "tasks.jsonl"
    path.parent.mkdir(exist_ok=True)
    write_task_file(path, [json.dumps(LINE)])
    assert open_task_files(Path(name)).name == "v1.train"


def test_tasks_of_several_worlds_are_refused() -> None:
    file = put("mixed.jsonl", LINE, {**LINE, "id": "two", "base": "behavior"})
    with pytest.raises(InputError, match="line 2: base: expected 'lamps:lamps'"):
        find_benchmark(str(file)).tasks(Source())["two"]


def test_the_page_shows_the_schema_and_a_sound_line(eai: Command) -> None:
    assert json.loads(eai("check", "--schema").out) == make_task_line_schema()
    line = json.loads(PAGE.read_text().split("```json\n")[1].partition("```")[0])
    assert set(line) <= set(make_task_line_schema()["properties"])  # type: ignore[arg-type]
    assert eai("check", put("page.jsonl", line)).status == 0


def test_pddl_problems_import(eai: Command) -> None:
    folder = TESTS / "pddl" / "domains" / "gripper"
    reference = f"pddl:{folder / 'domain.pddl'},{folder}"
    assert eai("export", "tasks", "--domain", reference, "--out", "g.jsonl.gz").status == 0
    assert eai("check", "g.jsonl.gz").status == 0
    original = find_benchmark(reference).tasks(Source())
    assert list(find_benchmark(str(Path("g.jsonl.gz").resolve())).tasks(Source())) == list(original)


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_public_tasks_survive(name: str, data_store: DataPackStore) -> None:
    base, source = find_benchmark(name), Source(data_store)
    originals = list(base.tasks(source).values())[:: 60 if name == "virtualhome" else 5]
    file = put(f"{name}.jsonl", *(write_task_line(task, name, base.domain) for task in originals))
    tasks = find_benchmark(str(file)).tasks(source)
    for original in originals:
        read = tasks[original.id]
        assert tuple(read.initial.facts()) == tuple(original.initial.facts())
        assert read.scene.objects == original.scene.objects
        assert (read.relevant, read.instruction) == (original.relevant, original.instruction)
        assert read.script in (original.script, ())
        assert write_task_line(read, name, base.domain) == write_task_line(original, name, base.domain)


def closed(name: str, store: DataPackStore) -> Benchmark:
    """Some public tasks of a household as a task file."""
    base, source = find_benchmark(name), Source(store)
    tasks = [task for task in base.tasks(source).values() if task.script and task.goals][:3]
    return find_benchmark(
        str(put(f"few_{name}.jsonl", *(write_task_line(t, name, base.domain) for t in tasks)))
    )


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_all_abilities_work(name: str, ability: Ability, data_store: DataPackStore) -> None:
    if name == "virtualhome" and ability is Ability.TRANSITION_MODELING:
        pytest.skip("300 objects a problem: tested on generated tasks, which have 30")
    benchmark, source = closed(name, data_store), Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite(benchmark, ability, source=source)
    prompts = PromptLibrary("official", source=source).open(benchmark, ability)
    assert list(prompts) == list(suite.task_ids) != []
    book = open_gold_answers(benchmark, ability, source)
    for task_id in suite.task_ids:
        verdict = suite.score(task_id, book[task_id].text)
        if isinstance(verdict, OperatorVerdict):  # the built-in planner knows no axioms that need each other
            sides = [side for each in verdict.operators for side in (each.precondition, each.effect)]
            assert not any(side.additional or side.missing for side in sides)
        else:
            assert getattr(verdict, "success", True), verdict
    assert suite.domain == f"{name}-few_{name}"


def test_the_planner_and_the_environment_take_them(data_store: DataPackStore) -> None:
    benchmark = closed("behavior", data_store)
    book = open_answers_of_planner(benchmark, Ability.ACTION_SEQUENCING, Source(data_store))
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=Source(data_store))
    assert all(suite.score(task_id, book[task_id].text).success for task_id in suite.task_ids)  # type: ignore[union-attr]
    environment = make(benchmark, suite.task_ids[0], source=Source(data_store))
    assert "Goals" in environment.reset()[0]


def test_tasks_are_generated_from_them(data_store: DataPackStore) -> None:
    benchmark, source = closed("behavior", data_store), Source(data_store)
    spec = TaskSpecification("behavior", benchmark.tasks(source).sha256)
    made = TaskGenerator(benchmark, spec, source)
    assert any(isinstance(made.generate_task(seed), GeneratedTask) for seed in "0123")


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_they_use_no_counts_and_problems_of_the_tasks_of_their_base(
    name: str, data_store: DataPackStore
) -> None:
    data = closed(name, data_store).data
    assert (data.own_figures, data.problem_of) == (None, None)


def test_a_run_takes_them_to_a_table() -> None:
    pytest.importorskip("inspect_ai")
    put("tasks/a.jsonl", LINE, {**LINE, "id": "two"})
    (Path("lamps.py")).write_text((LAMPS / "lamps.py").read_text())
    options = ("--domain", "tasks/", "--planner", "built_in", "--out", "runs")
    outcome = in_own_process("run", "--model", "eai/oracle", *options)
    assert outcome.status == 0, outcome.err
    summary = json.loads(Path("runs/lamps-tasks/action_sequencing/eai_oracle/summary.json").read_text())
    assert summary["task_success"]["numerator"] == 2
    told = in_own_process("explain", "runs/lamps-tasks/action_sequencing/eai_oracle", "one")
    assert "+ inside(ball, box)" in told.out


def test_a_file_keeps_as_many_tasks_as_its_source_allows() -> None:
    benchmark = find_benchmark(str(put("two.jsonl", LINE, {**LINE, "id": "two"})))
    few, every = (benchmark.tasks(Source(kept=kept)) for kept in (1, None))
    kept, other = few["one"], few["two"]
    assert [compute_task_sha256(task) for task in (kept, other)] == [
        *map(compute_task_sha256, every.values())
    ]
    assert few["two"] is other
    assert few["one"] is not kept
    assert every["one"] is every["one"]
    assert benchmark.tasks(Source()) is every
