from __future__ import annotations

from dataclasses import fields

import pytest

from eai.abilities.verdict import ConfusionCounts
from eai.results.rate import compute_rates
from eai.studies.perception.declaration import make_numerator_and_denominator_by_rate
from eai.studies.perception.errors import find_perception_errors
from eai.studies.perception.scene_graph import SceneGraph
from studies.perception.kitchen import TRUTH, WORDS, fact, kitchen_task, seen

ALL = ("in cup_1 box_1", "on box_1 table_1", "lit lamp_1")
ERRORS = ("missing", "misplaced", "unnecessary", "invented")


def test_a_scene_graph_has_the_objects_and_facts_of_the_prompt() -> None:
    assert TRUTH.facts == tuple(
        sorted(map(fact, ALL), key=lambda each: WORDS.wording.predicates.index(each[0]))
    )
    assert WORDS.holding_predicate_names == ("holds",)
    assert {*WORDS.placement_predicate_names} == {"in", "on"}


@pytest.mark.parametrize(
    ("facts", "errors"),
    [
        (ALL, (0, 0, 0, 0)),
        (ALL[1:], (1, 0, 0, 0)),
        (("in cup_1 table_1", *ALL[1:]), (0, 1, 0, 0)),
        (("on cup_1 box_1", *ALL[1:]), (1, 0, 1, 0)),  # another relation of the same two
        (("in lamp_1 box_1", *ALL[1:]), (1, 0, 1, 0)),  # the same relation of another thing
        ((*ALL, "in cup_1 table_1"), (0, 0, 1, 0)),  # nothing is lost for it
        (("in cup_1 table_1", "in cup_1 lamp_1", *ALL[1:]), (0, 1, 1, 0)),  # one fact accounts for one
        ((*ALL, "lit lamp_2"), (0, 0, 1, 0)),
        ((*ALL, "lit lamp_3"), (0, 0, 0, 1)),
        (("in cup_1 box_7", *ALL[1:]), (1, 0, 0, 1)),
        ((), (3, 0, 0, 0)),
    ],
)
def test_each_kind_of_perception_error_is_counted(facts: tuple[str, ...], errors: tuple[int, ...]) -> None:
    perceived = find_perception_errors(kitchen_task(), WORDS, seen(*facts))
    assert tuple(getattr(perceived, name) for name in ERRORS) == errors
    right, wrong, lost = map(sum, zip(*perceived.predicates.values(), strict=True))
    assert right + wrong == perceived.perceived
    assert right + lost == perceived.facts
    assert lost == perceived.missing + perceived.misplaced
    assert wrong == perceived.misplaced + perceived.unnecessary + perceived.invented


def test_each_error_rate_has_its_own_denominator() -> None:
    objects = ("robot", "cup_1", "box_1", "table_1", "lamp_1", "lamp_9")
    graph = seen("in cup_1 table_1", "lit lamp_9", "lit lamp_1", objects=objects)
    perceived = find_perception_errors(kitchen_task(), WORDS, graph)
    rates = compute_rates([make_numerator_and_denominator_by_rate(perceived)])
    told = {name: (rate.numerator, rate.denominator) for name, rate in rates.items() if "." not in name}
    assert told == {
        "predicate_error": (2, 3),
        "object_error": (1, 6),
        "missing": (1, 3),
        "misplaced": (1, 2),
        "unnecessary": (0, 3),
        "invented": (1, 3),
        "unseen": (1, 5),
    }
    assert perceived.predicates == {
        "in": ConfusionCounts(0, 1, 1),
        "lit": ConfusionCounts(1, 1, 0),
        "on": ConfusionCounts(0, 0, 1),
    }


def test_an_unreadable_answer_perceives_nothing() -> None:
    perceived = find_perception_errors(kitchen_task(), WORDS, SceneGraph(unreadable="prose"))
    assert (perceived.missing, perceived.unseen, perceived.unreadable) == (3, 5, True)
    assert {field.name for field in fields(perceived)} >= {*ERRORS}
