"""Kill a run many times, resume it, and check that no answer is lost, duplicated or changed.

    python -m bench kill_and_resume --kills 70                  replanning
    python -m bench kill_and_resume --kills 70 --kind plain     one answer a task
    python -m bench kill_and_resume --kills 70 --kind pipeline  questions that state interpreted goals
    python -m bench kill_and_resume --kills 70 --kind acting    episodes, killed in their midst

A process that does a job of ``eai run`` is killed (SIGKILL) at an arbitrary moment after a few more answers,
and started again, until the job ends. Then three checks follow:

- Records, summary and answers equal those of an undisturbed run, byte for byte.
- No answer that was in the journal at a kill is missing.
- No answer is in the journal twice.

More runs follow until the number of kills is reached. An interrupted episode begins again: its record says
how often it has begun (`begun`), and equals the undisturbed record otherwise. The program prints one line of
JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from bench.record import add_write_option, write_rows
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.agents.setting import ACTING
from eai.base.json_value import Json
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import open_suite
from eai.results.epochs import GoalsAndScenesStatedInPrompts, score_answers
from eai.results.options import ScoringOptions
from eai.results.trials import make_replanning_conversation_factory
from eai.run.job import QuestionJob, RequestOptions
from eai.run.tasks import request_missing_answers
from eai.studies.pipeline.stage_one import make_interpreted_goals_for_prompts
from eai.studies.variation import ModelEndpoint

EXPERIMENT = ReplanningOptions(3, feedback="explained", slip=0.05, slip_seed=0)
MODEL = "eai/noisy"
JOURNAL = "answers.jsonl"
COMPARED = ("records.jsonl", "summary.json")


class Work(NamedTuple):
    """The work of each run; in a pipeline, with goals that answers state."""

    job: QuestionJob
    believed: GoalsAndScenesStatedInPrompts | None = None


def make_work(kind: str, tasks: int) -> Work:
    """Return the work on the first tasks of BEHAVIOR.

    Answers are corrupted, and repaired in experiments; episodes are gold.
    """
    ability = ACTING if kind == "acting" else Ability.ACTION_SEQUENCING
    suite, library = open_suite("behavior", ability), PromptLibrary("official")
    task_ids = suite.task_ids[:tasks]
    believed, trials = None, None
    if kind == "pipeline":
        book = open_gold_answers(suite.benchmark, Ability.GOAL_INTERPRETATION)
        stated = {task_id: book[task_id].text for task_id in task_ids}
        believed = make_interpreted_goals_for_prompts(("oracle", stated), suite.benchmark, suite.source)
    prompts = library.open(suite.benchmark, suite.ability, None if believed is None else believed.beliefs)
    asked = {task_id: prompts[task_id] for task_id in task_ids}
    arguments: dict[str, Json] = {} if kind == "acting" else {"rate": 0.2}
    if kind == "replanning":
        trials = make_replanning_conversation_factory(
            suite, EXPERIMENT, library.make_question_writer(suite.benchmark, suite.ability, asked), asked
        )
        arguments["heed"] = 0.7
    job = QuestionJob(
        ModelEndpoint("eai/oracle" if kind == "acting" else MODEL, arguments),
        suite,
        asked,
        pace=RequestOptions(max_connections=2),
        trials=trials,
    )
    return Work(job, believed)


def work(todo: Work, folder: Path) -> None:
    """Do the work of a run in this process."""
    job = todo.job
    answers = request_missing_answers(job, folder / JOURNAL, folder / "logs")
    obtained = replace(answers, name="noisy", beliefs=todo.believed)
    score_answers(obtained, folder, job.suite, ScoringOptions(explanations=job.suite.ability is not ACTING))


def start(todo: Work, folder: Path) -> int:
    """Start a process that does the work, and return its id."""
    child = os.fork()
    if child:
        return child
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    try:
        work(todo, folder)
        status = 0
    except BaseException as error:  # the parent must see any exception
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        status = 1
    os._exit(status)


def lines(folder: Path) -> list[str]:
    """Return the complete lines of the journal."""
    path = folder / JOURNAL
    return path.read_text(encoding="utf-8").split("\n")[:-1] if path.exists() else []


def kill_or_wait(child: int, folder: Path, more: int, later: float) -> bool:
    """Kill a process some seconds after some more answers. Return whether it was killed before its end."""
    wanted = len(lines(folder)) + more
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            if status:
                raise SystemExit(f"a run exited with status {status}; see its output above")
            return False
        if len(lines(folder)) >= wanted:
            time.sleep(later)
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return True
        time.sleep(0.001)


def episodes(folder: Path) -> list[tuple[int, dict[str, Json]]]:
    """Return the records of episodes: how often each has begun, and the record without this number."""
    found = []
    for line in (folder / "records.jsonl").read_text(encoding="utf-8").splitlines():
        record = json.loads(line)
        begun = record.pop("begun")
        answer = {**json.loads(record.pop("response")), "begun": 1}
        del record["response_sha256"]
        found.append((begun, {**record, "answer": answer}))
    return found


def unsaid(folder: Path) -> int:
    """Return the number of records with a wrong count of the beginnings of their episode."""
    path = folder / "begun.jsonl"
    begun = Counter(json.loads(line)[0] for line in path.read_text(encoding="utf-8").splitlines())
    return sum(times != begun[record["task_id"]] for times, record in episodes(folder))


def outcome(folder: Path, kind: str) -> object:
    """Return the files of a run, except its journal and log."""
    if kind == "acting":
        return [record for _, record in episodes(folder)]
    attempts = sorted(folder.glob("noisy_attempt_*_outputs.json"))
    return [path.read_bytes() for path in (*[folder / name for name in COMPARED], *attempts)]


def places(journal: list[str]) -> Counter[tuple[str, int, int]]:
    """Return how often each answer is in a journal."""
    rows = map(json.loads, journal)
    return Counter((row["task_id"], row["epoch"], row["attempt"]) for row in rows)


def main() -> None:
    """Kill, resume and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--kind", choices=("plain", "replanning", "pipeline", "acting"), default="replanning")
    parser.add_argument("--tasks", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    add_write_option(parser)
    arguments = parser.parse_args()
    todo, chance = make_work(arguments.kind, arguments.tasks), random.Random(arguments.seed)
    kills, runs, lost, doubled, differing, answers, anew = 0, 0, 0, 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        alone = Path(temporary, "alone")
        work(todo, alone)  # import here, before the first fork, so that all later processes have it
        expected = outcome(alone, arguments.kind)
        while kills < arguments.kills:
            runs += 1
            folder = Path(temporary, f"run_{runs}")
            killed = True
            while killed:
                most, longest = (3, 0.5) if arguments.kind == "acting" else (12, 0.0)
                more = chance.randint(1, most) if kills < arguments.kills else sys.maxsize
                before = lines(folder)
                later = chance.uniform(0, longest)
                killed = kill_or_wait(start(todo, folder), folder, more, later)
                kills += killed
                lost += len(set(before) - set(lines(folder)))
            written = places(lines(folder))
            answers += len(written)
            doubled += sum(times - 1 for times in written.values())
            lost += len(places(lines(alone)) - written)
            differing += outcome(folder, arguments.kind) != expected
            if arguments.kind == "acting":
                anew += sum(begun > 1 for begun, _ in episodes(folder))
                lost += unsaid(folder)
    counted = {"kind": arguments.kind, "kills": kills, "runs": runs, "answers": answers}
    found = {"lost": lost, "doubled": doubled, "differing": differing, "begun_anew": anew}
    print(json.dumps({**counted, **found}))
    if arguments.write:
        write_rows("kill_and_resume", [[*counted.values(), *found.values()]])
