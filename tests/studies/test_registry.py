from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from base.test_entry_points import declared
from command_line import Command
from eai.base.errors import InputError
from eai.studies import registry
from studies.report.samples import action_run, write_runs
from studies.told import read_table

STRANGER = """
from pydantic import Field

from eai.tasks.options import Options
from eai.results.table import Estimate, Table
from eai.results.lines import make_task_rate_contribution
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.studies.study import Analysis, Study


class Words(Options):
    \"\"\"How short answers are.

    Attributes:
        most: The most characters of a short answer.
    \"\"\"

    most: int = Field(default=40, ge=1)


def analyze(records, chosen):
    answers = records.make_tidy_tables_of_comparable_runs(features=False).answers
    shares = [make_rate_contribution_of_answer(answer.characters <= chosen.most) for answer in answers]
    cases = [make_task_rate_contribution(*pair) for pair in zip(answers, shares)]
    columns, rows = ("answers", "short"), ((len(answers), Estimate.from_task_rate_contributions(cases)),)
    yield Analysis([Table("brevity", "Short answers", "In percent.", columns, rows)])


BREVITY = Study("brevity", "How short answers are.", choices=Words, analyze=analyze)
"""

ENTERED = """
import sys
from pathlib import Path
import eai
from eai import cli

FUNCTION = 1  # of code that is no module and no body of a class
entered, root = set(), str(Path(eai.__file__).parent)

def watch(frame, event, argument):
    code = frame.f_code
    if event == "call" and code.co_flags & FUNCTION and code.co_filename.startswith(root):
        entered.add(code.co_filename)

sys.setprofile(watch)
cli.app(sys.argv[1:], standalone_mode=False)
sys.setprofile(None)
print(len(entered))
"""


SOURCE = Path(registry.__file__).parents[1]


def list_present_studies() -> dict[str, str]:
    """Return the module of each declared study, without extensions that `tools/without.py` removed."""
    modules = {name: place.partition(":")[0] for name, place in declared(registry.GROUP).items()}
    files = {name: SOURCE.parent.joinpath(*module.split(".")) for name, module in modules.items()}
    return {name: modules[name] for name, file in files.items() if file.with_suffix(".py").is_file()}


def test_every_declared_study_is_found_by_its_name() -> None:
    assert sorted(registry.list_study_names()) == sorted(list_present_studies())
    for name in registry.list_study_names():
        assert registry.find_study(name).name == name


def test_every_folder_of_studies_has_one_value_and_every_value_is_registered() -> None:
    """It is the only public value of its ``study.py``."""
    files = [*SOURCE.glob("studies/*/study.py"), *SOURCE.glob("extensions/*/study.py")]
    modules = {".".join(("eai", *file.relative_to(SOURCE).with_suffix("").parts)) for file in files}
    assert set(list_present_studies().values()) == modules


def test_a_study_of_another_distribution_is_found_and_run(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "brevity.py").write_text(STRANGER)
    about = tmp_path / "brevity-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: brevity\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[{registry.GROUP}]\nbrevity = brevity:BREVITY\n")
    monkeypatch.syspath_prepend(tmp_path)
    registry._find_study_entry_points.cache_clear()
    try:
        told = eai("analyze").out
        assert "brevity" in told
        assert "The most characters of a short answer." in told
        runs, out = write_runs(tmp_path / "runs", [action_run("first")]), tmp_path / "out"
        done = eai("analyze", "brevity", runs, "--with", "most=3", "--out", out)
        assert (done.status, done.out) == (0, f"1 table, 0 plots; in {out}\n")
        (row,) = read_table(out / "brevity.csv")
        assert row["answers"] == row["short_denominator"]
        assert "brevity has most" in eai("analyze", "brevity", runs, "--with", "least=1", "--out", out).err
    finally:
        registry._find_study_entry_points.cache_clear()


def test_an_unknown_study_is_refused_with_similar_names(eai: Command, tmp_path: Path) -> None:
    assert "did you mean errors?" in eai("analyze", "error", tmp_path).err
    with pytest.raises(InputError, match="did you mean goals"):
        registry.find_study("goal")


def test_the_study_of_errors_imports_few_modules(tmp_path: Path) -> None:
    """It opens no benchmark for the titles of plots, and imports no other study."""
    runs = write_runs(tmp_path / "runs", [action_run("first")])
    words = [sys.executable, "-c", ENTERED, "analyze", "errors", str(runs), "--out", str(tmp_path / "out")]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) <= 40
