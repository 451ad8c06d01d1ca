"""Mutated interpretations of goals: the data set's own goals with other entries, fields and types."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial

from differential.mutations import Dice, rearranged, slightly_corrupted
from eai.benchmarks.behavior.notation import RELATIONS, STATES
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask

SECTIONS = ("node goals", "edge goals", "action goals")
NODE_STATES = (
    "ON",
    "OFF",
    "OPEN",
    "CLOSED",
    "PLUGGED_IN",
    "PLUGGED_OUT",
    "CLEAN",
    "DIRTY",
    "SITTING",
    "LYING",
)
ODD_WORDS: tuple[object, ...] = (
    "on",
    "",
    " ON",
    "FLYING",
    "unicorn",
    7,
    1.5,
    None,
    True,
    [],
    ["ON"],
    {},
    {"a": 1},
    "d'or",
)
ODD_SECTIONS: tuple[object, ...] = (
    None,
    {},
    "",
    "ON",
    0,
    7,
    True,
    [None],
    [[]],
    ["name state"],
    [7],
    [""],
    [[["ON"]]],
)
ODD_ENTRIES: tuple[object, ...] = (
    None,
    {},
    "",
    "name state",
    "action",
    [],
    ["name", "state"],
    0,
    7,
    [["a", "b"]],
)


def virtualhome_goals(dice: Dice, task: VirtualHomeTask, gold: Sequence[str]) -> str:
    """Return VirtualHome's three sections of goals, mutated.

    Each part of ``gold`` is an object whose key is its section.
    """
    names = sorted({task.scene.objects[i].category for i in task.relevant}) or ["character"]
    actions = sorted({word for words in task.record.action_goals for word in words}) or ["GRAB"]

    if dice.chance(0.2):
        names = sorted({thing.category for thing in task.scene.objects})

    def more(section: str) -> object:
        if section == "node goals":
            return {"name": dice.one(names), "state": dice.one(NODE_STATES)}
        if section == "edge goals":
            relation = dice.one(sorted(PREDICATE_OF_RELATION))
            return {"from_name": dice.one(names), "relation": relation, "to_name": dice.one(names)}
        said = dice.one((*actions, *actions, "TYPE", "LOOKAT", "WALK"))
        return {
            "action": dice.one((said, said.lower(), f"{said} ")),
            "description": dice.one(("", "then", "so")),
        }

    entries = [entry for part in gold for entry in json.loads(part).items()]
    sections: dict[str, object] = {}
    for section in SECTIONS:
        mine = [entry for key, entry in entries if key == section]
        changed = rearranged(dice, mine, partial(more, section), dice.one((0, 1, 3)))
        sections[section] = [_odd_entry(dice, entry) if dice.chance(0.08) else entry for entry in changed]
    return slightly_corrupted(dice, _written(dice, sections), 0.25)


def _odd_entry(dice: Dice, entry: object) -> object:
    if not isinstance(entry, Mapping) or not entry or dice.chance(0.25):
        return dice.one(ODD_ENTRIES)
    found = dict(entry)
    key = dice.one(sorted(found))
    match dice.below(5):
        case 0:
            del found[key]
        case 1 | 2:
            found[key] = dice.one(ODD_WORDS)
        case 3:
            found["note"] = dice.one(("", 1, ["x"], {"y": []}, None))
        case _:
            found[key.upper()] = found.pop(key)
    return found


def _written(dice: Dice, sections: dict[str, object]) -> str:
    if dice.chance(0.12):
        sections[dice.one(SECTIONS)] = dice.one(ODD_SECTIONS)
    if dice.chance(0.12):
        del sections[dice.one(sorted(sections))]
    if dice.chance(0.06):
        sections[dice.one(("Node Goals", "node_goals", "goals", "output"))] = dice.one((*ODD_SECTIONS, []))
    if dice.chance(0.03):
        return json.dumps(dice.one(([sections], {"output": sections}, list(sections), json.dumps(sections))))
    return json.dumps(sections, indent=dice.one((None, 1, 4)), ensure_ascii=dice.chance(0.5))


def behavior_goals(dice: Dice, task: BehaviorTask) -> str:
    """Return lists of BEHAVIOR conditions, mutated from random options of each goal."""
    instances = [thing.instance for thing in task.record.objects]
    conditions = [
        _listed(condition)
        for options in task.record.goal_options
        for condition in dice.one(options if dice.chance(0.5) else options[:1])
    ]

    def more() -> object:
        unary = dice.chance(0.4)
        words = [dice.one(STATES if unary else RELATIONS)]
        words += [dice.one(instances) for _ in range(1 if unary else 2)]
        return ["not", words] if dice.chance(0.25) else words

    changed = rearranged(dice, conditions, more, dice.one((0, 1, 3, 6)))
    changed = [_odd_condition(dice, each) if dice.chance(0.08) else each for each in changed]
    sections: dict[str, object] = {"node goals": [], "edge goals": []}
    for each in changed:
        rest = sections[dice.one(("node goals", "edge goals"))]
        if isinstance(rest, list):
            rest.append(each)
    if dice.chance(0.08):
        sections[dice.one(sorted(sections))] = dice.one((*ODD_SECTIONS, "open", ["open"], ["not"], [["not"]]))
    if dice.chance(0.1):
        sections = {"goals": changed, **({"more": changed[:2]} if dice.chance(0.5) else {})}
    text = json.dumps(sections, indent=dice.one((None, 1)), ensure_ascii=dice.chance(0.5))
    return slightly_corrupted(dice, text, 0.25)


def _listed(value: object) -> object:
    return [_listed(part) for part in value] if isinstance(value, tuple | list) else value


def _odd_condition(dice: Dice, condition: object) -> object:
    words = list(condition) if isinstance(condition, list) else ["open"]
    odd: tuple[object, ...] = (
        ["not", condition],
        ["not", *words],
        ["not", ["not", words]],
        ["not"],
        ["not", []],
        ["not", "open"],
        ["and", condition, condition],
        words[::-1],
        words[:1],
        [*words, "rag.n.01_1"],
        [*words, None],
        [*words[:-1], 7],
        [*words[:-1], ["rag.n.01_1"]],
        [*words[:-1], "unicorn.n.01_1"],
        [*words[:-1], str(words[-1]).upper()],
        ["flying", *words[1:]],
        ["toggledon", *words[-1:]],
        ["ToggledOn", *words[-1:]],
        [[words]],
        [7, *words[1:]],
        " ".join(map(str, words)),
        "open",
        "not",
        "",
        "no",
        [],
        7,
        None,
        {},
        {"open": words[-1]},
    )
    return dice.one(odd)
