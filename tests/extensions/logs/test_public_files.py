"""Published files, one of each form. A test reads a file only if the user has a copy of it.

An environment variable gives the path of the copy. This repository has no copies.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.extensions.logs.episode import EpisodeOutcome
from eai.extensions.logs.readers import read_log
from eai.world.fault import FaultKind

SITE = "embodied-agent-interface-v2-internal"


def find_copy(variable: str, address: str) -> Path:
    """Return the user's copy of a published file, or skip the test."""
    place = os.environ.get(variable)
    if place is None:
        pytest.skip(f"{variable} names no copy of {address}")
    return Path(place)


def test_the_behavior_run_of_eai_v2_has_the_known_outcomes() -> None:
    commit = "bbd7e20db6424b5f708c5399051228e27311b926"
    run = "data/published_runs/behavior-1k/codex-0.157-gpt6luna-xhigh-cgpt.json"
    address = f"https://github.com/{SITE}/{SITE}.github.io/blob/{commit}/{run}"
    counted = Counter((e.setting, e.outcome) for e in read_log(find_copy("EAI_V2_RUN", address)))
    assert counted == {
        ("limited", EpisodeOutcome.GOAL_UNMET): 36,
        ("limited", EpisodeOutcome.NOT_REPRODUCED): 11,
        ("limited", EpisodeOutcome.NOTHING_SUBMITTED): 2,
        ("unlimited", EpisodeOutcome.WON): 9,
        ("unlimited", EpisodeOutcome.GOAL_UNMET): 15,
        ("unlimited", EpisodeOutcome.NOTHING_SUBMITTED): 25,
    }


def test_a_log_of_alfworld_shows_an_agent_that_repeats_what_the_game_cannot_read() -> None:
    commit = "71b56ff212410e64dbf829b154023fda95a8b8c9"
    name = "3___put___pick_and_place_simple-Watch-None-Safe-219_trial_T20190907_074556_124850.log"
    address = f"https://github.com/aFlyBird0/haok/blob/{commit}/result/exp2/logs/react/{name}"
    (episode,) = read_log(find_copy("EAI_ALFWORLD_LOG", address))
    assert (episode.task, episode.outcome) == ("put some watch on safe", EpisodeOutcome.CANNOT_TELL)
    assert [step.accepted for step in episode.steps] == [False] * 30
    assert (episode.index_of_first_error, episode.max_occurrences_of_action_reply_pair) == (0, 19)


def test_trajectories_of_embodiedbench_have_the_verdicts_of_the_file() -> None:
    folder = "https://huggingface.co/datasets/EmbodiedBench/EB-Alfred_trajectory_dataset"
    path = find_copy("EAI_EMBODIEDBENCH_LOG", f"{folder}/blob/main/eb-alfred_dataset_multi_step.json")
    episodes, verdicts = read_log(path), [each["success"] for each in json.loads(path.read_bytes())]
    assert [episode.outcome is EpisodeOutcome.WON for episode in episodes] == [*map(bool, verdicts)]
    kinds = Counter(step.kind for episode in episodes for step in episode.steps if step.is_error)
    assert kinds[None] > 0
    assert kinds[FaultKind.MISSING_STEP] + kinds[FaultKind.WRONG_ORDER] > 0


def test_a_log_of_inspect_with_other_tools_is_refused() -> None:
    commit, name = "92099a875c18abd7ded477119f03818db781c6de", "2025-05-12T20-27-36-04-00_browser.json"
    place = "UKGovernmentBEIS/inspect_ai/blob"
    address = f"https://github.com/{place}/{commit}/tests/analysis/test_logs/{name}"
    path = find_copy("EAI_INSPECT_LOG", address)
    pytest.importorskip("inspect_ai", reason="needs the extra run")
    with pytest.raises(InputError, match="expected calls of act with an action and objects, found none"):
        read_log(path)
