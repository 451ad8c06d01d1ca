"""Read the prompts of each benchmark as a person would."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.names import remove_prompt_variant_endings
from eai.tasks.task import Task
from tasks.prompts.sufficiency import ListingReader, Reader, Statement, Told

_SUPPORTS = ("ontop", "attached", "overlaid", "draped")
"""Relations to a supporting object. A thing on a support enters other containers only with its support."""

_BEHAVIOR = {"inside": "lies_in", "ontop": "lies_on", "onfloor": "stands_on"}
_BEHAVIOR |= {"under": "stands_under", "nextto": "stands_by"}
_BEHAVIOR_1K = {"inside": "lies_in", "ontop": "lies_on", "nextto": "stands_by", "under": "stands_under"}
_BEHAVIOR_1K |= {"attached": "attached_to", "overlaid": "laid_over", "draped": "draped_on", "real": "present"}
_BEHAVIOR_1K |= {
    "covered": "has_cover",
    "contains": "has_in",
    "filled": "full_of",
    "saturated": "soaked_with",
}
_STATES = (
    *("cooked", "burnt", "dusty", "frozen", "open", "sliced", "soaked", "stained", "toggled_on"),
    *("folded", "unfolded", "hot", "on_fire", "broken"),
)
_FOLLOWS = ("touching",)
"""Relations that follow from other stated relations."""

_UNCHANGING = "Facts that no action changes:"
"""Heading of a list in prompts with exact rules."""

_ROOMS = ("bathroom", "bedroom", "dining_room", "home_office", "kitchen", "living_room")


def reader_of(benchmark: Benchmark, ability: Ability, task: Task) -> Reader:
    """Return the reader of our own prompts about a task, of an ability that takes plans or of acting."""
    domain, wording = benchmark.domain, benchmark.wording(ability)
    stored, convention = STORED.get(domain.name, _as_stated), _CONVENTIONS.get(domain.name, _is_heading)
    if domain.name == "behavior-1k" and remove_prompt_variant_endings(benchmark.name) != benchmark.name:
        stored, convention = partial(_stored, relations=_BEHAVIOR_1K), _is_heading
    renamed = {written: name for name, written in wording.answer_names.items()}
    renamed |= {wording.object_name(task, i): thing.name for i, thing in enumerate(task.scene.objects)}
    return Reader(
        domain,
        ListingReader(benchmark.notation.plans.replace_answer_words_by_domain_names, convention),
        stored,
        renamed,
    )


def _as_stated(told: Told) -> Iterator[Statement]:
    yield from told.statements


def _of_halves(line: str, told: Told) -> bool:
    sentence = re.fullmatch(r"SLICE makes (.+) of (\S+)\.", line)
    if sentence is not None:
        _product("part_of")(told, *sentence.groups())
    return sentence is not None or _is_heading(line, told)


def _is_heading(line: str, told: Told) -> bool:
    return line == _UNCHANGING


def _stored(told: Told, relations: Mapping[str, str]) -> Iterator[Statement]:
    """Yield the stored facts behind the words of BDDL."""
    resting = {names[0] for name, *names in told.statements if name in _SUPPORTS}
    inside = {(names[0], names[1]) for name, *names in told.statements if name == "inside"}
    for name, *names in told.statements:
        if name == "inside" and (names[0] in resting or _is_indirect(names[0], names[1], inside)):
            continue
        if name in _FOLLOWS:
            continue
        yield relations.get(name, f"is_{name}" if name in _STATES else name), *names


def _is_indirect(thing: str, container: str, inside: set[tuple[str, str]]) -> bool:
    return any((between, container) in inside for one, between in inside if one == thing)


def _of_behavior(told: Told) -> Iterator[Statement]:
    yield from _stored(told, _BEHAVIOR)


def _of_behavior_1k(told: Told) -> Iterator[Statement]:
    yield from _stored(told, _BEHAVIOR_1K)
    for name, kind in told.kinds.items():
        noun = kind.removeprefix("made__")
        yield "heatable", name
        if noun == "water":
            yield "water", name
        if noun in ("cooked__water", "boiled_water"):
            yield "boiled_water", name


def _of_virtualhome(told: Told) -> Iterator[Statement]:
    told.agent = next(name for name, kind in told.kinds.items() if kind == "character")
    yield from told.statements
    yield from (("ROOM", name) for name, kind in told.kinds.items() if kind in _ROOMS)


STORED: Mapping[str, Callable[[Told], Iterator[Statement]]] = {
    "behavior": _of_behavior,
    "behavior-1k": _of_behavior_1k,
    "virtualhome": _of_virtualhome,
}


def _names(text: str) -> list[str]:
    return re.split(r", | and | or ", text) if text else []


def _gives(told: Told, source: str, given: str) -> None:
    for each in _names(given):
        told.state("gives", source, each)


def _floor(told: Told, floor: str, things: str) -> None:
    for each in _names(things):
        told.state("by_floor", each, floor)


def _removal(told: Told, substance: str, ways: str, solvents: str | None) -> None:
    manners = {
        "dry": "removes_dry",
        "switched on": "removes_running",
        "soaked with a solvent": "removes_soaked",
    }
    for tools, manner in re.findall(r"by wiping with ([^()]+) \(([^()]+)\)", ways):
        for tool in _names(tools):
            told.state(manners[manner], tool, substance)
    for machines in re.findall(r"by washing or rinsing in ([^;]+?)(?:;|$)", ways):
        if not machines.endswith("with a solvent in it or on the thing"):
            for machine in _names(machines):
                told.state("washes_off", machine, substance)
    for solvent in _names(solvents or ""):
        told.state("dissolved_by", substance, solvent)


def _heat(told: Told, source: str, needs: str, effects: str | None) -> None:
    words = {"on what is inside it": "works_inside", "while switched on": "works_on"}
    words |= {"while closed": "works_closed"}
    for need in needs.split(", ") if needs != "always" else ():
        told.state(words[need], source)
    text = effects or ""
    cooked = re.search(r"cooks (all food here|.+?)(?= and melts | and cools |$)", text)
    for name in _eaten(told, cooked[1]) if cooked else ():
        told.state("cooks", source, name)
    molten = re.search(r"melts (.+?)(?= and cools |$)", text)
    for name in _names(molten[1] if molten else ""):
        told.state("melts", source, name)
    if "cools and freezes" in text:
        for name in told.kinds:
            told.state("chills", source, name)


def _eaten(told: Told, text: str) -> Sequence[str]:
    return list(told.kinds) if text == "all food here" else _names(text)


def _product(predicate: str) -> Callable[..., None]:
    def read(told: Told, made: str, of: str) -> None:
        for each in _names(made):
            told.state(predicate, *((each, of) if predicate == "part_of" else (of, each)))

    return read


def _melting(told: Told, of: str, made: str) -> None:
    _product("melts_to")(told, made, of)


def _fits(told: Told, name: str, others: str) -> None:
    for other in _names(others):
        told.state("fits", name, other)


_RECIPE = re.compile(
    r"- (?P<made>.+?) (?:is|are) made (?:(?P<result>(?:cooked|hot)(?: and hot)?) )?"
    r"(?:by (?P<stirring>stirring), in any vessel|in (?P<machine>.+?), switched on, by RUN"
    r"|in (?P<oven_ware>.+?) by (?P<source>.+?)) of (?P<ingredient>.+?)"
    r"(?:, with (?P<topping>.+) on (?P<base>\S+(?: or \S+)*))?(?P<alone>, and nothing else)?\."
)


def _recipe(told: Told, line: str) -> bool:
    """Read a recipe, an object without a name; False if the line is no recipe."""
    sentence = _RECIPE.fullmatch(line)
    if sentence is None:
        return False
    recipe = f"recipe_{sum(kind == 'recipe' for kind in told.kinds.values()) + 1}"
    told.kinds[recipe] = "recipe"
    words = {role: text or "" for role, text in sentence.groupdict().items()}
    told.state("recipe", recipe)
    for predicate, role in (("by_stirring", "stirring"), ("by_heat", "source")):
        if words[role]:
            told.state(predicate, recipe)
    if not words["alone"]:
        told.state("relaxed", recipe)
    for made in _names(words["made"]):
        told.state("makes", recipe, made)
        told.state("product", made)
    for word in _names(words["result"]):
        told.state(f"makes_{word}", recipe)
    for predicate, role in (
        ("made_in", "oven_ware"),
        ("made_in", "machine"),
        ("heated_by", "source"),
        ("base", "base"),
    ):
        for each in _names(words[role]):
            told.state(predicate, recipe, each)
    for role in ("ingredient", "topping"):
        for name, note in _TAKEN.findall(words[role].replace("no ingredients", "")):
            told.state(role, recipe, name)
            if note:
                told.state("cooked_first" if note == "cooked" else "raw", recipe, name)
    return True


_TAKEN = re.compile(r"([^\s,()]+)(?: \((not cooked|cooked)\))?(?=,| and |$)")

_SENTENCES: Sequence[tuple[str, Callable[..., None]]] = (
    (r"- (\S+) (?:gives|always holds) (.+?)(?:, while it is switched on)?\.", _gives),
    (r"- (\S+) is the floor of (.+)\.", _floor),
    (r"- (\S+) is removed (.+?)\.(?: Its solvents here: (.+)\.)?", _removal),
    (r"- (\S+) works (.+?)(?:; it (.+))?\.", _heat),
    (r"- SLICE makes (.+) of (\S+)\.", _product("part_of")),
    (r"- DICE makes (.+) of (\S+)\.", _product("diced_as")),
    (r"- DICE makes (.+) of (\S+) if that is cooked\.", _product("diced_cooked_as")),
    (r"- Heat makes (.+) of (\S+) in a vessel\.", _product("cooks_to")),
    (r"- Heat makes (.+) of (\S+) in a vessel with boiled water\.", _product("boils_to")),
    (r"- Heat melts (\S+) in or on something to (.+)\.", _melting),
    (r"- (\S+) can be attached to (.+)\.", _fits),
)
"""Patterns of the sentences of BEHAVIOR-1K's conventions, each with its reader."""


def _of_house(line: str, told: Told) -> bool:
    if line in ("Conventions of this household that matter here:", "Sources and floors of this household:"):
        return True
    for pattern, read in _SENTENCES:
        sentence = re.fullmatch(pattern, line)
        if sentence is not None:
            read(told, *sentence.groups())
            return True
    return _recipe(told, line)


_CONVENTIONS: Mapping[str, Callable[[str, Told], bool]] = {"behavior-1k": _of_house, "behavior": _of_halves}
