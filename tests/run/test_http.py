"""Requests over HTTP to a local server that misbehaves on demand."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Literal

import pytest

from eai.abilities.protocol import Ability
from eai.base.errors import EaiError, InputError
from eai.benchmarks.suite import open_suite
from eai.results.epochs import ModelAnswers
from eai.run.job import DecodingOptions, QuestionJob, RequestOptions
from eai.studies.variation import ModelEndpoint
from eai.tasks.prompts.prompt import Prompt
from processes import own_process
from run.child import obtain_in_child
from run.server import COUNTED, Log, Reply, serve

PLAN = '{"WALK": ["sofa", "352"]}'
Script = Mapping[str, Sequence[Reply]]
Run = Callable[..., tuple[ModelAnswers, Log]]


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    """A process of its own for Inspect, so that its warnings stay there."""
    with own_process() as pool:
        yield pool


@pytest.fixture
def ask(tmp_path: Path, process: Executor) -> Callable[..., ModelAnswers]:
    """Ask questions of a running server; the answers go to one journal."""

    def obtain(
        url: str,
        task_ids: Collection[str],
        cut_at: tuple[str, ...] = (),
        decoding: DecodingOptions | None = None,
        timeout: int = 60,
        connections: int | None = None,
        model: str = "openai-api/local/scripted",
        answer_limit: int | None = None,
        too_long: Literal["stop", "ask"] = "stop",
    ) -> ModelAnswers:
        job = QuestionJob(
            ModelEndpoint(model, {"max_retries": 1, "api_key": "none"}, url),
            open_suite("virtualhome", Ability.SUBGOAL_DECOMPOSITION),
            {task_id: Prompt(task_id, stop=cut_at) for task_id in task_ids},
            decoding=decoding or DecodingOptions(),
            pace=RequestOptions(
                max_connections=connections, max_retries=0, timeout=timeout, too_long=too_long
            ),
            answer_limit=answer_limit,
        )
        journal, logs = tmp_path / "answers.jsonl", tmp_path / "logs"
        return process.submit(obtain_in_child, job, journal, logs).result(timeout=300)

    return obtain


@pytest.fixture
def run(ask: Callable[..., ModelAnswers]) -> Run:
    """Ask the questions of a script of a server that answers by the script."""

    def serve_and_ask(
        script: Script, cut_at: tuple[str, ...] = (), decoding: DecodingOptions | None = None
    ) -> tuple[ModelAnswers, Log]:
        with serve(script) as served:
            return ask(served.url, script, cut_at, decoding), served.log

    return serve_and_ask


def test_a_failed_request_affects_only_its_own_sample(run: Run) -> None:
    answers, log = run(
        {
            "good": [Reply(PLAN)],
            "busy": [Reply(status=429, retry_after="0.01"), Reply(PLAN)],
            "shaky": [Reply(status=500), Reply(PLAN)],
            "broken": [Reply(status=500)],
            "cut": [Reply(PLAN, cut=True)],
            "empty": [Reply("")],
            "fenced": [Reply(f"```json\n{PLAN}\n```")],
            "quotes": [Reply("{“WALK”: [„sofa“, «352»]}")],
        }
    )
    texts = {task_id: answer.text for (task_id, _), answer in answers.answers.items()}
    assert texts == {
        "good": PLAN,
        "busy": PLAN,
        "shaky": PLAN,
        "empty": "",
        "fenced": f"```json\n{PLAN}\n```",
        "quotes": "{“WALK”: [„sofa“, «352»]}",
    }
    assert {task_id for task_id, _ in answers.failures} == {"broken", "cut"}
    assert "scripted failure 500" in answers.failures["broken", 1]
    assert "Connection" in answers.failures["cut", 1]
    assert log.asked["busy"] == 2
    assert {request["temperature"] for request in log.requests} == {0.0}


CALL = {"id": "1", "type": "function", "function": {"name": "walk", "arguments": "{}"}}
EMPTY_LIST = '{"object": "list", "data": []}'
UNREAD = "the provider's reply cannot be read"
TOO_LONG = "the question is too long for the model's context"
FAULTS = {
    "busy": ([Reply(status=429, retry_after="0.01"), Reply(PLAN)], PLAN),
    "busy, and says not for how long": ([Reply(status=429), Reply(PLAN)], PLAN),
    "busy for ever": ([Reply(status=429, retry_after="0.01")], "RateLimitError: "),
    "out of order for a while": ([Reply(status=500), Reply(PLAN)], PLAN),
    "out of order": ([Reply(status=500)], "InternalServerError: "),
    "reset once": ([Reply(reset=True), Reply(PLAN)], PLAN),
    "reset": ([Reply(reset=True)], "APIConnectionError: "),
    "cut": ([Reply(PLAN, cut=True)], "APIConnectionError: "),
    "half of JSON": ([Reply(body='{"choices": [{"mess')], UNREAD),
    "no JSON": ([Reply(body="<html>Bad gateway</html>")], UNREAD),
    "other JSON": ([Reply(body=EMPTY_LIST)], UNREAD),
    "empty": ([Reply("")], ""),
    "null": ([Reply(message={"content": None})], ""),
    "refusal": ([Reply(message={"content": None, "refusal": "I will not"})], "I will not"),
    "too long a question": (
        [
            Reply(
                status=400,
                body=json.dumps({"error": {"code": "context_length_exceeded", "message": "9 < 10"}}),
            )
        ],
        TOO_LONG,
    ),
    "refused for another reason": (
        [Reply(status=400, body='{"object": "error", "message": "9 < 10", "code": 400}')],
        "BadRequestError: Error code: 400 - ",
    ),
    "filtered": ([Reply("", finish="content_filter")], ""),
    "tool call": ([Reply(message={"content": None, "tool_calls": [CALL]}, finish="tool_calls")], ""),
    "slow drip": ([Reply(PLAN, drip=0.02)], PLAN),
    "500 kB": ([Reply("x" * 500_000)], "x" * 500_000),
    "lone surrogates": ([Reply('["\ud800", "\udfff\ud800"]')], '["\ud800", "\udfff\ud800"]'),
    "controls": ([Reply('["\0\u202e\r\n\u2028"]')], '["\0\u202e\r\n\u2028"]'),
}
"""Fault of a provider -> the resulting answer, or the beginning of the line that reports the failure."""


def test_a_providers_fault_affects_one_sample_and_is_reported_in_one_line(run: Run) -> None:
    answers, _ = run({name: replies for name, (replies, _) in FAULTS.items()})
    texts = {name: answer.text for (name, _), answer in answers.answers.items()}
    reasons = {name: why for (name, _), why in answers.failures.items()}
    failing = {
        name for name, (_, expected) in FAULTS.items() if expected.endswith((": ", UNREAD, "- ", TOO_LONG))
    }
    assert texts == {name: expected for name, (_, expected) in FAULTS.items() if name not in failing}
    assert reasons.keys() == failing
    for name, why in reasons.items():
        assert why.startswith(FAULTS[name][1]), name
        assert len(why.splitlines()) == 1, name


@pytest.mark.parametrize("model", ["openai-api/local/scripted", "openai/gpt-4o"])
def test_an_html_page_instead_of_a_reply_is_reported_as_such(
    ask: Callable[..., ModelAnswers], model: str
) -> None:
    with serve({"page": [Reply(body='"<html>Bad gateway</html>"')]}) as served:
        (why,) = ask(served.url, ("page",), model=model).failures.values()
    assert "AssertionError" not in why
    assert ("non-ChatCompletion response" in why) or why == f"{UNREAD} (it is no completion)"


USAGES: Mapping[str, object] = {
    "nothing counted": dict.fromkeys(COUNTED),
    "words": {**COUNTED, "prompt_tokens": "many"},
    "parts": {**COUNTED, "completion_tokens": 7.5},
    "empty": {},
    "list": [11, 7],
    "text": "18",
    "details": {**COUNTED, "prompt_tokens_details": "none"},
    "negative": {**COUNTED, "prompt_tokens": -11, "completion_tokens": -7},
}


@pytest.mark.parametrize("model", ["openai-api/local/scripted", "openai/gpt-4o"])
def test_an_answer_with_unreadable_usage_is_accepted(ask: Callable[..., ModelAnswers], model: str) -> None:
    script = {name: [Reply(PLAN, usage=usage)] for name, usage in {**USAGES, "good": COUNTED}.items()}
    with serve(script) as served:
        answers = ask(served.url, script, model=model)
    assert answers.failures == {}
    assert {answer.text for answer in answers.answers.values()} == {PLAN}
    taken = {
        name: (each.usage.input_tokens, each.usage.output_tokens)
        for (name, _), each in answers.answers.items()
    }
    assert taken == {**dict.fromkeys(USAGES, (None, None)), "good": (11, 7)}


@pytest.mark.parametrize("status", [401, 404])
def test_an_error_that_no_repetition_mends_stops_the_run_at_once(
    ask: Callable[..., ModelAnswers], tmp_path: Path, status: int
) -> None:
    script = {"first": [Reply(PLAN)]} | {f"{n}": [Reply(status=status, delay=0.2)] for n in range(60)}
    with serve(script) as served:
        told = r"openai-api/local/scripted: \w+: Error code: 40\d.*; the same command resumes from here$"
        with pytest.raises(EaiError, match=told):
            ask(served.url, script, connections=2)
    assert sum(served.log.asked.values()) < 10
    assert len((tmp_path / "answers.jsonl").read_text().splitlines()) == 1


def test_a_run_whose_first_requests_all_fail_stops(ask: Callable[..., ModelAnswers], tmp_path: Path) -> None:
    names = [f"{number}" for number in range(60)]
    with serve({name: [Reply(status=403), Reply(PLAN)] for name in names}) as served:
        told = r"all of the first 10 requests failed: .* 403 .*; the same command resumes from here$"
        with pytest.raises(EaiError, match=told):
            ask(served.url, names, connections=2)
        asked = sum(served.log.asked.values())
        assert 10 <= asked < 20
        resumed = ask(served.url, names)
    assert (len(resumed.answers), len(resumed.failures)) == (asked, len(names) - asked)


@pytest.mark.parametrize("position", [0, 9])
def test_a_run_goes_on_if_one_of_the_first_requests_succeeds(
    ask: Callable[..., ModelAnswers], position: int
) -> None:
    """A slow answer counts, although later requests fail before it."""
    script = [(f"{number}", [Reply(status=403)]) for number in range(20)]
    script.insert(position, ("good", [Reply(PLAN, delay=2)]))
    with serve(dict(script)) as served:
        answers = ask(served.url, dict(script), connections=4)
    assert [*answers.answers] == [("good", 1)]
    assert len(answers.failures) == 20


@pytest.mark.parametrize(
    ("model", "problem"),
    [
        ("openai-api/local/scripted", "refuses the connection at http://127.0.0.1:"),
        ("openrouter/scripted", "refuses the connection; nothing more was asked"),
    ],
    ids=["before the first question", "at a question"],
)
def test_a_port_at_which_no_server_listens_stops_the_run(
    ask: Callable[..., ModelAnswers], model: str, problem: str
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"http://127.0.0.1:{server.getsockname()[1]}/v1"
    with pytest.raises(EaiError, match=problem):
        ask(url, [f"{number}" for number in range(60)], model=model)


def test_a_journal_that_cannot_be_written_stops_the_run_at_once(
    ask: Callable[..., ModelAnswers], tmp_path: Path
) -> None:
    (tmp_path / "answers.jsonl").mkdir()
    script = {f"{n}": [Reply(PLAN, delay=0.2)] for n in range(60)}
    with serve(script) as served, pytest.raises(InputError, match=r"answers\.jsonl: cannot be"):
        ask(served.url, script, connections=2)
    assert sum(served.log.asked.values()) < 10


def test_an_answer_after_the_timeout_is_missing(ask: Callable[..., ModelAnswers]) -> None:
    with serve({"slow": [Reply(PLAN, delay=2)]}) as served:
        answers = ask(served.url, ("slow",), timeout=1)
    assert answers.answers == {}
    assert answers.failures["slow", 1] == "no reply within 1 s (requests.timeout)"


def test_answered_questions_are_not_asked_again(ask: Callable[..., ModelAnswers]) -> None:
    with serve({"good": [Reply(PLAN)], "broken": [Reply(status=400), Reply("mended")]}) as served:
        first = ask(served.url, ("good", "broken"))
        second = ask(served.url, ("good", "broken"))
        warmer = ask(served.url, ("good",), decoding=DecodingOptions(temperature=1.0))
    assert set(first.answers) == {("good", 1)}
    assert set(first.failures) == {("broken", 1)}
    assert second.answers["good", 1] == first.answers["good", 1]
    assert second.answers["broken", 1].text == "mended"
    assert second.failures == {}
    assert warmer.answers["good", 1].request_sha256 != first.answers["good", 1].request_sha256
    assert served.log.asked == {"good": 2, "broken": 2}


def test_sampling_options_reach_the_server_and_change_the_request_digest(
    ask: Callable[..., ModelAnswers],
) -> None:
    sampling = DecodingOptions(temperature=0.7, seed=7, top_p=0.9)
    with serve({"good": [Reply(PLAN)]}) as served:
        plain, sampled = ask(served.url, ("good",)), ask(served.url, ("good",), decoding=sampling)
    assert plain.answers["good", 1].request_sha256 != sampled.answers["good", 1].request_sha256
    asked = [
        (request["temperature"], request.get("seed"), request.get("top_p")) for request in served.log.requests
    ]
    assert asked == [(0.0, None, None), (0.7, 7, 0.9)]


def test_reasoning_is_separated_and_tokens_are_counted(run: Run) -> None:
    answers, _ = run(
        {
            "tags": [Reply(f"<think>first the sofa</think>\n{PLAN}")],
            "end": [Reply(f"first the sofa\n</think>\n{PLAN}")],
            "field": [Reply(PLAN, reasoning="first the sofa")],
        }
    )
    for answer in answers.answers.values():
        assert (answer.text.strip(), answer.reasoning) == (PLAN, "first the sofa")
        assert (answer.usage.input_tokens, answer.usage.output_tokens) == (11, 7)
    assert answers.answers["end", 1].repairs == ("reasoning",)
    assert answers.answers["field", 1].repairs == ()


def test_truncated_answers_are_marked(run: Run) -> None:
    answers, log = run(
        {"long": [Reply('{"a": ["so', finish="length")]}, ("}",), DecodingOptions(max_tokens=5)
    )
    assert answers.answers["long", 1].is_cut_off
    assert answers.answers["long", 1].text == '{"a": ["so'
    assert log.requests[0]["max_tokens"] == 5


def test_the_papers_stop_sequences_are_sent_and_the_brace_is_restored(run: Run) -> None:
    answers, log = run({"cut": [Reply('{"output": ["ON(tv.1)"]')]}, ("}",))
    assert [request["stop"] for request in log.requests] == [["}"]]
    assert answers.answers["cut", 1].text == '{"output": ["ON(tv.1)"]}'
    assert answers.answers["cut", 1].repairs == ("stop_sequence",)


def test_stop_sequences_can_be_left_out(run: Run) -> None:
    answers, log = run({"cut": [Reply('{"output": ["ON(tv.1)"]')]}, ("}",), DecodingOptions(stop=False))
    assert ["stop" in request for request in log.requests] == [False]
    assert answers.answers["cut", 1].text == '{"output": ["ON(tv.1)"]'


@pytest.mark.parametrize(
    "reply",
    [
        Reply(PLAN, unless=("stop",)),
        Reply(PLAN, empty_if=("stop",)),
        Reply(PLAN, unless=("response_format",)),
        Reply(PLAN, empty_if=("response_format",)),
    ],
)
def test_refused_parameters_are_left_out_of_the_second_request(run: Run, reply: Reply) -> None:
    answers, log = run({"task": [reply]}, ("}",), DecodingOptions(structured=True))
    assert answers.answers["task", 1].text == PLAN
    assert [("stop" in r, "response_format" in r) for r in log.requests] == [(True, True), (False, False)]
    assert answers.answers["task", 1].usage.input_tokens == (11 if reply.unless else 22)
    assert answers.answers["task", 1].repairs == ("form_left_out",)


def test_left_out_stop_sequences_are_not_reported_as_a_left_out_schema(run: Run) -> None:
    answers, _ = run({"task": [Reply(PLAN, unless=("stop",))]}, ("}",))
    assert answers.answers["task", 1].repairs == ()


def test_the_default_limit_is_sent_and_a_cut_answer_counts(ask: Callable[..., ModelAnswers]) -> None:
    with serve({"loop": [Reply("sofa sofa", finish="length")]}) as served:
        answers = ask(served.url, ("loop",), answer_limit=1024)
    assert [request["max_tokens"] for request in served.log.requests] == [1024]
    assert answers.answers["loop", 1].is_cut_off


def test_a_limit_of_the_user_replaces_the_default(ask: Callable[..., ModelAnswers]) -> None:
    with serve({"short": [Reply(PLAN)]}) as served:
        ask(served.url, ("short",), decoding=DecodingOptions(max_tokens=7))
    assert [request["max_tokens"] for request in served.log.requests] == [7]


@pytest.mark.parametrize(
    "cut",
    [
        Reply("<think>first the sofa", finish="length"),
        Reply("", reasoning="first the sofa", finish="length"),
        Reply("", usage={**COUNTED, "completion_tokens_details": {"reasoning_tokens": 7}}, finish="length"),
    ],
)
def test_a_model_that_reasons_is_asked_again_without_the_default_limit(
    ask: Callable[..., ModelAnswers], cut: Reply
) -> None:
    with serve({"a": [cut, Reply(PLAN)], "b": [Reply(PLAN)]}) as served:
        answers = ask(served.url, ("a", "b"), connections=1, answer_limit=1024)
    assert [request.get("max_tokens") for request in served.log.requests] == [1024, None, None]
    assert {answer.text for answer in answers.answers.values()} == {PLAN}
    assert answers.answers["a", 1].usage.input_tokens == 22


VLLM_REFUSAL = json.dumps(
    {
        "error": {
            "message": "This model's maximum context length is 2048 tokens. However, you requested 3072 "
            "tokens (2048 in the messages, 1024 in the completion).",
            "type": "BadRequestError",
            "code": 400,
        }
    }
)


def test_a_question_that_fits_without_the_default_limit_is_asked_without_it(
    ask: Callable[..., ModelAnswers],
) -> None:
    with serve({"a": [Reply(status=400, body=VLLM_REFUSAL), Reply(PLAN)]}) as served:
        answers = ask(served.url, ("a",), ("}",), answer_limit=1024)
    requests = [(request.get("max_tokens"), "stop" in request) for request in served.log.requests]
    assert requests == [(1024, True), (None, True)]
    assert answers.answers["a", 1].text == PLAN


def test_a_limit_that_a_server_does_not_allow_is_sent_no_more(ask: Callable[..., ModelAnswers]) -> None:
    message = "max_tokens is too large: 36000. This model supports at most 16384 completion tokens."
    refused = Reply(status=400, body=json.dumps({"error": {"message": message, "code": "invalid_value"}}))
    with serve({"a": [refused, Reply(PLAN)], "b": [Reply(PLAN)]}) as served:
        answers = ask(served.url, ("a", "b"), connections=1, answer_limit=36_000)
    assert [request.get("max_tokens") for request in served.log.requests] == [36_000, None, None]
    assert answers.failures == {}


def test_the_first_refusal_that_names_the_context_stops_the_run(ask: Callable[..., ModelAnswers]) -> None:
    long, refused = "word " * 2048, Reply(status=400, body=VLLM_REFUSAL)
    script = {f"{number} {long}": [refused] for number in range(30)} | {"short": [Reply(PLAN)]}
    problem = r"30 of 31 tasks of \S+ \S+ need more than 2,048 tokens \(2,\d+ to 2,\d+\), by estimate.*kept"
    with serve(script) as served, pytest.raises(EaiError, match=problem):
        ask(served.url, script, connections=1)
    assert sum(served.log.asked.values()) <= 2


def test_long_questions_are_asked_all_the_same_if_the_user_wants_it(ask: Callable[..., ModelAnswers]) -> None:
    long = "word " * 2048
    with serve({long: [Reply(status=400, body=VLLM_REFUSAL)], "short": [Reply(PLAN)]}) as served:
        answers = ask(served.url, (long, "short"), too_long="ask")
    assert [*answers.failures.values()] == [f"{TOO_LONG} of 2,048 tokens"]
    assert [*answers.answers] == [("short", 1)]
