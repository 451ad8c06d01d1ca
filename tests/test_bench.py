from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.overnight import ChildCost, WorkLine, measure_line, read_estimated_tasks
from bench.page import HEAD, PAGE, format_measurement, format_section, format_table, make_page
from bench.record import describe_measurement
from bench.result import (
    FOLDER,
    Claim,
    Figure,
    FigureTable,
    Measurement,
    Result,
    format_result,
    read_result,
    read_results,
    replace_figures,
    replace_rows,
)
from by_path import ROOT

RESULTS = read_results()
MEASURED = Measurement("python -m bench coverage", "abc1234", "2 cores, 24 GB")
TABLE = FigureTable("Speed", ("suite", "cold", "steady"), (("goals", 1, 2.5), ("plans", 3, "-")))


def test_the_page_of_benchmarks_is_up_to_date() -> None:
    """If this fails, run `python -m bench page`."""
    assert PAGE.read_text(encoding="utf-8") == make_page()


def test_hand_written_words_of_the_page_are_at_most_3000() -> None:
    texts = [HEAD]
    for result in RESULTS.values():
        texts += [result.title, *(claim.claim for claim in result.claims)]
        texts += [text for table in result.tables for text in (table.title, *table.columns)]
    assert sum(len(re.findall(r"\S*\w\S*", text)) for text in texts) <= 3000


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_file_is_as_it_would_be_written(name: str) -> None:
    path = FOLDER / f"{name}.json"
    assert format_result(read_result(path)) == path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_file_names_a_machine_without_paths_and_each_claim_once(name: str) -> None:
    result = RESULTS[name]
    assert result.measured.machine
    assert "/" not in result.measured.machine
    claims = [claim.claim for claim in result.claims]
    assert len(claims) == len(set(claims))
    for table in result.tables:
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_commands_of_results_name_programs_that_exist() -> None:
    listing = run().stdout
    commands = [result.measured.command or "" for result in RESULTS.values()]
    names = [name for command in commands for name in re.findall(r"python -m bench (\w+)", command)]
    assert len(names) > 20
    assert [name for name in names if f"\n  {name} " not in listing] == []


def test_claims_that_programs_write_are_in_the_result_files() -> None:
    calls = [*written_claims()]
    missing = [(name, claim) for name, claim in calls if claim not in page_claims(name)]
    assert missing == []


def page_claims(name: str) -> list[str]:
    return [claim.claim for claim in RESULTS[name].claims]


