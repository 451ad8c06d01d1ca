"""Our prompts in other words: each wording states all rules and facts, and records name it."""

from __future__ import annotations

import re
from pathlib import Path
from string import Template

import pytest

from agents.switches import SWITCHES
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.run.spec import read_spec
from eai.tasks.prompts.prompt import VARIANTS, PromptSet
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.source import Source
from sweeps import every
from tasks.prompts.long_form import write_long_form

PLACE = re.compile(r"\$(\w+)")
SHORT = ["short", "facts"]
WORDINGS = [name for name in VARIANTS if name not in SHORT]
SIDES = ("and", "or", "not", "exists", "forall", "when")


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
@pytest.mark.parametrize("variant", WORDINGS)
def test_a_wording_has_every_place_but_the_example(variant: PromptSet, ability: Ability) -> None:
    """The values of placeholders are the rules and facts; only an example may be left out."""
    plain, other = (PromptTemplates(variant=name).read(f"{ability.value}.txt") for name in ("eai", variant))
    assert plain != other
    assert set(PLACE.findall(plain)) - set(PLACE.findall(other)) <= {"example"}
    assert set(PLACE.findall(other)) <= set(PLACE.findall(plain))


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_short_prompts_have_every_place_in_short_form(ability: Ability) -> None:
    """Only plans need no list of predicates, because their answers name none."""
    plain, short = (PromptTemplates(variant=name).read(f"{ability.value}.txt") for name in ("eai", "short"))
    unneeded = {"example", "of_each"} | ({"vocabulary"} if ability is Ability.ACTION_SEQUENCING else set())
    places = {place.removeprefix("short_") for place in PLACE.findall(short)}
    assert set(PLACE.findall(plain)) - unneeded == places


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_facts_have_no_instruction(ability: Ability) -> None:
    assert PromptTemplates(variant="facts").read(f"{ability.value}.txt") == "$task"
    question = PromptTemplates(variant="facts").read(f"{ability.value}_task.txt")
    stated = {"instruction"} if ability is Ability.GOAL_INTERPRETATION else {"goals"}
    facts = {"short_problem", "short_heads"}
    if ability is not Ability.TRANSITION_MODELING:
        facts = {"short_objects", "short_initial", *stated}
    assert set(PLACE.findall(question)) == facts


def read_lists(question: str) -> tuple[set[str], set[str]]:
    """Return the lines with objects and conventions, and the lines with facts, of a question's task."""
    _, _, text = question.rpartition("Objects [kind]: properties\n")
    objects, _, facts = text.partition("\nInitial state:\n")
    return {*filter(None, objects.splitlines())}, {*facts.partition("\n\n")[0].splitlines()}


@every(10)
@pytest.mark.parametrize("variant", SHORT)
@pytest.mark.parametrize("domain", ["behavior", "virtualhome", "behavior-1k"])
def test_short_lists_state_the_plain_facts_and_no_others(
    domain: str, variant: PromptSet, data_store: DataPackStore, every: int
) -> None:
    source, benchmark = Source(data_store), find_benchmark(domain)
    for ability in PAPER_ABILITIES:
        if ability is Ability.TRANSITION_MODELING:
            continue
        plain, other = (
            PromptLibrary(name, None, source).open(benchmark, ability) for name in ("eai", variant)
        )
        for task_id in list(plain)[:: every * 4]:
            long_form = write_long_form(other[task_id].user)
            assert read_lists(long_form) == read_lists(plain[task_id].user), task_id


@pytest.mark.parametrize("domain", ["behavior", "virtualhome"])
@pytest.mark.parametrize("variant", WORDINGS)
def test_a_question_states_what_the_plain_one_states(
    domain: str, variant: PromptSet, data_store: DataPackStore
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
                wording.describe_initial_state(task),
            ]
            if ability is Ability.GOAL_INTERPRETATION:
                facts.append(task.instruction)
            else:
                facts += [wording.describe_operators(), wording.describe_goals(task)]
            for fact in facts:
                assert fact in question
                assert fact in plain[task_id].user
            assert question != plain[task_id].user


@pytest.mark.parametrize("variant", [*WORDINGS, "short"])
def test_rules_of_operators_are_in_every_wording(variant: PromptSet) -> None:
    text = PromptTemplates(variant=variant).read("transition_modeling.txt")
    assert all(re.search(rf"\b{word}\b", text) for word in SIDES)
    filled = Template(text.replace("$short_", "$")).safe_substitute(
        predicates="P", format="F", task="T", example="E"
    )
    assert "$" not in filled


def test_a_wording_names_itself_unless_the_user_does() -> None:
    assert read_spec({"prompts": {"set": "eai-brief"}}).prompts.prompt_label == "eai-brief"
    assert [read_spec({"prompts": {"set": name}}).prompts.prompt_label for name in SHORT] == SHORT
    assert read_spec({"prompts": {"set": "eai-brief", "name": "mine"}}).prompts.prompt_label == "mine"
    assert read_spec({"prompts": {"set": "eai"}}).prompts.prompt_label is None
    with pytest.raises(InputError, match=r"prompts\.set: expected 'official', 'eai', 'eai-brief', "):
        read_spec({"prompts": {"set": "eai-short"}})


def test_files_of_the_user_come_before_those_of_a_wording(tmp_path: Path) -> None:
    (tmp_path / "action_sequencing.txt").write_text("Mine: $task")
    prompts = PromptLibrary("eai-careful", tmp_path).open(SWITCHES, Ability.ACTION_SEQUENCING)
    assert all(prompt.user.startswith("Mine: ") for prompt in prompts.values())
