from __future__ import annotations

import ast
from typing import Any

import pytest

from benchmarks.behavior.kitchen import EVIDENCE, GOAL, make_record, make_task
from eai.benchmarks.behavior.evidence import load_unpublished_facts
from eai.benchmarks.behavior.tasks import (
    BehaviorTasks,
    assume_furniture_on_floor,
    build_tasks,
    collect_initial_relations,
    compare_object_sizes_across_tasks,
    get_category_of_3d_model,
    read_initial_relations,
    yield_initial_states_of_objects,
)
from eai.tasks.goal_text import make_task as make_plain_task
from eai.tasks.source import TaskSet
from eai.tasks.task import GoalKind
from eai.world.state import Fact
from logic.bddl_text import print_condition
from oracle import read_shared


def respell(state: str) -> str:
    """Return a state in the reference's spelling."""
    return "".join(word.capitalize() for word in state.split("_"))


def triples(relations: Any) -> list[tuple[str, ...]]:
    return sorted(map(tuple, relations))


@pytest.fixture(scope="module")
def reconstructed() -> Any:
    return read_shared("oracle", "behavior", "reconstructed.json.gz")


def test_all_records_equal_the_reconstruction(behavior_tasks: BehaviorTasks, reconstructed: Any) -> None:
    evidence = load_unpublished_facts()
    assert behavior_tasks.keys() == reconstructed.keys()
    for task_id, expected in reconstructed.items():
        record = behavior_tasks[task_id].record
        assert (record.activity, record.definition, record.scene) == (
            expected["task_name"],
            expected["definition"],
            expected["scene"],
        )
        assert [
            {
                "name": obj.name,
                "bddl_instance": obj.instance,
                "category": obj.category,
                "igibson_category": obj.model,
                "igibson_synset": obj.synset,
                "kind": "room_floor" if obj.is_floor else "object",
                "parts": list(obj.names_of_sliced_halves),
                "states": sorted(map(respell, obj.possible_states)),
                "cleaning_tool": "cleaningTool" in obj.abilities,
                "slicer": "slicer" in obj.abilities,
                "water_source": "waterSource" in obj.abilities,
                "volume_m3_ESTIMATED": None
                if obj.is_floor
                else evidence.volumes.get_volume(record.scene, obj.name, obj.model),
            }
            for obj in record.objects
        ] == [{**obj, "states": sorted(obj["states"])} for obj in expected["objects"]]
        relations = expected["initial_relations"]
        assert triples(read_initial_relations(record)) == triples(relations["listed"])
        assert triples(assume_furniture_on_floor(record, evidence)) == triples(
            relations["assumed_furniture_onfloor"]
        )
        assert triples(collect_initial_relations(record, evidence)) == triples(relations["used"])
        states = {(name, respell(state)) for state, name in yield_initial_states_of_objects(record, evidence)}
        assert states == set(map(tuple, expected["initial_states_true"]))


def test_initial_facts_equal_the_simulator_log_of_the_authors(behavior_tasks: BehaviorTasks) -> None:
    """Two logged facts are removed with a reason (evidence.toml): sweaters on a bed."""
    evidence = load_unpublished_facts()
    robot, differing = "agent.n.01_1", set()
    for row in read_shared("oracle", "behavior", "igibson_run.claude-3-haiku-20240307.json.gz"):
        record = behavior_tasks[row["identifier"]].record
        facts = {
            *map(tuple, collect_initial_relations(record, evidence)),
            *yield_initial_states_of_objects(record, evidence),
        }
        logged = [tuple(ast.literal_eval(fact)) for fact in row["initial_state"]]
        true = {fact for fact in logged if fact[0] != "not" and robot not in fact}
        false = {fact[1:] for fact in logged if fact[0] == "not"}
        assert true >= set(map(tuple, read_initial_relations(record)))
        assert not false & facts
        differing |= {(record.activity, *fact) for fact in true - facts}
    assert differing == {
        ("brushing_lint_off_clothing", "ontop", sweater, "bed_11") for sweater in ("sweater_38", "sweater_39")
    }


def test_models_in_checks_match_the_words_in_the_checks_of_the_reference(
    behavior_tasks: BehaviorTasks,
) -> None:
    """The reference searches names for words. For names of the data set, both agree."""
    for task in behavior_tasks.values():
        models = {obj.name: obj.model for obj in task.record.objects}
        for word in ("sink", "dishwasher", "teapot", "saucepan", "detergent"):
            assert {n for n in task.scene.index if word in n} == {n for n, m in models.items() if m == word}
        for whole in task.record.objects:
            halves = {n for n in task.scene.index if "_part_" in n and whole.name in n}
            assert halves == set(whole.names_of_sliced_halves)


