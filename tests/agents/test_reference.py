"""Plans recorded in a task replace the search for its reference, and are carried out before they are used."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agents.switches import SWITCHES, WON
from eai.abilities.protocol import Ability
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.reference import (
    add_reference_plans,
    describe_wrong_recorded_plans,
    find_reference_solution,
    make_setup,
)
from eai.agents.rules import STANDARD, GameRules
from eai.base.errors import InputError
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.action import Action

BOTH = SWITCHES.tasks_for(Ability.ACTION_SEQUENCING, Source())["both"]
IN_FULL_VIEW = GameRules(budget=2)


def act(*commands: str) -> tuple[Action, ...]:
    index = BOTH.scene.index
    return tuple(
        [Action(name, (index[thing],)) for name, thing in (c.rstrip(")").split("(") for c in commands)]
    )


def open_setup(task: Task, rules: GameRules = STANDARD) -> GameSetup:
    return GameSetup(task, SWITCHES, rules, find_reference_solution)


RECORDED = replace(
    BOTH, shortest_plan=act("PRESS(lamp)", "GO(shed)", "PRESS(torch)"), reference_plan=act(*WON)
)
PADDED = ("GO(shed)", "GO(hall)")


def test_a_completed_task_records_the_plans_that_would_be_searched() -> None:
    completed = add_reference_plans(BOTH, SWITCHES)
    searched = make_setup(BOTH, SWITCHES, STANDARD).reference
    assert open_setup(completed).reference == searched
    assert (len(completed.shortest_plan), len(completed.reference_plan)) == (3, 5)
    assert add_reference_plans(completed, SWITCHES) is completed


def test_recorded_plans_are_used_without_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse_search(*_: object) -> None:
        raise AssertionError("nothing may be searched")

    monkeypatch.setattr("eai.agents.reference.find_plan", refuse_search)
    monkeypatch.setattr("eai.agents.reference.AGENTS", {})
    assert open_setup(RECORDED).reference == (3, WON)
    assert open_setup(RECORDED).action_limit == 2 * 3 + 8


def test_the_recorded_reference_is_for_the_view_of_the_standard_setting() -> None:
    """Who sees everything plays the gold plan; the recorded shortest plan still counts."""
    longer = replace(RECORDED, shortest_plan=act(*WON), script=act("PRESS(lamp)", "GO(shed)", "PRESS(torch)"))
    assert open_setup(longer, IN_FULL_VIEW).reference == (3, ("PRESS(lamp)", "GO(shed)", "PRESS(torch)"))
    assert open_setup(longer).reference == (4, WON)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"shortest_plan": act("PRESS(lamp)")}, "both: the plan `shortest` does not reach"),
        ({"shortest_plan": act("PRESS(torch)", *WON)}, "both: the plan `shortest` does not"),
        (
            {"reference_plan": act("PRESS(lamp)")},
            r"both: correct the plan .*: expected to reach goals\.1",
        ),
        (
            {"reference_plan": RECORDED.shortest_plan},
            r"both: correct .*\.2: expected an action that is possible: .*you have not yet seen torch",
        ),
    ],
)
def test_a_wrong_recorded_plan_is_an_error_when_it_is_used(
    changed: dict[str, tuple[Action, ...]], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        _ = open_setup(replace(RECORDED, **changed)).reference


def test_other_goals_have_no_recorded_plans() -> None:
    other = RECORDED.replace_goals(RECORDED.goals[:1])
    assert (other.shortest_plan, other.reference_plan) == ((), ())


def test_plans_that_are_too_long_are_found_by_a_search() -> None:
    padded = replace(RECORDED, shortest_plan=act(*PADDED, *WON), reference_plan=act(*PADDED, *PADDED, *WON))
    assert list(describe_wrong_recorded_plans(padded, SWITCHES, searches_shorter_plans=False)) == []
    assert list(describe_wrong_recorded_plans(padded, SWITCHES, searches_shorter_plans=True)) == [
        "shortest: expected at most 3 steps, as a search finds, found 6",
        "reference: expected at most 5 steps, as a search finds, found 8",
    ]
    assert list(describe_wrong_recorded_plans(RECORDED, SWITCHES, searches_shorter_plans=True)) == []


def test_a_setup_without_limits_has_none_even_if_the_limit_was_read_before() -> None:
    setup = make_setup(BOTH, SWITCHES, STANDARD)
    assert setup.action_limit is not None
    game = Game(setup.copy_setup_without_failures_and_step_limit())
    for _ in range(2 * setup.action_limit):
        game.act("WAVE()")
    assert not game.is_over
