"""Methods to make objects and substances in BEHAVIOR-1K: cutting, cooking, melting, recipes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ways import NoWayError, Way, Ways

from eai.benchmarks.behavior_1k import predicates as p
from eai.world.vocabulary import Predicate


class Products(Ways):
    """The methods of `Ways`, extended by methods to make objects and substances."""

    def _produce(self, name: str, inside: str | None = None) -> None:
        """Make an object or substance that does not exist yet; a substance in `inside`, if it is given."""
        if self._has_fact(p.substance, name):
            if self._holders(name, movable=False) and (
                inside is None or self._has_fact(p.has_in, inside, name)
            ):
                return
        elif self._is("real", name):
            return
        self._first_of(self._ways_to_make(name, inside), f"there is no way to make {name}")

    def _ways_to_make(self, name: str, inside: str | None) -> Iterator[Way]:
        yield from (partial(self._slice, w) for w in self._find_targets_of(p.part_of, name))
        yield from (
            lambda w=w: self._dice(w, inside, cooked=False) for w in self._find_sources_of(p.diced_as, name)
        )
        yield from (
            lambda w=w: self._dice(w, inside, cooked=True)
            for w in self._find_sources_of(p.diced_cooked_as, name)
        )
        yield from (
            lambda s=s: self._cook_in_pot(s, name, inside) for s in self._find_sources_of(p.cooks_to, name)
        )
        yield from (
            lambda s=s: self._boil_in_pot(s, name, inside) for s in self._find_sources_of(p.boils_to, name)
        )
        yield from (lambda w=w: self._melt(w, name, inside) for w in self._find_sources_of(p.melts_to, name))
        for recipe in self._find_sources_of(p.makes, name):
            yield from self._follow(recipe, inside)

    def _tool(self, ability: Predicate) -> str:
        found = [tool for tool in self._find_objects_with(ability) if self._is("real", tool)]
        if not found:
            raise NoWayError(f"there is no {ability.name}")
        return found[0]

    def _cut(self, operator: str, name: str) -> None:
        knife = self._tool(p.slicer)
        self._reach(name)
        self._get(knife)
        self._reach(name, knife)
        self._do(operator, name, knife)

    def _slice(self, whole: str) -> None:
        self._produce(whole)
        self._cut("SLICE", whole)

    def _dice(self, whole: str, inside: str | None, *, cooked: bool) -> None:
        self._produce(whole)
        if cooked and not self._has_fact(p.is_cooked, whole):
            self._heat(whole, self._find_sources_of(p.cooks, whole))
        vessels = [v for v in (inside, *self._vessels()) if v and not self._is("carried_by", v, whole)]
        boards = [o for o in self._category if not self._has_fact(p.fixed, o) and "board" in o]

        def dice(place: str | None) -> None:
            if place is not None:
                self._put_at(whole, place)
            self._cut("DICE", whole)

        ways = (partial(dice, place) for place in (*vessels, *boards, None))
        self._first_of(ways, f"{whole} cannot be diced")

    def _put_at(self, name: str, place: str) -> None:
        """Put an object into a container that can be filled, or onto another object."""
        if self._has_fact(p.fillable, place):
            self._put_into(name, place)
        else:
            self._put_with("PLACE_ONTOP", name, place)

    def _pots(self, substance: str | None, inside: str | None) -> list[str]:
        """Return containers for a product: the intended one, holders of the substance, empty ones, others."""
        holding = [] if substance is None else self._holders(substance)
        wanted = [] if inside is None or self._has_fact(p.fixed, inside) else [inside]
        others = [
            v
            for v in self._find_objects_with(p.fillable)
            if self._is("real", v) and not self._has_fact(p.fixed, v)
        ]
        return [*dict.fromkeys((*wanted, *(v for v in holding if v in others), *self._vessels(), *others))]

    def _expect_in(self, vessel: str, substance: str) -> None:
        if not self._has_fact(p.has_in, vessel, substance):
            raise NoWayError(f"there is no {substance} in {vessel}")

    def _cook_in_pot(self, substance: str, made: str, inside: str | None) -> None:
        def cook(pot: str) -> None:
            self._have_in(pot, substance)
            self._heat(pot, self._find_sources_of(p.cooks, substance))
            self._expect_in(pot, made)

        if not self._holders(substance, movable=False):
            self._produce(substance, None if inside is None or self._has_fact(p.fixed, inside) else inside)
        self._with_any(cook, self._pots(substance, inside), f"no pot for {substance}")

    def _boil_in_pot(self, substance: str, made: str, inside: str | None) -> None:
        boiled = self._find_objects_with(p.boiled_water)
        if not boiled:
            raise NoWayError("there is no boiled water")

        def boil(pot: str) -> None:
            if not self._has_fact(p.has_in, pot, boiled[0]):
                for water in self._find_sources_of(p.cooks_to, boiled[0])[:1]:
                    self._have_in(pot, water)
                    self._heat(pot, self._find_sources_of(p.cooks, water))
            self._have_in(pot, substance)
            self._heat(pot, self._find_sources_of(p.cooks, substance))
            self._expect_in(pot, made)

        self._with_any(boil, self._pots(substance, inside), f"no pot for {substance}")

    def _melt(self, thing: str, made: str, inside: str | None) -> None:
        """Melt an object in a pot, or on another object, which the product then covers."""

        def melt(place: str) -> None:
            self._put_at(thing, place)
            self._heat(place, self._find_sources_of(p.melts, thing))
            if not (self._has_fact(p.has_in, place, made) or self._has_fact(p.has_cover, place, made)):
                raise NoWayError(f"there is no {made} in or on {place}")

        unfit = (*self._find_objects_with(p.fixed), *self._find_objects_with(p.substance), thing)
        trays = [o for o in self._category if o not in unfit]
        places = list(dict.fromkeys((*self._pots(None, inside), *trays)))
        ordered = places[::-1] if self._backwards else places
        self._with_any(melt, ordered, f"no pot for {thing}")

    def _follow(self, recipe: str, inside: str | None) -> Iterator[Way]:
        """Yield the methods to follow a recipe."""
        if self._has_fact(p.by_heat, recipe):
            vessels = self._find_targets_of(p.made_in, recipe)
            sources = self._find_targets_of(p.heated_by, recipe)
            pairs = [(vessel, source) for vessel in vessels for source in sources]
            yield from (lambda v=v, s=s: self._bake(recipe, v, s) for v, s in pairs)
        elif self._has_fact(p.by_stirring, recipe):
            yield from (lambda v=v: self._stir(recipe, v) for v in self._pots(None, inside))
        else:
            yield from (lambda m=m: self._run(recipe, m) for m in self._find_targets_of(p.made_in, recipe))

    def _prepare(self, recipe: str, vessel: str) -> None:
        """Put all ingredients of a recipe into its container, and remove things that prevent the recipe."""
        things = self._find_targets_of(p.ingredient, recipe)
        toppings = self._find_targets_of(p.topping, recipe)
        for each in (*things, *toppings):
            if not self._has_fact(p.substance, each):
                self._produce(each)
            if self._has_fact(p.cooked_first, recipe, each) and not self._has_fact(p.is_cooked, each):
                self._heat(each, self._find_sources_of(p.cooks, each))
        for each in (*things, *toppings):
            if self._has_fact(p.substance, each) and not (
                self._holders(each, movable=False) or self._taps(each)
            ):
                self._produce(each)
        for each in things:
            if self._has_fact(p.substance, each):
                self._have_in(vessel, each)
            elif not self._is("carried_by", each, vessel):
                self._put_into(each, vessel)
        bases = self._find_targets_of(p.base, recipe)
        for each in toppings:
            if self._has_fact(p.substance, each):
                self._cover(bases[0], each)
            elif not any(self._has_fact(p.lies_on, each, base) for base in bases):
                self._put_with("PLACE_ONTOP", each, bases[0])

    def _run(self, recipe: str, machine: str) -> None:
        self._prepare(recipe, machine)
        self._switch_on(machine)
        self._do("RUN", machine)

    def _stir(self, recipe: str, vessel: str) -> None:
        self._prepare(recipe, vessel)
        tool = self._tool(p.mixing_tool)
        self._get(tool)
        self._do("STIR", vessel, tool)

    def _bake(self, recipe: str, vessel: str, source: str) -> None:
        self._prepare(recipe, vessel)
        self._expose("FREEZE" if self._has_fact(p.cold_source, source) else "HEAT", vessel, source)
