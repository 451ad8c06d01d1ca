"""Draw the output of a command in a terminal of 80 columns as SVG.

    python tools/terminal_picture.py PICTURE.svg eai score answers --out scores

The command runs in the current folder. The picture in README shows the public answers of three models.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from rich._export_format import CONSOLE_SVG_FORMAT
from rich.console import Console
from rich.terminal_theme import SVG_EXPORT_THEME
from rich.text import Text

COLUMNS = 80
FONT_DOWNLOADS = re.compile(r"@font-face \{\{.*?\}\}\n", re.DOTALL)
"""Style rules that would download fonts. Any font of fixed width will do."""


def main() -> None:
    picture, command = Path(sys.argv[1]), sys.argv[2:]
    terminal = {"COLUMNS": str(COLUMNS), "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    finished = subprocess.run(
        command, env={**os.environ, **terminal}, stdout=subprocess.PIPE, text=True, check=True
    )
    screen = Console(record=True, width=COLUMNS, file=io.StringIO(), force_terminal=True)
    screen.print(Text(f"$ {shlex.join(command)}\n"), Text.from_ansi(finished.stdout.rstrip()), sep="\n")
    form = FONT_DOWNLOADS.sub("", CONSOLE_SVG_FORMAT)
    drawn = screen.export_svg(title="", theme=SVG_EXPORT_THEME, code_format=form, unique_id="terminal")
    picture.write_text(drawn, encoding="utf-8")


if __name__ == "__main__":
    main()
