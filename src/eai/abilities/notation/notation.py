"""The notation of a benchmark: the form of answers, and the names of objects and predicates in prompts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from eai.abilities.notation.goals import GoalNotation, JsonGoalNotation
from eai.abilities.notation.plans import JsonPlanNotation, PlanNotation
from eai.abilities.protocol import Ability
from eai.tasks.english import PLAIN_ENGLISH, EnglishWords

if TYPE_CHECKING:
    from eai.abilities.notation.subgoals import SubgoalNotation
    from eai.tasks.wording import PromptAndAnswerWording


@dataclass(frozen=True, eq=False, slots=True)
class Notation:
    """The form of answers, and the names of objects and predicates; by default the names of the domain.

    Attributes:
        plans: notation of plans; by default a JSON list of actions with their objects.
        goals: notation of goals; by default JSON lists of conditions.
        subgoals: notation of subgoals; None for formulas with the names of the domain.
        formats: mapping from abilities to prompt texts that describe the answer. For other abilities, prompts
            describe the default notation.
        short_texts: texts for prompts in short notation (``short``), by key. The text ``rules`` states the
            rules of actions; the text with an ability's name describes the form of its answers. If a text is
            missing, prompts have shortened rules, or describe the default notation.
        wordings: returns the names in the prompts of an ability; None for the names of the domain.
        also_observed: predicates that observations list after the predicates in prompts of action sequencing.
        english: the words with which instructions are written, and the role of the agent.
    """

    plans: PlanNotation = field(default_factory=JsonPlanNotation)
    goals: GoalNotation = field(default_factory=JsonGoalNotation)
    subgoals: SubgoalNotation | None = None
    formats: Mapping[Ability, str] = field(default_factory=dict)
    short_texts: Mapping[str, str] = field(default_factory=dict)
    wordings: Callable[[Ability], PromptAndAnswerWording] | None = None
    also_observed: tuple[str, ...] = ()
    english: EnglishWords = PLAIN_ENGLISH
