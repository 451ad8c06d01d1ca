"""Compare the option with the largest share of met conditions with all options written out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from fractions import Fraction
from itertools import chain, product
from random import Random

import pytest

import eai.logic.formula as f
from eai.logic.choice import (
    AndOrTree,
    build_and_or_tree,
    count_dnf_terms_of_tree,
    generate_dnf_terms_of_tree,
)
from eai.logic.ltl import parse
from eai.tasks import best_option
from logic.random_goals import objects, random_goal
from sweeps import every


def best_of(*goals: str, met: str = "", others: int = 0, others_met: int = 0) -> tuple[int, int, bool]:
    """Return the best share if the conditions in `met`, separated by blanks, are true."""
    best = best_option.make_finder_of_most_satisfied_goal_option(
        [build_and_or_tree(parse(goal), objects) for goal in goals], others
    )
    true = {str(parse(text)) for text in met.split()}
    known = {str(atom): 1 << number for number, atom in enumerate(best.atoms)}
    return best(sum([known[text] for text in true]), others_met)


def listed_best(
    choices: Sequence[AndOrTree], true: Set[f.Atom], others: int, others_met: int
) -> tuple[int, int] | None:
    """The best share by writing out all options; of equal ones the shortest."""
    best: tuple[Fraction, int, int] | None = None
    for ways in product(*[list(generate_dnf_terms_of_tree(choice)) for choice in choices]):
        conditions = frozenset(chain.from_iterable(ways))
        negated = {each.operand for each in conditions if isinstance(each, f.Not)}
        if negated & conditions:
            continue
        met = len(conditions & true) + len(negated - true) + others_met
        total = len(conditions) + others
        rank = Fraction(1) if not total else Fraction(met, total), -total, met
        best = rank if best is None else max(best, rank)
    return None if best is None else (best[2], -best[1])


def test_a_condition_of_a_quantified_goal_counts_by_itself() -> None:
    assert best_of("forall x: cup. (clean(x))", met="clean(cup1) clean(cup3)") == (2, 3, True)


def test_conditions_that_always_stand_in_the_goal_are_counted() -> None:
    assert best_of("exists x: cup. (clean(x))", met="clean(cup2)", others=3, others_met=1) == (2, 4, True)


def test_the_best_option_of_a_part_may_not_be_that_of_the_goal() -> None:
    """By itself 3 of 6 is better than 0 of 1; beside twelve conditions that are met it is worse."""
    part = "clean(cup1) or (beside(cup1, cup1) and beside(cup1, cup2) and beside(cup1, cup3) and "
    part += "beside(cup1, box1) and beside(cup1, box2) and beside(cup1, box3))"
    half = "beside(cup1,cup1) beside(cup1,cup2) beside(cup1,cup3)"
    assert best_of(part, met=half) == (3, 6, True)
    assert best_of(part, met=half, others=12, others_met=12) == (12, 13, True)


def test_of_equal_shares_the_one_with_the_fewest_conditions_is_told() -> None:
    goal = "(clean(cup1) and clean(cup2)) or "
    goal += "(clean(box1) and clean(box2) and beside(box1, box2) and clean(box3))"
    assert best_of(goal, met="clean(cup1) clean(box1) clean(box2)") == (1, 2, True)
    assert best_of(goal) == (0, 2, True)


def test_a_condition_that_two_parts_demand_counts_once() -> None:
    assert best_of("clean(cup1)", "forall x: cup. (clean(x))", met="clean(cup1)") == (1, 3, True)


def test_a_condition_that_two_parts_can_choose_counts_once() -> None:
    """Both parts choose `clean(cup1)`, or one of them a condition that is not met."""
    choose_one = "exists x: cup. (clean(x))"
    assert best_of(choose_one, choose_one, "clean(box1)", met="clean(cup1)") == (1, 2, True)
    assert best_of(choose_one, choose_one, "clean(box1)", met="clean(cup1) clean(cup2)") == (2, 3, True)


def test_no_option_contains_a_condition_and_its_negation() -> None:
    goal = "clean(cup1) or clean(cup2)", "not clean(cup1) or beside(cup1, cup2)"
    assert best_of(*goal, met="clean(cup1)") == (1, 2, True)


def test_a_goal_without_options_has_no_share() -> None:
    assert best_of("clean(cup1)", "not clean(cup1)", met="clean(cup1)") == (0, 1, True)
    assert best_of("cup1 = cup2", "clean(cup1)", met="clean(cup1)") == (0, 1, True)


def test_pairs_are_matched_so_that_most_conditions_are_met() -> None:
    goal = "forpairs x: cup, y: box. (beside(x, y))"
    met = "beside(cup1,box1) beside(cup1,box2) beside(cup2,box1)"
    assert best_of(goal, met=met) == (2, 3, True)


@pytest.mark.parametrize("size", [20])
def test_many_options_are_never_written_out(size: int) -> None:
    names = [f"o{number}" for number in range(size)]
    goal = f.ForAll(
        f.Variable("x"), f.Exists(f.Variable("y"), f.Atom("beside", (f.Variable("x"), f.Variable("y"))))
    )
    pairs = f.ForPairs(f.Variable("x"), f.Variable("y"), f.Atom("near", (f.Variable("x"), f.Variable("y"))))
    choices = [
        build_and_or_tree(goal, lambda category: names),
        build_and_or_tree(pairs, lambda category: names),
    ]
    assert count_dnf_terms_of_tree(choices[0]) == size**size
    best = best_option.make_finder_of_most_satisfied_goal_option(choices)
    assert best(0) == (0, 2 * size, True)
    assert best((1 << len(best.atoms)) - 1) == (2 * size, 2 * size, True)


def test_a_share_that_may_not_be_the_largest_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, names = Random(1), [f"o{number}" for number in range(40)]
    parts = [_both(rng.sample(names, 4)) for _ in range(30)]
    best = best_option.make_finder_of_most_satisfied_goal_option(
        [build_and_or_tree(part, lambda category: names) for part in parts]
    )
    true = rng.getrandbits(40)
    largest = best(true)
    assert largest == (21, 27, True)
    monkeypatch.setattr(best_option, "_MAX_UNPRUNED_SETS", 1)
    monkeypatch.setattr(best_option, "_MAX_SETS", 2)
    bound = best(true)
    assert not bound.is_exact
    assert 0 < bound.met / bound.total <= largest.met / largest.total


def _both(names: Sequence[str]) -> f.Formula:
    one, two, three, four = [f.Atom("clean", (f.Constant(name),)) for name in names]
    return f.Or((f.And((one, two)), f.And((three, four))))


@every(10)
def test_the_share_is_that_of_all_options_written_out(every: int) -> None:
    for seed in range(0, 300, every):
        rng = Random(seed)
        choices, others = random_choices(rng), rng.randint(0, 2)
        best = best_option.make_finder_of_most_satisfied_goal_option(choices, others)
        for density in (0.1, 0.5, 0.9):
            true = frozenset(
                [atom for atom in best.atoms if isinstance(atom, f.Atom) and rng.random() < density]
            )
            others_met = rng.randint(0, others)
            listed = listed_best(choices, true, others, others_met)
            share = best(as_mask(best.atoms, true), others_met)
            assert (share.met, share.total) == (listed or (0, 1)), seed
            assert share.is_exact


def as_mask(atoms: Iterable[f.Atom | f.Occurs], true: Set[f.Atom]) -> int:
    return sum([1 << number for number, atom in enumerate(atoms) if atom in true])


def random_choices(rng: Random) -> list[AndOrTree]:
    """Random parts of a goal, with more than one option and not too many to be written out."""
    while True:
        goals = [random_goal(rng, rng.randint(0, 3)) for _ in range(rng.randint(1, 4))]
        choices = [build_and_or_tree(goal, objects) for goal in goals]
        number = 1
        for choice in choices:
            number *= count_dnf_terms_of_tree(choice)
        if 1 < number < 3_000:
            return choices
