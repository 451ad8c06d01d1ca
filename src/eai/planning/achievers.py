"""Achievers: which operators make an atom true or false, and what they need for it.

What the achievers of an atom can be about, as far as no action changes that, are its matches: the same in all
states that differ in nothing but what actions change, so that a search finds each of them once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import NamedTuple

import eai.logic.formula as f
from eai.logic.traversal import free_variables, predicates_of, walk
from eai.planning.effect_schema import EffectSchema, effect_schemas, make_operator_schema, match_atom
from eai.planning.search import Effort
from eai.planning.subgoal import GroundAtom, find_object
from eai.world.condition import ConditionCompiler
from eai.world.derived import Defined, Lookup
from eai.world.domain import Domain
from eai.world.frame import UNBOUND, Extension, Frame, FrameBinding, Truth
from eai.world.operator import Operator
from eai.world.relation import bits
from eai.world.state import Scene, State
from eai.world.vocabulary import Vocabulary


class _Step(NamedTuple):
    """A variable to give values to: its slot, whether they must be usable, and what they must meet.

    What stored predicates say is read for all values at once, other conditions for one after the other.

    Attributes:
        slot: its slot.
        is_parameter: whether its values must be usable.
        own: what they must meet whatever the open variables before it are.
        masks: what they must meet together with those.
        tests: what else they must meet.
    """

    slot: int
    is_parameter: bool
    own: tuple[Extension, ...]
    masks: tuple[Extension, ...]
    tests: tuple[Truth, ...]


class _Join(NamedTuple):
    """How to find the values of the variables that an atom leaves open.

    Attributes:
        first: what must hold of those that it determines.
        steps: the others, one after the other.
        needed: what must be brought about for those that it determines, where it does not hold.
    """

    first: tuple[Truth, ...]
    steps: tuple[_Step, ...]
    needed: tuple[Truth, ...]


class _Partial(NamedTuple):
    """A match as a binding that is to be completed, and how."""

    binding: FrameBinding
    join: _Join


class Achiever:
    """An effect of an operator, compiled: a way to make atoms of its predicate true, or false.

    Args:
        schema: the effect.
        vocabulary: of the domain.
        wide: whether what the effect asks of the operator's own objects is brought about, too; else that must
            hold already where the atom does not name them.

    Attributes:
        schema: the effect.
        conditions: what must be brought about for it where it does not hold, in order, each with its test.
        open_variables: how many of its variables the atom does not determine.
        is_fixed: whether no action changes in which ways a match can be completed.
    """

    def __init__(self, schema: EffectSchema, vocabulary: Vocabulary, *, wide: bool = False) -> None:
        self.schema = schema
        self._vocabulary = vocabulary
        self._frame = Frame([f.Variable(name) for name in schema.variables])
        self._compiler = ConditionCompiler(vocabulary, self._frame)
        self._joins: dict[tuple[str, ...], tuple[_Join, _Join]] = {}
        self.open_variables = len(set(schema.variables) - _named(schema))
        own = _own(schema, wide=wide)
        others = [c for c in schema.conditions if c not in own]
        needed = [c for c in (*own, *schema.checks) if c != f.TRUE]
        fixed = [c for c in needed if _is_fixed(c, vocabulary)]
        self._filters = (*fixed, *others)
        self._fixed = [c for c in self._filters if _is_fixed(c, vocabulary)]
        self.is_fixed = len(self._fixed) == len(self._filters)
        self.conditions = tuple((c, self._compiler.truth(c)) for c in needed if c not in fixed)

    def match(self, arguments: tuple[int, ...], scene: Scene) -> dict[str, int] | None:
        """The variables' objects that make this an achiever of the atom with these arguments, or None."""
        return match_atom(self.schema.atom, arguments, lambda constant: find_object(constant, scene))

    def bindings(
        self, state: State, scope: Mapping[str, int], usable: int, effort: Effort | None = None
    ) -> Iterator[FrameBinding]:
        """The ways to complete a match, for which what no action changes is as it must be.

        Args:
            state: the state.
            scope: the match.
            usable: the mask of the objects that actions may be about.
            effort: counts values of variables, as in `completed`.

        Yields:
            One binding of `schema.variables`, the same list each time.
        """
        return complete_bindings(state, self.partial(state.scene, scope), usable, effort)

    def partial(self, scene: Scene, scope: Mapping[str, int], *, fixed: bool = False) -> _Partial:
        """A match, to be completed in a state; or (``fixed``) whatever actions change."""
        names = self.schema.variables
        unbound = tuple([name for name in names if name not in scope])
        joins = self._joins.get(unbound)
        if joins is None:
            joins = self._make_join(unbound, self._filters), self._make_join(unbound, self._fixed)
            self._joins[unbound] = joins
        return _Partial(self._frame.bind(scene, [scope.get(name, UNBOUND) for name in names]), joins[fixed])

    def failing(self, state: State, binding: FrameBinding, most: float) -> list[f.Formula] | None:
        """The conditions that do not hold, or None if there are ``most`` of them or more."""
        found: list[f.Formula] = []
        for condition, holds in self.conditions:
            if not holds(state, binding):
                found.append(condition)
                if len(found) >= most:
                    return None
        return found

    def scope(self, binding: FrameBinding) -> dict[str, int]:
        """The variables' objects in a binding."""
        return dict(zip(self.schema.variables, binding[1:], strict=False))

    def arguments(self, binding: FrameBinding) -> tuple[int, ...]:
        """The operator's arguments in a binding."""
        return tuple(binding[1 : 1 + self.schema.operator.arity])

    def _make_join(self, unbound: tuple[str, ...], filters: Sequence[f.Formula]) -> _Join:
        scope = self._frame.scope
        pending = list(filters)
        determined = set(self.schema.variables) - set(unbound)
        bound = set(determined)
        first = [c for c in pending if free_variables(c) <= determined]
        pending = [c for c in pending if c not in first]
        steps: list[_Step] = []
        for name in unbound:
            bound.add(name)
            ready = [c for c in pending if free_variables(c) <= bound]
            pending = [c for c in pending if c not in ready]
            plain = [c for c in ready if _is_plain(c, self._vocabulary)]
            own = [c for c in plain if free_variables(c) <= determined | {name}]
            step = _Step(
                scope[name],
                scope[name] <= self.schema.operator.arity,
                tuple(self._compiler.extension(c, scope[name], scope) for c in own),
                tuple(self._compiler.extension(c, scope[name], scope) for c in plain if c not in own),
                tuple(self._compiler.truth(c) for c in ready if c not in plain),
            )
            steps.append(step)
        needed = tuple(holds for c, holds in self.conditions if free_variables(c) <= determined)
        return _Join(tuple(self._compiler.truth(c) for c in first), tuple(steps), needed)


