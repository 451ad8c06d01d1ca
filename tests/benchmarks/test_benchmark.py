"""A benchmark as a third party declares it."""

from __future__ import annotations

from dataclasses import MISSING, fields, replace

import pytest

import eai
from studies.lamps import DOMAIN, lamp_task


def lamps(data: eai.DataSet | None = None) -> eai.Benchmark:
    return eai.Benchmark("lamps", DOMAIN, eai.use_tasks(lamp_task()), data=data or eai.DataSet())


def test_a_benchmark_needs_a_name_a_domain_and_tasks() -> None:
    needed = [f.name for f in fields(eai.Benchmark) if (f.default, f.default_factory) == (MISSING, MISSING)]
    assert needed == ["name", "domain", "open_tasks"]
    assert len(fields(eai.Benchmark)) == 6


def test_tables_call_a_benchmark_by_its_name_unless_its_data_set_has_a_title() -> None:
    assert lamps().title == "lamps"
    assert lamps(eai.DataSet("Lamps of the lab")).title == "Lamps of the lab"
    assert replace(lamps(), name="lights").title == "lights"


def test_a_data_set_may_ask_an_ability_of_some_tasks_or_of_its_own() -> None:
    ability, source = eai.Ability("action_sequencing"), eai.Source()
    assert list(lamps().tasks_for(ability, source)) == [lamp_task().id]
    assert not lamps(eai.DataSet(asks={ability: lambda task: False})).tasks_for(ability, source)
    own = lamps(eai.DataSet(own_tasks={ability: eai.use_tasks(replace(lamp_task(), id="own"))}))
    assert list(own.tasks_for(ability, source)) == ["own"]
    assert list(own.tasks_for(eai.Ability("goal_interpretation"), source)) == [lamp_task().id]


def test_operator_tasks_are_made_once() -> None:
    benchmark = lamps()
    tasks = benchmark.operator_tasks(eai.Source())
    assert benchmark.operator_tasks(eai.Source()) is tasks
    other = replace(benchmark, open_tasks=eai.use_tasks(replace(lamp_task(), id="other")))
    assert [*tasks, *other.operator_tasks(eai.Source())] == [lamp_task().id, "other"]


def test_a_file_with_tasks_of_one_ability_alone_names_the_ability_to_give() -> None:
    ability = eai.Ability("action_sequencing")
    only = replace(lamps(eai.DataSet(own_tasks={ability: eai.use_tasks()})), open_tasks=eai.use_tasks())
    with pytest.raises(
        eai.InputError,
        match="it has no tasks for goal_interpretation; give --ability action_sequencing",
    ):
        only.tasks_for(eai.Ability("goal_interpretation"), eai.Source())
