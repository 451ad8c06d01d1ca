"""Skip a module's tests where MuJoCo is not installed, which must not be imported before EGL is chosen."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

if find_spec("mujoco") is None:
    pytest.skip("the extra physics is not installed", allow_module_level=True)
