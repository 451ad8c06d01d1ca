"""The board: what people submit is scored here, and nothing in it is believed."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from browsing import needs_browser, quiet_page, started_browser
from by_path import ROOT
from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.source import Source

DESCRIPTION = 'model = "{model}"\ndate = 2026-11-26\n'
PLACE = "virtualhome/action_sequencing/m_outputs.json"
LAMPS = ROOT / "examples" / "lamps"


def answers(rows: dict[str, str]) -> str:
    return json.dumps([{"identifier": task, "llm_output": text} for task, text in rows.items()])


@pytest.fixture(scope="module")
def right(data_store: DataPackStore) -> str:
    """A right answer to the task 27_2."""
    benchmark = find_benchmark("virtualhome")
    book = open_gold_answers(benchmark, Ability.ACTION_SEQUENCING, Source(data_store))
    return book["27_2"].text


@pytest.fixture
def submit(tmp_path: Path, right: str) -> Callable[..., Path]:
    """Return a function that makes a submission of one right answer, with its files changed as given."""

    def submitted(name: str = "mine", model: str = "M", more: str = "", **files: str) -> Path:
        folder = tmp_path / "board" / name
        texts = {"submission.toml": DESCRIPTION.format(model=model) + more, PLACE: answers({"27_2": right})}
        for place, text in {**texts, **files}.items():
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            (folder / place).write_text(text)
        return folder

    return submitted


def made(eai: Command, tmp_path: Path) -> str:
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert done.status == 0, done.err
    return (tmp_path / "site" / "index.html").read_text()


def rows_of(page: str) -> list[list[str]]:
    """Return the cells of the first table's rows, without marks."""
    body = page[page.index("<tbody>") : page.index("</tbody>")]
    plain = re.compile(r"<sup>.*?</sup>|<[^>]+>")
    return [
        [plain.sub("", cell) for cell in re.findall("<td>(.*?)</td>", row)]
        for row in body.split("</tr>")[:-1]
    ]


def test_answers_are_scored_here_and_missing_ones_are_failures(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit(
        more='harness = "react"\neffort = "high"\ntokens = 1200\ndollars = 0.5\nlogs = "https://example.org/l"\n'
    )
    page = made(eai, tmp_path)
    rows = {row[1].split(" ")[0]: row for row in rows_of(page)}
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING)
    mine = rows["M"]
    assert float(mine[2].split()[0]) < 1
    assert f"1/{len(suite.task_ids)}" in mine
    assert mine[-8:-1] == ["react", "high", "2026-11-26", "1,200", "0.50", "strict", mine[-2]]
    assert "left out" in mine[-2]
    assert '<a href="https://example.org/l" rel="nofollow noreferrer">logs</a>' in page
    assert {"GPT-4o", "eai/lookup", "eai/random"} <= rows.keys()  # public models, and null models
    assert rows["eai/lookup"][0] == "–"
    assert "Percent, ranked by Task. In brackets" in page