def complete_bindings(
    state: State, partial: _Partial, usable: int, effort: Effort | None = None
) -> Iterator[FrameBinding]:
    """Yield the ways to complete a match, like `Achiever.bindings`.

    Args:
        state: the state.
        partial: the match.
        usable: the mask of the objects that actions may be about.
        effort: counts values of variables. When it is exceeded, there are no more ways. None for no limit.
    """
    binding, join = [*partial.binding], partial.join
    for holds in join.first:
        if not holds(state, binding):
            return
    values: list[int] = []
    for step in join.steps:
        mask = usable if step.is_parameter else state.scene.everything
        for matching in step.own:
            mask = matching(state, binding, mask)
        if not mask:
            return
        values.append(mask)
    yield from _complete(state, binding, join.steps, values, effort or Effort())


def _complete(
    state: State, binding: FrameBinding, steps: Sequence[_Step], values: Sequence[int], effort: Effort
) -> Iterator[FrameBinding]:
    if not steps:
        yield binding
        return
    step, mask = steps[0], values[0]
    for matching in step.masks:
        mask = matching(state, binding, mask)
    for index in bits(mask):
        if effort.spend():
            return
        binding[step.slot] = index
        if all(test(state, binding) for test in step.tests):
            yield from _complete(state, binding, steps[1:], values[1:], effort)
    binding[step.slot] = UNBOUND


