"""Answers that have the reference's verdict in ``../shared/oracle``."""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path
from typing import NamedTuple

ORACLE = Path(__file__).resolve().parents[3] / "shared" / "oracle"

NO_MODELS = ("gold", "gt", "perturb", "helm")
"""How the names of files begin that hold no model's answers."""

WITHOUT_ANSWERS = "third_party_run.json.gz"
"""A file of verdicts whose answers are in other files."""

OTHER_PLANNER = ".fd26.6"
"""In the name of a file that repeats the answers of another, with the outcomes of another planner."""


class OracleAnswer(NamedTuple):
    """An answer as it is in a file.

    Attributes:
        identifier: the task's id, and after an `@` what tells several answers to one task apart.
        text: the answer; empty where there is none.
    """

    identifier: str
    text: str

    @property
    def task_id(self) -> str:
        return self.identifier.partition("@")[0]


def require_oracle() -> None:
    """End with a message where the oracle is not on this machine."""
    if not ORACLE.is_dir():
        sys.exit("the oracle is not beside the repository")


def answer_files(suite: str) -> list[Path]:
    """The files of a suite, `DOMAIN/ABILITY`, by name; each answer is in one of them."""
    files = sorted((ORACLE / suite).glob("*.json.gz"))
    return [path for path in files if OTHER_PLANNER not in path.name and path.name != WITHOUT_ANSWERS]


def model_files(suite: str) -> list[Path]:
    """Those of `answer_files` that a model wrote."""
    return [path for path in answer_files(suite) if not path.name.startswith(NO_MODELS)]


def oracle_answers(path: Path) -> list[OracleAnswer]:
    """The answers of a file, in its order."""
    content = json.loads(gzip.decompress(path.read_bytes()))
    return [
        OracleAnswer(row.get("id", row.get("identifier")), row.get("llm_output", row.get("response")) or "")
        for row in content.get("tasks") or content["records"]
    ]
