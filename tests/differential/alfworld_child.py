"""Make games of ALFWorld and play them on TextWorld's engine, for comparison by `alfworld_games.py`.

It runs in a separate environment with the packages `alfworld` and `textworld[pddl]`, which provide the
domain, the grammar and the goals of the six types. ``alfworld_child.py FOLDER GAMES TURNS SEED`` writes the
games below the folder, laid out like a download of ALFWorld. Beside each game it writes ``played.jsonl``. A
line has the possible commands, the true facts, whether the goal is reached, and the random command that is
played next.
"""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path
from typing import Any

import alfworld
from alfworld.gen import constants
from alfworld.gen.goal_library import gdict

TYPES = (
    *("pick_and_place_simple", "look_at_obj_in_light", "pick_clean_then_place_in_recep"),
    *("pick_heat_then_place_in_recep", "pick_cool_then_place_in_recep", "pick_two_obj_and_place"),
)
DATA = Path(alfworld.__file__).parent / "data"
FURNITURE = (
    "Fridge",
    "Microwave",
    "SinkBasin",
    "CounterTop",
    "Cabinet",
    "Drawer",
    "DiningTable",
    "SideTable",
)
CAN = {"Cleanable": "cleanable", "Heatable": "heatable", "Coolable": "coolable", "Sliceable": "sliceable"}


def identifier(kind: str, rng: random.Random) -> str:
    place = "|".join([f"{rng.uniform(-9, 9):+06.2f}" for _ in range(3)])
    return f"Sink|{place}|SinkBasin" if kind == "SinkBasin" else f"{kind}|{place}"


def escaped(text: str) -> str:
    """Return names in ALFRED's PDDL spelling."""
    for sign, word in (("-", "minus"), ("#", "-"), ("|", "bar"), ("+", "plus"), (".", "dot"), (",", "comma")):
        text = text.replace(sign, "-" if sign == "#" else f"_{word}_")
    return text


def problem(task: str, rng: random.Random) -> tuple[str, dict[str, str]]:
    """Return the text of a random problem of a task type, and the target classes of its goal."""
    holders = [*FURNITURE, *rng.choices(FURNITURE[3:], k=rng.randint(2, 6))]
    places = {identifier(kind, rng): kind for kind in holders}
    at = {
        name: f"loc|{rng.randint(-9, 9)}|{rng.randint(-9, 9)}|{rng.randint(0, 3)}|{i}"
        for i, name in enumerate(places)
    }
    if rng.random() < 0.3:  # two receptacles share a location
        one, other = rng.sample(list(places), 2)
        at[one] = at[other]
    able = {"pick_clean": "Cleanable", "pick_heat": "Heatable", "pick_cool": "Coolable"}.get(
        task[:10].rstrip("_")
    )
    holding = {*constants.RECEPTACLES, *FURNITURE} - set(constants.MOVABLE_RECEPTACLES)
    kinds = sorted(
        k
        for k in constants.OBJECTS_SET - holding
        if any(k in constants.VAL_RECEPTACLE_OBJECTS.get(f, ()) for f in FURNITURE[3:])
    )
    wanted = rng.choice([k for k in kinds if able is None or k in constants.VAL_ACTION_OBJECTS[able]])
    where = rng.choice([k for k in FURNITURE[3:] if wanted in constants.VAL_RECEPTACLE_OBJECTS.get(k, ())])
    chosen = [wanted, wanted, "Knife", "DeskLamp", *rng.sample(kinds, 5)]
    things = {identifier(kind, rng): kind for kind in chosen}
    facts = [f"(receptacleType {name} {kind}Type)" for name, kind in places.items()]
    facts += [f"(receptacleAtLocation {name} {at[name]})" for name in places]
    facts += [f"(openable {name})" for name, kind in places.items() if kind in constants.OPENABLE_CLASS_SET]
    for name, kind in things.items():
        inside = rng.choice(
            [p for p, k in places.items() if kind in constants.VAL_RECEPTACLE_OBJECTS.get(k, ())]
            or list(places)
        )
        facts += [
            f"(objectType {name} {kind}Type)",
            f"(inReceptacle {name} {inside})",
            f"(objectAtLocation {name} {at[inside]})",
        ]
        facts += [
            f"({word} {name})"
            for able_to, word in CAN.items()
            if kind in constants.VAL_ACTION_OBJECTS[able_to]
        ]
        facts.append(f"(toggleable {name})" if kind == "DeskLamp" else f"(pickupable {name})")
    facts += [
        f"(canContain {holder}Type {kind}Type)"
        for holder in sorted(set(holders))
        for kind in sorted(constants.VAL_RECEPTACLE_OBJECTS.get(holder, ()))
        if kind in constants.OBJECTS_SET - holding
    ]
    start = "loc|0|0|0|99"
    goal = gdict[task]["pddl"].format(obj=wanted, recep=where, toggle="DeskLamp", mrecep="")
    spots = [f"{name} # location" for name in dict.fromkeys([start, *at.values()])]
    listed = [f"{k} # object" for k in sorted(constants.OBJECTS_SET)]
    listed += [f"{k}Type # otype" for k in sorted(constants.OBJECTS_SET - holding)]
    listed += [f"{k}Type # rtype" for k in sorted(holding)]
    listed += [f"{name} # object" for name in things] + [f"{name} # receptacle" for name in places] + spots
    spots_of = list(dict.fromkeys(at.values()))
    costs = [f"(= (distance {a} {b}) {i + 1})" for i, a in enumerate(spots_of) for b in spots_of]
    head = "(define (problem plan_0)\n(:domain alfred)\n(:objects\nagent1 # agent\n"
    body = [*listed, ")", "(:init", "(= (total~cost) 0)", f"(atLocation agent1 {start})", *facts, *costs, ")"]
    return escaped(head + "\n".join(body) + goal).replace("~", "-"), {
        "object_target": wanted,
        "parent_target": where,
    }


