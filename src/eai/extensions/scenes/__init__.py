"""Pictures of scenes: diagrams, and rendered three-dimensional scenes. No verdict uses them.

Entry points: `diagrams` and `rendered_pictures` (for the setting `perception.scene` of runs, the option
`render_mode` of environments, and `eai explain --film`); `diagrams_of_answers` (for `eai report --pictures`);
`export pictures` (a command).
Extra: `physics` (scenes with bodies); diagrams as PNG need `plots`.
Page: docs/extensions/scenes/README.md.
"""
