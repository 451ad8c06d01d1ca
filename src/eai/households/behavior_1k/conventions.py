"""The conventions of a scene of BEHAVIOR-1K, in words: tools, solvents, heat, products and recipes.

Nobody can know which tool removes what, how hot a toaster is or what a recipe takes, but it is the same for
all. Prompts tell what matters for the activity, unless what is to be seen is whether a model knows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from eai.abilities.task import Task
from eai.households.behavior_1k import predicates as p
from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import Predicate

HEADING = "Conventions of this household that matter here:"


_NEEDS: Mapping[Predicate, str] = {
    p.works_inside: "on what is inside it",
    p.works_on: "while switched on",
    p.works_closed: "while closed",
}


def conventions(task: Task) -> str:
    """Return the conventions that matter in a task, one a line below the heading; empty if there are none."""
    lines = list(_Conventions(task.initial).lines())
    return "\n".join((HEADING, *lines)) if lines else ""


class _Conventions:
    """Reads the static facts of a scene."""

    def __init__(self, initial: State) -> None:
        self._state = initial
        self._names = [thing.name for thing in initial.scene.objects]
        recipes = initial.those(p.recipe.name)
        self._things = [name for i, name in enumerate(self._names) if not recipes >> i & 1]

    def lines(self) -> Iterator[str]:
        """One line for each convention."""
        for source in self._those(p.sink):
            yield from self._gives(source)
        yield from self._removal()
        yield from self._heat()
        yield from self._cutting()
        for recipe in self._those(p.recipe):
            yield self._recipe(recipe)
        for one in self._things:
            fitting = self._of(p.fits, one)
            if fitting:
                yield f"- {one} can be attached to {_listed(fitting)}."

    def _those(self, predicate: Predicate) -> list[str]:
        return [self._names[i] for i in bits(self._state.those(predicate.name))]

    def _has(self, predicate: Predicate, name: str) -> bool:
        return self._state.has(predicate.name, self._names.index(name))

    def _of(self, predicate: Predicate, name: str) -> list[str]:
        row = self._state.relation(predicate.name).row(self._names.index(name))
        return [self._names[i] for i in bits(row)]

    def _gives(self, source: str) -> Iterator[str]:
        given = self._of(p.gives, source)
        if given:
            running = ", while it is switched on" if self._has(p.toggleable, source) else ""
            yield f"- {source} gives {_listed(given)}{running}."

    def _removal(self) -> Iterator[str]:
        """How each substance that covers something is removed."""
        covering = {j for _, j in self._state.relation(p.has_cover.name).pairs()}
        for index in sorted(covering):
            substance = self._names[index]
            ways = []
            for manner, how in (
                (p.removes_dry, "dry"),
                (p.removes_running, "switched on"),
                (p.removes_soaked, "soaked with a solvent"),
            ):
                tools = self._to(manner, index)
                if tools:
                    ways.append(f"by wiping with {_listed(tools)} ({how})")
            washing = self._to(p.washes_off, index)
            if washing:
                ways.append(f"by washing or rinsing in {_listed(washing)}")
            solvents = self._of(p.dissolved_by, substance)
            machines = [one for one in (*self._those(p.washer), *self._those(p.sink)) if one not in washing]
            if solvents and machines:
                ways.append(
                    f"by washing or rinsing in {_listed(machines)} with a solvent in it or on the thing"
                )
            dissolved = f" Its solvents here: {_listed(solvents)}." if solvents else ""
            if ways or solvents:
                yield f"- {substance} is removed {'; '.join(ways) or 'with its solvents'}.{dissolved}"

    def _to(self, predicate: Predicate, index: int) -> list[str]:
        return [self._names[i] for i in bits(self._state.relation(predicate.name).column(index))]

    def _heat(self) -> Iterator[str]:
        """Yield the needs of sources of heat and cold, and their effects on things here."""
        sources = self._those(p.heat_source)
        food = {name for source in sources for name in self._of(p.cooks, source)}
        for source in (*sources, *self._those(p.cold_source)):
            needs = [words for need, words in _NEEDS.items() if self._has(need, source)]
            cooked, molten = self._of(p.cooks, source), self._of(p.melts, source)
            effects = (
                ["cooks all food here" if set(cooked) == food else f"cooks {_listed(cooked)}"]
                if cooked
                else []
            )
            effects += [f"melts {_listed(molten)}"] if molten else []
            effects += ["cools and freezes what can be frozen"] if self._of(p.chills, source) else []
            does = f"; it {' and '.join(effects)}" if effects else ""
            yield f"- {source} works {', '.join(needs) or 'always'}{does}."

    def _cutting(self) -> Iterator[str]:
        """Yield the products of cutting and heating."""
        for index, name in enumerate(self._things):
            halves = self._to(p.part_of, index)
            if halves:
                yield f"- SLICE makes {_listed(halves)} of {name}."
            for predicate, words in (
                (p.diced_as, "DICE makes {} of {}."),
                (p.diced_cooked_as, "DICE makes {} of {} if that is cooked."),
                (p.cooks_to, "Heat makes {} of {} in a vessel."),
                (p.boils_to, "Heat makes {} of {} in a vessel with boiled water."),
                (p.melts_to, "Heat melts {1} in or on something to {0}."),
            ):
                made = self._of(predicate, name)
                if made:
                    yield f"- {words.format(_listed(made), name)}"

    def _recipe(self, recipe: str) -> str:
        """A recipe in a sentence."""
        vessels, sources = self._of(p.made_in, recipe), self._of(p.heated_by, recipe)
        if self._has(p.by_stirring, recipe):
            how = "by stirring, in any vessel,"
        elif self._has(p.by_heat, recipe):
            how = f"in {_listed(vessels, 'or')} by {_listed(sources, 'or')} of"
        else:
            how = f"in {_listed(vessels, 'or')}, switched on, by RUN of"
        bases = set(self._of(p.base, recipe))
        taken = [self._taken(recipe, name, name in bases) for name in self._of(p.ingredient, recipe)]
        toppings = [self._taken(recipe, name, False) for name in self._of(p.topping, recipe)]
        over = f", with {_listed(toppings)} on top" if toppings else ""
        alone = "" if self._has(p.relaxed, recipe) else ", and nothing else"
        how = how.replace(" vessel,", " vessel, of") if self._has(p.by_stirring, recipe) else how
        made = self._of(p.makes, recipe)
        are = "are" if len(made) > 1 else "is"
        return f"- {_listed(made)} {are} made {how} {_listed(taken)}{over}{alone}."

    def _taken(self, recipe: str, name: str, is_base: bool) -> str:
        if name in self._of(p.raw, recipe):
            return f"{name} (not cooked)"
        return f"{name} (cooked)" if name in self._of(p.cooked_first, recipe) else name


def _listed(names: Iterable[str], word: str = "and") -> str:
    several: Sequence[str] = list(names)
    return f" {word} ".join([", ".join(several[:-1]), several[-1]]) if len(several) > 1 else "".join(several)
