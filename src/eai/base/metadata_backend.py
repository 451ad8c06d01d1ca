"""A build backend that lets pip download a source distribution without running its `setup.py`.

pip asks the build backend for the metadata of a source distribution before it keeps the file. The usual
backend, setuptools, would run the package's `setup.py` for this. A copy of this module takes the place of
setuptools on Python's module path, and returns the metadata that the distribution already contains. eai
itself never imports this module.
"""

import pathlib
import sys


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: object = None) -> str:
    """Copy `PKG-INFO` of the working folder to a new metadata folder, and return its name (PEP 517)."""
    information = pathlib.Path("PKG-INFO").read_text(encoding="utf-8")
    fields = dict(line.partition(": ")[::2] for line in information.partition("\n\n")[0].splitlines())
    folder = f"{fields['Name'].replace('-', '_')}-{fields['Version']}.dist-info"
    target = pathlib.Path(metadata_directory) / folder
    target.mkdir()
    (target / "METADATA").write_text(information, encoding="utf-8")
    return folder


__legacy__ = sys.modules[__name__]
