"""A step of Ray Data that scores answers: the records of one process, whoever is killed."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

import eai
from by_path import ROOT
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import Suite
from eai.extensions.distributed.ray_data import RECORD_COLUMNS, BatchScorer
from eai.results.batch import Scoring
from eai.results.records import format_record_line
from eai.results.responses import Response

# Ray warns of its own options, and of actors that a test has no work for.
pytestmark = pytest.mark.filterwarnings("ignore:::ray")

PAGE = ROOT / "docs/extensions/distributed/README.md"
EXAMPLE = re.compile(r"^```py\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def suite(data_store: DataPackStore) -> Suite:
    return eai.open("virtualhome", "action_sequencing", source=eai.Source(data_store))


@pytest.fixture(scope="module")
def answers(suite: Suite) -> list[Response]:
    book = open_gold_answers(suite.benchmark, suite.ability)
    return [Response(task_id, book[task_id].text) for task_id in suite.task_ids]


def columns(answers: Sequence[Response]) -> dict[str, list[str]]:
    return {
        "identifier": [answer.task_id for answer in answers],
        "llm_output": [answer.text for answer in answers],
    }


def rows(answers: Sequence[Response]) -> list[dict[str, str]]:
    return [{"identifier": answer.task_id, "llm_output": answer.text} for answer in answers]


def lines(suite: Suite, answers: Sequence[Response]) -> list[str]:
    return [format_record_line(record) for record in Scoring().score_records(suite, "my-model", answers)]


def test_a_batch_gets_the_records_of_one_process(suite: Suite, answers: list[Response]) -> None:
    few = answers[:20]
    batch = BatchScorer(suite, "my-model")({**columns(few), "seed": range(20)})
    assert list(batch) == ["identifier", "llm_output", "seed", "record", "outcome", "success"]
    assert batch["record"] == lines(suite, few)
    assert (batch["outcome"][0], batch["success"][0]) == ("success", True)


def test_frames_of_spark_get_the_same_columns_with_their_types(suite: Suite, answers: list[Response]) -> None:
    pandas = pytest.importorskip("pandas")
    few = [*answers[:3], Response(answers[3].task_id, "no plan")]
    given = [pandas.DataFrame(columns(part)) for part in (few[:2], few[2:])]
    written = pandas.concat(BatchScorer(suite, "my-model").score_frames(given))
    assert list(written) == ["identifier", "llm_output", *RECORD_COLUMNS]
    assert written["record"].tolist() == lines(suite, few)
    assert written["outcome"].tolist()[-1] == "parsing"
    assert written["success"].tolist()[-1] is False


def test_identifiers_are_those_of_response_files(suite: Suite, answers: list[Response]) -> None:
    asked, missing = answers[0], Response(answers[1].task_id, "")
    batch = {"identifier": [f"scene_1_{asked.task_id}", missing.task_id], "llm_output": [asked.text, None]}
    assert BatchScorer(suite, "my-model")(batch)["record"] == lines(suite, [asked, missing])


@pytest.mark.parametrize("missing", [None, float("nan")])
def test_a_missing_text_is_an_empty_answer(
    suite: Suite, answers: list[Response], missing: float | None
) -> None:
    scorer, task_id = BatchScorer(suite, "m"), answers[0].task_id
    empty, other = (scorer({"identifier": [task_id], "llm_output": [text]}) for text in ("", missing))
    assert other["record"] == empty["record"]


def test_what_is_no_batch_of_answers_is_said(suite: Suite) -> None:
    scores = BatchScorer(suite, "my-model")
    with pytest.raises(InputError, match="expected the columns identifier and llm_output, found identifier"):
        scores({"identifier": ["27_2"]})
    with pytest.raises(InputError, match="no task 'nothing'"):
        scores({"identifier": ["nothing"], "llm_output": [""]})


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Ray Data on a cluster of this machine, whose processes begin in an empty folder, as does this one."""
    ray = pytest.importorskip("ray", reason="Ray is not installed")
    found = pytest.importorskip("ray.data", reason="Ray Data is not installed")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("here"))
        ray.init("local", num_cpus=4, log_to_driver=False, logging_level="error")
        yield found
        ray.shutdown()


def test_the_example_of_the_documentation(data: Any, suite: Suite, answers: list[Response]) -> None:
    data.from_items(rows(answers), override_num_blocks=2).write_parquet("answers")
    (example,) = EXAMPLE.finditer(PAGE.read_text(encoding="utf-8"))
    exec(example["code"], {})  # noqa: S102 - our own documentation
    written = [row["record"] for row in data.read_parquet("scored").take_all()]
    assert sorted(written) == sorted(lines(suite, answers))


def test_an_actor_that_is_killed_loses_and_doubles_nothing(
    data: Any, suite: Suite, answers: list[Response], tmp_path: Path
) -> None:
    class Dying(BatchScorer):
        """Its process dies at the third batch of all, once."""

        def __call__(self, batch: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
            seen = tmp_path / str(os.getpid())
            seen.mkdir(exist_ok=True)
            (seen / str(len(list(seen.iterdir())))).touch()
            if len(list(seen.iterdir())) == 3 and not (tmp_path / "died").exists():
                (tmp_path / "died").touch()
                os._exit(1)
            return super().__call__(batch)

    scored = data.from_items(rows(answers), override_num_blocks=2).map_batches(
        Dying,
        fn_constructor_args=[suite, "my-model"],
        compute=data.ActorPoolStrategy(size=1),
        batch_size=32,
    )
    written = [row["record"] for row in scored.take_all()]
    assert (tmp_path / "died").exists()
    assert sorted(json.loads(line)["task_id"] for line in written) == sorted(suite.task_ids)
    assert sorted(written) == sorted(lines(suite, answers))
