"""The rates of perception errors; the paper gives no denominators, so these are ours."""

from __future__ import annotations

from eai.abilities.record import Perceived
from eai.abilities.verdict import Share, add, confusion_shares


def perception_shares(perceived: Perceived) -> dict[str, Share]:
    """The share that one scene graph adds to each rate.

    ``predicate_error`` is the paper's: facts missing or misplaced, of those described. ``object_error`` too:
    names that the scene has not, of all names given. Below them are the four kinds of error, each of what it
    can befall, the objects that are not named, and precision, recall and F1 of facts.
    """
    lost = perceived.missing + perceived.misplaced
    return {
        "predicate_error": Share(lost, perceived.facts),
        "object_error": Share(perceived.invented_names, perceived.names),
        "missing": Share(perceived.missing, perceived.facts),
        "misplaced": Share(perceived.misplaced, perceived.relations),
        "unnecessary": Share(perceived.unnecessary, perceived.perceived),
        "invented": Share(perceived.invented, perceived.perceived),
        "unseen": Share(perceived.unseen, perceived.objects),
        **confusion_shares("facts", add(perceived.predicates.values())),
    }
