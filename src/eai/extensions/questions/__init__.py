"""World-model questions: what actions change, require and lead to, in any benchmark with a declared domain.

Every gold answer is computed: actions are executed, or all states that some actions lead to are explored.
Entry points: `world_model` (an ability) and `export questions` (a command).
Extra: none.
Page: docs/extensions/questions/README.md.
"""
