"""Answers by people: a page that asks questions, and a page on which people act in a world.

Entry points: `play` (a command) and `answer_form` (`eai export prompts --out FILE.html`).
Extra: none.
Page: docs/extensions/people/README.md.
"""
