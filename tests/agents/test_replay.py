"""Recorded episodes give equal bytes in each replay."""

from __future__ import annotations

from collections.abc import Iterator

from agents.switches import SWITCHES
from eai import Benchmark
from eai.agents.agents import make_blind_agent, random_agent
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING, AgentSetting
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import Scoring
from eai.results.records import format_record_line
from eai.results.responses import Response


def recorded(benchmark: Benchmark, number: int, sample: int = 1) -> Iterator[Response]:
    """Return episodes of agents that do not know the goals, in worlds with slips."""
    suite = open_suite(benchmark, ACTING)
    arena = EpisodeFactory(benchmark, AgentSetting(slip=0.2, slip_seed=7))
    task_ids = [i for i in suite.task_ids if suite.tasks[i].unplannable_reason is None][::sample]
    for epoch in range(number):
        play = arena.begin_episode(suite.tasks[task_ids[epoch % len(task_ids)]], epoch)
        agent = (random_agent, make_blind_agent)[epoch % 2](play, epoch)
        while not play.is_over:
            play.play_command(agent())
        yield Response(play.task.id, play.write_as_json_text("stopped"))


def replayed(suite: Suite, responses: list[Response]) -> list[str]:
    return list(
        map(format_record_line, Scoring().score_records(suite, "model", responses, explanations=True))
    )


def test_a_thousand_episodes_replayed_twice_give_equal_bytes() -> None:
    responses = list(recorded(SWITCHES, 1_000))
    first, second = (replayed(open_suite(SWITCHES, ACTING), responses) for _ in range(2))
    assert first == second
    assert not any("unreplayable" in line for line in first)


def test_episodes_of_households_replayed_twice_give_equal_bytes(data_store: DataPackStore) -> None:
    for name in ("virtualhome", "behavior"):
        responses = list(recorded(find_benchmark(name), 4, sample=40))
        first, second = (replayed(open_suite(name, ACTING), responses) for _ in range(2))
        assert first == second
        assert not any("unreplayable" in line for line in first)
