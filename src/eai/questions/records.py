"""Records of questions: a line each, from which reports and comparisons are made without the questions."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from eai.abilities.codec import sha256_of
from eai.abilities.options import misfit
from eai.abilities.verdict import Confusion, Json
from eai.data.files import lines, write_whole
from eai.errors import InputError
from eai.questions.answers import Graded
from eai.questions.question import Question
from eai.questions.results import Result, table_json, tabulate

RECORDS = "records.jsonl"
ABILITY = "world_model"
"""What records of questions say that they are of."""

_MARK = f'{{"ability": "{ABILITY}"'
"""How a line of such records begins."""

_ASKED = frozenset(Question.model_fields) - {"version", "prompt"}


@dataclass(frozen=True, slots=True)
class QuestionRun:
    """The results of a model, in the order of the questions, whose prompts are not known any more.

    Attributes:
        model: the model.
        questions_sha256: digest of the file of questions.
        results: there is at least one.
    """

    model: str
    questions_sha256: str
    results: tuple[Result, ...]

    @property
    def domain(self) -> str:
        """The benchmark whose world the questions are about."""
        return self.results[0].question.domain


class _Line(BaseModel):
    """What a record says besides the question."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    model: str
    questions_sha256: str
    exact: bool
    counts: tuple[int, int, int]
    readable: bool
    repairs: tuple[str, ...]
    response: str | None


def write_results(folder: Path, run: QuestionRun) -> None:
    """Write ``records.jsonl``, a line a question, and ``summary.json``.

    Raises:
        InputError: the folder cannot be written.
    """
    about = {"model": run.model, "questions_sha256": run.questions_sha256, "unit": "percent"}
    summary = json.dumps({**about, **table_json(tabulate(run.results))}, indent=2)
    records = (json.dumps(_record(run, result)) + "\n" for result in run.results)
    write_whole({folder / RECORDS: records, folder / "summary.json": summary + "\n"})


def are_of_questions(path: Path) -> bool:
    """Whether a file of records is of questions; one that cannot be read is not."""
    try:
        with path.open(encoding="utf-8") as file:
            return file.readline().startswith(_MARK)
    except (OSError, UnicodeDecodeError):
        return False


def read_question_run(path: Path) -> QuestionRun:
    """The results in a file of records.

    Raises:
        InputError: it cannot be read, or a line is no such record; names file, line and field.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    found = [_parse(f"{path}, line {number}", line) for number, line in lines(content)]
    if not found:
        raise InputError(f"{path}: expected at least one record, found none")
    said, _ = found[0]
    return QuestionRun(said.model, said.questions_sha256, tuple([result for _, result in found]))


def _parse(place: str, line: bytes) -> tuple[_Line, Result]:
    try:
        values = json.loads(line, strict=False)
        if not isinstance(values, dict) or values.get("ability") != ABILITY:
            raise InputError(f"{place}: expected a record of a world-model question")
        said = _Line.model_validate(values)
        asked = {name: value for name, value in values.items() if name in _ASKED}
        question = Question.model_validate({**asked, "prompt": "-"})
    except ValidationError as error:
        raise InputError(f"{place}: {misfit(error)}") from error
    except ValueError as error:
        raise InputError(f"{place}: expected a JSON object ({error})") from error
    graded = Graded(said.exact, Confusion(*said.counts), said.readable, said.repairs)
    return said, Result(question, said.response, graded)


def _record(run: QuestionRun, result: Result) -> dict[str, Json]:
    question, graded = result.question, result.graded
    about: dict[str, Json] = question.model_dump(mode="json", exclude={"version", "prompt"})
    return {
        "ability": ABILITY,
        **about,
        "model": run.model,
        "questions_sha256": run.questions_sha256,
        "exact": graded.exact,
        "counts": list(graded.counts),
        "readable": graded.readable,
        "repairs": list(graded.repairs),
        "response_sha256": None if result.text is None else sha256_of(result.text),
        "response": result.text,
    }


def read_question_runs(paths: Sequence[Path]) -> list[QuestionRun]:
    """The runs in files of records, by domain, questions and model.

    Raises:
        InputError: a file is none of questions, or two are of one model and the same questions.
    """
    found: dict[tuple[str, str, str], QuestionRun] = {}
    for path in paths:
        run = read_question_run(path)
        key = (run.domain, run.questions_sha256, run.model)
        if key in found:
            raise InputError(
                f"{path}: {run.model} has answered these questions in another file, too; give one"
            )
        found[key] = run
    return [found[key] for key in sorted(found)]
