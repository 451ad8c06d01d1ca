from __future__ import annotations

from collections.abc import Sequence

from eai.benchmarks.packs import Pack, open_virtualhome
from eai.benchmarks.statistics import StatRow, stats, virtualhome_rows
from eai.benchmarks.virtualhome.pack import PACK, VirtualHome
from eai.data.dataset import fetch
from eai.data.store import Store

PUBLISHED = {
    "task names": 26,
    "instructions": 338,
    "goals": 801,
    "state goals": 340,
    "relation goals": 299,
    "action goals": 162,
    "trajectories": 338,
    "action steps": 2960,
    "steps per trajectory": 8.76,
    "transition models": 33,
}


def by_label(rows: Sequence[StatRow]) -> dict[str, StatRow]:
    return {row.label: row for row in rows}


def test_rows_count_what_they_say(store: Store, packs: Sequence[Pack]) -> None:
    fetch(store, packs=packs)
    rows = by_label(virtualhome_rows(VirtualHome(store.open(PACK)), ["1_1"], 5))
    assert {label: row.value for label, row in rows.items()} == {
        "task names": 2,
        "tasks": 3,
        "instructions": 2,
        "action sequencing tasks": 2,
        "transition modeling tasks": 1,
        "goals": 5,
        "state goals": 1,
        "relation goals": 2,
        "action goals": 2,
        "trajectories": 2,
        "action steps": 4,
        "steps per trajectory": 2.0,
        "transition models": 5,
    }
    assert "Put cup (1)" in rows["transition modeling tasks"].note


def test_the_papers_table_comes_out_of_the_published_data(data_store: Store) -> None:
    (table,) = [each for each in stats(data_store) if each.domain == "virtualhome"]
    rows = by_label(table.rows)
    assert {label: rows[label].value for label in PUBLISHED} == PUBLISHED
    assert [
        rows[label].value for label in ("tasks", "action sequencing tasks", "transition modeling tasks")
    ] == [
        342,
        305,
        296,
    ]
    assert "less the 37 with two or more" in rows["action sequencing tasks"].note


def test_four_tasks_have_neither_goals_nor_a_temporal_goal(data_store: Store) -> None:
    tasks = open_virtualhome(data_store).values()
    assert {task.id for task in tasks if task.tl_goal is None} == {"627_1", "339_1", "84_1", "93_1"}
    assert all(
        (task.tl_goal is None) == (not (task.node_goals or task.edge_goals or task.action_goals))
        for task in tasks
    )


def test_behaviors_column_of_the_papers_table_comes_out(data_store: Store) -> None:
    (table,) = [each for each in stats(data_store) if each.domain == "behavior"]
    assert {label: row.value for label, row in by_label(table.rows).items()} == {
        "task names": 100,
        "instructions": 100,
        "goals": 673,
        "state goals": 153,
        "relation goals": 520,
        "action goals": 0,
        "goals per task": 6.73,
        "goal conditions": 366,
        "goal options per task": 4164.41,
        "trajectories": 100,
        "action steps": 1455,
        "steps per trajectory": 14.55,
        "transition models": 30,
    }
