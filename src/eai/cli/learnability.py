"""``eai check --learnable``: measure whether answers differ enough in reward to train a model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from eai.abilities.protocol import Ability
from eai.base.json_value import Json
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.cli.console import format_count, get_output_console, inspect_needed, print_result
from eai.cli.options import open_data_source, open_scoring_workers
from eai.cli.table import PERCENT
from eai.pddl.planning import PlannerChoice
from eai.results.learnability import count_tasks_by_reward_spread, measure_rewards_of_trivial_baselines
from eai.results.rate import Rate
from eai.results.records import read_records
from eai.results.reward import Reward, Shaping
from eai.results.runs import find_record_files
from eai.results.table import Estimate, NamedCells, Table
from eai.results.terminal import print_table
from eai.tasks.prompts.prompt import PromptSet


def print_learnability_of_rewards(
    benchmark_reference: str,
    ability: Ability,
    reward_shaping: Shaping,
    record_paths: Sequence[Path],
    context_tokens: int | None,
    prompt_set: PromptSet,
    data_folder: Path | None,
    workers: int | None,
    ray: str | None,
    *,
    as_json: bool,
) -> None:
    """Print numbers that show whether a model can learn from the rewards of tasks.

    The numbers are the rewards of null models (trivial built-in models such as eai/random), and the groups of
    answers to one task whose rewards differ. Tasks that are longer than a model's context are listed.

    Raises:
        InputError: answers to the ability get no reward, or a file of records cannot be read.
        EaiError: a context is given, and Inspect is not installed.
    """
    with (
        open_data_source(data_folder, PlannerChoice.NONE) as source,
        open_scoring_workers(workers, ray) as scoring,
    ):
        suite = open_suite(find_benchmark(benchmark_reference), ability, source=source)
        nulls = measure_rewards_of_trivial_baselines(Reward(suite, reward_shaping), scoring)
        value: dict[str, Json] = {
            "null_models": {
                name: {"mean": rewards.mean.to_json(), "full": rewards.full.to_json()}
                for name, rewards in nulls.items()
            }
        }
        if not as_json:
            title = f"{suite.domain} {ability.value}: null models' reward {reward_shaping.value}, percent"
            columns: list[NamedCells] = [("", [*nulls])]
            for i, heading in enumerate(("mean", "full reward")):
                rates = [Estimate.from_rate(rewards[i]) for rewards in nulls.values()]
                columns.append((replace(PERCENT, name=heading), rates))
            print_table(get_output_console(), Table.from_columns(title, columns))
        lines = []
        if record_paths:
            records = (record for file in find_record_files(record_paths) for record in read_records(file))
            of_suite = [
                record for record in records if (record.domain, record.ability) == (suite.domain, ability)
            ]
            groups = count_tasks_by_reward_spread(of_suite, Reward(suite, reward_shaping), scoring)
            value["groups"] = {**groups}
            lines.append(_describe_reward_spread(groups))
        if context_tokens is not None:
            line, value["too_long"] = _describe_and_list_long_tasks(suite, prompt_set, context_tokens)
            lines.append(line)
    print_result(*lines, value=value, as_json=as_json)


def _describe_reward_spread(group_count_by_spread: Counter[str]) -> str:
    number = group_count_by_spread.total() - group_count_by_spread["single"]
    if not number:
        return "no task has two answers of one model: run the model with --epochs"
    percent = Rate(group_count_by_spread["mixed"], number).percent
    mixed = (
        f"mixed rewards in {group_count_by_spread['mixed']:,} of {format_count(number, 'group')} of answers"
    )
    equal = ", ".join(
        [
            f"{group_count_by_spread[kind]:,} {text}"
            for kind, text in _WORDS_FOR_EQUAL_REWARDS.items()
            if group_count_by_spread[kind]
        ]
    )
    return f"{mixed} ({percent:.1f} %){'; equal rewards: ' * bool(equal)}{equal}"


_WORDS_FOR_EQUAL_REWARDS = {"none": "with no reward", "full": "with full rewards", "equal": "between"}
"""Mapping from kinds of tasks whose answers have equal rewards to a text on these rewards.

The kinds are names of counts in `count_tasks_by_reward_spread`.
"""


def _describe_and_list_long_tasks(
    suite: Suite, prompt_set: PromptSet, context_tokens: int
) -> tuple[str, Json]:
    """Return a line on the tasks whose question and gold answer exceed a context, and these tasks' ids."""
    with inspect_needed():
        from eai.run.context import describe_long_tasks, find_long_tasks
    prompts = PromptLibrary(prompt_set, None, suite.source).open(suite.benchmark, suite.ability)
    long_tasks = find_long_tasks(suite, prompts, None, context_tokens)
    fits = f"all {format_count(len(prompts), 'task')} fit into {context_tokens:,} tokens"
    line = describe_long_tasks(context_tokens, [long_tasks]) or fits
    return f"{line}, by estimate (--set {prompt_set})", [*long_tasks.needs]