class Achievers:
    """The achievers of a domain: all effects of its operators, by what they make true or false.

    Attributes:
        schemas: the effects of each operator, in the order in which they are written.
        by_effect: the effects that make atoms of a predicate true, or false.
    """

    def __init__(self, domain: Domain) -> None:
        self._vocabulary = vocabulary = domain.vocabulary
        fixed = {predicate.name for predicate in vocabulary.predicates if predicate.static}
        self._fixed_unary = [slot for name, slot in vocabulary.unary_slots.items() if name in fixed]
        self._fixed_binary = [slot for name, slot in vocabulary.binary_slots.items() if name in fixed]
        self._fixed_tuples = [slot for name, slot in vocabulary.tuple_slots.items() if name in fixed]
        self._compiled = cache(self._compile)
        self.schemas = {o.name: tuple(effect_schemas(o)) for o in domain.operators}
        self.by_effect: dict[tuple[str, bool], list[EffectSchema]] = {}
        self._writers: dict[str, dict[str, Operator]] = {}
        self._taking = {o.name: Achiever(make_operator_schema(o), vocabulary) for o in domain.operators}
        self._matches: _Matches | None = None
        for operator in domain.operators:
            for schema in self.schemas[operator.name]:
                self.by_effect.setdefault((schema.atom.predicate, schema.adds), []).append(schema)
                self._writers.setdefault(schema.atom.predicate, {})[operator.name] = operator

    def find(self, predicate: str, *, adding: bool, wide: bool = False) -> Sequence[Achiever]:
        """The achievers that make atoms of a predicate true, or false: the straight ones first.

        Those are the ones that are about nothing but the objects of the atom, and need least. Wide ones are
        those of effects that ask something of other objects of the operator, which can be brought about.
        """
        return self._compiled(predicate, adding, wide)

    def _compile(self, predicate: str, adding: bool, wide: bool) -> Sequence[Achiever]:
        schemas = self.by_effect.get((predicate, adding), ())
        asking = [each for each in schemas if not wide or _asks_wider(each, self._vocabulary)]
        achievers = [Achiever(each, self._vocabulary, wide=wide) for each in asking]
        return sorted(achievers, key=_straightness)

    def static_facts(self, state: State) -> Sequence[object]:
        """The part of a state that no action changes: equal for states of one scene where it is the same."""
        unary, binary, tuples = state.unary, state.binary, state.tuples
        return [
            *[unary[slot] for slot in self._fixed_unary],
            *[binary[slot] for slot in self._fixed_binary],
            *[tuples[slot] for slot in self._fixed_tuples],
        ]

    def find_operators(self, names: Iterable[str]) -> list[Achiever]:
        """The operators of these names, if there are any, as they are taken for their own sake."""
        return [self._taking[name] for name in names if name in self._taking]

    def matches(self, state: State, usable: int) -> _Matches:
        """Return the matches in a state; those of the last state if they are equal.

        Args:
            state: the state.
            usable: the mask of the objects that actions may be about.
        """
        if self._matches is None or not self._matches.are_of(state, usable):
            self._matches = _Matches(self, state, usable)
        return self._matches

    def writers(self, predicates: Iterable[str]) -> list[Operator]:
        """The operators that change any of these predicates, in a fixed order."""
        found = {name: op for p in predicates for name, op in self._writers.get(p, {}).items()}
        return list(found.values())


def _straightness(achiever: Achiever) -> tuple[int, int]:
    """How much an achiever leaves open, and needs."""
    return achiever.open_variables, len(achiever.conditions)


def _named(schema: EffectSchema) -> set[str]:
    """The variables that the atom of an effect names."""
    return {term.name for term in schema.atom.arguments if isinstance(term, f.Variable)}


def _own(schema: EffectSchema, *, wide: bool) -> list[f.Formula]:
    """Conditions of an effect on the objects of its atom; or (``wide``) on the operator's own besides."""
    named = _named(schema)
    own = [c for c in schema.conditions if free_variables(c) <= named]
    if wide:
        about = (named | {p.name for p in schema.operator.parameters}) - schema.read_variables
        own += [c for c in schema.conditions if c not in own and free_variables(c) <= about]
    return own


def _asks_wider(schema: EffectSchema, vocabulary: Vocabulary) -> bool:
    """Whether an effect asks something of other objects of the operator that actions can bring about."""
    own = _own(schema, wide=False)
    others = [c for c in _own(schema, wide=True) if c not in own]
    return any(c != f.TRUE and not _is_fixed(c, vocabulary) for c in others)


