"""World-model questions: what actions do, need and lead to, asked of any declared domain.

Every gold answer is computed, by carrying actions out or by exhausting what a few actions can lead to.
Entry points: `world_model` (an ability) and `export questions` (a command).
Extra: none.
Page: docs/extensions/questions/README.md.
"""
