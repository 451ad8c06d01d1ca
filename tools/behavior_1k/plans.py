"""Write the gold plans of BEHAVIOR-1K: `python tools/behavior_1k/plans.py`.

The plans are found by regression: for each kind of goal, the methods to achieve it are tried in turn. The
package's planner knows only the declared operators, and is slow if products need long chains of recipes. Here
each method is written down (`ways`). At the end, actions that a plan does not need are removed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from products import Products
from ways import NoWayError, Scope, Way

import eai.logic.formula as f
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.challenge import (
    PLANS_2026,
    load_activities_of_challenge_2026,
    load_activity_amendments,
)
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, PACK, PLANS
from eai.benchmarks.behavior_1k.operators import build_domain
from eai.benchmarks.behavior_1k.scene import SceneBuilder
from eai.benchmarks.behavior_1k.tasks import (
    DataForAmendedDefinitions,
    load_scene_builder_and_object_kinds,
    split_by_activity,
)
from eai.benchmarks.packs import open_pack
from eai.logic.traversal import walk_subformulas
from eai.planning.planner import drop_needless_actions
from eai.planning.successor_generator import PlanNode
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator
from eai.world.domain import Domain
from eai.world.state import State

FILE = Path(__file__).resolve().parents[2] / "src" / "eai" / "benchmarks" / "behavior_1k" / PLANS
FILE_2026 = FILE.with_name(PLANS_2026)

ROUNDS = 4
"""Maximum number of passes over the goals, because achieving one goal can undo another."""

_ORDERED = (
    "real, cooked, covered, contains filled, saturated folded unfolded, frozen hot, attached draped, "
    "ontop, inside, nextto under touching, overlaid, toggled_on on_fire, open"
)
_ORDER = {name: place for place, names in enumerate(_ORDERED.split(", ")) for name in names.split(" ")}
"""Order of goals by predicate: ingredients before positions, doors last."""

_PLACED_BY: Mapping[str, str] = {
    "ontop": "PLACE_ONTOP",
    "under": "PLACE_UNDER",
    "attached": "ATTACH",
    "overlaid": "OVERLAY",
    "draped": "DRAPE",
}
"""Action for each relation that only one action achieves."""

_CLEAN = 1.5
"""Order of goals that forbid a cover on an object."""


def write_plan(domain: Domain, initial: State, goal: f.Formula, declared: int) -> tuple[Action, ...] | str:
    """Return a plan that reaches a goal, without needless actions, or the reason why no plan was found.

    Args:
        domain: Domain of the actions.
        initial: State at the start.
        goal: Goal of the plan.
        declared: Number of the scene's declared objects, over which quantifiers of the goal range.
    """
    reading, reason = FormulaEvaluator(domain.vocabulary), ""

    def reached(node: PlanNode) -> bool:
        return reading.holds(goal, {}, node.state)

    for backwards in (False, True):
        writer = _Regression(domain, initial, declared, backwards=backwards)
        try:
            writer.achieve(goal, {})
        except NoWayError as error:
            reason = reason or str(error)
        else:
            return drop_needless_actions(domain, initial, writer.plan, reached)
    return reason


def write_plan_line(plan: tuple[Action, ...]) -> str:
    """Return a plan in the pack's form: ``OPERATOR 3 5;...``, with the indices of objects."""
    return ";".join(" ".join((action.operator, *map(str, action.arguments))) for action in plan)


