"""`eai data annotate`, as a person uses it."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from by_path import TESTS
from command_line import Command
from eai.extensions.annotation.decisions import read_ignored_predicates_and_user_decisions
from eai.pddl.planners import make_planner
from eai.pddl.planning import PlannerChoice, PlannerOutcome, PlanningTask
from eai.pddl.reader import read_domain, read_problem

SHELVES = ("--domain", "extensions.annotation.demonstrated:shelves")
CHOOSE = ("data", "annotate", "choose", *SHELVES, "--title", "Tidy up", "--without", "near")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def saying(monkeypatch: pytest.MonkeyPatch, *commands: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("".join(f"{command}\n" for command in commands)))


def solved(domain: Path, problem: Path) -> bool:
    """Whether a planner solves a written problem of a written domain."""
    task = PlanningTask(read_domain(domain.read_text()), read_problem(problem.read_text()))
    planner = make_planner(PlannerChoice.BUILT_IN, 10)
    return planner is not None and planner.solve(task).outcome is PlannerOutcome.SOLVED


def test_from_demonstrations_to_a_task_file(eai: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = eai("data", "annotate", "differences", *SHELVES)
    assert shown.out.splitlines()[0] == "cup: near(robot, shelf), on(cup, shelf)"
    counted = eai("data", "annotate", "differences", "--count", *SHELVES, "--without", "near")
    assert counted.out.splitlines()[:2] == ["Tidy up: 3 demonstrations", "    3 lit(lamp)"]
    saying(monkeypatch, "kep 2", "keep 2", "new", "keep 1", "drop 3", "undo", "done")
    chosen = eai(*CHOOSE)
    assert chosen.status == 0
    assert chosen.err == "'kep' is no command: keep, or, drop, add, new, undo, done; did you mean keep?\n"
    assert "candidate 1, met by 2:" in chosen.out
    assert chosen.out.endswith("done; written to decisions.toml\n")
    assigned = json.loads(eai("data", "annotate", "goals", "--assigned", *SHELVES, "--json").out)
    assert assigned == {"cup": 0, "jar": 0, "lamp": 1}
    checked = eai("data", "annotate", "goals", "--check", *SHELVES)
    assert (checked.status, checked.out) == (2, "Tidy up: lamp: lacks lit(lamp_2)\n")
    made = eai("data", "annotate", "goals", *SHELVES, "--out", "goals.jsonl")
    assert made.out == "3 tasks written to goals.jsonl\n"
    assert eai("check", "goals.jsonl").status == 0
    posed = eai(
        "data", "annotate", "problems", "--domain", "goals.jsonl", "--out", "problems", "--conditions", "1"
    )
    assert posed.out == "3 problems written to problems\n"
    domain, *problems = sorted(Path("problems").glob("*.pddl"), key=lambda each: each.name != "domain.pddl")
    assert len(problems) == 3
    assert all(solved(domain, problem) for problem in problems)
    again = eai(
        "data", "annotate", "problems", "--domain", "goals.jsonl", "--out", "again", "--conditions", "1"
    )
    assert again.status == 0
    assert (Path("again") / domain.name).read_bytes() == domain.read_bytes()
    assert all((Path("again") / each.name).read_bytes() == each.read_bytes() for each in problems)


def test_choosing_resumes_from_the_saved_decisions(eai: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    saying(monkeypatch, "keep 1")
    assert eai(*CHOOSE).out.endswith("the input ended; written to decisions.toml\n")
    saying(monkeypatch, "drop 2")
    going_on = eai(*CHOOSE)
    assert re.search(r"candidate 1, met by 2:\n    lit\(lamp\)\n   2  on", going_on.out)
    chosen = read_ignored_predicates_and_user_decisions(Path("decisions.toml"))[1]["Tidy up"]
    assert (len(chosen.candidates), len(chosen.dropped)) == (1, 1)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("goals", *SHELVES), "decisions.toml: no such file; eai data annotate choose writes it"),
        (
            ("differences", *SHELVES, "--title", "Tidy"),
            "no demonstration is called 'Tidy'; did you mean Tidy up",
        ),
        (
            ("differences", *SHELVES, "--demonstrations", "x.whl"),
            "shelves reads no archive of demonstrations",
        ),
        (
            ("problems", *SHELVES, "--out", "p", "--planner", "none"),
            "choose a planner, as only solvable problems are kept",
        ),
    ],
)
def test_unusable_input_is_one_line(eai: Command, arguments: tuple[str, ...], why: str) -> None:
    outcome = eai("data", "annotate", *arguments)
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert why in outcome.err


@pytest.mark.skipif(sys.platform == "win32", reason="interrupts are sent otherwise there")
@pytest.mark.parametrize("command", ["differences", "differences --count", "choose"])
def test_leaving_out_an_unknown_predicate_is_an_error(eai: Command, command: str) -> None:
    title = ("--title", "Tidy up")
    outcome = eai("data", "annotate", *command.split(), *SHELVES, *title, "--without", "onn")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "eai: --without: 'onn' is no predicate; did you mean on?\n"


@pytest.mark.parametrize(
    ("decided", "why"),
    [
        (
            '[title."Tidy up"]\ncandidates = [[["litt(lamp)"]]]',
            "'litt' is no changing predicate of 1; did you mean lit?",
        ),
        ('[title."Tidy up"]\ncandidates = [[["do LIHGT"]]]', "'LIHGT' is no action; did you mean LIGHT?"),
        ('[title."Tidy up"]\ncandidates = [[["small(cup)"]]]', "'small' is no changing predicate of 1"),
    ],
)
def test_decisions_with_undeclared_names_are_refused(eai: Command, decided: str, why: str) -> None:
    Path("decisions.toml").write_text(decided)
    for option in (["--assigned"], [], ["--check"]):
        outcome = eai("data", "annotate", "goals", *option, *SHELVES)
        assert outcome.status == 2
        assert outcome.err.startswith("eai: title 'Tidy up': ")
        assert why in outcome.err


def test_an_interrupt_loses_no_decision() -> None:
    command = [sys.executable, "-u", "-c", "from eai.cli import main; main()", *CHOOSE]
    path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONPATH": path, "COLUMNS": "80"},
    )
    with process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write("keep 1\ndrop 3\n")
        process.stdin.flush()
        said = [process.stdout.readline()]
        while not (said.count("candidate 1, met by 2:\n") == 2 and "   6 " in said[-1]):
            said.append(process.stdout.readline())
            assert said[-1], "".join(said)  # it ended
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
    assert "interrupted; every decision is in decisions.toml, and the same command resumes from here" in rest
    assert process.returncode == 128 + signal.SIGINT
    chosen = read_ignored_predicates_and_user_decisions(Path("decisions.toml"))[1]["Tidy up"]
    assert [list(map(str, entry)) for entry in chosen.candidates[0]] == [["lit(lamp)"]]
    assert list(map(str, chosen.dropped)) == ["on(cup, shelf)"]
