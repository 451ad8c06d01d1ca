from __future__ import annotations

import re

from eai.results.model_cards import make_model_table
from eai.results.paper_tables import map_files_to_paper_models
from eai.results.table import TextCell


def test_every_model_of_the_paper_has_one_card() -> None:
    rows = make_model_table().row_dicts()
    names = [row["model"] for row in rows]
    assert len(names) == len(set(names)) == 18
    assert set(names) == set(map_files_to_paper_models().values())


def test_a_card_has_a_date_and_a_source_for_a_known_size() -> None:
    cards = make_model_table()
    for row in cards.row_dicts():
        assert all(row[name] for name in ("creator", "identifier", "host"))
        assert re.fullmatch(r"202[34]-\d\d-\d\d", str(row["release"]))
        size = row["parameters"]
        assert isinstance(size, TextCell)
        assert (str(size) == "unknown") == (not size.notes)
        assert all(1 <= note <= len(cards.notes) for note in size.notes)
