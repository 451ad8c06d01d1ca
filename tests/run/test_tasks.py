from __future__ import annotations

import asyncio
import re
from collections.abc import Iterator
from unittest.mock import Mock

import pytest
from inspect_ai.dataset import Sample
from inspect_ai.log import EvalSample
from inspect_ai.model import ChatMessageSystem, ChatMessageUser
from inspect_ai.util import registry_info

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol, find_ability_entry_points
from eai.base.errors import EaiError, InputError
from eai.base.store import DataPackStore
from eai.benchmarks.registry import list_benchmarks
from eai.run.registry import TASKS
from eai.run.tasks import _require_finished_log, _SamplesFedToInspect, open_model_at_endpoint
from eai.studies.variation import ModelEndpoint
from protocols import PROTOCOLS
from suites import official_prompts

SUITES = [(domain, ability) for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES]


def test_inspect_finds_every_suite_under_its_name() -> None:
    of_files = {
        ability
        for ability in find_ability_entry_points()
        if get_declaration(ability).interaction.task_command
    }
    others = find_ability_entry_points().keys() - of_files
    names = {*of_files, *(f"{domain}_{ability}" for domain in list_benchmarks() for ability in others)}
    assert TASKS.keys() == names
    assert {registry_info(task).name for task in TASKS.values()} == {f"eai/{name}" for name in names}


def test_a_run_that_fails_says_that_it_can_be_resumed() -> None:
    """A full disk, for example, ends Inspect's evaluation, but not the answers in the journal."""
    log = Mock(status="error", error=Mock(message="Traceback\nOSError(28, 'No space left on device')\n"))
    with pytest.raises(EaiError, match=r"No space left on device'\); .* the same command resumes from here$"):
        _require_finished_log(Mock(), log)


@pytest.mark.parametrize(("domain", "ability"), SUITES, ids=str)
def test_a_task_asks_the_official_prompts(data_store: DataPackStore, domain: str, ability: Ability) -> None:
    task = TASKS[f"{domain}_{ability.value}"]()
    prompts = official_prompts(domain, ability, data_store)
    assert [sample.id for sample in task.dataset] == list(prompts)
    for sample in task.dataset:
        prompt = prompts[str(sample.id)]
        assert isinstance(sample.input, list)
        *system, user = sample.input
        assert isinstance(user, ChatMessageUser)
        assert user.text == prompt.user
        assert [type(message) for message in system] == [ChatMessageSystem] * (prompt.system is not None)
        assert [message.text for message in system] == [prompt.system] * (prompt.system is not None)
        assert sample.metadata is not None
        assert tuple(sample.metadata["stop"]) == prompt.stop
    assert task.config.temperature == 0.0


def test_a_task_takes_arguments() -> None:
    """Inspect reads arguments as YAML, in which 27_2 is a number, and splits them at commas."""
    make = TASKS["virtualhome_transition_modeling"]
    for tasks, ids in (
        (272, ["27_2"]),
        ("27_2", ["27_2"]),
        (["27_2", "975_2"], ["975_2", "27_2"]),
        ([272, 9752], ["975_2", "27_2"]),
    ):
        task = make(tasks=tasks, planner="none", protocol=PROTOCOLS[-1].value, prompts="eai")
        assert [sample.id for sample in task.dataset] == ids
    for wrong, message in (
        ({"tasks": "0_0"}, "tasks: '0_0' is not a task of this suite"),
        ({"tasks": 99}, "tasks=99: expected the id of a task, found a number"),
        ({"planner": "fast"}, "planner: expected 'auto', 'full', 'built_in'"),
        (
            {"protocol": "lax"},
            f"protocol: expected {' or '.join(map(repr, map(str, Protocol.list_names())))}, found 'lax'",
        ),
        (
            {"prompts": "mine"},
            "prompts.set: expected 'official', 'eai', 'eai-brief', 'eai-careful', 'short' or 'facts', "
            "found 'mine'",
        ),
        ({"replan": 3}, "replan: unknown; did you mean replans? (there are replans, world, feedback"),
        ({"scene_model": "eai/captioner"}, "scene_model: a task in Inspect cannot ask a second model"),
    ):
        with pytest.raises(InputError, match=re.escape(message)):
            make(**wrong)


@pytest.mark.parametrize(("epochs", "ahead"), [(1, 3), (2, 3), (3, None)])
def test_a_feed_makes_few_samples_ahead(epochs: int, ahead: int | None) -> None:
    made: list[int] = []

    def make_samples() -> Iterator[Sample]:
        for number in range(20):
            made.append(number)
            yield Sample(input="?", id=number)

    async def finish_all() -> list[int]:
        feed = _SamplesFedToInspect(make_samples(), epochs=epochs, ahead=ahead)
        waiting = [sample for sample in await feed.next_samples() or [] for _ in range(epochs)]
        finished = []
        while waiting:
            sample = waiting.pop(0)
            finished.append(int(sample.id or 0))
            done = EvalSample(id=sample.id or 0, epoch=1, input="?", target="")
            waiting += [more for more in await feed.sample_complete(done) for _ in range(epochs)]
            assert ahead is None or len(waiting) < ahead + epochs
        assert await feed.next_samples() is None
        return finished

    feed = _SamplesFedToInspect(make_samples(), epochs=epochs, ahead=ahead)
    assert (
        len(asyncio.run(feed.next_samples()) or []) == len(made) == (20 if ahead is None else -(-3 // epochs))
    )
    assert sorted(asyncio.run(finish_all())) == sorted([*range(20)] * epochs)


@pytest.mark.parametrize("message", ["quantization [/q8] not recognized", "OTHER_API_KEY is not used"])
def test_an_error_of_a_provider_keeps_its_text(message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*names: object, **options: object) -> None:
        raise ValueError(message)

    monkeypatch.setattr("eai.run.tasks.get_model", fail)
    with pytest.raises(EaiError) as error:
        open_model_at_endpoint(ModelEndpoint("vllm/m"))
    assert str(error.value) == f"cannot open the model vllm/m: {message}"
