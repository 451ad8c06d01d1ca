"""Methods to achieve single conditions in BEHAVIOR-1K: hands and doors, substances, heat and cold.

Several methods are tried in turn; a failed one is undone. The domain checks every action.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TypeAlias

import eai.logic.formula as f
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.conventions import SceneFactReader
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator
from eai.world.domain import Domain
from eai.world.state import State
from eai.world.vocabulary import Predicate

Way: TypeAlias = Callable[[], None]
Scope: TypeAlias = Mapping[str, str]
"""Names of objects, by the variables that stand for them."""

MAX_DEPTH, MAX_STEPS = 40, 6_000
"""Maximum depth of nested methods, and maximum number of actions tried."""


_Moment: TypeAlias = tuple[State, tuple[Action, ...], frozenset[str]]
"""Point to return to after a failed method: the state, the plan, and the placed objects."""


class NoWayError(Exception):
    """A method failed."""


class Ways(SceneFactReader):
    """A plan under construction, the state after it, and methods to achieve single conditions there.

    Args:
        domain: Domain of the actions.
        initial: State at the start.
        declared: Number of the scene's declared objects.
        backwards: Whether the last of several suitable objects is tried first.

    Attributes:
        reading: Evaluator of formulas.
        plan: Actions so far.
    """

    def __init__(self, domain: Domain, initial: State, declared: int, *, backwards: bool = False) -> None:
        super().__init__(initial)
        self._initial, self._domain = initial, domain
        self._cleaned: set[str] = set()
        self.reading = FormulaEvaluator(domain.vocabulary)
        self.plan: list[Action] = []
        self._category = {thing.name: thing.category for thing in initial.scene.objects[:declared]}
        self._backwards = backwards
        self._depth = self._steps = 0
        self._placed: set[str] = set()
        self._reached: list[tuple[f.Formula, Scope]] = []
        self._atoms: dict[tuple[str, int], f.Atom] = {}

    # Reading the state.

    def _is(self, predicate: str, *names: str) -> bool:
        """Return whether a derived predicate holds."""
        key = (predicate, len(names))
        if key not in self._atoms:
            self._atoms[key] = f.Atom(predicate, tuple([f.Variable(f"v{i}") for i in range(len(names))]))
        scope = {f"v{i}": self._index[name] for i, name in enumerate(names)}
        return self.reading.holds(self._atoms[key], scope, self._state)

    def _holds(self, formula: f.Formula, scope: Scope) -> bool:
        free = {name: self._index[thing] for name, thing in scope.items()}
        return self.reading.holds(formula, free, self._state)

    def _support(self, name: str) -> str | None:
        for relation in p.SUPPORTS:
            row = self._state.relation(relation).row(self._index[name])
            if row:
                return self._names[row.bit_length() - 1]
        return None

    # Acting.

    def _do(self, operator: str, *names: str) -> None:
        self._steps += 1
        if self._steps > MAX_STEPS:
            raise NoWayError(f"more than {MAX_STEPS} actions tried")
        compiled = self._domain.compiled_operators[operator]
        binding = compiled.bind(self._state, [self._index[name] for name in names])
        if not compiled.is_possible(self._state, binding):
            reason = compiled.find_failures(self._state, binding)[0].check.check.reason
            raise NoWayError(f"{operator}({', '.join(names)}): {reason}")
        self._state = compiled.apply(self._state, binding)
        self.plan.append(Action(operator, tuple([self._index[name] for name in names])))
        if operator.startswith("PLACE"):
            self._placed.add(names[0])

    def _first_of(self, ways: Iterable[Way], otherwise: str) -> None:
        """Use the first method that succeeds and undoes no reached goal, or else the first that succeeds."""
        if self._depth >= MAX_DEPTH:
            raise NoWayError(f"methods nested deeper than {MAX_DEPTH}")
        self._depth += 1
        before, kept = self._moment(), self._kept_goals()
        failed: NoWayError | None = None
        undoing: _Moment | None = None
        try:
            for way in ways:
                try:
                    way()
                except NoWayError as error:
                    failed = failed or error
                else:
                    if kept <= self._kept_goals():
                        return
                    undoing = undoing or self._moment()
                self._go_back(before)
        finally:
            self._depth -= 1
        if undoing is None:
            raise failed or NoWayError(otherwise)
        self._go_back(undoing)

    def _moment(self) -> _Moment:
        return self._state, tuple(self.plan), frozenset(self._placed)

    def _go_back(self, moment: _Moment) -> None:
        state, plan, placed = moment
        self._state, self.plan, self._placed = state, list(plan), set(placed)

    def _kept_goals(self) -> set[int]:
        """Return the indices of reached goals that still hold."""
        return {i for i, (goal, scope) in enumerate(self._reached) if self._holds(goal, scope)}

    def _with_any(self, go: Callable[[str], None], things: Iterable[str], otherwise: str) -> None:
        """Use a method with the first object for which it succeeds."""
        self._first_of((partial(go, thing) for thing in things), otherwise)

    # Hands, doors and switches. Objects in `keep` stay in the hand.

    def _free_hand(self, *keep: str) -> None:
        holding = self._find_objects_with(p.held)
        if len(holding) < 2:
            return
        free = [name for name in holding if name not in keep]
        if not free:
            raise NoWayError("no free hand: both held objects are needed")
        self._do("RELEASE", free[0])

    def _reach(self, name: str, *keep: str) -> None:
        """Open all closed containers around an object, from the outermost to the innermost."""
        around: list[tuple[str, str]] = []
        inner = name
        while (outer := self._support(inner)) is not None and len(around) < len(self._names):
            around.append((inner, outer))
            inner = outer
        for inner, outer in reversed(around):
            if self._has_fact(p.lies_in, inner, outer) and self._is("closed", outer):
                self._free_hand(*keep)
                self._do("OPEN", outer)

    def _get(self, name: str, *keep: str) -> None:
        """Take an object into a hand."""
        if self._has_fact(p.held, name):
            return
        self._produce(name)
        self._reach(name, *keep)
        self._free_hand(*keep)
        attached = self._find_targets_of(p.attached_to, name)
        if attached:
            self._do("DETACH", name, attached[0])
        else:
            self._do("GRASP", name)

    def _opened(self, name: str, *keep: str) -> None:
        self._reach(name, *keep)
        if self._is("closed", name):
            self._free_hand(*keep)
            self._do("OPEN", name)

    def _shut(self, name: str, *keep: str) -> None:
        if self._has_fact(p.openable, name) and self._has_fact(p.is_open, name):
            self._free_hand(*keep)
            self._do("CLOSE", name)

    def _switch_on(self, name: str, *keep: str) -> None:
        if self._has_fact(p.toggleable, name) and not self._has_fact(p.is_toggled_on, name):
            self._reach(name, *keep)
            if not self._has_fact(p.held, name):
                self._free_hand(*keep)
            self._do("TOGGLE_ON", name)

    def _put_into(self, name: str, place: str) -> None:
        if not self._has_fact(p.lies_in, name, place):
            self._opened(place)
            self._get(name)
            self._opened(place, name)
            self._do("PLACE_INSIDE", name, place)

    def _put_with(self, operator: str, name: str, place: str) -> None:
        self._get(name)
        self._reach(place, name)
        self._do(operator, name, place)

    # Substances.

    def _holders(self, substance: str, *, movable: bool = True) -> list[str]:
        """Return objects from which a substance can be taken: sources and containers before surfaces."""
        filled = [o for how in (p.gives, p.full_of, p.has_in) for o in self._find_sources_of(how, substance)]
        if movable and not self._has_fact(p.visual, substance):
            filled += self._find_sources_of(p.has_cover, substance)
        found = dict.fromkeys(filled)
        return [o for o in found if self._is("real", o) and not (movable and self._has_fact(p.fixed, o))]

    def _taps(self, substance: str) -> list[str]:
        return [
            source for source in self._find_sources_of(p.gives, substance) if self._has_fact(p.fixed, source)
        ]

    def _vessels(self, *without: str) -> list[str]:
        """Return the empty containers."""
        empty = [v for v in self._find_objects_with(p.fillable) if not self._find_targets_of(p.has_in, v)]
        return [
            v for v in empty if self._is("real", v) and not self._has_fact(p.fixed, v) and v not in without
        ]

    def _supply(self, substance: str, *without: str) -> str:
        """Return a movable object that holds a substance, after filling or making it if necessary."""
        found = [name for name in self._holders(substance) if name not in without]
        if found:
            return found[0]
        for tap in self._taps(substance):
            for vessel in self._vessels(*without):
                self._fill(vessel, tap)
                return vessel
        self._produce(substance)
        found = [name for name in self._holders(substance) if name not in without]
        if not found:
            raise NoWayError(f"no movable object holds {substance}")
        return found[0]

    def _fill(self, vessel: str, tap: str) -> None:
        self._opened(vessel)
        self._get(vessel)
        self._switch_on(tap, vessel)
        self._do("FILL", vessel, tap)

    def _have_in(self, vessel: str, substance: str, *, full: bool = False) -> None:
        """Bring a substance into a container."""
        wanted = p.full_of if full else p.has_in
        if self._has_fact(wanted, vessel, substance):
            return

        def pour() -> None:
            source = self._supply(substance, vessel)
            self._opened(vessel, source)
            self._get(source)
            self._opened(vessel, source)
            self._do("POUR", source, vessel)

        def make() -> None:
            self._produce(substance, vessel)
            if full and not self._has_fact(p.full_of, vessel, substance):
                pour()

        def done(way: Way) -> None:
            way()
            if not self._has_fact(wanted, vessel, substance):
                raise NoWayError(f"{vessel} does not hold enough {substance}")

        taps = [] if self._has_fact(p.fixed, vessel) else self._taps(substance)
        fills: list[Way] = [partial(self._fill, vessel, tap) for tap in taps]
        ways: list[Way] = [pour, *fills, make] if self._holders(substance) else [*fills, make, pour]
        self._first_of((partial(done, way) for way in ways), f"{substance} cannot be brought into {vessel}")

    def _cover(self, name: str, substance: str) -> None:
        """Cover an object with a substance."""
        self._put_with("APPLY", self._supply(substance, name), name)
        if not self._has_fact(p.has_cover, name, substance):
            raise NoWayError(f"{name} is not covered with {substance}")

    def _uncover(self, name: str, substance: str) -> None:
        """Remove a substance from an object: wipe, wash, rinse or dry it. Dirty tools are tried last."""
        tools = [
            (tool, manner)
            for manner in (p.removes_dry, p.removes_running, p.removes_soaked)
            for tool in self._find_sources_of(manner, substance)
            if tool != name and self._is("real", tool) and not self._has_fact(p.fixed, tool)
        ]
        dirty = [each for each in tools if self._was_dirty(each[0])]
        ways = [partial(self._wipe, name, substance, *each) for each in tools if each not in dirty]
        if not self._has_fact(p.fixed, name):
            ways += [
                partial(self._wash, name, substance, machine) for machine in self._find_objects_with(p.washer)
            ]
            ways += [partial(self._rinse, name, substance, sink) for sink in self._find_objects_with(p.sink)]
            ways += [
                partial(self._run_closed, "DRY", name, machine)
                for machine in self._find_objects_with(p.dryer)
            ]
        ways += [partial(self._clean_and_wipe, name, substance, *each) for each in dirty]
        ways += [partial(self._wipe, name, substance, *each) for each in dirty]
        self._first_of(ways, f"nothing here removes {substance}")

    def _clean_and_wipe(self, name: str, substance: str, tool: str, manner: Predicate) -> None:
        """Clean a tool and wipe with it, unless it is being cleaned already."""
        if tool in self._cleaned:
            raise NoWayError(f"{tool} is being cleaned")
        self._cleaned |= {tool, name}
        try:
            for cover in self._find_targets_of(p.has_cover, tool):
                self._uncover(tool, cover)
        finally:
            self._cleaned -= {tool, name}
        self._wipe(name, substance, tool, manner)

    def _was_dirty(self, tool: str) -> bool:
        """Return whether a substance covers a tool at the start."""
        return bool(self._initial.relation(p.has_cover.name).row(self._initial.scene.index[tool]))

    def _with_solvent(self, substance: str, bring: Callable[[str], None]) -> None:
        """Bring a solvent of a substance."""
        self._with_any(bring, self._find_targets_of(p.dissolved_by, substance), f"no solvent for {substance}")

    def _wipe(self, name: str, substance: str, tool: str, manner: Predicate) -> None:
        solvents = self._find_targets_of(p.dissolved_by, substance)
        if manner is p.removes_soaked and not any(
            self._has_fact(p.soaked_with, tool, each) for each in solvents
        ):
            self._with_solvent(substance, partial(self._soak, tool))
        self._get(tool)
        if manner is p.removes_running:
            self._switch_on(tool, tool)
        self._reach(name, tool)
        if self._has_fact(p.held, name):
            self._do("RELEASE", name)
        self._do("WIPE", name, tool)

    def _wash(self, name: str, substance: str, machine: str) -> None:
        if not self._has_fact(p.washes_off, machine, substance):
            self._with_solvent(substance, partial(self._have_in, machine))
        self._run_closed("WASH", name, machine)

    def _rinse(self, name: str, substance: str, sink: str) -> None:
        if not self._has_fact(p.washes_off, sink, substance):
            self._with_solvent(substance, partial(self._cover, name))
        self._get(name)
        self._switch_on(sink, name)
        self._do("RINSE", name, sink)

    def _run_closed(self, operator: str, name: str, machine: str) -> None:
        """Put an object into a washer or dryer, close the machine, and run it."""
        self._put_into(name, machine)
        self._shut(machine)
        self._switch_on(machine)
        self._do(operator, machine)

    def _soak(self, name: str, substance: str) -> None:
        """Soak an object with a substance."""

        def under(source: str) -> None:
            self._get(name)
            self._reach(source, name)
            if self._has_fact(p.fixed, source) and not self._has_fact(p.has_in, source, substance):
                self._switch_on(source, name)
            self._do("SOAK", name, source)

        def water() -> None:
            self._put_with("APPLY", self._supply(substance, name), name)

        near = [o for o in self._holders(substance, movable=False) if o != name]
        sources = [partial(under, source) for source in dict.fromkeys((*self._taps(substance), *near))]
        ways: tuple[Way, ...] = (*sources, lambda: under(self._supply(substance, name)), water)
        self._first_of(ways, f"{name} cannot be soaked with {substance}")
        if not self._has_fact(p.soaked_with, name, substance):
            raise NoWayError(f"{name} is not soaked with {substance}")

    # Heat and cold.

    def _expose(self, operator: str, name: str, source: str) -> None:
        """Expose an object to a working source of heat or cold."""
        if not self._is("exposed_to", name, source):
            if self._has_fact(p.works_inside, source):
                self._put_into(name, source)
            else:
                self._put_with("PLACE_ONTOP", name, source)
        if self._has_fact(p.works_closed, source):
            self._shut(source)
        if self._has_fact(p.works_on, source):
            self._switch_on(source)
        self._do(operator, name, source)

    def _heat(self, name: str, sources: Sequence[str]) -> None:
        """Heat an object with one of some sources; sources that cannot be moved come first."""
        able = [source for source in sources if not self._has_fact(p.lighter, source)]
        able.sort(key=lambda source: not self._has_fact(p.fixed, source))
        self._with_any(partial(self._expose, "HEAT", name), able, f"no source of heat for {name}")

    def _thaw(self, name: str) -> None:
        if any(self._is("exposed_to", name, source) for source in self._find_objects_with(p.cold_source)):
            self._get(name)
            self._do("RELEASE", name)
        self._do("WAIT")

    def _produce(self, name: str, inside: str | None = None) -> None:
        """Make an object or substance that does not exist yet; `products` implements this."""
        raise NotImplementedError