class _Regression(Products):
    """Achieves formulas by regression."""

    def achieve(self, formula: f.Formula, scope: Scope, *, wanted: bool = True) -> None:
        """Make a formula true or false."""
        goal = formula if wanted else f.Not(formula)
        if self._holds(goal, scope):
            return
        match formula:
            case f.Not(part):
                self.achieve(part, scope, wanted=not wanted)
            case f.Implies(premise, conclusion):
                self.achieve(f.Or((f.Not(premise), conclusion)), scope, wanted=wanted)
            case f.And(parts) | f.Or(parts):
                each = [(part, scope) for part in sorted(parts, key=_place)]
                together = isinstance(formula, f.And) == wanted
                self._achieve_several(each, wanted=wanted, together=together)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                things = self._of_category(variable.category)
                each = [(body, {**scope, variable.name: thing}) for thing in things]
                together = isinstance(formula, f.ForAll) == wanted
                self._achieve_several(each, wanted=wanted, together=together)
            case f.Exactly(number, variable, body):
                self._achieve_count(number, variable, body, scope)
            case f.ForPairs(first, second, body):
                self._achieve_pairs(first, second, body, scope)
            case f.Atom(predicate, arguments):
                names = [scope.get(term.name, term.name) for term in arguments]
                self._bring_about(predicate, names) if wanted else self._undo(predicate, names)
        if not self._holds(goal, scope):
            raise NoWayError("a later goal undoes an earlier one")

    def _of_category(self, category: str | None) -> list[str]:
        """Return the declared objects of a category. Objects that were placed come last."""
        found = [name for name, each in self._category.items() if each == category]
        return sorted(found[:: -1 if self._backwards else 1], key=lambda name: name in self._placed)

    def _achieve_several(
        self, parts: Sequence[tuple[f.Formula, Scope]], *, wanted: bool, together: bool
    ) -> None:
        """Make all subformulas, or one of them, true or false."""
        if not together:
            ways = (partial(self.achieve, part, its_scope, wanted=wanted) for part, its_scope in parts)
            self._first_of(ways, "there is nothing of that kind")
            return
        before = len(self._reached)
        try:
            for _ in range(ROUNDS):
                for part, its_scope in parts:
                    self.achieve(part, its_scope, wanted=wanted)
                    self._reached.append((part if wanted else f.Not(part), its_scope))
                if all(self._holds(*each) for each in self._reached[before:]):
                    return
                del self._reached[before:]
        finally:
            del self._reached[before:]
        raise NoWayError("goals undo each other")

    def _achieve_count(self, number: int, variable: f.Variable, body: f.Formula, scope: Scope) -> None:
        scopes = [{**scope, variable.name: name} for name in self._of_category(variable.category)]
        while len(met := [each for each in scopes if self._holds(body, each)]) < number:
            others = [each for each in scopes if each not in met]
            self._first_of((partial(self.achieve, body, other) for other in others), "there are too few")
        for each in met[number:]:
            self.achieve(body, each, wanted=False)

    def _achieve_pairs(self, first: f.Variable, second: f.Variable, body: f.Formula, scope: Scope) -> None:
        ones, others = self._of_category(first.category), self._of_category(second.category)
        used: set[str] = set()

        def pair(one: str, other: str) -> None:
            self.achieve(body, {**scope, first.name: one, second.name: other})
            used.add(other)

        for one in ones:
            free = [other for other in others if other not in used and other != one]
            met = [o for o in free if self._holds(body, {**scope, first.name: one, second.name: o})]
            if met:
                used.add(met[0])
            elif free:
                self._with_any(partial(pair, one), free, "no pair")

    def _bring_about(self, predicate: str, names: Sequence[str]) -> None:
        """Make an atom true."""
        for name in names:
            if predicate == "real" or not self._has_fact(p.substance, name):
                self._produce(name)
        match predicate, *names:
            case "real", _:
                pass
            case "inside", name, place:
                self._bring_inside(name, place)
            case (("nextto" | "touching"), name, other):
                self._bring_together(name, other)
            case relation, name, other if relation in _PLACED_BY:
                self._put_with(_PLACED_BY[relation], name, other)
            case "covered", name, substance:
                self._cover(name, substance)
            case (("contains" | "filled"), name, substance):
                self._have_in(name, substance, full=predicate == "filled")
            case "saturated", name, substance:
                self._soak(name, substance)
            case _, name:
                self._bring_into_state(predicate, name)

    def _bring_into_state(self, state: str, name: str) -> None:
        match state:
            case "cooked":
                self._heat(name, self._find_sources_of(p.cooks, name))
            case "hot":
                self._heat(name, self._find_objects_with(p.heat_source))
            case "frozen":
                sources = self._find_sources_of(p.chills, name)
                self._with_any(partial(self._expose, "FREEZE", name), sources, f"nothing freezes {name}")
            case "open":
                self._opened(name)
            case "toggled_on":
                self._switch_on(name)
            case "folded" | "unfolded":
                self._reach(name)
                self._free_hand()
                self._do("FOLD" if state == "folded" else "UNFOLD", name)
            case "on_fire":
                self._with_any(
                    partial(self._ignite, name), self._find_objects_with(p.lighter), "nothing lights it"
                )
            case _:
                raise NoWayError(f"no method makes {state} true")

    def _ignite(self, name: str, tool: str) -> None:
        self._get(tool)
        self._switch_on(tool, tool)
        self._reach(name, tool)
        self._do("IGNITE", name, tool)

    def _bring_inside(self, name: str, place: str) -> None:
        """Put an object into another.

        If the plan has placed it on a movable object, first try to move both together.
        """
        support = self._support(name)
        ways: list[Way] = [lambda: self._put_into(name, place)]
        if support not in (None, place) and name in self._placed:
            carrier = str(support)
            if not (self._has_fact(p.fixed, carrier) or self._has_fact(p.floor, carrier)):
                ways.insert(0, lambda: self._put_into(carrier, place))
        self._first_of(ways, f"{name} cannot be put into {place}")

    def _bring_together(self, name: str, other: str) -> None:
        """Put one of two objects next to the other.

        First try objects with a common support, so that they stay there.
        """

        def beside(one: str, there: str, *, in_place: bool) -> None:
            if in_place and (self._support(one) is None or self._support(one) != self._support(there)):
                raise NoWayError("the objects have no common support")
            neighbours = [n for n in self._find_targets_of(p.stands_by, one) if n != there]
            self._get(one)
            self._reach(there, one)
            if neighbours:
                self._do("PLACE_BETWEEN", one, there, neighbours[0])
            else:
                self._do("PLACE_NEXTTO", one, there)

        pairs = [(name, other), (other, name)]
        ways = [partial(beside, *pair, in_place=in_place) for in_place in (True, False) for pair in pairs]
        self._first_of(ways, f"{name} and {other} cannot be put together")

    def _undo(self, predicate: str, names: Sequence[str]) -> None:
        """Make an atom false."""
        match predicate, *names:
            case "real", name if self._has_fact(p.sliceable, name):
                self._slice(name)
            case "covered", name, substance:
                self._uncover(name, substance)
            case (("contains" | "filled"), name, _):
                places = [
                    *self._find_objects_with(p.sink),
                    *self._vessels(name),
                    *self._find_objects_with(p.floor),
                ]
                self._with_any(partial(self._empty, name), places, f"{name} cannot be emptied")
            case "saturated", name, _:
                dryers = [
                    partial(self._run_closed, "DRY", name, machine)
                    for machine in self._find_objects_with(p.dryer)
                ]
                self._first_of((*dryers, lambda: self._do("WAIT")), f"{name} cannot be dried")
            case "attached", name, other:
                self._free_hand()
                self._reach(name)
                self._do("DETACH", name, other)
            case relation, name, place if relation in ("inside", "nextto", "touching", *_PLACED_BY):
                self._take_away(name, place)
            case "hot", _:
                self._do("WAIT")
            case "frozen", name:
                self._thaw(name)
            case "open", name:
                self._reach(name)
                self._shut(name)
            case "toggled_on", name:
                self._reach(name)
                self._free_hand()
                self._do("TOGGLE_OFF", name)
            case _:
                raise NoWayError(f"no method makes {predicate} false")

    def _empty(self, name: str, place: str) -> None:
        self._get(name)
        self._opened(place, name)
        self._do("EMPTY", name, place)

    def _take_away(self, name: str, place: str) -> None:
        self._get(name)
        if self._has_fact(p.floor, place):
            places = [
                o
                for o in self._find_objects_with(p.fixed)
                if o != place and not self._has_fact(p.openable, o)
            ]
            self._with_any(
                partial(self._do, "PLACE_ONTOP", name), places, f"there is nowhere else to put {name}"
            )
        else:
            self._do("RELEASE", name)


