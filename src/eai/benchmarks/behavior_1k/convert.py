"""Convert the source distribution of ``bddl`` 3.6.0 to the data package (pack) `behavior_1k`.

No code of the distribution is imported. The distribution has the definitions of the activities, and the
abilities of each kind of object (synset of WordNet) with parameters. It also has rules that turn objects of
one kind into another kind. The package contains only kinds and rules that some activity can use.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from eai.base.errors import DataError
from eai.base.source import ArchiveFiles
from eai.base.store import ReportProgress
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, KINDS, RULES, RemovalMethod

_DEFINITION = re.compile(r"bddl/activity_definitions/(\w+)/problem0\.bddl")
_SYNSET = re.compile(r"[\w'-]+\.n\.\d\d\b")
_RULES = "bddl/generated_data/transition_map/tm_jsons"
_ATTACHMENTS = re.compile(r"VALID_ATTACHMENTS = set\((\[.*?\])\)", re.DOTALL)

CORRECTIONS: Mapping[str, tuple[str, str]] = {
    "loading_the_car": (") ) (not (open ?car.n.01_1) ) )", ") (not (open ?car.n.01_1) ) ) )"),
    "wash_a_baseball_cap": ("\\", ""),
}
"""Activity -> wrong passage in its definition, and the corrected passage."""

_PLAIN_ABILITIES = {
    *("openable", "toggleable", "slicer", "fillable", "cloth", "drapeable", "rope", "mixingTool"),
    *("sceneObject", "substance", "liquid", "visualSubstance", "flammable", "freezable"),
}
"""Abilities of objects, such as ``openable``, that have no parameters in the annotations."""

_TEMPERATURES = {"cookable": ("cook_temperature", 70.0), "heatable": ("heat_temperature", 40.0)}
"""Ability of objects -> name of the parameter with its minimum temperature, and default in Celsius."""


def convert_tasks(files: ArchiveFiles, report: ReportProgress) -> dict[str, bytes]:
    """Return the files of the data package (pack) `behavior_1k`: name -> content. No progress is reported.

    Raises:
        DataError: the distribution lacks a file, or a file has an unexpected form.
    """
    texts = dict(_yield_activity_names_and_definitions(files))
    rules = _read_transition_rules(files)
    mentioned = set(_SYNSET.findall(json.dumps(rules))) | set(_SYNSET.findall(" ".join(texts.values())))
    annotated = _read_json(files, "bddl/generated_data/propagated_annots_params.json")
    kinds = {
        synset: dict(_convert_supported_abilities(annotated[synset]))
        for synset in sorted(mentioned & annotated.keys())
    }
    removers: list[object] = []
    for abilities in kinds.values():
        if "removes" in abilities:
            # tools remove substances in only nine ways, so each way is stored once
            abilities["removes"] = _find_or_append(removers, abilities["removes"])
    values = {"kinds": kinds, "removers": removers}
    lines = [f"{name}\t{text}\n" for name, text in texts.items()]
    return {
        ACTIVITIES: "".join(lines).encode(),
        KINDS: _to_compact_json(values),
        RULES: _to_compact_json(rules),
    }


def _to_compact_json(value: object) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()


def _find_or_append(values: list[object], value: object) -> int:
    """Return the index of a value in a list. A value that the list lacks is appended first."""
    if value not in values:
        values.append(value)
    return values.index(value)


def _read_json(files: ArchiveFiles, path: str) -> Any:
    try:
        return json.loads(files.read(path))
    except ValueError as error:
        raise DataError(
            f"{path}: expected JSON ({error}): this version of bddl is not supported; use bddl 3.6.0"
        ) from error


def _yield_activity_names_and_definitions(files: ArchiveFiles) -> Iterator[tuple[str, str]]:
    """Yield the name and the definition of each activity, in alphabetical order. A definition is one line."""
    for path in sorted(files.names):
        match = _DEFINITION.fullmatch(path)
        if match is not None:
            text = join_lines_of_definition(files.read(path).decode())
            wrong, corrected = CORRECTIONS.get(match[1], ("", ""))
            if wrong not in text:
                raise DataError(
                    f"{path}: the text to correct, {wrong!r}, is missing: "
                    "this version of bddl is not supported; use bddl 3.6.0"
                )
            yield match[1], text.replace(wrong, corrected) if wrong else text


def join_lines_of_definition(text: str) -> str:
    """Return a definition in one line of lower-case letters, without comments."""
    text = re.sub(r";[^\n]*", "", text).lower()
    return re.sub(r"\( ", "(", " ".join(text.split()))


def _convert_supported_abilities(
    parameters_by_ability: Mapping[str, Any],
) -> Iterator[tuple[str, object]]:
    """Yield the abilities of one kind of objects, with parameters, except abilities unknown to the domain."""
    for name, parameters in parameters_by_ability.items():
        if name in _PLAIN_ABILITIES:
            yield name, True
        elif name in _TEMPERATURES:
            key, usual = _TEMPERATURES[name]
            yield name, float((parameters or {}).get(key, usual))
        elif name in ("heatSource", "coldSource"):
            needs = [word for word in ("toggled_on", "closed", "inside") if parameters[f"requires_{word}"]]
            yield name, {"temperature": parameters["temperature"], "needs": needs}
        elif name in ("particleSource", "particleApplier"):
            yield "gives", list(parameters["conditions"])
        elif name == "particleSink":
            yield "drains", True
        elif name == "particleRemover":
            yield "removes", _read_removal_methods_by_substance(parameters)


def _read_removal_methods_by_substance(
    tool_parameters: Mapping[str, Any],
) -> Mapping[str, RemovalMethod] | None:
    """Return a mapping: substance -> method by which a kind of tool removes the substance.

    Returns None if the annotations state no conditions for the tool. A few abstract kinds of tools have no
    conditions: such a tool removes substances as a rag does.
    """
    if not tool_parameters:
        return None
    by_substance = {
        name: _read_method_of_removing_substance(way) for name, way in tool_parameters["conditions"].items()
    }
    others = {
        kind: _read_method_of_removing_substance(tool_parameters[f"default_{kind}_conditions"])
        for kind in ("visual", "fluid", "non_fluid")
    }
    return {**by_substance, **others}


def _read_method_of_removing_substance(conditions: Sequence[Sequence[Any]] | None) -> RemovalMethod:
    match conditions:
        case None:
            return None
        case []:
            return []
        case [["toggled_on", _]]:
            return "toggled_on"
    return [solvent for _, solvent in conditions]


def _read_transition_rules(files: ArchiveFiles) -> dict[str, object]:
    def read_rule_file(name: str) -> Any:
        return _read_json(files, f"{_RULES}/{name}.json")

    def get_first_item(items: Iterable[str]) -> str:
        return next(iter(items))

    dice: dict[str, dict[str, str]] = {}
    for rule in read_rule_file("dicing"):
        whole = get_first_item(rule["input_synsets"])
        cooked = bool(rule.get("input_states")) and rule["input_states"][whole][0][1]
        dice.setdefault(whole, {})["cooked" if cooked else "raw"] = get_first_item(rule["output_synsets"])
    match = _ATTACHMENTS.search(files.read("bddl/bddl_verification.py").decode())
    if match is None:
        raise DataError(
            "bddl/bddl_verification.py has no VALID_ATTACHMENTS: this version of bddl is not supported; "
            "use bddl 3.6.0"
        )
    mixed = [
        *(("machine", rule) for rule in read_rule_file("single_toggleable_machine")),
        *(("stirring", rule) for rule in read_rule_file("mixing_stick")),
        *(("heat", rule) for rule in read_rule_file("heat_cook")),
    ]
    return {
        "slice": {
            get_first_item(r["input_synsets"]): get_first_item(r["output_synsets"].items())
            for r in read_rule_file("slicing")
        },
        "dice": dice,
        "melt": _map_input_to_output_object_kinds(read_rule_file("melting")),
        "cook": _map_input_to_output_object_kinds(read_rule_file("substance_cooking")),
        "cook_in_water": _map_input_to_output_object_kinds(read_rule_file("substance_watercooking")),
        "wash": read_rule_file("washer"),
        "fits": sorted(ast.literal_eval(match[1])),
        "recipes": [_convert_recipe_rule_to_json(by, rule) for by, rule in mixed],
    }


def _map_input_to_output_object_kinds(transition_rules: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """Return a mapping from each kind of object to the kind into which a rule turns it.

    Boiled water, which some rules also need, is not in the mapping.
    """
    return {
        next(name for name in rule["input_synsets"] if not name.startswith("cooked__")): next(
            iter(rule["output_synsets"])
        )
        for rule in transition_rules
    }


def _convert_recipe_rule_to_json(preparation_method: str, rule: Mapping[str, Any]) -> dict[str, object]:
    """Return the JSON value of a recipe: ingredients, method, vessel, heat source and products."""
    states = rule.get("input_states") or {}
    result = [
        state for pairs in (rule.get("output_states") or {}).values() for state, holds in pairs if holds
    ]
    toppings = {}
    for pair, ((relation, _),) in states.items():
        if "," in pair:
            over, under = pair.split(",") if relation == "ontop" else pair.split(",")[::-1]
            toppings[over] = under
    return {
        "name": rule["rule_name"],
        "by": preparation_method,
        "takes": rule["input_synsets"],
        "cooked": {
            name: holds for name, pairs in states.items() for state, holds in pairs if state == "cooked"
        },
        "toppings": toppings,
        "vessel": next(iter(rule.get("container") or rule.get("machine") or {"": 0})),
        "source": next(iter(rule.get("heat_source") or {"": 0})),
        "makes": rule["output_synsets"],
        "result": sorted(set(result)),
    }
