"""Tests of the public library, `import eai`, as a reader of README uses it."""

from __future__ import annotations

import pytest

import eai
from eai.base.store import DataPackStore


def test_an_answer_is_scored_in_one_line(data_store: DataPackStore) -> None:
    suite = eai.open("virtualhome", "action_sequencing", source=eai.Source(data_store))
    verdict = suite.score("27_2", '{"WALK": ["washing_machine", "1001"]}')
    assert (verdict.error, verdict.success) == (None, False)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            ("mars", "action_sequencing"),
            "'mars' is not a benchmark: expected virtualhome, behavior, ",
        ),
        (("virtualhome", "cooking"), "'cooking' is no ability: expected one of goal_interpretation, "),
        (
            ("virtualhome", "action_sequencing", "lenient"),
            "'lenient' is no protocol: expected one of strict, ",
        ),
        (("no.such.module:x", "action_sequencing"), "no.such.module:x: the module cannot be imported"),
        (
            ("eai.base.errors:nothing", "action_sequencing"),
            "eai.base.errors:nothing: eai.base.errors has no object 'nothing'",
        ),
        (
            ("eai.base.errors:EaiError", "action_sequencing"),
            "eai.base.errors:EaiError: expected a Benchmark, found EaiError",
        ),
    ],
)
def test_what_there_is_not_is_named(arguments: tuple[str, ...], told: str) -> None:
    with pytest.raises(eai.InputError) as error:
        eai.open(*arguments)
    assert str(error.value).startswith(told)


def test_a_name_that_there_is_not_is_an_error_of_the_program() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = eai.nothing
