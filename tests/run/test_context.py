from __future__ import annotations

from collections.abc import Mapping

import pytest
from inspect_ai.model import get_model

from eai.abilities.protocol import Ability
from eai.base.errors import EaiError
from eai.benchmarks.suite import open_suite
from eai.run.context import (
    GOLD_LENGTHS,
    MIN_ANSWER_TOKENS,
    choose_default_max_answer_tokens,
    describe_long_tasks,
    estimate_longest_answer,
    estimate_prompt_tokens,
    estimate_tokens,
    find_long_tasks,
    read_context_length,
    require_server_at_model_address,
)
from eai.run.job import DecodingOptions
from eai.tasks.prompts.prompt import Prompt
from run.server import serve
from suites import answer_book

PLANS = ("virtualhome", Ability.ACTION_SEQUENCING)

LLAMA_CPP = {"id": "small", "object": "model", "owned_by": "llamacpp", "meta": {"n_ctx_train": 8192}}
OLLAMA = {"id": "small:latest", "object": "model", "created": 1, "owned_by": "library"}
SHOWN = {"parameters": 'stop "<|eot|>"\nnum_ctx 2048', "model_info": {"llama.context_length": 8192}}

SERVERS: Mapping[str, Mapping[str, object]] = {
    "vllm": {
        "/v1/models": {"data": [{"id": "other", "max_model_len": 9}, {"id": "small", "max_model_len": 2048}]}
    },
    "vllm, another name": {"/v1/models": {"data": [{"id": "/models/small", "max_model_len": 2048}]}},
    "hosted": {"/v1/models": {"data": [{"id": "small", "context_length": 2048}]}},
    "llama.cpp": {"/v1/models": {"data": [{**LLAMA_CPP, "meta": {"n_ctx": 2048, "n_ctx_train": 8192}}]}},
    "llama.cpp, older": {
        "/v1/models": {"data": [LLAMA_CPP]},
        "/props": {"default_generation_settings": {"n_ctx": 2048}, "total_slots": 1},
    },
    "llama.cpp, training alone": {"/v1/models": {"data": [{**LLAMA_CPP, "meta": {"n_ctx_train": 2048}}]}},
    "ollama, running": {
        "/v1/models": {"data": [OLLAMA]},
        "/api/ps": {"models": [{"name": "small:latest", "context_length": 2048}]},
        "/api/show": {"model_info": {"llama.context_length": 8192}},
    },
    "ollama, parameter": {"/v1/models": {"data": [OLLAMA]}, "/api/ps": {"models": []}, "/api/show": SHOWN},
    "ollama, training alone": {"/api/show": {"model_info": {"llama.context_length": 2048}}},
}
"""Pages of servers with a context of 2,048 tokens."""


@pytest.mark.parametrize("pages", SERVERS.values(), ids=SERVERS)
def test_the_context_of_a_server_is_read(pages: Mapping[str, object]) -> None:
    with serve({}, pages) as served:
        model = get_model("openai-api/local/small", base_url=served.url, api_key="none", memoize=False)
        require_server_at_model_address(model)
        assert read_context_length(model) == 2048


@pytest.mark.parametrize(
    "page", [None, [], "text", {"data": None}, {"data": ["small"]}, {"data": [{"id": "small", "meta": 7}]}]
)
def test_a_server_that_states_no_context_has_none(page: object) -> None:
    with serve({}, {"/v1/models": page, "/props": page, "/api/ps": page, "/api/show": page}) as served:
        model = get_model("openai-api/local/small", base_url=served.url, api_key="none", memoize=False)
        require_server_at_model_address(model)
        assert read_context_length(model) is None


def test_an_address_without_a_server_is_an_error() -> None:
    with serve({}) as served:
        model = get_model("openai-api/local/small", base_url=served.url, api_key="none", memoize=False)
    assert read_context_length(model) is None
    with pytest.raises(EaiError, match=r"local/small: the server refuses the connection at http://127"):
        require_server_at_model_address(model)


def test_tokens_are_parts_of_words_digits_and_signs() -> None:
    assert estimate_tokens('{"WALK": ["sofa", "352"]}') == 11
    assert estimate_tokens("washing_machine\n    goal") == 5
    assert estimate_tokens("") == 0
    prompt = Prompt("two words", system="one", turns=(("answer", "a reply"),))
    assert estimate_prompt_tokens(prompt) == 6


def test_answers_may_be_four_times_as_long_as_the_longest_gold_answer() -> None:
    suite = open_suite(*PLANS)
    longest = estimate_longest_answer(suite)
    assert longest > MIN_ANSWER_TOKENS / GOLD_LENGTHS
    assert choose_default_max_answer_tokens("openai-api/local/small", suite, DecodingOptions()) == 4 * longest


@pytest.mark.parametrize(
    ("model", "decoding"),
    [
        ("eai/oracle", DecodingOptions()),
        ("openai/o3-mini", DecodingOptions()),
        ("openai-api/vllm/Qwen/Qwen3-4B", DecodingOptions()),
        ("openai-api/vllm/deepseek-ai/DeepSeek-R1", DecodingOptions()),
        ("openai-api/local/small", DecodingOptions(reasoning_effort="low")),
        ("openai-api/local/small", DecodingOptions(reasoning_tokens=100)),
        ("openai-api/local/small", DecodingOptions(max_tokens=7)),
    ],
)
def test_models_that_reason_and_users_who_set_a_limit_get_no_default(
    model: str, decoding: DecodingOptions
) -> None:
    assert choose_default_max_answer_tokens(model, open_suite(*PLANS), decoding) is None


def test_turns_have_no_default_limit() -> None:
    assert (
        choose_default_max_answer_tokens(
            "openai/gpt-4o", open_suite("virtualhome", Ability("acting")), DecodingOptions()
        )
        is None
    )


def test_tasks_that_do_not_fit_are_counted_with_their_lengths() -> None:
    suite = open_suite(*PLANS)
    prompts = {name: Prompt("word " * number) for name, number in (("a", 900), ("b", 1100), ("c", 2000))}
    long_tasks = find_long_tasks(suite, prompts, 1000, 2048)
    assert long_tasks.needs == {"b": 2100, "c": 3000}
    assert describe_long_tasks(2048, [long_tasks, find_long_tasks(suite, prompts, 1, 2048)]) == (
        "2 of 3 tasks of virtualhome action_sequencing need more than 2,048 tokens (2,100 to 3,000)"
    )


def test_a_task_fits_if_its_question_and_its_gold_answer_do() -> None:
    suite = open_suite(*PLANS)
    gold = answer_book(*PLANS)
    prompts = {task_id: Prompt("word " * 1000) for task_id in gold}
    needs = find_long_tasks(suite, prompts, None, 1000).needs
    assert needs == {task_id: 1000 + estimate_tokens(gold[task_id].text) for task_id in gold}
    shortest, longest = min(needs.values()), max(needs.values())
    assert longest == 1000 + estimate_longest_answer(suite)
    assert 0 < len(find_long_tasks(suite, prompts, None, shortest).needs) < len(gold)
    assert find_long_tasks(suite, prompts, None, longest).needs == {}