def _place(formula: f.Formula) -> float:
    """Return the position of a goal in the order of goals."""
    atoms = [part.predicate for part in walk_subformulas(formula) if isinstance(part, f.Atom)]
    inner = formula.body if isinstance(formula, f.ForAll | f.Exists) else formula
    if isinstance(inner, f.Not) and atoms[:1] == ["covered"]:
        return _CLEAN
    return max((_ORDER.get(predicate, 5) for predicate in atoms), default=5)


def opened(source: Source | None = None) -> tuple[Sequence[str], SceneBuilder]:
    """Return the names of all activities, and a function that sets up an activity."""
    pack = open_pack(PACK, source)
    nothing = DataForAmendedDefinitions({}, {}, {})
    return list(split_by_activity(pack.read_member(ACTIVITIES))), load_scene_builder_and_object_kinds(
        pack, {}, nothing
    )[0]


def opened_2026(source: Source | None = None) -> tuple[Sequence[str], SceneBuilder]:
    """Return the names of the amended activities of the 2026 challenge, and a function that sets up each."""
    definitions, supplement = load_activities_of_challenge_2026(source)
    builder, _ = load_scene_builder_and_object_kinds(open_pack(PACK, source), definitions, supplement)
    return sorted(load_activity_amendments().activities), builder


def line_of(set_up: SceneBuilder, name: str) -> str:
    """Return the line of an activity, or an empty text if no plan is found."""
    activity, initial = set_up(name)
    plan = write_plan(build_domain(), initial, activity.problem.goal, len(activity.category_by_object))
    return "" if isinstance(plan, str) else f"{name}\t{write_plan_line(plan)}\n"


def main() -> None:
    """Write the plans that are found, one line for each activity."""
    for file, (names, set_up) in ((FILE, opened()), (FILE_2026, opened_2026())):
        file.write_text("".join(line_of(set_up, name) for name in names), encoding="utf-8")


if __name__ == "__main__":
    main()
