"""Random goals with few objects and predicates, so that their parts share and contradict conditions."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import eai.logic.formula as f

CATEGORIES = {"cup": ("cup1", "cup2", "cup3"), "box": ("box1", "box2", "box3")}
NAMES = tuple(name for names in CATEGORIES.values() for name in names)
_MEANS = ("and", "or", "implies", "forall", "forall", "exists", "exists", "forn", "forpairs")


def objects(category: str | None) -> Sequence[str]:
    return NAMES if category is None else CATEGORIES[category]


def random_goal(rng: Random, depth: int, scope: tuple[str, ...] = ()) -> f.Formula:
    """Return a closed formula with a finite list of options, though perhaps an empty one."""
    if depth == 0 or rng.random() < 0.2:
        return _random_condition(rng, scope)
    means = rng.choice(_MEANS)
    if means in ("and", "or"):
        parts = tuple([random_goal(rng, depth - 1, scope) for _ in range(rng.randint(1, 3))])
        return f.And(parts) if means == "and" else f.Or(parts)
    if means == "implies":
        return f.Implies(_random_condition(rng, scope), random_goal(rng, depth - 1, scope))
    x, y = (f.Variable(f"x{len(scope) + i}", rng.choice([*CATEGORIES])) for i in range(2))
    if means == "forpairs":
        body = random_goal(rng, depth - 1, (*scope, x.name, y.name))
        return f.ForPairs(x, y, body, rng.choice([None, None, 1, 2]))
    body = random_goal(rng, depth - 1, (*scope, x.name))
    match means:
        case "forall":
            return f.ForAll(x, body)
        case "exists":
            return f.Exists(x, body)
        case _:
            return f.Exactly(rng.randint(0, 3), x, body)


def _random_condition(rng: Random, scope: tuple[str, ...]) -> f.Formula:
    def term() -> f.Term:
        if scope and rng.random() < 0.8:
            return f.Variable(rng.choice(scope))
        return f.Constant(rng.choice(NAMES))

    if rng.random() < 0.05:
        return f.Equals(term(), term())
    atom = f.Atom("clean", (term(),)) if rng.random() < 0.5 else f.Atom("beside", (term(), term()))
    return f.Not(atom) if rng.random() < 0.25 else atom
