"""Check that facts hold in scenes with bodies; measure the cost of scenes and what their pictures show.

    python -m bench bodies [TASKS.jsonl ...] [--step 1] [--seen]

Scenes are built for BEHAVIOR's published tasks and for each task file. Times are CPU times of one process.
With --seen, the program also counts the objects and facts that the two pictures of a question show. It then
prints how often a planner succeeds that knows only these facts and the names of all objects.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

from bench.record import add_write_option, write_figures, write_rows
from bench.result import Figure
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import InputError
from eai.benchmarks.gold_answers import open_answers_of_planner
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.scenes.camera import Camera, CameraView
from eai.extensions.scenes.scene import MujocoScene
from eai.planning.search import Limits
from eai.results.rate import Rate
from eai.studies.perception.belief import make_scene_graph_vocabulary, replace_scenes_of_benchmark
from eai.studies.perception.scene_graph import SceneGraph, make_scene_graph

VIEWS: tuple[CameraView, ...] = ("head", "near")
LEAST = 12
"""Minimum number of visible pixels of an object that counts as seen."""


class Seen(NamedTuple):
    """Scene graph of the visible objects of a task, with the numbers of objects and facts."""

    graph: SceneGraph
    things: int
    seen: int
    facts: int


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("files", nargs="*", metavar="TASKS")
    parser.add_argument("--step", type=int, default=1)
    parser.add_argument("--seen", action="store_true")
    add_write_option(parser)
    chosen, rows = parser.parse_args(), list[list[Figure]]()
    for name in ("behavior", *chosen.files):
        suite = open_suite(name, Ability.ACTION_SEQUENCING)
        task_ids = suite.task_ids[:: chosen.step]
        scenes, cost = build_scenes(suite, task_ids)
        rows.append([Path(name).name, f"{len(scenes)} of {len(task_ids)}", cost])
        if name == "behavior":
            of_frame = measure_frames(list(scenes.values())[::10])
            if chosen.write:
                write_figures("bodies", {"CPU s of a frame of 640 x 480: with shadows, without": of_frame})
        if chosen.seen:
            print_seen_facts(suite, {i: find_seen_facts(scene, suite) for i, scene in scenes.items()})
    if chosen.write:
        write_rows("bodies", rows)


def build_scenes(suite: Suite, task_ids: Sequence[str]) -> tuple[dict[str, MujocoScene], str]:
    """Return the scenes that can be built. Print their cost, and why the others cannot be built."""
    scenes, times = dict[str, MujocoScene](), []
    for task_id in task_ids:
        start = time.process_time()
        try:
            scenes[task_id] = MujocoScene(suite.tasks[task_id])
        except InputError as error:
            print(f"  {error}")
        times.append(time.process_time() - start)
    attempts = Counter(scene.attempts for scene in scenes.values())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{suite.domain}: facts hold in {len(scenes)} of {len(task_ids)}; CPU s median {median(times):.3f}, "
        f"most {max(times):.2f}; arranged {dict(sorted(attempts.items()))} times; {memory:.0f} MB so far"
    )
    return scenes, f"{median(times):.2f} ({max(times):.2f})"


def measure_frames(scenes: Sequence[MujocoScene]) -> str:
    """Print and return the cost of rendering a frame of 640 x 480 pixels."""
    costs = []
    for shadows in (True, False):
        times = list(measure_frame_times(scenes, shadows=shadows))
        print(f"frame, shadows {shadows}: CPU s median {median(times):.3f}, most {max(times):.2f}")
        costs.append(f"{median(times):.2f} ({max(times):.2f})")
    return ", ".join(costs)


def measure_frame_times(scenes: Sequence[MujocoScene], *, shadows: bool) -> Iterator[float]:
    for scene in scenes:
        with Camera(scene, shadows=shadows) as camera:
            camera.render_colours("head")
            for view in (*VIEWS, "top"):
                start = time.process_time()
                camera.render_colours(view)
                yield time.process_time() - start


def find_seen_facts(scene: MujocoScene, suite: Suite) -> Seen:
    """Return the facts whose objects are all visible in a question's pictures. Floors count as visible."""
    with Camera(scene, shadows=False) as camera:
        pixels = Counter(int(i) for view in VIEWS for i in camera.render_object_indexes(view).ravel())
    task, words = scene.task, make_scene_graph_vocabulary(suite.benchmark)
    names = words.list_object_names(task)
    seen = {names[i] for i in scene.locations.bodies if pixels[i] >= LEAST}
    known = seen | {names[i] for i in scene.locations.floors}
    described = words.make_true_graph(task)
    facts = [fact for fact in described.facts if known.issuperset(fact.arguments)]
    return Seen(
        make_scene_graph(described.objects, facts),
        len(scene.locations.bodies),
        len(seen),
        len(described.facts),
    )


def print_seen_facts(suite: Suite, seen: Mapping[str, Seen]) -> None:
    """Print how much is visible, and how often a planner succeeds with the visible facts alone."""
    things = Rate(sum(each.seen for each in seen.values()), sum(each.things for each in seen.values()))
    facts = Rate(
        sum(len(each.graph.facts) for each in seen.values()), sum(each.facts for each in seen.values())
    )
    print(f"seen: things {format_rate(things)}, facts {format_rate(facts)}")
    believed = replace_scenes_of_benchmark(suite.benchmark, {i: each.graph for i, each in seen.items()})
    book = open_answers_of_planner(believed, Ability.ACTION_SEQUENCING, limits=Limits(200))
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in seen]
    won = Rate(sum(isinstance(v, PlanVerdict) and bool(v.success) for v in verdicts), len(verdicts))
    print(f"planner that knows what is seen: {format_rate(won)}")


def format_rate(rate: Rate) -> str:
    return f"{rate.percent:.1f} % ({rate.numerator}/{rate.denominator})"
