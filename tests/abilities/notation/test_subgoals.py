from __future__ import annotations

import json

import pytest

from abilities.subgoal_decomposition.test_scorer import TASK
from eai.abilities.notation.subgoals import SubgoalNotation, WrittenSubgoals
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.verdict import Unreadable
from eai.logic.formula import Atom, Constant, Not, Variable
from eai.logic.ltl import map_formula_safe_names_to_original_names
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.effect import Add, Delete
from eai.world.operator import Operator, missing_step
from eai.world.state import Scene, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

NOTATION = SubgoalNotation(toy.DOMAIN)


def steps(*texts: str) -> list[Action]:
    index = TASK.scene.index
    return [Action(name, tuple([index[i] for i in names])) for name, *names in map(str.split, texts)]


def test_each_action_is_written_as_its_effects_on_its_objects() -> None:
    plan = steps("LIFT red", "GO shed", "DROP red", "PRESS lamp", "PRESS lamp")
    assert NOTATION.write(TASK, plan) == (
        "holding(red)",
        "at(robot, shed) and at(red, shed)",
        "not holding(red)",
        "lit(lamp)",
        "not lit(lamp)",
    )


def test_impossible_actions_are_left_out_and_actions_without_effect_are_named() -> None:
    wave = Operator("WAVE-AT", (toy.X,), (), ())
    notation = SubgoalNotation(toy.DOMAIN.replace_operators(wave))
    assert notation.write(TASK, steps("DROP red", "WAVE-AT red")) == ("WAVE_AT(red)",)


def test_subgoals_are_joined_and_read() -> None:
    text = NOTATION.join(["lit(lamp)", "holding(red)"])
    assert json.loads(text) == {"output": ["lit(lamp)", "holding(red)"]}
    assert NOTATION.read(f"So:\n```json\n{text}\n```") == WrittenSubgoals(
        ("lit(lamp)", "holding(red)"), ("code_fence",)
    )
    assert isinstance(NOTATION.read('{"output": "lit(lamp)"}'), Unreadable)


def test_names_without_arguments_need_no_brackets() -> None:
    rest = Operator("REST", (), (), ())
    notation = SubgoalNotation(toy.DOMAIN.replace_operators(rest))
    assert notation.read('{"output": ["REST", "", "now"]}') == WrittenSubgoals(
        ("REST()", "now"), ("brackets",)
    )


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("AT(bed) and REST", "AT(bed) and REST()"),
        ("(REST or AT(bed))then REST", "(REST() or AT(bed))then REST()"),
        ("not(REST)", "not(REST())"),
        ("REST and REST", "REST() and REST()"),
        ("REST() and  not REST", "REST() and  not REST()"),
        ("AT(REST) and forall REST. (AT(REST)) and x = REST", None),
        ("exists x: REST. (ON(x, REST))", None),
        ("AT(bed) and RESTS", None),
    ],
)
def test_a_name_without_objects_needs_no_brackets_beside_others(written: str, read: str | None) -> None:
    rest = Operator("REST", (), (), ())
    found = SubgoalNotation(toy.DOMAIN.replace_operators(rest)).read(json.dumps({"output": [written]}))
    assert found == WrittenSubgoals((read or written,), () if read is None else ("brackets",))


@pytest.mark.parametrize(
    ("key", "text", "is_read"),
    [
        ("output2", "on(b)", False),
        ("more", "then on(b)", False),
        ("more", "on(b), on(c)", False),
        ("reasoning", "on(b)", True),
        ("note", "No other step(s) are needed.", True),
        ("necessity_to_use_action", "yes", True),
    ],
)
def test_a_text_beside_subgoals_is_no_subgoal(key: str, text: str, is_read: bool) -> None:
    answer = NOTATION.read(json.dumps({"output": ["on(a)"], key: text}))
    assert isinstance(answer, WrittenSubgoals) is is_read


@pytest.mark.parametrize(
    ("beside", "is_read"),
    [
        (', "lit(lamp)", "lit(red)"]}', False),
        (', shed)", "lit(lamp)"]}', False),
        ("]}", True),
        ("\nlit(lamp), lit(red)", False),
        ("\nlit(lamp) then lit(red)", False),
        ("\nFinally: lit(lamp)", False),
        ("\nAnswer (JSON)", True),
        ("\nFinally, lit(lamp) holds.", True),
        ('\n---\n{"output": ["lit(red)"]}', False),
        ('\nStep 2:\n{"output": ["lit(red)"]}', False),
        ('\nThe form is {"output": []}.', True),
        ('\nThe form is {"output": ["state(object)", "..."]}.', True),
    ],
)
def test_a_text_after_subgoals_is_prose_or_the_answer_is_unreadable(beside: str, is_read: bool) -> None:
    answer = NOTATION.read(f'{{"output": ["holding(red)"]}}{beside}')
    assert isinstance(answer, WrittenSubgoals) is is_read
    assert getattr(answer, "subgoals", ("holding(red)",)) == ("holding(red)",)


def test_the_last_subgoals_with_known_names_count() -> None:
    answer = NOTATION.read('{"output": ["lit(lamp)"]} No: {"output": ["not at(red, shed)"]}')
    assert isinstance(answer, WrittenSubgoals)
    assert answer.subgoals == ("not at(red, shed)",)


def test_a_text_without_a_formula_is_kept_unchanged() -> None:
    notation = SubgoalNotation(toy.DOMAIN.replace_operators(Operator("REST", (), (), ())))
    assert notation.read('{"output": ["go and REST now"]}') == WrittenSubgoals(("go and REST now",))


def test_names_are_spelt_as_formulas_can_have_them() -> None:
    assert map_formula_safe_names_to_original_names(["a-b", "a_b", "sofa.12", "t-shirt.3", "3d"]) == {
        "a_b": "a-b",
        "a_b_": "a_b",
        "sofa.12": "sofa.12",
        "t_shirt.3": "t-shirt.3",
        "_3d": "3d",
    }
    assert list(map_formula_safe_names_to_original_names(["a1", "_", "_a"])) == ["a1", "_", "_a"]


def test_a_domain_is_scored_by_its_own_spelling() -> None:
    on_table, clear = Predicate("on-table", 1), Predicate("hand empty", 0)
    x = Variable("x")
    pick = Operator(
        "pick-up", (x,), (missing_step(on_table(x), "no"),), (Delete(on_table(x)), Delete(clear()))
    )
    put = Operator("put-down", (x,), (missing_step(~on_table(x), "no"),), (Add(on_table(x)), Add(clear())))
    domain = Domain("blocks", Vocabulary((on_table, clear)), (pick, put))
    scene = Scene(domain.vocabulary, [WorldObject("a-1", "block"), WorldObject("b", "block")])
    start = scene.state([("on-table", (0,)), ("on-table", (1,)), ("hand empty", ())])
    goal = Goal(GoalKind.STATE, Not(Atom("on-table", (Constant("a-1"),))))
    task = Task("1", "Blocks", "Lift it.", start, (goal,), (0, 1))
    notation = SubgoalNotation(domain)
    subgoals = notation.write(task, [Action("pick-up", (0,))])
    assert subgoals == ("not on_table(a_1)",)
    scorer = SubgoalDecompositionScorer(task, domain)
    assert scorer.score(notation.join(subgoals)).success
    assert scorer.score('{"output": ["pick_up(a_1)", "not hand_empty"]}').repairs == ("brackets",)
    assert scorer.score('{"output": ["pick_up(a_1)"]}').success


def test_a_line_of_punctuation_is_refused_in_linear_time() -> None:
    assert isinstance(NOTATION.read("." * 60_000), Unreadable)