@pytest.mark.parametrize(
    ("specification", "named"),
    [
        ("", ""),
        ('[model]\nname = "m"\n', "official"),
        ('[prompts]\nset = "short"\n', "short"),
        ('[prompts]\nset = "facts"\nname = "mine"\n', "facts, mine"),
        ('prompts = "short"\n', "official"),
    ],
)
def test_a_row_names_the_prompt_set_of_the_specification(
    specification: str, named: str, submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit(**({"run.toml": specification} if specification else {}))
    page = made(eai, tmp_path)
    headings = re.findall("<th>(.*?)</th>", page[: page.index("</thead>")])
    (mine,) = [row for row in rows_of(page) if row[1] == "M"]
    shown = mine[headings.index("Prompts")] if "Prompts" in headings else ""
    assert shown == named


def test_columns_without_a_value_are_left_out(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit()
    page = made(eai, tmp_path)
    headings = re.findall("<th>(.*?)</th>", page[: page.index("<tbody>")])
    assert headings[:2] == ["#", "Model"]
    assert headings[-4:] == ["Answered", "Date", "Protocol", "Errata"]
    assert {len(row) for row in rows_of(page)} == {len(headings)}
    submit("other", more="tokens = 0\n")
    assert "<th>Date</th><th>Tokens</th><th>Protocol</th>" in made(eai, tmp_path)


def test_rows_without_a_rank_are_below_all_rows_with_a_rank(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit()
    submit("goals", **{PLACE.replace("action_sequencing", "goal_interpretation"): answers({"27_2": "{}"})})
    ranks = [row[0] for row in rows_of(made(eai, tmp_path))]
    ranked = [rank for rank in ranks if rank != "–"]
    assert ranks == [*ranked, *["–"] * (len(ranks) - len(ranked))]
    assert ranked == sorted(ranked, key=int)
    assert len(ranks) > len(ranked)


def test_results_stated_in_a_submission_are_ignored(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    lies = {"summary.json": '{"task_success": 100}', "records.jsonl": "{}\n"}
    submit(**lies)
    assert rows_of(made(eai, tmp_path)) == rows_of(made(eai, tmp_path))
    submit("other", "M", **dict.fromkeys(lies, ""))
    found = [row[2] for row in rows_of(made(eai, tmp_path)) if row[1] == "M"]
    assert len(found) == 2
    assert len(set(found)) == 1


def test_no_text_becomes_part_of_the_page(submit: Callable[..., Path], eai: Command, tmp_path: Path) -> None:
    attack = "<img src=x onerror=alert(1)>"
    submit(model=attack, more=f'by = "{attack}"\nharness = "{attack}"\n', **{"run.toml": f'x = "{attack}"\n'})
    page = made(eai, tmp_path)
    assert "<img" not in page
    assert page.count("&lt;img src=x") == 9  # in three tables, and below
    assert "default-src 'none'" in page


def test_a_withdrawn_submission_is_shown_with_its_reason_and_not_scored(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit(more='withdrawn = "The answers were copied."\n', **{PLACE: "not even JSON"})
    page = made(eai, tmp_path)
    assert "<b>Withdrawn:</b> The answers were copied." in page
    assert "<tbody>" not in page


def zipped(folder: Path, name: str = "z.zip", **more: bytes) -> Path:
    place = folder.parent / name
    with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in folder.rglob("*"):
            archive.write(file, file.relative_to(folder))
        for member, content in more.items():
            archive.writestr(member, content)
    for file in sorted(folder.rglob("*"), reverse=True):
        file.rmdir() if file.is_dir() else file.unlink()
    folder.rmdir()
    return place


def test_a_zip_is_as_good_as_a_folder(submit: Callable[..., Path], eai: Command, tmp_path: Path) -> None:
    folder = submit()
    expected = rows_of(made(eai, tmp_path))
    zipped(folder, "mine.zip", **{"__MACOSX/._m_outputs.json": b"\0"})
    assert rows_of(made(eai, tmp_path)) == expected


def test_nothing_is_written_outside_of_the_folder_of_a_zip(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    outside = "../../../../outside_outputs.json"
    zipped(submit(), **{outside: b"[]", str(tmp_path / "absolute_outputs.json"): b"[]"})
    assert eai("board", tmp_path / "board", "--out", tmp_path / "site").status == 2
    assert not list(tmp_path.rglob("outside_outputs.json"))
    assert not (tmp_path / "absolute_outputs.json").exists()


def test_a_zip_that_holds_too_much_is_refused_unread(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    zipped(submit(), **{"virtualhome/goal_interpretation/m_outputs.json": b" " * 60_000_000})
    assert "bytes of answers in it" in eai("board", tmp_path / "board", "--out", tmp_path / "s").err


HOSTILE = {
    "a link to somewhere else": "is a link;",
    "an unknown task": "is not one of the tasks",
    "a task twice": "occurs twice",
    "a task of no scene": "tasks that are not in the data set",
    "an endless answer": "expected at most 100,000 characters",
    "deep JSON": "expected JSON",
    "a module": "is not a registered benchmark",
    "Parquet": "expected one of",
    "many files": "at most 200 files",
    "two descriptions": "expected one submission.toml",
    "no description": "expected one submission.toml",
    "a script": "logs: ",
    "an unknown entry": "rank: unknown",
    "no model": "model: ",
    "a huge description": "at most 64,000 bytes",
    "a specification that is none": "run.toml",
    "a number of 5,000 digits": "submission.toml: expected TOML",
    "too many tokens": "tokens: ",
    "too many dollars": "dollars: ",
    "a deep list": "run.toml: expected TOML",
}


def spoil(how: str, folder: Path, right: str) -> None:
    place, described = folder / PLACE, folder / "submission.toml"
    match how:
        case "a link to somewhere else":
            place.unlink()
            place.symlink_to("/etc/passwd")
        case "an unknown task":
            place.write_text(answers({"27_2": right, "nobody": right}))
        case "a task twice":
            place.write_text(answers({"27_2": right})[:-1] + ", " + answers({"27_2": right})[1:])
        case "a task of no scene":
            place.write_text(answers({"scene_9_27_2": right}))
        case "an endless answer":
            place.write_text(answers({"27_2": "x" * 100_001}))
        case "deep JSON":
            place.write_text("[" * 100_000)
        case "a module":
            (folder / "os:system" / "action_sequencing").mkdir(parents=True)
            place.rename(folder / "os:system" / "action_sequencing" / "m_outputs.json")
        case "Parquet":
            place.rename(place.with_name("m_outputs.parquet"))
        case "many files":
            for number in range(200):
                (folder / f"{number}.txt").touch()
        case "two descriptions":
            (place.parent / "submission.toml").write_text(described.read_text())
        case "no description":
            described.unlink()
        case "a script":
            described.write_text(described.read_text() + 'logs = "javascript:alert(1)"\n')
        case "an unknown entry":
            described.write_text(described.read_text() + "rank = 1\n")
        case "no model":
            described.write_text('model = ""\ndate = 2026-11-26\n')
        case "a huge description":
            described.write_text(described.read_text() + "#" * 64_000)
        case "a specification that is none":
            (folder / "run.toml").write_text("[[[")
        case "a number of 5,000 digits":
            described.write_text(f"{described.read_text()}tokens = {'9' * 5_000}\n")
        case "too many tokens":
            described.write_text(f"{described.read_text()}tokens = {10**18}\n")
        case "too many dollars":
            described.write_text(described.read_text() + "dollars = 1e308\n")
        case "a deep list":
            (folder / "run.toml").write_text(f"a = {'[' * 20_000}")
        case _:
            raise AssertionError(how)


@pytest.mark.parametrize("how", HOSTILE)
def test_a_hostile_submission_is_refused_in_one_line(
    how: str, submit: Callable[..., Path], eai: Command, tmp_path: Path, right: str
) -> None:
    spoil(how, submit(), right)
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert done.status == 2
    *told, last = done.err.splitlines()
    assert told == ["scoring mine"]
    assert HOSTILE[how] in last
    assert "root:" not in last
    assert not (tmp_path / "site").exists()


@pytest.mark.parametrize("name", ["<b>", "a b", "eai_lookup", "x" * 65])
def test_an_invalid_submission_name_is_refused(
    name: str, submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit(name)
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert (done.status, "expected a name" in done.err) == (2, True)


@pytest.fixture
def season(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A season whose tasks are published, but not their secret."""
    monkeypatch.syspath_prepend(LAMPS)
    folder = tmp_path / "board" / "season-1"
    made = ("--n", 2, "--split", "train", "--secret", "hush", "--out", folder)
    assert eai("generate", "--like", "lamps:lamps", *made).status == 0
    (folder / "season.toml").write_text('title = "Season 1"\nsplit = "train"\n')
    return folder


def test_a_season_is_announced_opened_and_revealed(season: Path, eai: Command, tmp_path: Path) -> None:
    tasks = season / "train.jsonl"
    lines = tasks.read_text()
    tasks.unlink()
    announced = made(eai, tmp_path)
    assert "its tasks are not published yet" in announced
    digest = json.loads((season / "generated.json").read_text())["sets"]["train"]["sha256"]
    assert digest in announced
    assert "hush" not in announced
    tasks.write_text(lines)
    assert "its tasks are those announced" in made(eai, tmp_path)
    (season / "season.toml").write_text('title = "Season 1"\nsplit = "train"\nsecret = "hush"\n')
    assert "2 tasks follow from it" in made(eai, tmp_path)
    (season / "season.toml").write_text('title = "Season 1"\nsplit = "train"\nsecret = "another"\n')
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert "the digest of the secret is not the one that was published" in done.err


def test_other_tasks_than_announced_are_refused(season: Path, eai: Command, tmp_path: Path) -> None:
    tasks = season / "train.jsonl"
    tasks.write_text(tasks.read_text().splitlines(keepends=True)[0])
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert (done.status, "is not what was published" in done.err) == (2, True)


def test_open_seasons_of_one_name_are_refused(season: Path, eai: Command, tmp_path: Path) -> None:
    again = season.parent / "season-2"
    made = ("--n", 2, "--split", "train", "--seed", 1, "--secret", "hush", "--out", again)
    assert eai("generate", "--like", "lamps:lamps", *made).status == 0
    (again / "season.toml").write_text('title = "Season 2"\nsplit = "train"\n')
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert (done.status, "another season has tasks of the name lamps-train" in done.err) == (2, True)


def test_answers_to_a_season_are_ranked_in_a_table_of_their_own(
    season: Path, eai: Command, tmp_path: Path
) -> None:
    benchmark = find_benchmark(str(season / "train.jsonl"))
    book = open_gold_answers(benchmark, Ability.ACTION_SEQUENCING, Source())
    folder = tmp_path / "board" / "mine"
    place = folder / benchmark.name / "action_sequencing" / "m_outputs.json"
    place.parent.mkdir(parents=True)
    place.write_text(answers({task: book[task].text for task in book}))
    (folder / "submission.toml").write_text(DESCRIPTION.format(model="M"))
    (row,) = rows_of(made(eai, tmp_path))
    assert row[:3] == ["1", "M", row[2]]
    assert row[2].startswith("100.0 [")


@needs_browser
def test_the_page_fits_wide_and_narrow_windows_and_asks_for_nothing(
    submit: Callable[..., Path], eai: Command, tmp_path: Path
) -> None:
    submit(model="a name of a model that is rather long for a narrow window")
    made(eai, tmp_path)
    with started_browser() as browser, quiet_page(browser) as page:
        for width in (1400, 390):
            page.set_viewport_size({"width": width, "height": 900})
            page.goto((tmp_path / "site" / "index.html").as_uri())
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            names = "[...document.querySelectorAll('details[open] td:nth-child(2)')]"
            heights = page.evaluate(f"{names}.map((cell) => cell.getBoundingClientRect().height)")
            assert max(heights) < 1.5 * min(heights)  # each name is on one line
