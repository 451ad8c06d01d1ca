"""World-model questions as Inspect tasks, and asking a model a file of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import inspect_ai
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.model import GenerateConfig
from inspect_ai.scorer import (
    CORRECT,
    INCORRECT,
    Score,
    Scorer,
    Target,
    accuracy,
    grouped,
    scorer,
    stderr,
)
from inspect_ai.solver import Solver, TaskState
from inspect_ai.util import registry_info

from eai.abilities.protocol import member
from eai.abilities.verdict import Json
from eai.benchmark.registry import find_benchmark
from eai.prompts.prompt import Prompt
from eai.questions.answers import gold_text, grade
from eai.questions.question import Form, Kind, Question, read_questions
from eai.questions.writer import Wanted, Writer
from eai.run.evaluation import Answers, obtain
from eai.run.job import Endpoint, Pace, Requests
from eai.run.journal import JOURNAL
from eai.run.logs import JOB
from eai.run.messages import QUESTION, messages_of
from eai.run.refusal import refusing
from eai.run.solver import ask, ask_as_published
from eai.run.state import Watch, unwatched


@scorer(metrics=[grouped(accuracy(), "kind", all=False), accuracy(), stderr(cluster="task")], name="question")
def question_scorer() -> Scorer:
    """Scores an answer with the pure function of the library; standard errors are clustered by task."""

    async def score(state: TaskState, target: Target) -> Score:
        question = Question.model_validate(state.metadata[QUESTION])
        graded = grade(question, state.output.completion)
        return Score(
            value=CORRECT if graded.exact else INCORRECT,
            answer=state.output.completion,
            metadata={"counts": list(graded.counts), "readable": graded.readable},
        )

    return score


def question_task(
    questions: Sequence[Question],
    name: str,
    solver: Solver | None = None,
    metadata: Mapping[str, Json] | None = None,
) -> inspect_ai.Task:
    """The Inspect task that puts questions to a model.

    Args:
        questions: the questions.
        name: of the task.
        solver: what asks them; by default each once.
        metadata: what the log says of the task.
    """
    return inspect_ai.Task(
        dataset=MemoryDataset([_sample(question) for question in questions], name=name),
        solver=solver or ask_as_published(),
        scorer=question_scorer(),
        name=name,
        metadata=dict(metadata or {}),
        config=GenerateConfig(temperature=0.0),
    )


def published_questions(reference: str) -> Callable[..., inspect_ai.Task]:
    """Register the questions about a benchmark as an Inspect task, ``eai/<domain>_questions``."""

    def questions(
        kinds: str | Sequence[str] | None = None,
        forms: str | Sequence[str] | None = None,
        n: int = Wanted().number,
        seed: int = 0,
        rules: bool = True,
        file: str | None = None,
    ) -> inspect_ai.Task:
        with refusing():
            if file is not None:
                return question_task(read_questions(Path(file)).questions, name)
            wanted = Wanted(
                [member(Kind, each, "kind of question") for each in _listed(kinds)] or tuple(Kind),
                [member(Form, each, "form of question") for each in _listed(forms)] or tuple(Form),
                n,
                seed,
                rules,
            )
            return question_task(list(Writer(find_benchmark(reference)).write(wanted)), name)

    name = f"{reference}_questions"
    registered = inspect_ai.task(name=name)(questions)
    if registry_info(registered).name == name:  # Inspect names the package only where it is not editable
        registered = inspect_ai.task(name=f"eai/{name}")(questions)
    return registered


def ask_questions(
    questions: Sequence[Question],
    endpoint: Endpoint,
    folder: Path,
    pace: Pace,
    *,
    watch: Watch = unwatched,
) -> Answers:
    """Ask a model for what the journal in a folder does not hold yet.

    Raises:
        InputError: the folder cannot be used.
        InterruptError: the user ended it.
        EaiError: the run as a whole failed: no such model, a key is missing.
    """
    requests = Requests(endpoint, {each.id: Prompt(each.prompt) for each in questions}, pace=pace)
    about: dict[str, Json] = {JOB: requests.sha256}
    return obtain(
        requests,
        lambda desk: question_task(questions, "questions", ask(desk), about),
        folder / JOURNAL,
        folder / "logs",
        watch=watch,
    )


def _sample(question: Question) -> Sample:
    about = question.model_dump(mode="json", exclude={"prompt"})
    told = {QUESTION: {**about, "prompt": "-"}}
    return Sample(
        id=question.id,
        input=messages_of(Prompt(question.prompt), told),
        target=gold_text(question),
        metadata={**told, "kind": question.kind.value, "task": question.task},
    )


def _listed(names: str | Sequence[str] | None) -> list[str]:
    return names.split(",") if isinstance(names, str) else list(names or ())