def written_claims() -> Iterator[tuple[str, str]]:
    """Yield the result and the claim of each figure that a call of `write_figures` names."""
    for path in [*(ROOT / "bench").glob("*.py"), *(ROOT / "tests/differential").glob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "write_figures":
                name, figures = node.args
                assert isinstance(name, ast.Constant), path
                assert isinstance(figures, ast.Dict), path
                for key in figures.keys:
                    assert isinstance(key, ast.Constant), path
                    yield str(name.value), str(key.value)


def test_new_rows_replace_rows_with_the_same_first_cell_or_are_added() -> None:
    table = replace_rows(TABLE, [("plans", 4, 5), ("operators", 6, 7)], 1, MEASURED)
    assert table.rows == (("goals", 1, 2.5), ("plans", 4, 5), ("operators", 6, 7))
    assert table.measured == {"plans": MEASURED, "operators": MEASURED}


def test_a_row_of_another_width_is_an_error() -> None:
    with pytest.raises(ValueError, match="expected 3 cells, not 2"):
        replace_rows(TABLE, [("plans", 4)], 1, MEASURED)


def test_a_new_figure_replaces_the_figure_of_its_claim_only() -> None:
    claims = [Claim("steps", 1), Claim("plans", 2)]
    assert replace_figures(claims, {"plans": 3}, MEASURED) == [Claim("steps", 1), Claim("plans", 3, MEASURED)]


def test_a_figure_without_a_claim_is_an_error() -> None:
    with pytest.raises(ValueError, match="no claim of the result has this text: goals"):
        replace_figures([Claim("steps", 1)], {"goals": 3}, MEASURED)


def test_a_table_shows_numbers_with_separators_and_aligned_to_the_right() -> None:
    lines = format_table(FigureTable("Speed", ("suite", "cold"), (("goals", 1234567), ("plans", 2.5))))
    assert lines == ["| suite | cold |", "| --- | --: |", "| goals | 1,234,567 |", "| plans | 2.5 |"]


def test_a_measurement_shows_command_machine_and_commit() -> None:
    text = "`python -m bench coverage`; machine: 2 cores, 24 GB, commit abc1234"
    assert format_measurement(MEASURED) == text
    assert format_measurement(Measurement(None, None, "any")) == "No program; machine: any"


def test_a_result_with_measurements_of_its_own_is_read_as_it_was_written(tmp_path: Path) -> None:
    result = RESULTS["coverage"]
    claims = replace_figures(result.claims, {result.claims[0].claim: 7}, MEASURED)
    table = replace_rows(result.tables[0], result.tables[0].rows[:2], 1, MEASURED)
    changed = Result(result.title, result.measured, tuple(claims), (table,))
    path = tmp_path / "coverage.json"
    path.write_text(format_result(changed), encoding="utf-8")
    assert read_result(path) == changed


def test_the_page_names_the_rows_that_were_measured_apart() -> None:
    measured = format_measurement(MEASURED)
    some = replace_rows(TABLE, [("plans", 4, 5)], 1, MEASURED)
    whole = replace_rows(some, [("goals", 4, 5)], 1, MEASURED)
    result = Result("Speed", MEASURED, (), (some, whole, TABLE))
    text = "\n".join(format_section(result))
    assert f"\nSpeed (plans: {measured}):\n" in text
    assert f"\nSpeed ({measured}):\n" in text
    assert "\nSpeed:\n" in text


def test_a_measurement_has_no_absolute_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    words = ["python -m bench report", str(tmp_path / "records"), "--models", "2", "--write"]
    monkeypatch.setattr(sys, "argv", words)
    measured = describe_measurement()
    assert measured.command == "python -m bench report records --models 2"
    assert re.fullmatch(r"\d+ cores, \d+ GiB", measured.machine)


@pytest.mark.parametrize(("exponent", "hours"), [(1.0, 10.01), (1.3, "not extrapolated")])
def test_only_linear_costs_are_extrapolated(exponent: float, hours: Figure, tmp_path: Path) -> None:
    def measure(size: int, folder: Path) -> ChildCost:
        return ChildCost(36 + 36 * size**exponent, 100 + size)

    line = WorkLine("1,000 tasks", "eai generate", 1_000, measure)
    *_, growth, at_goal, on_cores = measure_line(line, 0.1, tmp_path)
    assert growth == pytest.approx(exponent, abs=0.05)
    assert at_goal == hours
    assert on_cores == (1.25 if exponent == 1 else hours)


@pytest.mark.parametrize(("different", "is_extrapolated"), [(None, True), (1_000, True), (999, False)])
def test_tasks_are_extrapolated_only_if_there_are_enough(
    tmp_path: Path, different: int | None, is_extrapolated: bool
) -> None:
    def measure(size: int, folder: Path) -> ChildCost:
        made = {"sets": {"tasks": {"estimated_tasks": different if size == 100 else 0}}}
        (folder / "generated.json").write_text(json.dumps(made), encoding="utf-8")
        return ChildCost(36 + 36 * size, 100)

    line = WorkLine("1,000 tasks", "eai generate", 1_000, measure, estimate=read_estimated_tasks)
    *_, at_goal, on_cores = measure_line(line, 0.1, tmp_path)
    assert (at_goal, on_cores) == ((10.01, 1.25) if is_extrapolated else ("not extrapolated",) * 2)


def test_an_unknown_program_is_refused() -> None:
    done = run("nothing")
    assert done.returncode == 1
    assert "no program 'nothing'" in done.stderr


def test_programs_are_listed_with_what_they_do() -> None:
    lines = run().stdout.splitlines()[2:]
    assert len(lines) > 30
    assert [line for line in lines if not re.fullmatch(r"  \w+ +[A-Z][^\n]+\.", line)] == []


def run(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
