"""Signs that a server ignored a part of the requests."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import pytest

from by_path import ROOT
from eai.abilities.attempt import AnswerUsage
from eai.abilities.protocol import Ability
from eai.benchmarks.suite import open_suite
from eai.results.trials import Answer
from eai.run.job import DecodingOptions, QuestionJob
from eai.run.remarks import describe_unfulfilled_requests
from eai.studies.variation import ModelEndpoint
from eai.tasks.prompts.prompt import Prompt
from processes import eai
from run.server import Reply, serve

GOOD, OTHER = '{"output": "(:action walk)"}', "Here it is: (:action walk)"


@pytest.fixture
def job() -> QuestionJob:
    suite = open_suite("virtualhome", Ability.TRANSITION_MODELING)
    return QuestionJob(ModelEndpoint("openai/gpt-4o"), suite, {"27_2": Prompt("word " * 2000)})


def answer(text: str, tokens: int | None = None, stop_reason: str = "stop") -> Answer:
    return Answer("27_2", 1, "", "", text, "", stop_reason, (), AnswerUsage(tokens, 10))


@pytest.mark.parametrize(
    ("text", "stop_reason", "is_ignored"),
    [
        (GOOD, "stop", False),
        (OTHER, "stop", True),
        ('{"output": 3}', "stop", True),
        (OTHER, "max_tokens", False),
    ],
)
def test_an_ignored_schema_is_found_from_the_answers(
    job: QuestionJob, text: str, stop_reason: str, *, is_ignored: bool
) -> None:
    answers = {("27_2", 1): answer(text, stop_reason=stop_reason), ("27_2", 2): answer(GOOD)}
    assert describe_unfulfilled_requests(job, answers) == ()
    remarks = describe_unfulfilled_requests(replace(job, decoding=DecodingOptions(structured=True)), answers)
    assert bool(remarks) is is_ignored
    if is_ignored:
        assert remarks[0].endswith("1 of 2 answers do not have the requested form")


@pytest.mark.parametrize(
    ("tokens", "is_cut"),
    [(None, False), (2500, False), (1250, False), (1249, True), (256, True), (11, False)],
)
def test_a_prompt_with_far_too_few_tokens_was_cut_off(
    job: QuestionJob, tokens: int | None, *, is_cut: bool
) -> None:
    remarks = describe_unfulfilled_requests(job, {("27_2", 1): answer(GOOD, tokens)})
    assert bool(remarks) is is_cut
    if is_cut:
        assert f"it counted {tokens:,} tokens in a prompt of 10,000 characters (1 of 1 prompts)" in remarks[0]


def test_the_word_counts_of_a_built_in_model_are_no_sign_of_cut_prompts(job: QuestionJob) -> None:
    job = replace(job, endpoint=ModelEndpoint("eai/noisy"))
    assert describe_unfulfilled_requests(job, {("27_2", 1): answer(GOOD, 300)}) == ()


@pytest.mark.parametrize(
    ("harness", "reply", "remark"),
    [
        (
            "react",
            Reply("Go and press it."),
            "in 1 of 1 episodes a reply called no tool ('Go and press it.'), in 1",
        ),
        (
            "react",
            Reply("Go and press it."),
            "of them before any action; agent.harness=text or auto takes lines",
        ),
        (
            "auto",
            Reply("DONE"),
            "in 1 of 1 episodes a reply called no tool ('DONE'); later commands are lines",
        ),
        ("auto", Reply("DONE", unless=("tools",)), "a reply called no tool ('the server refused tools: "),
        ("text", Reply("DONE"), None),
    ],
)
def test_closing_lines_name_a_reply_without_a_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harness: str, reply: Reply, remark: str | None
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples/lamps")
    with serve(defaultdict(lambda: [reply])) as served:
        model = ("--model", "openai-api/local/scripted", "--model-base-url", served.url, "-M", "api_key=none")
        what = ("--domain", "lamps:lamps", "--ability", "acting", "--limit", 1)
        outcome = eai("run", *model, *what, "--with", f"agent.harness={harness}", "--out", tmp_path)
    assert outcome.status == 0, outcome.err
    told = " ".join(outcome.err.split())
    assert remark in told if remark is not None else "called no tool" not in told
