from __future__ import annotations

import json
from pathlib import Path

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.tasks.prompts.prompt import PromptSet
from eai.tasks.prompts.template import list_template_names
from eai.tasks.source import Source
from suites import SUITES

SUITE = (find_benchmark("behavior"), Ability.SUBGOAL_DECOMPOSITION)
TASK = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"


def make_library(store: DataPackStore, folder: Path | None, prompts: PromptSet = "official") -> PromptLibrary:
    return PromptLibrary(prompts, folder, Source(store))


def test_a_users_files_replace_single_prompts(data_store: DataPackStore, tmp_path: Path) -> None:
    official = make_library(data_store, None).open(*SUITE)
    rows = [{"identifier": f"scene_1_{TASK}", "llm_prompt": "mine"}]
    (tmp_path / "behavior_subgoal_decomposition.json").write_text(json.dumps(rows))
    (tmp_path / "behavior_subgoal_decomposition_system.json").write_text('{"system_prompt": "be brief"}')
    opened = make_library(data_store, tmp_path).open(*SUITE)
    assert opened[TASK].user == "mine"
    assert {prompt.system for prompt in opened.values()} == {"be brief"}
    assert [i for i in opened if opened[i].user != official[i].user] == [TASK]
    assert opened[TASK].sha256 != official[TASK].sha256
    assert make_library(data_store, tmp_path).open(find_benchmark("behavior"), Ability.ACTION_SEQUENCING)


def test_questions_that_a_user_replaces_are_not_corrected_by_errata(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    benchmark, official = find_benchmark("virtualhome"), make_library(data_store, None)
    errata = benchmark.get_errata(official.source)
    ability = next(each for each in PAPER_ABILITIES if len(errata.find_corrected_tasks(each)) > 1)
    corrected = sorted(errata.find_corrected_tasks(ability))
    other = next(i for i in official.open(benchmark, ability) if i not in corrected)
    rows = [{"identifier": i, "llm_prompt": "mine"} for i in (corrected[0], other)]
    (tmp_path / f"virtualhome_{ability.value}.json").write_text(json.dumps(rows))
    counts = [
        library.count_questions_corrected_by_errata(benchmark, ability, [*corrected, other])
        for library in (official, make_library(data_store, tmp_path))
    ]
    assert counts == [len(corrected), len(corrected) - 1]


def test_a_users_templates_replace_single_templates(data_store: DataPackStore, tmp_path: Path) -> None:
    (tmp_path / "subgoal_decomposition.txt").write_text("Only this: $task")
    opened = make_library(data_store, tmp_path, "eai").open(*SUITE)
    assert opened[TASK].user.startswith("Only this: Task: assembling_gift_baskets")


def test_unusable_prompt_files_are_an_error(data_store: DataPackStore, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a folder of prompts"):
        make_library(data_store, tmp_path / "none").open(*SUITE)
    with pytest.raises(InputError, match="expected a folder of prompts"):
        make_library(data_store, tmp_path).open(*SUITE)
    (tmp_path / "behavior_subgoal_decomposition.json").write_text('[{"identifier": "x", "llm_prompt": "?"}]')
    with pytest.raises(InputError, match="identifier 'x' is not one of the tasks"):
        make_library(data_store, tmp_path).open(*SUITE)


@pytest.mark.parametrize(
    "name",
    [
        "behaviour_action_sequencing.json",
        "behavior_action_sequencing.jsonl",
        "action_sequences.txt",
        "formats/x.txt",
        "a/example.txt",
    ],
)
def test_a_file_that_replaces_nothing_is_an_error(
    data_store: DataPackStore, tmp_path: Path, name: str
) -> None:
    """Otherwise a typing error in a name would silently change nothing."""
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("[]")
    with pytest.raises(
        InputError, match=f"{name}: no prompt or template has this name; expected <domain>_<ability>.json"
    ):
        make_library(data_store, tmp_path).open(*SUITE)


def test_every_file_that_replaces_a_prompt_or_template_is_accepted(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    for folder in {Path(name).parent for name in list_template_names()}:
        (tmp_path / folder).mkdir(exist_ok=True)
    (tmp_path / "formats/virtualhome_action_sequencing.txt").write_text("mine")
    for name in list_template_names():
        (tmp_path / name).write_text("mine")
    for domain, ability in SUITES:
        (tmp_path / f"{domain}_{ability.value}.json").write_text("[]")
        (tmp_path / f"{domain}_{ability.value}_system.json").write_text('{"system_prompt": "mine"}')
    (tmp_path / "README.md").write_text("why")
    assert {prompt.system for prompt in make_library(data_store, tmp_path).open(*SUITE).values()} == {"mine"}
