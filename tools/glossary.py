"""Write docs/glossary.md: `python tools/glossary.py`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "glossary.md"

NOUNS = {
    "Formula": "A goal, subgoal, condition or derived predicate, on one state or on a sequence of states.",
    "State": "All facts that hold in a scene at one time.",
    "Operator": "A kind of action: ordered checks, and effects.",
    "Domain": "A declared world: predicates, derived predicates and operators.",
    "Trajectory": "The states and steps of an executed plan, up to its first error.",
    "Episode": "A task played one action at a time, with full diagnosis.",
    "Planner": "Searches for a plan on a declared domain.",
    "SearchResult": "How a search ended, its plan, and its effort.",
    "Task": "A scene at the start, a goal, an instruction, and often a gold plan.",
    "TaskSet": "Tasks by id, each built at its first use.",
    "Goal": "A condition that a task asks for, about states, relations or actions.",
    "Benchmark": "A world with tasks, and how its answers are written.",
    "Notation": "How answers are written and read: `PlanNotation`, `GoalNotation`, `SubgoalNotation`.",
    "Ability": "A kind of question, with how its answers are judged; registered by name.",
    "Prompt": "The text that is sent to a model for a task.",
    "Answer": "The text that a model returns.",
    "Verdict": "The result of scoring one answer.",
    "Fault": "The reason why an action is impossible: the failed check, and the kind of error.",
    "Explanation": "A verdict step by step, in words.",
    "Record": "An answer's verdict, evidence and origin as one line of a file.",
    "Run": "The records of one model on one suite.",
    "Rate": "A numerator and a denominator, with an interval.",
    "Table": "Columns and cells, written to terminal, Markdown, LaTeX, CSV and JSON by one set of writers.",
    "Study": "A variation around benchmarks and abilities: options, beliefs, tables, figures.",
    "RunSpec": "The models, tasks, studies and limits of a run.",
}
"""Nouns that the other texts of the project use, with their meanings."""

HEAD = """\
# Glossary

On this page you can look up the 25 nouns of this project. The [API page](api.md) shows the classes.
`python tools/glossary.py` writes this page.

| noun | meaning |
|---|---|
"""


class PublicClass(NamedTuple):
    """A class without a leading underscore, its module, and the first sentence of its docstring."""

    module: str
    name: str
    meaning: str


def list_public_classes() -> Iterator[PublicClass]:
    """Yield all public classes of the package, by module."""
    source = ROOT / "src" / "eai"
    for path in sorted(source.rglob("*.py")):
        module = ".".join(path.relative_to(source).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield PublicClass(module, node.name, (ast.get_docstring(node) or "").partition("\n\n")[0])


def make_page() -> str:
    """Return the content of the page."""
    return HEAD + "".join(f"| {noun} | {meaning} |\n" for noun, meaning in NOUNS.items())


if __name__ == "__main__":
    PAGE.write_text(make_page(), encoding="utf-8")
