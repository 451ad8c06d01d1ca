"""Goals that may be combined, judged by goals of public tasks of a household."""

from __future__ import annotations

import pytest

from benchmarks.generator.worlds import generator
from eai.benchmarks.generator.usual_goals import do_goals_clash, is_goal_pointless_without_missing_goal
from eai.benchmarks.registry import find_benchmark
from eai.logic.ltl import parse
from eai.world.state import Scene, WorldObject

pytestmark = pytest.mark.usefixtures("data_store")

_KINDS = {
    "behavior": {
        "plate": "plate.n.04",
        "other": "plate.n.04",
        "chicken": "chicken.n.01",
        "table": "table.n.02",
        "cabinet": "cabinet.n.01",
        "carton": "carton.n.02",
        "apple": "apple.n.01",
        "pear": "apple.n.01",
        "fridge": "electric_refrigerator.n.01",
        "towel": "towel.n.01",
        "sink": "sink.n.01",
    },
    "virtualhome": {"dishwasher": "dishwasher", "plate": "plate", "light": "light"},
}


def scene(like: str) -> Scene:
    things = [WorldObject(name, kind) for name, kind in _KINDS[like].items()]
    return Scene(find_benchmark(like).domain.vocabulary, things, None)


@pytest.mark.parametrize(
    ("goal", "other", "clashes"),
    [
        # A public task puts plates with chicken on the table; no public task puts them away.
        ("ontop(chicken, plate)", "ontop(plate, table)", False),
        ("ontop(chicken, plate)", "inside(plate, cabinet)", True),
        ("ontop(chicken, plate)", "inside(other, cabinet)", False),
        ("inside(apple, carton)", "ontop(carton, table)", False),
        # One apple is put beside another one, which is put away.
        ("nextto(apple, pear)", "inside(pear, fridge)", True),
        ("nextto(apple, pear)", "inside(chicken, fridge)", False),
        # A soaked towel belongs in the sink, not on the table.
        ("soaked(towel)", "inside(towel, sink)", False),
        ("soaked(towel)", "ontop(towel, table)", True),
        # An object has one place, and each state once.
        ("inside(apple, carton)", "inside(apple, fridge)", True),
        ("sliced(apple)", "not sliced(apple)", True),
        ("sliced(apple)", "sliced(pear)", False),
        ("forall x: apple.n.01. (sliced(x))", "sliced(pear)", True),
    ],
)
def test_goals_that_no_public_task_combines_clash(goal: str, other: str, clashes: bool) -> None:
    formulas = [parse(text) for text in (goal, other)]
    where, usual_goals = scene("behavior"), generator("behavior").usual_goals
    assert do_goals_clash(formulas[0], formulas[1], where, usual_goals) == clashes
    assert do_goals_clash(formulas[1], formulas[0], where, usual_goals) == clashes


@pytest.mark.parametrize(
    ("goal", "others", "idle"),
    [
        ("ON(dishwasher)", [], True),
        ("ON(dishwasher)", ["ON(light)"], True),
        ("ON(dishwasher)", ["ONTOP(plate, dishwasher)"], False),
        ("ON(light)", [], False),
        ("ONTOP(plate, dishwasher)", [], False),
    ],
)
def test_goals_of_empty_machines_are_idle(goal: str, others: list[str], idle: bool) -> None:
    where, usual_goals = scene("virtualhome"), generator("virtualhome").usual_goals
    assert (
        is_goal_pointless_without_missing_goal(
            parse(goal), [parse(each) for each in others], where, usual_goals
        )
        == idle
    )
