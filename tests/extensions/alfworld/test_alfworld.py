"""Games in the form of ALFWorld's download, of a small domain that is written as its own is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.features import compute_features
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.source import Source
from processes import eai as in_own_process

DOMAIN = """(define (domain house)
(:requirements :adl :action-costs :typing)
(:types agent location receptacle object rtype otype)
(:predicates (atLocation ?a - agent ?l - location) (receptacleAtLocation ?r - receptacle ?l - location)
  (inReceptacle ?o - object ?r - receptacle) (openable ?r - receptacle) (opened ?r - receptacle)
  (holds ?a - agent ?o - object) (checked ?r - receptacle) (cool ?o - object)
  (receptacleType ?r - receptacle ?t - rtype) (objectType ?o - object ?t - otype)
  (canContain ?t - rtype ?o - otype) (full ?r - receptacle))
(:functions (total-cost) - number)
(:action GoTo :parameters (?a - agent ?from - location ?to - location ?r - receptacle)
  :precondition (and (atLocation ?a ?from) (receptacleAtLocation ?r ?to))
  :effect (and (not (atLocation ?a ?from)) (atLocation ?a ?to) (increase (total-cost) 1)))
(:action Open :parameters (?a - agent ?l - location ?r - receptacle)
  :precondition (and (openable ?r) (atLocation ?a ?l) (receptacleAtLocation ?r ?l) (not (opened ?r)))
  :effect (opened ?r))
(:action Take :parameters (?a - agent ?l - location ?o - object ?r - receptacle)
  :precondition (and (atLocation ?a ?l) (receptacleAtLocation ?r ?l) (inReceptacle ?o ?r)
    (or (not (openable ?r)) (opened ?r)))
  :effect (and (holds ?a ?o) (not (inReceptacle ?o ?r))))
(:action Put :parameters (?a - agent ?l - location ?o - object ?r - receptacle ?ot - otype ?rt - rtype)
  :precondition (and (holds ?a ?o) (atLocation ?a ?l) (receptacleAtLocation ?r ?l) (objectType ?o ?ot)
    (receptacleType ?r ?rt) (canContain ?rt ?ot))
  :effect (and (inReceptacle ?o ?r) (not (holds ?a ?o)) (when (canContain ?rt ?ot) (full ?r))))
(:action Cool :parameters (?a - agent ?l - location ?r - receptacle ?o - object)
  :precondition (and (or (receptacleType ?r FridgeType)) (atLocation ?a ?l) (receptacleAtLocation ?r ?l)
    (holds ?a ?o))
  :effect (and (cool ?o) (increase (total-cost) 5)))
(:action Look :parameters (?a - agent ?l - location) :precondition (and (atLocation ?a ?l))
  :effect (and (checked ?l)))
(:action ExamineReceptacle :parameters (?a - agent ?r - receptacle)
  :precondition (and (exists (?l - location) (and (atLocation ?a ?l) (receptacleAtLocation ?r ?l))))
  :effect (and (checked ?r)))
(:action ExamineObject :parameters (?a - agent ?o - object)
  :precondition (or (exists (?l - location, ?r - receptacle) (and (atLocation ?a ?l)
    (receptacleAtLocation ?r ?l) (inReceptacle ?o ?r))) (holds ?a ?o))
  :effect (and (checked ?o)))
)"""
GRAMMAR = """grammar :: \"\"\"
{ "task": [ { "rhs": "Your task is to: put a cool apple in table." } ] } \"\"\";
action GoTo { template :: "go to [{r.name | receptacleatlocation(r:receptacle, to:location)}]"; }
action Open { template :: "open {r}"; }
action Take { template :: "take {o} from {r}"; }
action Put { template :: "move {o} to {r}"; }
action Cool { template :: "cool {o} with {r}"; }
action Look { template :: "look"; }
action ExamineReceptacle { template :: "examine {r}"; }
action ExamineObject { template :: "examine {o}"; }
"""
PROBLEM = """(define (problem plan_0) (:domain house) (:objects agent1 - agent Apple - object
  Apple_bar_1 - object Apple_bar_2 - object Fridge_bar_1 - receptacle Table_bar_1 - receptacle
  Sink_bar_1_bar_SinkBasin - receptacle loc_bar_1 - location loc_bar_2 - location loc_bar_3 - location
  AppleType - otype MugType - otype FridgeType - rtype TableType - rtype SinkBasinType - rtype)
(:init (= (total-cost) 0) (atLocation agent1 loc_bar_3) (objectType Apple_bar_1 AppleType)
  (objectType Apple_bar_2 AppleType) (inReceptacle Apple_bar_1 Fridge_bar_1) (openable Fridge_bar_1)
  (inReceptacle Apple_bar_2 Table_bar_1) (receptacleType Fridge_bar_1 FridgeType)
  (receptacleType Table_bar_1 TableType) (receptacleType Sink_bar_1_bar_SinkBasin SinkBasinType)
  (receptacleAtLocation Fridge_bar_1 loc_bar_1) (receptacleAtLocation Table_bar_1 loc_bar_2)
  (receptacleAtLocation Sink_bar_1_bar_SinkBasin loc_bar_2)
  (canContain TableType AppleType) (canContain TableType MugType))
(:goal (and (exists (?r - receptacle) (exists (?o - object) (and (cool ?o) (objectType ?o AppleType)
  (receptacleType ?r TableType) (inReceptacle ?o ?r)))))))"""
GAME = {"pddl_domain": DOMAIN, "grammar": GRAMMAR, "pddl_problem": PROBLEM, "solvable": True}
WON = ["go to fridge 1", "open fridge 1", "take apple 2 from fridge 1", "cool apple 2 with fridge 1"]
WON += ["go to table 1", "move apple 2 to table 1"]
ID = "valid_seen.cool-Apple-None-Table-7.trial_1"


def write(folder: Path, name: str = "trial_1", **changed: object) -> Path:
    place = folder / "valid_seen" / "cool-Apple-None-Table-7" / name
    place.mkdir(parents=True)
    (place / "game.tw-pddl").write_text(json.dumps({**GAME, **changed}))
    return place


def opened(folder: Path) -> Benchmark:
    return find_benchmark(f"alfworld:{folder}")


def game(folder: Path) -> Game:
    benchmark = opened(folder)
    task = benchmark.tasks(Source())[ID]
    return Game(make_setup(task, benchmark, GameRules(admissible=True)))


def test_a_folder_of_games_is_a_benchmark(tmp_path: Path) -> None:
    write(tmp_path)
    write(tmp_path, "trial_2", solvable=False)
    tasks = opened(tmp_path).tasks(Source())
    assert [*tasks] == [ID]
    task = tasks[ID]
    assert (task.title, task.instruction) == ("cool", "put a cool apple in table.")
    names = {task.scene.objects[i].name for i in task.relevant}
    assert {"apple_1", "apple_2", "fridge_1", "sinkbasin_1", "loc_3", "appletype"} <= names
    assert names.isdisjoint({"apple", "mugtype"})
    assert "inreceptacle(apple_2, fridge_1)" in game(tmp_path).write_first_observation()


def test_its_goals_have_labels(tmp_path: Path) -> None:
    write(tmp_path)
    benchmark = opened(tmp_path)
    task = benchmark.tasks(Source())[ID]
    assert compute_features(task, benchmark).labels == "horizon-atomic transport"


def test_its_commands_are_those_of_the_environment(tmp_path: Path) -> None:
    write(tmp_path)
    played = game(tmp_path)
    assert sorted(played.list_admissible_commands()) == [
        *("go to fridge 1", "go to sinkbasin 1", "go to table 1"),
        "look",
    ]
    turn = played.act("go to table 1")
    assert turn.observation.startswith("go to table 1: done.")
    assert sorted(turn.info["admissible_commands"]) == [
        *("examine sinkbasin 1", "examine table 1"),
        *("go to fridge 1", "look", "take apple 1 from table 1"),
    ]
    assert "failed" in played.act("examine apple 1").observation
    played.act("take apple 1 from table 1")
    assert "failed" in played.act("go to sinkbasin 1").observation
    assert "checked(loc_" in played.act("look").observation
    assert "checked(apple_1)" in played.act("Examine apple 1.").observation
    for command in WON[:-1]:
        assert "failed" not in played.act(command).observation
    last = played.act(WON[-1])
    assert (last.terminated, last.info["won"]) == (True, True)


def test_plans_are_commands_one_a_line(tmp_path: Path) -> None:
    write(tmp_path)
    suite = open_suite(opened(tmp_path), Ability.ACTION_SEQUENCING)
    plan = opened(tmp_path).notation.plans.read(
        "Here it is:\n" + "\n".join(f"{i}. {c}" for i, c in enumerate(WON, 1))
    )
    assert isinstance(plan, WrittenPlan)
    assert plan.steps[2] == ("take", ("apple_2", "fridge_1"))
    assert suite.scorer(ID).score("\n".join(WON)).success
    assert suite.scorer(ID).score("(goto fridge_1)\n" + "\n".join(WON[1:])).success
    verdict = suite.scorer(ID).score("\n".join([*WON[:3], *WON[4:]]))
    assert not verdict.success


@pytest.mark.parametrize(
    "old", ["put apple 1 in/on fridge 1", "put apple 1 on countertop 2", "> heat apple 1"]
)
def test_a_command_that_the_game_does_not_have_is_no_prose(tmp_path: Path, old: str) -> None:
    write(tmp_path)
    benchmark = opened(tmp_path)
    lines = [*WON[:-1], old, "That is all."]
    plan = benchmark.notation.plans.read("\n".join(lines), benchmark.domain.operator_arities)
    assert isinstance(plan, Unreadable)
    assert plan.reason.startswith(f"line {len(WON)} is no step of a plan")


@pytest.mark.parametrize(
    "first",
    [
        "First, go to fridge 1",
        "# go to fridge 1",
        "go to fridge 1, then wait",
        "go to fridge 1; open fridge 1",
        "go to fridge 1 (now)",
        "go fridge 1",
        "; go to fridge 1",
    ],
)
def test_a_line_with_a_command_and_a_few_words_is_no_prose(tmp_path: Path, first: str) -> None:
    write(tmp_path)
    benchmark = opened(tmp_path)
    plan = benchmark.notation.plans.read("\n".join([first, *WON[1:]]), benchmark.domain.operator_arities)
    assert isinstance(plan, Unreadable)


@pytest.mark.parametrize(
    "text",
    [
        "Answer: {}",
        "```text {} ```",
        "<answer>{}</answer>",
        "\ufeff{}<|eot_id|>",
        '"{}"',
        "> {},",
        "To cool the apple, first open the fridge and take apple 2.\n{}",
        "Action: {}\nThe apple is now on table 1, as wanted.",
    ],
)
def test_signs_and_prose_around_commands_do_not_matter(tmp_path: Path, text: str) -> None:
    write(tmp_path)
    benchmark = opened(tmp_path)
    notation, actions = benchmark.notation.plans, benchmark.domain.operator_arities
    plan, bare = notation.read(text.format("\n".join(WON)), actions), notation.read("\n".join(WON), actions)
    assert isinstance(plan, WrittenPlan)
    assert isinstance(bare, WrittenPlan)
    assert plan.steps == bare.steps


@pytest.mark.parametrize("reference", ["alfworld:games/", "alfworld:games", "alfworld:./games/"])
def test_games_are_checked(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: str
) -> None:
    write(tmp_path / "games")
    monkeypatch.chdir(tmp_path)
    checked = eai("check", reference)
    assert (checked.status, checked.err) == (0, "")
    assert checked.out.startswith("alfworld: ")
    assert "and 1 task; nothing is wrong; the planner solves 1 of the 1 without a plan" in checked.out


def test_a_run_asks_for_commands_and_the_oracle_wins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "games")
    write(tmp_path / "games", "trial_3", grammar=GRAMMAR.replace("put a cool apple", "cool some apple"))
    monkeypatch.chdir(tmp_path)
    outcome = in_own_process(
        "run", "--model", "eai/oracle", "--domain", "alfworld:games", "--planner", "built_in"
    )
    assert outcome.status == 0, outcome.err
    (file,) = Path("runs").glob("*/action_sequencing/eai_oracle/summary.json")
    assert json.loads(file.read_text())["task_success"]["numerator"] == 2
    assert [*Path("runs").glob("*/goal_interpretation/eai_oracle/summary.json")]
    (answers,) = Path("runs").glob("*/action_sequencing/eai_oracle/answers.jsonl")
    assert " with fridge 1\\n" in answers.read_text()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"pddl_problem": PROBLEM.replace("(openable ", "(lockable ")}, "not lockable"),
        ({"grammar": GRAMMAR.replace("action Take", "action Grab")}, "no command for the action take"),
        ({"grammar": None}, "a JSON object with the member 'grammar'"),
    ],
)
def test_a_damaged_game_is_refused(tmp_path: Path, changed: dict[str, object], message: str) -> None:
    write(tmp_path, **changed)
    with pytest.raises(InputError, match=message):
        opened(tmp_path).tasks(Source())[ID]


def test_a_folder_without_games_or_of_two_domains_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a folder with games"):
        opened(tmp_path)
    write(tmp_path)
    write(tmp_path, "trial_2", pddl_domain=DOMAIN.replace("(cool ?o)", "(cool ?o)  "))
    with pytest.raises(
        InputError, match=r"trial_2/game.tw-pddl: this game and .*trial_1.* have different domains"
    ):
        opened(tmp_path)


def test_two_games_with_one_id_are_refused(tmp_path: Path) -> None:
    for folder in ("a.b/c", "a/b.c"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "game.tw-pddl").write_text(json.dumps(GAME))
    with pytest.raises(InputError, match=r"the games .* and .* have the same id, a\.b\.c"):
        opened(tmp_path)


def test_games_with_other_commands_are_refused(tmp_path: Path) -> None:
    write(tmp_path)
    write(tmp_path, "trial_2", grammar=GRAMMAR.replace("move {o} to {r}", "put {o} in/on {r}"))
    with pytest.raises(InputError, match="have different commands"):
        opened(tmp_path)
