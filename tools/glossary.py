"""Writes docs/glossary.md from the docstrings of all public classes: `python tools/glossary.py`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "glossary.md"

NOUNS = {
    "Formula": "A goal, subgoal, condition or derived predicate, on one state or a course of states.",
    "State": "All that is true of a scene at one moment.",
    "Operator": "A kind of action: ordered checks, and effects.",
    "Domain": "A declared world: predicates, derived predicates and operators.",
    "Trajectory": "The states and steps of a plan that is carried out, up to its first error.",
    "Episode": "A task played one action at a time, with full diagnosis.",
    "Planner": "Searches for a plan on a declared domain.",
    "SearchResult": "How a search ended, its plan, and its effort.",
    "Task": "A scene at the start, a goal, an instruction, and often a gold plan.",
    "TaskSet": "Tasks by id, built when they are asked for.",
    "Goal": "A part of what a task asks for: of states, relations or actions.",
    "Benchmark": "A world with tasks, and how its answers are written.",
    "Notation": "How answers are written and read: `PlanNotation`, `GoalNotation`, `SubgoalNotation`.",
    "Ability": "A kind of question, with how its answers are judged; registered by name.",
    "Prompt": "The text that a model is sent for a task.",
    "Answer": "The text that a model returns.",
    "Verdict": "The result of scoring one answer.",
    "Fault": "Why an action is impossible: the failed check, and the kind of error.",
    "Explanation": "A verdict step by step, in words.",
    "Record": "An answer's verdict, evidence and origin as one line of a file.",
    "Run": "The records of one model on one suite.",
    "Rate": "A numerator and a denominator, with an interval.",
    "Table": "Columns and cells, written to terminal, Markdown, LaTeX, CSV and JSON by one set of writers.",
    "Study": "A variation around benchmarks and abilities: options, beliefs, tables, figures.",
    "RunSpec": "The models, tasks, studies and limits of a run.",
}
"""The nouns that the rest is described with."""

HEAD = """\
# Glossary

On this page you can look up the 25 nouns of this project, and every public class.
`python tools/glossary.py` writes it from the docstrings.

## The nouns

| noun | meaning |
|---|---|
"""


class PublicClass(NamedTuple):
    """A class that a module shows: where it stands, and its first sentence."""

    package: str
    module: str
    name: str
    meaning: str


def public_classes() -> Iterator[PublicClass]:
    """All public classes, by module and name."""
    source = ROOT / "src" / "eai"
    for path in sorted(source.rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                meaning = (ast.get_docstring(node) or "").partition("\n\n")[0].replace("\n", " ")
                yield PublicClass(parts[0], ".".join(parts), node.name, meaning.replace("|", "\\|"))


def page() -> str:
    """The whole page."""
    nouns = "".join(f"| {noun} | {meaning} |\n" for noun, meaning in NOUNS.items())
    classes = [each for each in public_classes() if each.name not in NOUNS]
    packages = dict.fromkeys(each.package for each in classes)
    return HEAD + nouns + "".join(_section(name, classes) for name in packages)


def _section(package: str, classes: list[PublicClass]) -> str:
    rows = "".join(
        f"| `{each.name}` | `{each.module}` | {each.meaning} |\n"
        for each in sorted(classes, key=lambda each: each.name.lower())
        if each.package == package
    )
    return f"\n## {package}\n\n| class | module | meaning |\n|---|---|---|\n{rows}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