def _is_plain(formula: f.Formula, vocabulary: Vocabulary) -> bool:
    """Whether masks tell of all values at once: it comes down to what is stored, or looked up both ways.

    "There is some" does so where several things are said of it, some of which are about nothing else.
    """
    return all(
        isinstance(part, f.Not | f.And | f.Or)
        or (isinstance(part, f.Exists) and isinstance(part.body, f.And))
        or (isinstance(part, f.Atom) and _is_plain_predicate(part.predicate, vocabulary))
        for part in walk(formula)
    )


def _is_plain_predicate(name: str, vocabulary: Vocabulary) -> bool:
    if vocabulary.find_stored(name) is not None:
        return True
    derived = vocabulary.derived_by_name[name]
    if isinstance(derived, Lookup):
        return derived.inverse is not None
    return (
        isinstance(derived, Defined) and derived.values is None and _is_plain(derived.definition, vocabulary)
    )


def _is_fixed(formula: f.Formula, vocabulary: Vocabulary) -> bool:
    """Whether no action can change the truth of a formula."""
    return all(_is_fixed_predicate(name, vocabulary) for name in predicates_of(formula))


def _is_fixed_predicate(name: str, vocabulary: Vocabulary) -> bool:
    stored = vocabulary.find_stored(name)
    if stored is not None:
        return stored.static
    derived = vocabulary.derived_by_name[name]
    if isinstance(derived, Defined):
        return derived.values is None and _is_fixed(derived.definition, vocabulary)
    return False


_KEPT = 64
"""How many bindings of one achiever are kept at most: where there are more, they are found again."""

_MAX_BINDINGS = 100_000
"""Maximum number of values of variables that are tried to find bindings that hold in all states."""


class _Match(NamedTuple):
    """An achiever of an atom.

    Attributes:
        achiever: the achiever.
        partial: the objects of those of its variables that the atom determines.
        kept: all ways to complete that, as bindings; None if they are to be found in every state.
    """

    achiever: Achiever
    partial: _Partial
    kept: Sequence[tuple[int, ...]] | None

    def needs(self, state: State, most: float) -> bool:
        """Whether so many conditions or more do not hold, however it is completed."""
        binding, failing = [*self.partial.binding], 0
        for holds in self.partial.join.needed:
            failing += not holds(state, binding)
        return failing >= most

    def bindings(self, state: State, usable: int, effort: Effort | None = None) -> Iterator[FrameBinding]:
        """The ways to complete it, as `Achiever.bindings` yields them."""
        return (
            complete_bindings(state, self.partial, usable, effort)
            if self.kept is None
            else map(list, self.kept)
        )


class _Matches:
    """The matches in states with the same fixed facts.

    Args:
        achievers: of the domain.
        state: one of the states.
        usable: the mask of the objects that actions may be about.
    """

    def __init__(self, achievers: Achievers, state: State, usable: int) -> None:
        self._achievers = achievers
        self._state = state
        self._usable = usable
        self._fixed = achievers.static_facts(state)
        self._found: dict[tuple[GroundAtom, bool], Sequence[_Match]] = {}

    def are_of(self, state: State, usable: int) -> bool:
        """Whether they are those in a state."""
        return (
            self._state.scene is state.scene
            and self._usable == usable
            and self._fixed == self._achievers.static_facts(state)
        )

    def of(self, atom: GroundAtom, *, wide: bool = False) -> Sequence[_Match]:
        """The matches of an atom of a stored predicate, in the order of its achievers, wide ones or not."""
        found = self._found.get((atom, wide))
        if found is None:
            found = self._found[atom, wide] = self._find(atom, wide=wide)
        return found

    def _find(self, atom: GroundAtom, *, wide: bool) -> Sequence[_Match]:
        found: list[_Match] = []
        for achiever in self._achievers.find(atom.predicate, adding=atom.truth, wide=wide):
            scope = achiever.match(atom.arguments, self._state.scene)
            if scope is not None:
                fixed = achiever.partial(self._state.scene, scope, fixed=True)
                most = _KEPT + 1 if achiever.is_fixed else 1
                effort = Effort(_MAX_BINDINGS)
                ways = complete_bindings(self._state, fixed, self._usable, effort)
                bindings = [tuple(b) for b in islice(ways, most)]
                if bindings or effort.is_exceeded:
                    partial = achiever.partial(self._state.scene, scope)
                    is_whole = len(bindings) < most and not effort.is_exceeded
                    found.append(_Match(achiever, partial, bindings if is_whole else None))
        return found