def test_the_initial_state_has_the_facts_of_files_and_evidence() -> None:
    state = make_task().initial
    index = state.scene.index
    assert state.has("lies_in", index["peach_1"], index["fridge_1"])
    assert state.has("stands_on", index["sink_1"], index["room_floor_kitchen_0"])
    assert state.has("stands_by", index["rag_10"], index["rag_1"])
    assert not state.has("lies_on", index["pebble_1"], index["table_1"])
    assert state.has("is_open", index["carton_1"])
    assert not state.has("is_open", index["fridge_1"])
    assert state.has("robot_on", index["room_floor_kitchen_0"])
    assert state.has("part_of", index["peach_1_part_1"], index["peach_1"])
    assert state.has("ungraspable", index["car_1"])
    assert not state.has("ungraspable", index["fridge_1"])
    assert state.has("larger", index["peach_1"], index["peach_1_part_0"])
    assert state.has("much_larger", index["fridge_1"], index["plate_1"])
    assert not state.has("much_larger", index["plate_1"], index["peach_1_part_0"])


def test_goals_name_objects_by_their_name_in_actions() -> None:
    inside, clean = make_task().goals
    assert print_condition(inside.formula) == "(inside peach_1 saucepan_1)"
    assert print_condition(clean.formula).startswith("(forall (?plate.n.01 - plate.n.01) (not")
    assert (inside.kind, clean.kind) == (GoalKind.RELATION, GoalKind.STATE)


def test_halves_have_no_category_of_the_problem() -> None:
    scene = make_task(GOAL).scene
    assert scene.names(scene.get_category_mask("peach.n.01")) == ("peach_1",)


def test_a_plan_keeps_a_misspelt_action(behavior_tasks: BehaviorTasks) -> None:
    (task,) = (task for task in behavior_tasks.values() if task.title == "preserving_food")
    assert "RIGHT_REALEASE" in [action.operator for action in task.script]


def test_furniture_without_a_place_stands_on_the_floor_of_its_room() -> None:
    record = make_record()
    placed = {source for _, source, _ in assume_furniture_on_floor(record, EVIDENCE)}
    assert placed == {"fridge_1", "table_1", "sink_1", "dishwasher_1", "car_1"}


def test_the_digest_covers_data_and_evidence() -> None:
    records = TaskSet({}, {}.__getitem__, "0")
    assert build_tasks(records, load_unpublished_facts()).sha256 != build_tasks(records, EVIDENCE).sha256
    assert (
        build_tasks(records, EVIDENCE).sha256
        != build_tasks(TaskSet({}, {}.__getitem__, "1"), EVIDENCE).sha256
    )


SIZES = ("ungraspable", "larger", "much_larger")


def list_sizes(facts: Any) -> list[Fact]:
    return sorted(fact for fact in facts if fact.predicate in SIZES)


def test_objects_of_one_task_are_compared_as_in_the_task(behavior_tasks: BehaviorTasks) -> None:
    for task in behavior_tasks.values():
        objects = [(task, i) for i in range(len(task.scene.objects))]
        assert list_sizes(compare_object_sizes_across_tasks(objects)) == list_sizes(task.initial.facts())


def test_objects_of_two_tasks_are_compared_by_their_volumes(behavior_tasks: BehaviorTasks) -> None:
    """A large fridge of one scene is larger than another fridge, and an apple than its half."""
    chosen = [
        (task, i)
        for name in ("fridge_97", "fridge_40", "apple_80", "apple_81_part_0")
        for task in [next(task for task in behavior_tasks.values() if name in task.scene.index)]
        for i in [task.scene.index[name]]
    ]
    assert len({task.id for task, _ in chosen}) == 3
    assert list_sizes(compare_object_sizes_across_tasks(chosen)) == sorted(
        [
            Fact("ungraspable", (0,)),
            *[Fact("larger", pair) for pair in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))],
            *[Fact("much_larger", pair) for pair in ((0, 2), (0, 3), (1, 2), (1, 3))],
        ]
    )


def test_the_model_of_a_floor_names_its_room(behavior_tasks: BehaviorTasks) -> None:
    models = {
        task.scene.objects[i].name: get_category_of_3d_model(task, i)
        for task in behavior_tasks.values()
        for i in range(len(task.scene.objects))
    }
    assert models["room_floor_kitchen_0"] == "room_floor_kitchen_"
    assert models["coffee_table_12"] == "coffee_table"
    assert models["apple_80_part_1"] == "half_apple"


def test_only_tasks_of_the_data_set_are_compared(behavior_tasks: BehaviorTasks) -> None:
    task = next(iter(behavior_tasks.values()))
    made = make_plain_task("other", "-", task.initial)
    with pytest.raises(TypeError, match="other"):
        list(compare_object_sizes_across_tasks([(made, 0)]))
    with pytest.raises(TypeError, match="other"):
        get_category_of_3d_model(made, 0)
