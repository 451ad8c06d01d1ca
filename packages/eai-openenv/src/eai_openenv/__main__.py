"""``eai-openenv``: start the server."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer
import uvicorn

from eai.agents.rules import TRAINING, Feedback, GameRules, Observe
from eai.base.errors import EaiError, InputError
from eai.results.reward import Shaping
from eai_openenv.connections import TimeLimitedProtocol
from eai_openenv.limits import Limits
from eai_openenv.server import create_app
from eai_openenv.tasks import Tasks

app = typer.Typer(add_completion=False)


@app.command()
def serve(
    domain: Annotated[
        list[str],
        typer.Option(
            help="[SPLIT=]DOMAIN, such as test=tasks/test.jsonl: virtualhome, behavior, module:object or a "
            "task file. Without SPLIT, the split has the name of its domain. Repeat the option for several."
        ),
    ],
    shaping: Annotated[
        Shaping, typer.Option(help="Shaping of the rewards of answers and episodes.")
    ] = TRAINING.reward,
    turns: Annotated[int, typer.Option(min=1, help=GameRules.describe_option("max_steps"))] = 50,
    observe: Annotated[Observe, typer.Option(help=GameRules.describe_option("observe"))] = TRAINING.observe,
    feedback: Annotated[
        Feedback, typer.Option(help=GameRules.describe_option("feedback"))
    ] = TRAINING.feedback,
    host: Annotated[
        str,
        typer.Option(help="Address to listen on. There is no password: other machines at your own risk."),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on; 0 for any free port.")
    ] = 8000,
    sessions: Annotated[int, typer.Option(min=1, help="Maximum number of open sessions.")] = 64,
    idle: Annotated[float, typer.Option(min=1, help="Seconds after which an idle session is closed.")] = 600,
    answers: Annotated[int, typer.Option(min=1, help="Maximum number of answers in a request.")] = 1024,
) -> None:
    """Serve household tasks to OpenEnv's clients, and rewards to anybody.

    Example: eai-openenv --domain virtualhome --domain test=tasks/fresh.jsonl
    """
    limits = Limits(sessions=sessions, idle_seconds=idle, answers=answers)
    try:
        rules = GameRules(max_steps=turns, observe=observe, feedback=feedback, reward=shaping)
        application = create_app(Tasks(_parse_splits(domain)), rules, limits)
    except EaiError as error:
        typer.echo(f"eai-openenv: {error}", err=True)
        raise typer.Exit(2) from error
    uvicorn.run(
        application,
        host=host,
        port=port,
        http=TimeLimitedProtocol,
        timeout_graceful_shutdown=1,
        ws_max_size=limits.message_bytes,
        log_level="warning",
    )


def _parse_splits(texts: Iterable[str]) -> dict[str, str]:
    """Parse texts `SPLIT=BENCHMARK` into a mapping from split to benchmark.

    Raises:
        InputError: A split is given twice.
    """
    splits: dict[str, str] = {}
    for text in texts:
        split, _, benchmark = text.partition("=")
        if split in splits:
            raise InputError(f"--domain: the split {split} is given twice; give another name to one")
        splits[split] = benchmark or text
    return splits


if __name__ == "__main__":
    app()
