"""Answers in ``../shared/oracle``, which has the reference package's verdicts on them."""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path
from typing import NamedTuple

ORACLE = Path(__file__).resolve().parents[3] / "shared" / "oracle"

NO_MODELS = ("gold", "gt", "perturb", "helm")
"""Prefixes of the names of files without answers of models."""

WITHOUT_ANSWERS = "third_party_run.json.gz"
"""Name of a file of verdicts whose answers are in other files."""

OTHER_PLANNER = ".fd26.6"
"""Part of the name of files with repeated answers and the outcomes of another planner."""


class OracleAnswer(NamedTuple):
    """An answer in a file of the oracle.

    Attributes:
        identifier: Id of the task, and after an `@` a label if the task has several answers.
        text: The answer, or an empty text if the file has none.
    """

    identifier: str
    text: str

    @property
    def task_id(self) -> str:
        return self.identifier.partition("@")[0]


def require_oracle() -> None:
    """Exit with a message if the oracle is not on this machine."""
    if not ORACLE.is_dir():
        sys.exit("the oracle is not beside the repository")


def answer_files(suite: str) -> list[Path]:
    """Return the files of a suite, `DOMAIN/ABILITY`, by name. Each answer is in one file."""
    files = sorted((ORACLE / suite).glob("*.json.gz"))
    return [path for path in files if OTHER_PLANNER not in path.name and path.name != WITHOUT_ANSWERS]


def model_files(suite: str) -> list[Path]:
    """Return the files of a suite that hold answers of models."""
    return [path for path in answer_files(suite) if not path.name.startswith(NO_MODELS)]


def oracle_answers(path: Path) -> list[OracleAnswer]:
    """Yield the answers of a file in order."""
    content = json.loads(gzip.decompress(path.read_bytes()))
    return [
        OracleAnswer(row.get("id", row.get("identifier")), row.get("llm_output", row.get("response")) or "")
        for row in content.get("tasks") or content["records"]
    ]
