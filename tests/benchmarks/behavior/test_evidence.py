from __future__ import annotations

import re
from importlib.resources import files

from eai.base.files import parse_toml
from eai.benchmarks.behavior.evidence import load_unpublished_facts
from oracle import read_shared


def test_every_entry_of_the_table_has_a_reason() -> None:
    text = (files("eai.benchmarks.behavior") / "evidence.toml").read_text(encoding="utf-8")
    sections = re.split(r"(?m)^\[+(.+?)\]+\n", text)[1:]
    tables = zip(sections[::2], sections[1::2], strict=True)
    entries = [parse_toml(table) for name, table in tables if name != "volume.of_category"]
    assert len(entries) == 11
    assert all(entry["reason"].strip().endswith(".") for entry in entries)


def test_a_volume_is_looked_up_by_object_then_model_then_default() -> None:
    volumes = load_unpublished_facts().volumes
    assert volumes.get_volume("Wainscott_0_int", "fridge_97", "fridge") == 1.6
    assert volumes.get_volume("Pomaria_1_int", "fridge_97", "fridge") == 1.1
    assert volumes.get_volume("Pomaria_1_int", "gizmo_1", "gizmo") == volumes.default == 0.01


def test_the_table_equals_the_facts_of_the_specification() -> None:
    specified = read_shared("spec", "behavior_evidence.json")
    evidence = load_unpublished_facts()
    assert dict(evidence.volumes.by_model) == specified["volume_m3"]["by_category"]
    assert evidence.standing == set(specified["stands_on_its_rooms_floor"]["categories"])
    assert evidence.initially_open == set(specified["initially_open"]["categories"])
    assert set(evidence.added) == {entry["task"] for entry in specified["extra_relations"]}
    assert set(evidence.removed) == {entry["task"] for entry in specified["removed_relations"]}
