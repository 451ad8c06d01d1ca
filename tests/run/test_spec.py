"""The specification of a run: its sections, its contradictions, and its file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.base.errors import InputError
from eai.base.files import read_toml
from eai.run.spec import RunSpec, find_study_of_option, read_spec, save_spec
from eai.studies.perception.choice import ScenePresentationOptions
from eai.studies.perception.noise import PerceptionNoise
from eai.studies.registry import list_studies_with_run_options

EVERYTHING: dict[str, dict[str, Any]] = {
    "model": {"name": ["openai/gpt-4o"], "args": {"rate": 0.2, "deep": {"a b": [1, True]}, "limit": 1e-9}},
    "tasks": {"domain": "pddl:a.pddl,b/", "ability": ["action_sequencing"], "limit": "3"},
    "prompts": {"set": "eai", "folder": "my prompts", "name": "base"},
    "generation": {"seed": 1, "reasoning_effort": "low", "stop": "false"},
    "requests": {"batch": True},
    "scoring": {"protocol": "eai-1.0.5", "planner": "none"},
    "perception": {"scene": "noisy", "noise": ["missing=0.1", "seed=2"]},
}


ONWARD = {"replans": 1, "world": "continue"}
"""Further attempts in a world that continues."""


@pytest.mark.parametrize(
    "tables",
    [
        {"replanning": {"slip": 0.1, "replans": 2}, "pipeline": {"goals": "own"}},
        {"replanning": ONWARD, "perception": {"scene": "both"}, "pipeline": {"goals": "own"}},
        {"replanning": ONWARD, "perception": {"context": "some"}},
        {"replanning": {**ONWARD, "feedback": "none"}, "perception": {"scene": "rendered"}},
        {"replanning": {"replans": 1}, "perception": {"scene": "predicted", "scene_model": "eai/captioner"}},
        {"pipeline": {"goals": "own"}, "perception": {"scene": "numbered"}, "prompts": {"name": "mine"}},
    ],
)
def test_studies_that_change_different_options_are_combined(tables: dict[str, Any]) -> None:
    """A run of all studies has the abilities that each can vary, and the names of all."""
    spec = read_spec(tables)
    choices = {
        each.option_that_enables_study for each in spec.studies.values() if each.option_that_enables_study
    }
    assert {*spec.combined_options_of_studies.option_that_enables_study.split(" and ")} == choices
    assert set(spec.combined_options_of_studies.select_abilities([])) <= {
        ability for each in spec.studies.values() for ability in each.select_abilities([])
    }


def test_a_specification_is_read_as_it_was_written(tmp_path: Path) -> None:
    spec = read_spec(EVERYTHING)
    assert spec.tasks.limit == 3
    assert not spec.generation.stop
    perception = spec.studies["perception"]
    assert isinstance(perception, ScenePresentationOptions)
    assert perception.noise == PerceptionNoise(missing=0.1, seed=2)
    file = save_spec(spec, tmp_path)
    assert file == tmp_path / "run.toml"
    assert read_spec(read_toml(file)) == spec
    assert save_spec(spec, tmp_path) == file
    assert save_spec(RunSpec(), tmp_path) == tmp_path / "run-2.toml"
    assert read_spec(read_toml(tmp_path / "run-2.toml")) == RunSpec()


@given(
    st.dictionaries(
        st.text(st.characters(exclude_categories=["Cs"])).filter(lambda name: not name.endswith("key")),
        st.recursive(
            st.text(st.characters(exclude_categories=["Cs"]))
            | st.booleans()
            | st.integers()
            | st.floats(-9, 9),
            lambda inner: st.lists(inner, max_size=3),
            max_leaves=5,
        ),
        max_size=3,
    )
)
def test_any_arguments_are_read_as_they_were_written(
    tmp_path_factory: pytest.TempPathFactory, arguments: dict[str, Any]
) -> None:
    spec = read_spec({"model": {"args": arguments}})
    assert read_spec(read_toml(save_spec(spec, tmp_path_factory.mktemp("run")))) == spec


def test_each_option_belongs_to_one_study() -> None:
    """Therefore Inspect's arguments do not name a study."""
    names = [name for study in list_studies_with_run_options() for name in study.options.model_fields]
    assert [find_study_of_option(name) for name in names] == [
        s.name for s in list_studies_with_run_options() for _ in s.options.model_fields
    ]


def test_a_name_with_lone_surrogates_can_be_saved(tmp_path: Path) -> None:
    assert save_spec(read_spec({"pipeline": {"goals": "a\udc80"}}), tmp_path).is_file()


def test_keys_of_servers_are_never_written_to_a_file(tmp_path: Path) -> None:
    arguments = {
        "api_key": "sk-1",
        "HF_TOKEN": "sk-2",
        "password": "sk-3",
        "default_headers": {"Authorization": "sk-4"},
        "max_tokens": 5,
    }
    seen = {"scene": "predicted", "scene_model": "openai/gpt-4o", "scene_args": arguments}
    text = save_spec(read_spec({"model": {"args": arguments}, "perception": seen}), tmp_path).read_text()
    assert "sk-" not in text
    assert text.count("max_tokens = 5") == 2


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"replaning": {}}, "replaning: unknown; did you mean replanning?"),
        (
            {"replanning": {"replan": 1}},
            "replanning.replan: unknown; did you mean replans? (replanning has replans, ",
        ),
        ({"replanning": 3}, "replanning: expected "),
        ({"generation": {"top_p": 2}}, "generation.top_p: expected less than or equal to 1, found 2"),
        ({"perception": {"scene": "noisy", "noise": {"mising": 1}}}, "noise mising=1: expected NAME=NUMBER"),
        (
            {"tasks": {"adaptive": 0.5}, "perception": {"scene": "image"}},
            "tasks.adaptive: cannot be combined with perception.scene image; "
            "adaptive runs choose tasks by the difficulty ",
        ),
        (
            {"replanning": ONWARD, "perception": {"scene": "rendered"}},
            "perception.scene rendered: cannot be combined with replanning.replans, "
            "slip or until; the scene is only shown ",
        ),
        (
            {"replanning": {**ONWARD, "feedback_form": "chat"}, "perception": {"scene": "image"}},
            "perception.scene image: cannot be combined with replanning.replans, slip or until; "
            "a chat cannot show pictures ",
        ),
        (
            {"perception": {"scene": "noisy", "noise": {"missing": 0.1}, "context": "some"}},
            "perception.context: has no effect with perception.scene noisy",
        ),
    ],
)
def test_invalid_specifications_are_refused(tables: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as error:
        read_spec(tables)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(
    ("text", "message"), [("[model", "expected TOML; "), (None, "cannot be read (No such")]
)
def test_invalid_specification_files_are_refused(tmp_path: Path, text: str | None, message: str) -> None:
    file = tmp_path / "run.toml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(InputError) as error:
        read_toml(file)
    assert str(error.value).startswith(f"{file}: {message}")
