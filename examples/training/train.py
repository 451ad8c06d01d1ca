"""Train a small policy (a table of weights) on generated tasks, through the environment, in minutes on a CPU.

    pip install '.[analysis,envs,plots]'
    python examples/training/train.py --like behavior --out runs/training

First it generates tasks: `train` for learning, and `test` for measuring, with goals that are not in `train`.
After every few updates the policy plays each task of `test` once, and the number of wins is printed. Each
seed is a separate policy that begins with random commands, and has its own curve.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from policy import Choice, Reader, Table

from eai.agents.gym import TextEnvironment, make
from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.sets import make_seeds, make_shared_plan_test
from eai.benchmarks.generator.spec import GeneratedTask, PlanLengthTier, TaskSpecification, TaskSplit
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.tasks.task_files import write_task_file
from eai.tasks.task_lines import write_task_line

TURNS = 12
"""Maximum number of actions of an episode; certificates of tier S take 3 to 6."""

OBJECTS = 10
"""Maximum number of objects of a scene, which gives tens and not hundreds of commands."""

TOGETHER = 8
"""Number of episodes of a task that are played before each update."""

DISCOUNT = 0.9


class Episode(NamedTuple):
    """An episode: the choices, the reward of each turn, and whether the task was won."""

    choices: list[Choice]
    rewards: list[float]
    won: bool


class Point(NamedTuple):
    """A point of the learning curve: the number of test tasks won after this number of training episodes."""

    episodes: int
    won: int
    tasks: int


def make_tasks(like: str, folder: Path, sizes: dict[TaskSplit, int]) -> None:
    """Write task files of new tasks without common goals. Lookup in one file solves no task of another."""
    base, source = find_benchmark(like), Source()
    digest, earlier = base.tasks(source).sha256, list[Task]()
    for split, size in sizes.items():
        spec = TaskSpecification(like, digest, PlanLengthTier.S, most_objects=OBJECTS, split=split)
        generator = TaskGenerator(base, spec, source, make_shared_plan_test(base.domain, earlier))
        made = generate_from_seeds(generator, make_seeds(split.value, 0), size, set())
        tasks = [each for each in made if isinstance(each, GeneratedTask)]
        earlier += [each.task for each in tasks]
        lines = [write_task_line(each.task, like, base.domain, each.about) for each in tasks]
        write_task_file(folder / f"{split.value}.jsonl", lines)


def environment(domain: str) -> TextEnvironment:
    """Return the environment of a domain's tasks, which pays for each goal when it is reached."""
    return make(domain, admissible=True, reward="progress", max_steps=TURNS)


def play(environment: TextEnvironment, policy: Table, task: str) -> Episode:
    """Play one episode of a task."""
    observation, info = environment.reset(options={"task_id": task})
    reader = Reader(observation)
    choices: list[Choice] = []
    rewards: list[float] = []
    over = False
    while not over:
        commands = info["admissible_commands"]
        choices.append(policy.choose(reader, commands))
        command = commands[choices[-1].taken]
        observation, reward, terminated, truncated, info = environment.step(command)
        reader.see(observation, command)
        rewards.append(reward)
        over = terminated or truncated
    return Episode(choices, rewards, info["won"])


def returns(rewards: Sequence[float]) -> list[float]:
    """Return the discounted sum of the rewards from each turn on."""
    found: list[float] = []
    for reward in reversed(rewards):
        found.append(reward + DISCOUNT * (found[-1] if found else 0.0))
    return found[::-1]


def learn(policy: Table, episodes: Sequence[Episode]) -> None:
    """Learn from episodes of one task; the advantage of a turn is its return minus the mean at this turn."""
    paid = [returns(episode.rewards) for episode in episodes]
    longest = max(map(len, paid))
    padded = [[*each, *[0.0] * (longest - len(each))] for each in paid]
    usual = [statistics.fmean(column) for column in zip(*padded, strict=True)]
    policy.learn(
        [choice for episode in episodes for choice in episode.choices],
        [value - usual[turn] for each in paid for turn, value in enumerate(each)],
    )


def evaluate(environment: TextEnvironment, policy: Table) -> int:
    """Return the number of tasks that the policy wins, each played once."""
    return sum(play(environment, policy, task).won for task in environment.task_ids)


def train(
    learning: TextEnvironment, testing: TextEnvironment, seed: int, updates: int, every: int
) -> Iterator[Point]:
    """Yield the learning curve of one seed. The first point is the untrained policy."""
    policy = Table(seed)
    tasks = learning.task_ids
    for update in range(updates + 1):
        if update % every == 0:
            yield Point(update * TOGETHER, evaluate(testing, policy), len(testing.task_ids))
        task = tasks[(update * 7 + seed * 31) % len(tasks)]
        learn(policy, [play(learning, policy, task) for _ in range(TOGETHER)])


def draw(curves: Sequence[Sequence[Point]], file: Path) -> None:
    """Draw each seed's share of test tasks won, and the mean over seeds with its 95 % t-interval."""
    from matplotlib.figure import Figure
    from scipy.stats import t

    episodes = [point.episodes for point in curves[0]]
    shares = [[100 * point.won / point.tasks for point in curve] for curve in curves]
    means = [statistics.fmean(column) for column in zip(*shares, strict=True)]
    figure = Figure(figsize=(6, 3.6), layout="constrained")
    axes = figure.subplots()
    for share in shares:
        axes.plot(episodes, share, color="0.7", linewidth=1)
    axes.plot(episodes, means, color="C0", marker="o", label="mean of seeds")
    if len(shares) > 1:
        half = t.ppf(0.975, len(shares) - 1) / len(shares) ** 0.5
        errors = [half * statistics.stdev(column) for column in zip(*shares, strict=True)]
        low = [max(0.0, mean - error) for mean, error in zip(means, errors, strict=True)]
        high = [min(100.0, mean + error) for mean, error in zip(means, errors, strict=True)]
        axes.fill_between(episodes, low, high, alpha=0.2, label="95 % interval over seeds")
    axes.axhline(means[0], color="0.4", linestyle=":", label="random commands (nothing learned)")
    axes.set_xlabel("training episodes")
    axes.set_ylabel("fresh tasks won, %")
    axes.set_ylim(0, None)
    axes.legend(frameon=False)
    figure.savefig(file, dpi=150)


def main() -> None:
    """Train a policy for each seed, write the curves, print and draw them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--like", default="behavior", help="whose world")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--updates", type=int, default=120)
    parser.add_argument("--every", type=int, default=30, help="updates from one measurement to the next")
    parser.add_argument("--tasks", type=int, nargs=2, default=(100, 40), metavar=("TRAIN", "TEST"))
    parser.add_argument("--out", type=Path, default=Path("runs/training"))
    options = parser.parse_args()
    make_tasks(
        options.like, options.out, dict(zip((TaskSplit.TRAIN, TaskSplit.TEST), options.tasks, strict=True))
    )
    curves: list[list[Point]] = []
    for seed in range(options.seeds):
        begun = time.process_time()
        environments = [environment(str(options.out / f"{split}.jsonl")) for split in ("train", "test")]
        curves.append(list(train(*environments, seed, options.updates, options.every)))
        told = ", ".join([str(point.won) for point in curves[-1]])
        print(f"seed {seed}: won {told} of {curves[-1][0].tasks} ({time.process_time() - begun:.0f} CPU s)")
    (options.out / "curves.json").write_text(json.dumps(curves) + "\n", encoding="utf-8")
    draw(curves, options.out / "curve.png")


if __name__ == "__main__":
    main()
