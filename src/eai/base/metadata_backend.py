"""A stand-in for the build backend of a source distribution that pip is only asked to download.

pip wants a source distribution's metadata before it keeps the file, and would run the package's `setup.py` to
get it. Put in setuptools' place on the path, this module hands over the metadata that the package already
carries, so that nothing of it is run. It is copied, never imported by eai.
"""

import pathlib
import sys


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: object = None) -> str:
    """Copy `PKG-INFO` of the working folder; gives the name of the folder made (PEP 517)."""
    information = pathlib.Path("PKG-INFO").read_text(encoding="utf-8")
    fields = dict(line.partition(": ")[::2] for line in information.partition("\n\n")[0].splitlines())
    folder = f"{fields['Name'].replace('-', '_')}-{fields['Version']}.dist-info"
    target = pathlib.Path(metadata_directory) / folder
    target.mkdir()
    (target / "METADATA").write_text(information, encoding="utf-8")
    return folder


__legacy__ = sys.modules[__name__]
