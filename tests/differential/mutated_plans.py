"""Mutated plans: the data set's scripts with other steps, other objects, and other ways to write them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TypeAlias

from differential.mutations import Dice, rearranged, slightly_corrupted
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask

Step: TypeAlias = "tuple[str, list[object]]"
"""An action and the entries of its list."""

ODD_ACTIONS = (
    "PLUGIN",
    "PLUGOUT",
    "RELEASE",
    "Walk",
    "grab",
    "FLY",
    "LOOKAT_SHORT",
    "LOOKAT_LONG",
    "TURN TO",
    "",
)
ODD_NAMES: tuple[object, ...] = (
    "sofa",
    "unicorn",
    "",
    "Character",
    "character",
    "o'clock",
    "caf\u00e9",
    "a, b",
    7,
    None,
    True,
    [],
    {},
    "[x",
)
ODD_IDS = ("0", "999999", "65", "", "x", " 65", "065", "65.0", 65.5, None, True, -1)


def virtualhome_plan(dice: Dice, task: VirtualHomeTask) -> str:
    """Return a mutated VirtualHome plan with ids, as release 1.0.5 expects."""
    known = [_named(task, i) for i in task.relevant]
    script = [
        (action, [part for name, number in objects for part in (name, str(number))])
        for action, objects in task.record.script
    ]
    steps: list[Step] = [(action, list(words)) for action, words in script]
    if dice.chance(0.8):  # the reference package may not know a name of the data set's own script
        ids = {id_ for _, id_ in known}
        steps = [step for step in steps if {str(word) for word in step[1][1::2]} <= ids]
    arities = _virtualhome_arities()
    steps = rearranged(dice, steps, lambda: _random_step(dice, arities, known), dice.one((0, 1, 2, 4)))
    if dice.chance(0.25) and steps:
        for _ in range(1 + dice.few(0.5)):
            place = dice.below(len(steps))
            steps[place] = _misnamed(dice, steps[place])
    return slightly_corrupted(dice, _written(dice, steps), 0.2)


@cache
def _virtualhome_arities() -> Mapping[str, int]:
    return virtualhome.make_domain_with_checks_in_reference_order().operator_arities


@cache
def _behavior_arities() -> Mapping[str, int]:
    return {
        **behavior.make_domain_with_checks_in_reference_order().operator_arities,
        "NAVIGATE_TO": 1,
        "BURN": 1,
    }


def _named(task: VirtualHomeTask, index: int) -> tuple[str, str]:
    name, _, number = task.scene.objects[index].name.rpartition(".")
    return name, number


def _random_step(dice: Dice, arities: Mapping[str, int], known: Sequence[tuple[str, str]]) -> Step:
    action = dice.one(sorted(arities))
    return action, [part for _ in range(arities[action]) for part in dice.one(known)]


def _misnamed(dice: Dice, step: Step) -> Step:
    """Return a step with a fault in its names, numbers or types."""
    action, words = step
    words = list(words)
    match dice.below(10):
        case 0:
            return dice.one(ODD_ACTIONS), words
        case 1 if len(words) > 1:
            words[2 * dice.below(len(words) // 2)] = dice.one(ODD_NAMES)
        case 2 if len(words) > 1:
            words[1 + 2 * dice.below(len(words) // 2)] = dice.one(ODD_IDS)
        case 3:
            words.append(dice.one(ODD_NAMES))
        case 4 if words:
            words.pop()
        case 5:
            words += words[:2] or ["sofa", "352"]
        case 6 if words:
            del words[:2]
        case 7 if len(words) > 1 and "_" in str(words[0]):  # the joined text stays equal
            name, _, rest = str(words[0]).partition("_")
            words[:2] = [name, f"{rest}_{words[1]}"]
        case 8:
            words = [int(str(word)) if str(word).isdigit() else word for word in words]
        case _:
            return action.lower() if dice.chance(0.2) else action, words[::-1]
    return action, words


def _written(dice: Dice, steps: Sequence[Step]) -> str:
    """Return the steps in one of the forms that answers have."""
    nothing = dice.one(("[]", "[ ]", "[ ]", "[ ]", '[""]'))
    pairs = [f"{json.dumps(action)}: {json.dumps(words) if words else nothing}" for action, words in steps]
    if dice.chance(0.8):
        return "{" + ", ".join(pairs) + "}"
    shape = dice.one(("list", "lines", "output", "bare"))
    match shape:
        case "list":
            return "[" + ", ".join("{" + pair + "}" for pair in pairs) + "]"
        case "lines":
            return "{\n" + ",\n".join(pairs) + ",\n}"
        case "output":
            return '{"output": {' + ", ".join(pairs) + "}}"
        case _:
            return "\n".join(pairs)


def behavior_plan(dice: Dice, task: BehaviorTask) -> str:
    """Return a mutated BEHAVIOR plan."""
    names = [thing.name for thing in task.scene.objects]
    own = [task.scene.objects[i].name for action in task.script for i in action.arguments]
    arities = _behavior_arities()
    script = [
        {"action": action.operator, "object": ", ".join(task.scene.objects[i].name for i in action.arguments)}
        for action in task.script
    ]

    def more() -> dict[str, object]:
        action = dice.one(sorted(arities))
        chosen = [dice.one(own if dice.chance(0.7) and own else names) for _ in range(arities[action])]
        return {"action": action, "object": ", ".join(chosen)}

    steps: list[dict[str, object]] = [dict(step) for step in script]
    steps = rearranged(dice, steps, more, dice.one((0, 1, 2, 4, 8)))
    if dice.chance(0.25) and steps:
        for _ in range(1 + dice.few(0.5)):
            place = dice.below(len(steps))
            steps[place] = _odd_entry(dice, steps[place])
    return slightly_corrupted(dice, _as_python(dice, steps), 0.2)


def _odd_entry(dice: Dice, step: dict[str, object]) -> dict[str, object]:
    action, thing = step.get("action"), step.get("object")
    odd: tuple[dict[str, object], ...] = (
        {
            "action": dice.one(("open", "Open", "OPEN ", " OPEN", "FLY", "", "STAIN", "UNCLEAN")),
            "object": thing,
        },
        {
            "action": action,
            "object": dice.one(("agent", "agent.n.01_1", "unicorn_1", "", ",", "room_floor", "a,b,c")),
        },
        {"action": action, "object": f"{thing}, {thing}"},
        {"action": action, "object": f"{thing},{thing},{thing}"},
        {"action": action, "object": f" {thing} "},
        {"action": action, "object": str(thing).split(",", maxsplit=1)[0]},
        {"action": action, "object": f"{thing}_part_0"},
        {"action": action, "object": str(thing).upper()},
        {"action": action},
        {"object": thing},
        {"action": action, "object": thing, "why": "because [1]"},
        {"action": action, "object": thing, "why": None},
        {"action": action, "object": thing, "why": True},
        {"Action": action, "object": thing},
        {"action": "NAVIGATE_TO", "object": thing},
        {"action": "BURN", "object": thing},
        {"action": action, "object": [thing]},
        {"action": action, "object": 7},
        {"action": action, "object": None},
        {"action": None, "object": thing},
        {},
    )
    return dice.one(odd)


def _as_python(dice: Dice, steps: Sequence[dict[str, object]]) -> str:
    """Return the steps as a Python list, which the reference package evaluates."""
    match dice.below(14):
        case 0:
            return repr(list(steps))
        case 1:
            return "[\n" + "\n".join(f"{json.dumps(step)},  # then" for step in steps) + "\n]"
        case 2:
            return json.dumps({"output": list(steps)})
        case 3:
            return "[" + ", ".join(f"dict({_keywords(step)})" for step in steps) + "]"
        case 4:
            return "[" + ", ".join(f"{json.dumps(step)}, {dice.one(ODD_ELEMENTS)}" for step in steps) + "]"
        case 5:
            return "[" + " ".join(json.dumps(step) for step in steps) + "]"
        case 6:
            return json.dumps(list(steps)).replace('"object": "', dice.one(ODD_VALUES))
        case _:
            return json.dumps(list(steps), indent=dice.one((None, 1)))


ODD_ELEMENTS = (
    "1",
    '"OPEN"',
    "None",
    "null",
    "()",
    "{}",
    "{1, 2}",
    "...",
    "-1",
    "1 + 2j",
    "b''",
    "{'action': 'OPEN'}",
)
ODD_VALUES = (
    '"object": r"',
    '"object": b"',
    '"object": "" "',
    '"object": f"',
    '"object": "\\x20',
    '"object": u"',
)


def _keywords(step: Mapping[str, object]) -> str:
    return ", ".join(f"{key.lower()}={value!r}" for key, value in step.items())
