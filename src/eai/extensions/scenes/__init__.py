"""Pictures of scenes: diagrams, and rendered three-dimensional scenes. No verdict uses them.

Entry points: `diagrams` and `rendered_pictures`, which runs (`perception.scene`) and environments
(`render_mode`) ask for; `diagrams_of_answers` (`eai report --pictures`); `export pictures` (a command).
`eai explain --film` asks for `rendered_pictures`, too.
Extra: `physics` (scenes with bodies); diagrams as PNG need `plots`.
Page: docs/extensions/scenes/README.md.
"""
