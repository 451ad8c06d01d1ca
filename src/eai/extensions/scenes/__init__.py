"""Scenes with bodies: how objects look and where they are, drawn by cameras; no verdict uses them.

Entry point: `rendered_pictures`, which runs (`perception.scene`), environments (`render_mode="camera"`),
`eai export pictures` and `eai explain --film` ask for.
Extra: `physics`.
Page: docs/extensions/scenes/README.md.
"""
