"""Which goals nobody would want together, by what public tasks want together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import eai.logic.formula as f
from eai.generator.prior import Combination, Nesting, Prior
from eai.logic.traversal import walk
from eai.world.relation import bits
from eai.world.state import Scene


def clash(goal: f.Formula, other: f.Formula, scene: Scene, prior: Prior) -> bool:
    """Whether two goals are too near each other to be wanted together.

    They are if both may say where the same thing is to be, or the same of it, or if one action meets both; if
    one says how a thing is to be and the other where, and no public task wants such a thing there; if one
    puts something where the other's thing is to be and none wants such things as places there; and if one
    puts things of a kind beside each other and the other puts such somewhere else.
    """
    if not _subjects(goal, scene).isdisjoint(_subjects(other, scene)):
        return True
    said, told = list(_said(goal, scene)), list(_said(other, scene))
    return bool(prior.kinds) and any(
        _is_strange(one, another, scene, prior) or _is_strange(another, one, scene, prior)
        for one in said
        for another in told
    )


def is_idle(goal: f.Formula, others: Iterable[f.Formula], scene: Scene, prior: Prior) -> bool:
    """Whether a goal is only wanted of what something else is wanted with, and no other goal wants that.

    A dishwasher is not run empty.
    """
    needy = [
        terms[0]
        for predicate, terms in _said(goal, scene)
        if len(terms) == 1 and (predicate, _category(terms[0], scene)) in prior.needy
    ]
    places = [terms[1] for other in others for _, terms in _said(other, scene) if len(terms) == 2]
    return any(not any(mask & place for place in places) for mask in needy)


class _Said(NamedTuple):
    """A literal with what each of its terms may be, as masks."""

    predicate: str
    terms: tuple[int, ...]


def _said(goal: f.Formula, scene: Scene) -> Iterator[_Said]:
    """What a goal says of objects."""
    ranges: dict[str, int] = {}
    for part in walk(goal):
        match part:
            case f.ForAll(variable) | f.Exists(variable) | f.Exactly(variable=variable):
                ranges[variable.name] = scene.category(variable.category)
            case f.ForPairs(first, second):
                ranges |= {v.name: scene.category(v.category) for v in (first, second)}
            case f.Atom(predicate, terms):
                masks = [
                    ranges[term.name] if isinstance(term, f.Variable) else 1 << scene.index[term.name]
                    for term in terms
                ]
                yield _Said(predicate, tuple(masks))


def _is_strange(said: _Said, other: _Said, scene: Scene, prior: Prior) -> bool:
    """Whether nobody wants one thing to be so while the other is there: food on a plate that is put away."""
    if len(other.terms) < 2:
        return False
    moved, place = other.terms
    if len(said.terms) < 2:
        combined = Combination(said.predicate, other.predicate, _category(place, scene))
        return any(mask & moved for mask in said.terms) and combined not in prior.combinations
    thing, its_place = said.terms
    nesting = Nesting(said.predicate, _category(its_place, scene), other.predicate)
    if its_place & moved and nesting not in prior.nestings:
        return True
    kind = _category(thing, scene)
    return kind == _category(its_place, scene) == _category(moved, scene) != _category(place, scene)


def _category(mask: int, scene: Scene) -> str:
    """The category of the first object of a mask."""
    return scene.objects[next(bits(mask))].category


def _subjects(goal: f.Formula, scene: Scene) -> set[tuple[str, int]]:
    """Each state that a goal speaks of with each object that it may be said of; relations of a thing are one.

    Actions have no object.
    """
    found = {(part.action, -1) for part in walk(goal) if isinstance(part, f.Occurs)}
    for predicate, (first, *others) in (said for said in _said(goal, scene) if said.terms):
        found.update(("" if others else predicate, i) for i in bits(first))
    return found


def subjects_of(goal: f.Formula, scene: Scene) -> frozenset[int]:
    """The objects of which a goal may say something."""
    return frozenset({index for _, index in _subjects(goal, scene)})