def make(folder: Path, number: int, rng: random.Random) -> Path:
    """Write a game and return its file."""
    task = TYPES[number % len(TYPES)]
    text, about = problem(task, rng)
    target = "DeskLamp" if task.startswith("look") else about["parent_target"]
    place = (
        folder
        / "valid_seen"
        / f"{task}-{about['object_target']}-None-{target}-{number}"
        / f"trial_T{number:05}"
    )
    place.mkdir(parents=True)
    asked = gdict[task]["templates"][0].format(
        obj=about["object_target"].lower(), recep=target.lower(), toggle="desklamp"
    )
    game = {
        "pddl_domain": (DATA / "alfred.pddl").read_text(),
        "grammar": (DATA / "alfred.twl2").read_text().replace("UNKNOWN GOAL", asked),
        "pddl_problem": text,
        "solvable": True,
        "walkthrough": [],
    }
    (place / "initial_state.pddl").write_text(text)
    (place / "traj_data.json").write_text(json.dumps({"task_type": task, "pddl_params": about}))
    (place / "game.tw-pddl").write_text(json.dumps(game))
    return place / "game.tw-pddl"


def play(file: Path, turns: int, rng: random.Random) -> None:
    """Play a game at random and write what the engine reports.

    Facts come from the engine's own state, because TextWorld's list of facts is wrong: it applies every
    conditional effect, so that a used lamp stays off for ever. The command of each action is derived once.
    """
    import textworld
    from alfworld.agents.environment.alfred_tw_env import AlfredDemangler
    from textworld.envs import PddlEnv
    from textworld.envs.pddl.logic import Atom

    inner = PddlEnv(textworld.EnvInfos())
    env = AlfredDemangler(inner)
    env.load(str(file))
    env.reset()
    engine, logic = inner._pddl_state, inner._logic
    names = {key: info.name for key, info in inner._entity_infos.items()}
    derived: dict[tuple[str, ...], str] = {}

    def command(action: Any) -> str:
        key = (action.name, *(argument.name for argument in action.mapping.values()))
        if key not in derived:
            about: dict[str, Any] = {
                "state": engine,
                "facts": list(engine.facts),
                "entity_infos": inner._entity_infos,
            }
            about["variables"] = {ph.name: inner._entity_infos[v.name] for ph, v in action.mapping.items()}
            action.command_template = logic.grammar.derive(
                action.command_template, {**about, "mapping": action.mapping}
            )
            derived[key] = action.format_command(names)
        return derived[key]

    def fact(proposition: Any) -> str:
        return f"{proposition.name} {' '.join(names[each.name].strip() for each in proposition.arguments)}"

    def changing() -> set[str]:
        atoms = (Atom * engine.downward_lib.get_state_size())()
        engine.downward_lib.get_state(atoms)
        return {fact(each.get_fact(engine.name2type)) for each in atoms if each.name.startswith("Atom ")}

    static = {fact(each) for each in engine.facts if not each.is_negation} - changing()
    with (file.parent / "played.jsonl").open("w") as lines:
        for _ in range(turns + 1):
            actions = {command(each): each for each in reversed(engine.all_applicable_actions())}
            holds = sorted(
                each for each in static | changing() if not each.startswith(("new-axiom@", "cancontain"))
            )
            taken = rng.choice(sorted(actions))
            line = {
                "commands": sorted(actions),
                "facts": holds,
                "won": bool(engine.check_goal_names()),
                "taken": taken,
            }
            lines.write(json.dumps(line) + "\n")
            engine.apply(actions[taken])


def main() -> None:
    folder, games, turns, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
    rng = random.Random(seed)
    for number in range(games):
        file = make(folder, number, rng)
        if turns:
            play(file, turns, rng)


if __name__ == "__main__":
    main()
