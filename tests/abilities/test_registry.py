"""Abilities are registered values: a seventh ability of another distribution works in every command."""

from __future__ import annotations

import json
import os
import pickle
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from abilities import counting
from agents.switches import SWITCHES
from by_path import TESTS
from eai.abilities import declaration, protocol
from eai.abilities.protocol import PAPER_ABILITIES, Ability, get_ability_sort_key
from eai.base.errors import InputError
from eai.benchmarks.suite import open_suite
from eai.results.reward import Reward
from eai.tasks.source import Source
from processes import eai

LAMPS = TESTS.parent / "examples" / "lamps"


@pytest.fixture
def distribution(tmp_path: Path) -> dict[str, str]:
    """Return the environment in which the distribution with the seventh ability is installed."""
    info = tmp_path / "site" / "counting-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: counting\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[eai.abilities]\ncounting = abilities.counting:COUNTING\n")
    return python_path(info.parent, TESTS, LAMPS)


def python_path(*folders: Path) -> dict[str, str]:
    """Return the environment in which Python searches these folders first."""
    return {"PYTHONPATH": os.pathsep.join([*map(str, folders), os.environ.get("PYTHONPATH", "")])}


def test_a_seventh_ability_needs_few_lines() -> None:
    assert len(Path(counting.__file__).read_text(encoding="utf-8").splitlines()) <= 60


def test_a_seventh_ability_goes_through_every_command(tmp_path: Path, distribution: dict[str, str]) -> None:
    suite, runs = ("--domain", "lamps:lamps", "--ability", "counting"), tmp_path / "runs"
    models = ("--model", "eai/oracle", "--model", "eai/noisy", "-M", "rate=0.9")
    run = eai("run", *models, *suite, "--out", runs, **distribution)
    assert run.status == 0, run.err
    folder = runs / "lamps" / "counting"
    assert json.loads((folder / "eai_oracle" / "summary.json").read_text())["right"]["value"] == 100.0
    answers = next((folder / "eai_oracle").glob("*_outputs.json"))
    again = eai("score", answers, *suite, "--out", tmp_path / "again", "--json", **distribution)
    assert again.status == 0, again.err
    (record, *_) = (tmp_path / "again" / "records.jsonl").read_text().splitlines()
    assert {"ability": "counting", "right": True, "off_by": 0}.items() <= json.loads(record).items()
    report = eai("report", runs, "--out", tmp_path / "report", **distribution)
    assert report.status == 0, report.err
    page = (tmp_path / "report" / "report.md").read_text()
    assert "### Counting" in page
    assert "Right" in page
    compared = eai("compare", folder / "eai_noisy", folder / "eai_oracle", "--json", **distribution)
    assert compared.status == 0, compared.err
    (found,) = json.loads(compared.out)
    assert found["ability"] == "counting"
    assert found["differences"][0]["metric"] == "right"
    explained = eai("explain", folder / "eai_oracle" / "records.jsonl", **distribution)
    assert explained.status == 0, explained.err


def test_a_seventh_ability_is_paid_by_the_credit_of_its_verdicts(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("counting", "abilities.counting:COUNTING", protocol.ABILITY_GROUP)
    for module in (declaration, protocol):
        monkeypatch.setattr(module, "find_ability_entry_points", lambda: {Ability("counting"): point})
    paid = Reward(open_suite(SWITCHES, Ability("counting")), "diagnosis")
    named = len(SWITCHES.tasks(Source())["both"].relevant)
    assert (paid("both", str(named)), paid("both", str(named + 1))) == (1, 0)


def test_verdicts_without_credit_are_not_paid() -> None:
    with pytest.raises(InputError, match="answers to scene_graph have no reward"):
        Reward(open_suite("virtualhome", Ability("scene_graph")))


def test_records_of_an_uninstalled_ability_are_refused_in_one_line(
    tmp_path: Path, distribution: dict[str, str]
) -> None:
    suite = ("--domain", "lamps:lamps", "--ability", "counting")
    refused = eai("run", "--model", "eai/oracle", *suite, "--out", tmp_path, **python_path(LAMPS))
    assert refused.status != 0
    assert "'counting' is no ability: expected one of goal_interpretation" in refused.err
    null = eai("run", "--model", "eai/copy", *suite, "--limit", 1, "--out", tmp_path, **distribution)
    assert "eai/copy has no answer to counting" in null.err


def test_an_ability_is_one_value_for_each_name() -> None:
    assert Ability.from_name("action_sequencing") is Ability.ACTION_SEQUENCING
    assert pickle.loads(pickle.dumps(PAPER_ABILITIES)) == PAPER_ABILITIES  # noqa: S301 - our own
    assert pickle.loads(pickle.dumps(Ability("counting"))) is Ability("counting")  # noqa: S301
    assert sorted(PAPER_ABILITIES, key=get_ability_sort_key) == list(PAPER_ABILITIES)
    assert get_ability_sort_key(Ability("counting")) == len(protocol.find_ability_entry_points())


def test_an_entry_point_must_hold_the_ability_of_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("other", "abilities.counting:COUNTING", protocol.ABILITY_GROUP)
    monkeypatch.setattr(declaration, "find_ability_entry_points", lambda: {Ability("other"): point})
    with pytest.raises(InputError, match="expected the AbilityDeclaration of other"):
        declaration.get_declaration(Ability("other"))
    with pytest.raises(InputError, match="the ability none is not installed"):
        declaration.get_declaration(Ability("none"))
