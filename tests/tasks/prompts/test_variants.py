"""Our prompts in other words: each wording states all rules and facts, and records name it."""

from __future__ import annotations

import re
from pathlib import Path
from string import Template

import pytest

from agents.switches import SWITCHES
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.store import Store
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.run.spec import read_spec
from eai.tasks.prompts.prompt import VARIANTS, PromptSet
from eai.tasks.prompts.template import Templates
from eai.tasks.source import Source

PLACE = re.compile(r"\$(\w+)")
SIDES = ("and", "or", "not", "exists", "forall", "when")


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
@pytest.mark.parametrize("variant", VARIANTS)
def test_a_wording_has_every_place_but_the_example(variant: PromptSet, ability: Ability) -> None:
    """The values of placeholders are the rules and facts; only an example may be left out."""
    plain, other = (Templates(variant=name).read(f"{ability.value}.txt") for name in ("eai", variant))
    assert plain != other
    assert set(PLACE.findall(plain)) - set(PLACE.findall(other)) <= {"example"}
    assert set(PLACE.findall(other)) <= set(PLACE.findall(plain))


@pytest.mark.parametrize("domain", ["behavior", "virtualhome"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_a_question_states_what_the_plain_one_states(
    domain: str, variant: PromptSet, data_store: Store
) -> None:
    """Vocabulary, rules, objects, start and goals are word for word those of the other question."""
    source, benchmark = Source(data_store), find_benchmark(domain)
    for ability in PAPER_ABILITIES:
        if ability is Ability.TRANSITION_MODELING:
            continue
        plain, other = (
            PromptLibrary(name, None, source).open(benchmark, ability) for name in ("eai", variant)
        )
        wording, tasks = benchmark.wording(ability), benchmark.tasks_for(ability, source)
        for task_id in list(plain)[:3]:
            task, question = tasks[task_id], other[task_id].user
            facts = [
                wording.describe_vocabulary(),
                wording.describe_objects(task),
                wording.describe_initial(task),
            ]
            if ability is Ability.GOAL_INTERPRETATION:
                facts.append(task.instruction)
            else:
                facts += [wording.describe_operators(), wording.describe_goals(task)]
            for fact in facts:
                assert fact in question
                assert fact in plain[task_id].user
            assert question != plain[task_id].user


@pytest.mark.parametrize("variant", VARIANTS)
def test_rules_of_operators_are_in_every_wording(variant: PromptSet) -> None:
    text = Templates(variant=variant).read("transition_modeling.txt")
    assert all(re.search(rf"\b{word}\b", text) for word in SIDES)
    filled = Template(text).safe_substitute(predicates="P", format="F", task="T", example="E")
    assert "$" not in filled


def test_a_wording_names_itself_unless_the_user_does() -> None:
    assert read_spec({"prompts": {"set": "eai-brief"}}).prompts.prompt_label == "eai-brief"
    assert read_spec({"prompts": {"set": "eai-brief", "name": "mine"}}).prompts.prompt_label == "mine"
    assert read_spec({"prompts": {"set": "eai"}}).prompts.prompt_label is None
    with pytest.raises(InputError, match=r"prompts\.set: expected 'official', 'eai', 'eai-brief' or"):
        read_spec({"prompts": {"set": "eai-short"}})


def test_files_of_the_user_come_before_those_of_a_wording(tmp_path: Path) -> None:
    (tmp_path / "action_sequencing.txt").write_text("Mine: $task")
    prompts = PromptLibrary("eai-careful", tmp_path).open(SWITCHES, Ability.ACTION_SEQUENCING)
    assert all(prompt.user.startswith("Mine: ") for prompt in prompts.values())
