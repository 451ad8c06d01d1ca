from __future__ import annotations

from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.results.answer_files import (
    find_benchmarks_of_runs,
    find_files_of_suite,
    find_response_file_of_suite,
)
from eai.results.responses import format_attempt_name

PLANS, GOALS = Ability.ACTION_SEQUENCING, Ability.GOAL_INTERPRETATION


def file(place: Path) -> Path:
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text("[]")
    return place


@pytest.mark.parametrize(
    "place",
    [
        "virtualhome/action_sequencing/m_outputs.json",
        "virtualhome/action_sequencing/m/m_outputs.json",
        "virtualhome_action_sequencing_outputs.json",
        "challenge/virtualhome_action_sequencing_outputs.json",
    ],
)
def test_a_folder_has_a_file_for_each_suite(tmp_path: Path, place: str) -> None:
    wanted = file(tmp_path / place)
    file(tmp_path / "virtualhome" / "goal_interpretation" / "m_outputs.json")
    file(tmp_path / "behavior" / "action_sequencing" / "m_outputs.json")
    file(tmp_path / "behavior_action_sequencing_outputs.json")
    assert find_response_file_of_suite(tmp_path, "virtualhome", PLANS) == wanted


@pytest.mark.parametrize("place", ["m_outputs.json", "behavior/action_sequencing/m_outputs.json"])
def test_the_only_file_of_a_folder_is_not_taken_for_every_suite(tmp_path: Path, place: str) -> None:
    file(tmp_path / place)
    with pytest.raises(InputError, match=r"expected one file .*virtualhome/action_sequencing/.*, found none"):
        find_response_file_of_suite(tmp_path, "virtualhome", PLANS)


def test_a_folder_may_have_runs_with_one_attempt_and_with_several(tmp_path: Path) -> None:
    file(tmp_path / "lamps" / "goal_interpretation" / "m_outputs.json")
    first, second = (
        file(tmp_path / "lamps" / "action_sequencing" / f"{format_attempt_name('m', number)}_outputs.json")
        for number in (1, 2)
    )
    assert find_response_file_of_suite(tmp_path, "lamps", PLANS) == first
    assert find_response_file_of_suite(tmp_path, "lamps", PLANS, attempt=2) == second


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('tasks = ["a"]', []),
        ("[tasks]\ndomain = 5", []),
        ("[tasks]\ndomain = [5]", []),
        ('[tasks]\ndomain = "agents.switches:SWITCHES"', ["switches"]),
        ('[tasks]\ndomain = ["agents.switches:SWITCHES"]', ["switches"]),
    ],
)
def test_a_run_file_of_another_program_is_ignored(tmp_path: Path, text: str, names: list[str]) -> None:
    (tmp_path / "run.toml").write_text(text)
    assert [*find_benchmarks_of_runs([tmp_path])] == names


def test_a_suite_with_files_of_two_models_is_refused(tmp_path: Path) -> None:
    for model in ("a", "b"):
        file(tmp_path / "lamps" / "action_sequencing" / f"{model}_outputs.json")
    with pytest.raises(InputError, match="found 2"):
        find_response_file_of_suite(tmp_path, "lamps", PLANS)


def test_a_file_is_used_unless_it_names_another_suite(tmp_path: Path) -> None:
    bare = file(tmp_path / "m_outputs.json")
    assert find_response_file_of_suite(bare, "virtualhome", PLANS) == bare
    assert find_response_file_of_suite(bare, "behavior", GOALS) == bare
    named = file(tmp_path / "virtualhome" / "action_sequencing" / "m_outputs.json")
    assert find_response_file_of_suite(named, "virtualhome", PLANS) == named
    placed = file(tmp_path / "answers" / "action_sequencing" / "m_outputs.json")
    assert find_response_file_of_suite(placed, "virtualhome", PLANS) == placed
    for domain, ability in (("virtualhome", GOALS), ("behavior", PLANS)):
        with pytest.raises(InputError, match="not to virtualhome action_sequencing"):
            find_response_file_of_suite(named, domain, ability)
    with pytest.raises(InputError, match="no such file"):
        find_response_file_of_suite(tmp_path / "none.json", "virtualhome", PLANS)


def test_files_of_other_suites_in_a_folder_are_ignored(tmp_path: Path) -> None:
    bare = file(tmp_path / "a_outputs.json")
    named = file(tmp_path / "virtualhome" / "action_sequencing" / "b_outputs.json")
    other = file(tmp_path / "virtualhome" / "goal_interpretation" / "b_outputs.json")
    assert find_files_of_suite(tmp_path, "virtualhome", PLANS) == [bare, named]
    assert find_files_of_suite(tmp_path, "virtualhome", GOALS) == [bare, other]
    assert find_files_of_suite(tmp_path, "behavior", PLANS) == [bare]
    for place in (other, other.parent):
        with pytest.raises(InputError, match="not to virtualhome goal_interpretation"):
            find_files_of_suite(place, "virtualhome", PLANS)
