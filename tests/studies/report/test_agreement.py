from __future__ import annotations

import re
from dataclasses import replace

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.verdict import Verdict
from eai.results.runs import Run, RunKey
from eai.studies.report.document import compare_with_paper
from eai.studies.report.run_summary import summarize_run
from oracle import Oracle
from results.verdicts import record, whole

GPT_4O = "gpt-4o-2024-05-13"


def run_of(verdicts: list[Verdict], model: str, protocol: Protocol) -> Run:
    ability = Ability.SUBGOAL_DECOMPOSITION
    records = [record(str(i), v, ability=ability, model=model) for i, v in enumerate(verdicts)]
    return Run(RunKey(protocol, "behavior", ability, model), whole(records))


def compared(verdicts: list[Verdict], model: str, protocol: Protocol) -> list[dict[str, str]]:
    return compare_with_paper([summarize_run(run_of(verdicts, model, protocol))])


def test_only_the_paper_s_models_under_its_protocol_are_compared() -> None:
    verdicts: list[Verdict] = [SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT)]
    assert compared(verdicts, GPT_4O, Protocol("eai-1.0.5"))
    assert not compared(verdicts, GPT_4O, Protocol.STRICT)
    assert not compared(verdicts, "my-model", Protocol("eai-1.0.5"))


def test_a_run_that_leaves_tasks_out_is_not_compared() -> None:
    run = run_of([SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT)], GPT_4O, Protocol("eai-1.0.5"))
    part = replace(run, records=(replace(run.records[0], suite_size=2),))
    assert compare_with_paper([summarize_run(run)])
    assert not compare_with_paper([summarize_run(part)])


def test_cells_are_counted_by_their_distance_from_the_papers_figures() -> None:
    half = [
        SubgoalVerdict(category=SubgoalAnswerCategory.CORRECT),
        SubgoalVerdict(category=SubgoalAnswerCategory.NOT_PARSEABLE),
    ]
    found = compared(half, GPT_4O, Protocol("eai-1.0.5"))
    row = next(row for row in found if row["table"] == "Subgoal decomposition: trajectory evaluation")
    assert row["cells"] == "9"
    assert row["within 1"] == "3"  # task success 50 for 49, and two columns of zeros
    assert row["largest"] == "50.0"
    assert row["where"] == f"{GPT_4O}, parsing: 50.0 for 0.0"


def test_published_subgoal_categories_give_the_paper_s_success(oracle: Oracle) -> None:
    rows = oracle("behavior", "subgoal_decomposition", GPT_4O)["records"]
    names = {"Correct": "correct", "Runtime": "runtime", "GoalUnreachable": "goal_unreachable"}
    names |= {"Hallucination": "hallucination", "NotParseable": "not_parseable"}
    verdicts: list[Verdict] = [
        SubgoalVerdict(category=SubgoalAnswerCategory(names[row["verdict"]["category"]])) for row in rows
    ]
    overview = compared(verdicts, GPT_4O, Protocol("eai-1.0.5"))[0]
    assert (overview["cells"], overview["within 1"]) == ("2", "2")
    assert re.search(r"task\\_success: .* for 49\.0|execution\\_success: .* for 55\.0", overview["where"])
