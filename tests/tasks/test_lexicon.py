from __future__ import annotations

import pytest

from abilities.subgoal_decomposition.test_scorer import TASK
from eai.base.errors import InputError
from eai.logic.formula import Atom, Constant, Equals, Exists, Not, Occurs, Variable
from eai.logic.signature import FormulaSignature
from eai.planning.subgoal import GroundAtom
from eai.tasks.lexicon import FormulaNameLexicon
from eai.world.action import Action
from world import toy

LEXICON = FormulaNameLexicon(
    TASK.scene,
    FormulaSignature({"shining": 1, "lit": 1, "seen": 1, "box_of": 1}),
    {"lamp": 5, "lamp.1": 5, "red": 3},
    predicates={"shining": "lit"},
    actions={"press": "PRESS"},
    categories={"box_of": "box"},
    unobserved={"seen"},
)


def test_a_literal_is_said_in_the_words_of_the_domain() -> None:
    shining = Atom("shining", (Constant("lamp"),))
    assert LEXICON.to_literal(Not(shining)) == GroundAtom("lit", (5,), truth=False)
    for text in ("seen", "box_of"):
        assert LEXICON.to_literal(Atom(text, (Constant("lamp"),))) is None
    assert LEXICON.to_literal(Atom("lit", (Variable("x"),))) is None
    assert LEXICON.to_literal(Not(Not(shining))) is None


def test_what_the_domain_says_is_said_in_the_words_of_subgoals() -> None:
    dark = GroundAtom("lit", (5,), truth=False)
    assert LEXICON.convert_literal_to_formula(dark) == Not(Atom("lit", (Constant("lamp.1"),)))
    assert LEXICON.convert_action_to_formula(Action("PRESS", (3,))) == Occurs("press", (Constant("red"),))
    hidden = FormulaNameLexicon(
        TASK.scene, FormulaSignature({"shining": 1}), {"lamp": 5}, predicates={"shining": "lit"}
    )
    assert hidden.convert_literal_to_formula(GroundAtom("lit", (5,), truth=True)) == Atom(
        "shining", (Constant("lamp"),)
    )


def test_a_predicate_of_two_names_keeps_its_own_in_texts() -> None:
    literal = GroundAtom("lit", (5,), truth=True)
    assert LEXICON.convert_literal_to_formula(literal) == Atom("lit", (Constant("lamp.1"),))
    of_domain = Atom("lit", (Constant("lamp"),))
    assert LEXICON.replace_domain_names_by_lexicon_names(of_domain) == Atom("lit", (Constant("lamp.1"),))


def test_a_formula_means_something_in_the_domain() -> None:
    x = Variable("x")
    said = Exists(x, Atom("shining", (x,)) & Equals(x, Constant("lamp.1")) & Atom("box_of", (x,)))
    meant = LEXICON.replace_lexicon_names_by_domain_names(said)
    assert toy.DOMAIN.holds(meant, TASK.initial) is False
    assert LEXICON.replace_lexicon_names_by_domain_names(Occurs("press", (Constant("lamp.1"),))) == Occurs(
        "PRESS", (Constant("lamp"),)
    )
    assert LEXICON.has_unknown_names(Not(Atom("seen", (x,))))


def test_an_action_is_about_objects() -> None:
    assert LEXICON.to_action(Occurs("press", (Constant("red"),))) == Action("PRESS", (3,))
    with pytest.raises(InputError, match="expected the names of objects"):
        LEXICON.to_action(Occurs("press", (Constant("box"),)))
