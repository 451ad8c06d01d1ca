"""Tests that docs/study.md equals the present output of tools/study on the public answers."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.results.paper_tables import read_published_scores
from oracle import NO_REFERENCE

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "study.md"
PLACES = (str(ROOT / "tools" / "study"), str(ROOT / "tools"))
_FILES = (ROOT / "tools" / "study").glob("[a-z]*.py")
MODULES = ("published_scores", *(path.stem for path in _FILES))
PARTLY, REFUTED, ARTEFACT = "reproduced in part", "not supported", "an artefact"
MEASURED = {
    "With GPT-4o's plug_in and the data set's walk_towards and switch_on no plan is found.": "reproduced",
    "The most frequent runtime error is the additional step in VirtualHome.": "reproduced",
    "The most frequent runtime error is the missing step in BEHAVIOR.": "reproduced",
    "In making coffee, GPT-4o uses the action POUR, which does not exist in subgoals.": ARTEFACT,
    "GPT-4o uses POUR in making coffee.": ARTEFACT,
    "Claude-3 Opus's plans can all be read in both worlds.": "reproduced",
    "Missing steps and wrong orders are the most frequent runtime errors in both worlds.": PARTLY,
    "Non-spatial relations are the challenge across models.": PARTLY,
    "0.6 % of Llama 3 8B's goals cannot be read in VirtualHome, and 2.0 % in BEHAVIOR.": PARTLY,
    "Success with place_inside is rather low in many BEHAVIOR tasks.": PARTLY,
    "Quantifiers make BEHAVIOR's goals hard, because they tend to fail if one condition is unmet.": PARTLY,
    "No model has more than 3.8 % format errors.": REFUTED,
    "Every question gives the task's name and instruction, examples, objects, states and relations.": REFUTED,
    "Search turns six states of the fridge example into its seven printed actions.": REFUTED,
    "Two actions are needed to switch the sink on once the rag is next to it.": REFUTED,
    "In the fridge example, the objects are fridge 97, tray 1, bowl 1, rag 0 and sink 82.": PARTLY,
    "The reward depends on a state: it is 1 if the state meets the goal, and else 0.": PARTLY,
    "The lead of o1-preview is significant.": PARTLY,
    "Models do worse in BEHAVIOR because of quantifiers.": REFUTED,
    "Such operators fail because of complex preconditions and spatial requirements.": REFUTED,
    "plug_in succeeds in 0.09 and walk_towards in 0.63 of VirtualHome's problems.": PARTLY,
    "Success is lower for operators about space and objects than for other operators.": PARTLY,
    "At temperature 0, chance has no significant effect on the answers.": REFUTED,
    "Model cards give ids, release dates and hosts of 18 models.": PARTLY,
    "Additional steps are the most critical error.": REFUTED,
    "Most quantifiers have several solutions.": REFUTED,
    "An answer fails to open window.76 and window.81.": REFUTED,
    "Action goals are harder than state goals in VirtualHome's subgoals, as for o1-preview.": PARTLY,
    "Most of Command R's unreadable answers have tokens or a syntax that the parser of LTL refuses.": (
        "reproduced"
    ),
    "Preconditions stricter than VirtualHome's are one of the two main reasons for missing steps.": (
        "reproduced"
    ),
    "In general, a BEHAVIOR goal has several options, be it a task's whole goal or one condition.": REFUTED,
    "CLEAN needs no free hand.": "reproduced",
    "Contents move along with their container, by a tree of containers and contents.": "reproduced",
    "Each action needs an object that can be used.": PARTLY,
    "Operators: the rules on connectives and the grammar of clauses agree.": REFUTED,
    "Environment: “forn” counts exactly n objects.": REFUTED,
    "BEHAVIOR's operators were changed from an existing domain.": PARTLY,
    "Most tasks have quantifiers, such as “forall” or “forpairs”, with spatial or temporal requirements.": (
        "reproduced"
    ),
    "Many models explain their answers although they are told not to explain.": REFUTED,
    "The highest figure of each column of goals is in bold.": PARTLY,
    "A “when” matches if its condition and its effect do.": PARTLY,
    "Prediction from a goal back to subgoals is a future direction.": REFUTED,
    "The footnote on binding strength has all operators of the definition.": PARTLY,
    "The table of goals shows the accuracy of logic forms (a caption).": REFUTED,
    "The printed walk_towards, with a near object in its precondition, is the data set's.": REFUTED,
    "A planner finds a plan with the three printed operators of GPT-4o.": REFUTED,
    "o1-preview stands out among all models in planner success.": PARTLY,
    "o1-preview's planner success is robust in various categories and both worlds.": "reproduced",
    "Models give objects unknown properties, which can never hold.": "reproduced",
    "“inside”, “holding” and full hands of place_inside are all challenging for models.": PARTLY,
    "In affordance tasks, plug_in and put_inside succeed significantly less often than others.": PARTLY,
    "Planner success differs notably between spatial and non-spatial relations.": REFUTED,
    "The printed operators of GPT-4o are its predictions.": PARTLY,
    "Results of operators diverge between the two worlds.": "reproduced",
    "o1-preview has a clear advantage over the other models in general.": PARTLY,
    "The single-module rates in the table of pipelines are those of the other tables.": PARTLY,
    "GPT-4o tends to use POUR if it is asked to make coffee.": ARTEFACT,
    "Each action of VirtualHome has annotated preconditions and effects.": PARTLY,
    "BEHAVIOR-100's scenarios are in various indoor environments.": "reproduced",
    "The instructions of each VirtualHome category have common last states, in one form with wildcards.": (
        PARTLY
    ),
    "Nothing in the composition or collection of the data might affect later uses.": REFUTED,
    "Claude-3.5 Sonnet and o1-preview excel in kinds such as object orientation and non-spatial relations.": (
        PARTLY
    ),
    "State goals have fewer logical requirements than other goals.": PARTLY,
    "The best figure of each column of subgoals is in bold.": PARTLY,
    "The highest figure of each column of met goals is in bold.": PARTLY,
    "The names in the table of BEHAVIOR's actions are those of the simulator.": "reproduced",
    "The 40 listed names are actions of VirtualHome's environment.": PARTLY,
    "Placing next to one object and on top of another needs two objects that can be used.": PARTLY,
    "BEHAVIOR writes goals in BDDL, as a last state with logical constraints.": "reproduced",
    "By the table of notations, action t leads from state t to state t + 1.": REFUTED,
    "The table of the main text is a part of this table.": REFUTED,
    "The gain generally grows with the chance of failure.": "reproduced",
    "F1 combines precision and recall.": PARTLY,
    "Only answers that can be executed succeed.": PARTLY,
    "An answer that cannot be executed has one of six kinds of errors, additional steps not counted.": PARTLY,
    "RobotHow's last states are too noisy for goals.": "reproduced",
    "Plans: usually the robot needs several actions one after another.": "reproduced",
    "Operators: effects are generally several, joined by “and”.": PARTLY,
    "Plans: the sink has to be switched off after soaking.": REFUTED,
    "The printed program finds wrong orders.": REFUTED,
    "close and grab are perfect in VirtualHome's affordance tasks.": PARTLY,
    "An example is toggled_on, which is easier to reach than the relation ontop(agent, chair).": REFUTED,
    "Rinse is particularly hard for GPT-4o.": REFUTED,
    "The questions give no detailed information about the environment.": REFUTED,
    "In serving a meal chicken.0 belongs on plate.2 and plate.2 on table.1.": PARTLY,
    "State goals are about one object, relation goals about two.": PARTLY,
    "The larger a model is, the fewer grammar errors it makes.": PARTLY,
    "Newer editions of models tend to make fewer grammar errors than older editions.": "reproduced",
    "One challenge found is to reason about the effects of actions.": "reproduced",
    "The table of actions lists the 42 actions of VirtualHome.": REFUTED,
    "walk_towards has complex constraints on spatial relations.": PARTLY,
    "Models are also asked for operators without effects, which are scored by the accuracy of logic forms.": (
        REFUTED
    ),
    "The overview's figures are those of the full tables.": PARTLY,
    "Every question gives the name of the task.": PARTLY,
    "The changed domain fits BEHAVIOR's problem files and runs in a planner.": PARTLY,
    "The soap is dropped before top_cabinet.25 is cleaned: a wrong order.": PARTLY,
    "Only a few models make grammar errors.": REFUTED,
    "BEHAVIOR's spatial relations are between the robot and the objects.": PARTLY,
    "Examples of goals are a plugged-in television, a state of the agent and the agent on a chair.": PARTLY,
    "A plan for browsing is to get onto a chair, hold mouse and keyboard, and face the computer.": PARTLY,
    "Partial success of plans is evaluated.": REFUTED,
    "BEHAVIOR's tasks rest on real-world demonstrations of people.": REFUTED,
    "A task belongs to the two categories whose predicates are rarest in sum.": PARTLY,
}
"""Statements that the page once lacked or judged wrongly, with their status by 18 models."""


@pytest.fixture(scope="module")
def study() -> Iterator[ModuleType]:
    """Return tools/study as a module."""
    import importlib.util

    pytest.importorskip("scipy")
    sys.path[:0] = PLACES
    spec = importlib.util.spec_from_file_location("study", ROOT / "tools" / "study" / "__main__.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = [place for place in sys.path if place not in PLACES]
    for name in MODULES:
        sys.modules.pop(name, None)


def test_the_table_of_partial_success_is_that_of_the_scores(study: ModuleType) -> None:
    table = "\n".join(sys.modules["conditions"].partial_success_table())
    assert table in PAGE.read_text(encoding="utf-8")
    assert (
        len(read_published_scores("strict").suites["behavior/action_sequencing"].models)
        == table.count("\n") - 8
    )


def sections(study: ModuleType, evidence: object, keys: str) -> dict[str, str]:
    """Return the sections of some claims as the tool writes them now."""
    page = sys.modules["page"]
    chosen = [claim for claim in study.CLAIMS if claim.key in keys.split()]
    return {claim.key: "\n".join(page.section(claim, claim.find(evidence))) for claim in chosen}


def test_every_claim_is_on_the_page_once(study: ModuleType) -> None:
    text = PAGE.read_text(encoding="utf-8")
    keys = [claim.key for claim in study.CLAIMS]
    assert len(set(keys)) == len(keys)
    lines = text.splitlines()
    for claim in study.CLAIMS:
        name = f"{claim.key} {claim.title}"
        is_there = lines.count(f"## {name}") == 1 and f"](#{claim.anchor})" in text
        is_left_out = sum(line.startswith(f"* {name}: needs ") for line in lines) == 1
        assert is_there != is_left_out
        assert is_there or claim.plans


def test_claims_that_need_no_answers_come_out_as_on_the_page(
    study: ModuleType, data_store: DataPackStore
) -> None:
    evidence = sys.modules["evidence"].Evidence(study.Source(data_store))
    found = sections(study, evidence, "D1 D2 D3 E1 F1 G1 H1 I1 I2 I3 J1 K1 K2 K3")
    assert len(found) == 14
    text = PAGE.read_text(encoding="utf-8")
    assert [key for key, section in found.items() if section not in text] == []


@pytest.mark.parametrize(
    ("domain", "ability", "keys"),
    [
        ("behavior", Ability.ACTION_SEQUENCING, "A1 A2 A3 A4 A5 A6 A7 A8 A9"),
        ("behavior", Ability.GOAL_INTERPRETATION, "B5 B6"),
        ("virtualhome", Ability.GOAL_INTERPRETATION, "B8"),
    ],
)
def test_the_page_is_current(
    study: ModuleType, data_store: DataPackStore, domain: str, ability: Ability, keys: str
) -> None:
    if not study.ANSWERS.is_dir():
        pytest.skip(NO_REFERENCE)
    evidence = study.from_answers(domains=[domain], abilities=[ability])
    found = sections(study, evidence, keys)
    text = PAGE.read_text(encoding="utf-8")
    assert [key for key, section in found.items() if section not in text] == []


def rows_of_page() -> dict[str, list[str]]:
    """Return the statement, status and evidence of each row of the list of statements, by statement."""
    text = PAGE.read_text(encoding="utf-8")
    part = text[text.index("## All statements") : text.index("## Claims with figures")]
    rows = [line.strip("| ").split(" | ") for line in part.splitlines() if " | **" in line]
    return {row[0]: row for row in rows}


def test_every_statement_is_on_the_page_with_status_and_evidence(study: ModuleType) -> None:
    statements = sys.modules["statements"].read_statements()
    rows = rows_of_page()
    assert [each.text for each in statements if each.text not in rows] == []
    known = {f"**{status.value}**" for status in sys.modules["claim"].Status}
    assert [row for row in rows.values() if len(row) != 3 or row[1] not in known or not row[2]] == []
    assert len({each.section for each in statements}) > 30


def test_a_statement_names_checks_that_exist(study: ModuleType) -> None:
    module = sys.modules["statements"]
    keys = {claim.key for claim in study.CLAIMS}
    for statement in module.read_statements():
        for part in statement.check.split(" & "):
            kind, _, rest = part.partition(": ")
            assert rest, statement
            if kind == "claim":
                assert rest in keys, statement
            elif kind == "measure":
                assert callable(module.measure_of(rest)), statement
            elif kind == "read":
                assert rest.partition(": ")[0] in {s.value for s in sys.modules["claim"].Status}, statement


def test_statements_that_were_missing_have_the_measured_status() -> None:
    rows = rows_of_page()
    assert {text: rows[text][1].strip("*") for text in MEASURED} == MEASURED


def test_statements_about_tables_come_out_as_on_the_page(
    study: ModuleType, data_store: DataPackStore
) -> None:
    source = study.Source(data_store)
    evidence = sys.modules["evidence"].Evidence(source, read_published_scores("eai-1.0.5").suites)
    module = sys.modules["statements"]
    checker = module.Checker(evidence, {}, planner=False)
    tables = ("cell", "best", "lowest", "rank", "above", "printed", "count", "read", "skip")
    kinds = (*tables, "rates", "strength", "asked", "gold", "checks")
    rows, compared = rows_of_page(), 0
    for statement in module.read_statements():
        if all(
            part.startswith(tuple(f"{kind}: " for kind in kinds)) for part in statement.check.split(" & ")
        ):
            finding = checker.find(statement.check)
            compared += 1
            assert rows[statement.text][1:] == [f"**{finding.status.value}**", finding.summary.rstrip(".")]
    assert compared > 350


@pytest.mark.parametrize(
    ("domain", "names"),
    [
        (
            "virtualhome",
            "pour additional_in_virtualhome sitting_in_wrong_orders closed_of_gpt_3_5 harm_of_errors "
            "standup_left_out invented_predicates",
        ),
        (
            "behavior",
            "missing_in_behavior grammar_in_behavior conditions_in_quantifiers requirements_of_quantifiers "
            "majority_of_missing reasons_of_missing_steps unreadable_of_command_r closed_by_complexity "
            "plywood_moved",
        ),
    ],
)
def test_statements_about_subgoals_come_out_as_on_the_page(
    study: ModuleType, data_store: DataPackStore, domain: str, names: str
) -> None:
    if not study.ANSWERS.is_dir():
        pytest.skip(NO_REFERENCE)
    evidence = study.from_answers(domains=[domain], abilities=[Ability.SUBGOAL_DECOMPOSITION])
    module, rows = sys.modules["statements"], rows_of_page()
    checker = module.Checker(evidence, {}, planner=False)
    for name in names.split():
        texts = [each.text for each in module.read_statements() if each.check == f"measure: {name}"]
        finding = checker.find(f"measure: {name}")
        assert texts
        for text in texts:
            assert rows[text][1:] == [f"**{finding.status.value}**", finding.summary.rstrip(".")]


def test_statements_about_the_data_set_come_out_as_on_the_page(
    study: ModuleType, data_store: DataPackStore
) -> None:
    evidence = sys.modules["evidence"].Evidence(study.Source(data_store))
    module, rows = sys.modules["statements"], rows_of_page()
    checker = module.Checker(evidence, {}, planner=False)
    names = (
        "example_states example_subgoals sink_switched_on objects_of_the_fridge instruction_of_the_fridge "
        "conditions_of_the_fridge needs_of_soak parts_of_questions gold_in_questions formulas "
        "order_of_actions goals_over_time rewards_of_states parts_of_tasks parts_in_virtualhome "
        "names_share_tasks touching cooking bottling_fruit affordances_of_examples open_hosts "
        "gains_of_replanning simple_formulas pairs_of_jars formula_of_1057_1 identifiers system_prompts "
        "floor_action people_in_operators growing_gains solutions_of_quantifiers "
        "conditions_counted_singly devices_without_plug listed_predicates plans_of_gpt_4o "
        "arguments_of_goals gold_of_the_meal objects_of_work example_goals names_in_questions "
        "operators_asked_for goals_share_tasks figures_of_tables goals_of_the_agent dishes_by_hand "
        "plans_of_several_actions joined_effects f1_of_goals f1_of_operators errors_add_up "
        "success_within_execution final_states_are_noisy agent_stands_at_first figures_of_pipelines "
        "scenes_of_behavior common_goals usable_objects contents_that_move browsing_plan "
        "categories_by_weight chicken_on_the_table"
    )
    for name in names.split():
        finding = checker.find(f"measure: {name}")
        texts = [each.text for each in module.read_statements() if each.check == f"measure: {name}"]
        assert texts, name
        for text in texts:
            assert rows[text][1:] == [f"**{finding.status.value}**", finding.summary.rstrip(".")]


def test_each_measure_is_used_by_a_statement(study: ModuleType) -> None:
    module = sys.modules["statements"]
    checks = " & ".join(each.check for each in module.read_statements())
    used = {part.removeprefix("measure: ") for part in checks.split(" & ") if part.startswith("measure: ")}
    declared = {
        node.name
        for file in (ROOT / "tools" / "study").glob("measures_*.py")
        for node in ast.parse(file.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    }
    assert declared - used == {"first_place_columns"}


def test_no_two_rows_make_the_same_statement(study: ModuleType) -> None:
    texts = [each.text for each in sys.modules["statements"].read_statements()]
    assert len(set(texts)) == len(texts)


@pytest.mark.parametrize(
    ("check", "status"),
    [
        ("rates: all models: V/SD/parsing < 5", "reproduced"),
        ("rates: all models: V/SD/parsing < 0.5", PARTLY),
        ("rates: all models: V/SD/action_goal > V/SD/state_goal", REFUTED),
        ("rates: most strong: V/SD/parsing = 0", "reproduced"),
        ("rates: o1-preview: V/SD/state_goal > 95", REFUTED),
        ("strength: V/SD/relation_goal", "reproduced"),
        ("strength: falls V/SD/relation_goal", REFUTED),
        ("asked: all B/SD: open .{0,12} first", "reproduced"),
        ("asked: no B/SD: open .{0,12} first", REFUTED),
        ("gold: V/switch_on/precondition/plugged_in", "reproduced"),
        ("gold: V/switch_on/precondition/has_plug", REFUTED),
        ("gold: V/brush/precondition/hold", REFUTED),
        ("checks: no B/SLICE/both_hands", REFUTED),
        ("checks: all B/SLICE/both_hands", "reproduced"),
    ],
)
def test_a_comparison_can_hold_and_fail(
    study: ModuleType, data_store: DataPackStore, check: str, status: str
) -> None:
    source = study.Source(data_store)
    evidence = sys.modules["evidence"].Evidence(source, read_published_scores("eai-1.0.5").suites)
    checker = sys.modules["statements"].Checker(evidence, {}, planner=False)
    assert checker.find(check).status.value == status


def test_answers_are_searched_for_steps_errors_and_clear_differences(
    study: ModuleType, data_store: DataPackStore
) -> None:
    if not study.ANSWERS.is_dir():
        pytest.skip(NO_REFERENCE)
    evidence = study.from_answers(domains=["behavior"], abilities=[Ability.SUBGOAL_DECOMPOSITION])
    checker = sys.modules["statements"].Checker(evidence, {}, planner=False)
    found = {
        check: checker.find(check).status.value
        for check in (
            "step: B/SD/additional_step/OPEN carton_0",
            "step: B/SD/additional_step/OPEN unicorn",
            "error: B/SD/argument_number/nextto takes 2 objects, not 3",
            "error: B/SD/argument_number/nextto takes 3",
            "missed: B/SD/plywood",
            "missed: B/SD/unicorn",
            "clearly: all strong: B/SD/task_success of o1-preview > B/SD/task_success",
            "clearly: all strong: B/SD/task_success of o1-preview < B/SD/task_success",
        )
    }
    assert list(found.values()) == [*["reproduced", REFUTED] * 3, PARTLY, REFUTED]


def test_rows_with_a_word_are_printed_without_the_others(
    study: ModuleType, data_store: DataPackStore
) -> None:
    evidence = sys.modules["evidence"].Evidence(
        study.Source(data_store), read_published_scores("eai-1.0.5").suites
    )
    text = sys.modules["page"].rows_with("Human Performance", study.CLAIMS, evidence, planner=False)
    assert "| GPT-4o excels in transition modeling. | **reproduced in part** |" in text
    assert text.count("### ") == 1


def constant_conditions(code: str) -> list[str]:
    """Return the calls that judge a statement by a condition without a name, a call or an attribute."""
    calls = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call)]
    judging = [
        call for call in calls if isinstance(call.func, ast.Name) and call.func.id in ("if_so", "by_degree")
    ]
    depends = (ast.Name, ast.Call, ast.Attribute)
    return [
        ast.unparse(call)
        for call in judging
        if not any(isinstance(node, depends) for node in ast.walk(call.args[0]))
    ]


def test_the_first_condition_of_a_measure_depends_on_data() -> None:
    assert constant_conditions("if_so(18 * 2 == 36, text)") == ["if_so(18 * 2 == 36, text)"]
    files = sorted((ROOT / "tools" / "study").glob("measures_*.py"))
    found = {file.name: constant_conditions(file.read_text(encoding="utf-8")) for file in files}
    assert len(found) == 11
    assert not any(found.values()), found


def test_a_figure_counts_only_if_table_and_public_answers_have_it(
    study: ModuleType, data_store: DataPackStore
) -> None:
    evidence = sys.modules["evidence"].Evidence(
        study.Source(data_store), read_published_scores("eai-1.0.5").suites
    )
    checker = sys.modules["statements"].Checker(evidence, {}, planner=False)
    status = {
        figure: checker.find(f"cell: V/AS/state_goal/GPT-4o/{figure}").status.value
        for figure in ("82.0", "87.1", "50.0")
    }
    assert status == {"82.0": PARTLY, "87.1": PARTLY, "50.0": "not supported"}
    assert checker.find("cell: B/AS/parsing/GPT-3.5-turbo/4.0").status.value == "reproduced"
    assert checker.find("best: V/GI/overall.f1/Gemini 1.5 Pro").status.value == "not supported"
    assert checker.find("skip: a definition").status.value == "not judged"
    without_answers = checker.find("rank: V/GI/relation.f1/Claude-3.5 Sonnet/2")
    assert without_answers.summary.endswith("Claude-3.5 Sonnet is number 2 by the table.")


def test_without_records_the_page_says_what_is_missing(study: ModuleType, data_store: DataPackStore) -> None:
    evidence = sys.modules["evidence"].Evidence(study.Source(data_store))
    text = sys.modules["page"].page_of(study.CLAIMS, evidence)
    assert "## Left out" in text
    assert (
        "* A1 Success falls with the length of the annotated plan: needs BEHAVIOR, action sequencing" in text
    )
