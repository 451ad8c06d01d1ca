"""Register benchmarks as gymnasium environments: one action a turn; actions and observations are texts.

    import gymnasium
    import eai.agents.gym

    env = gymnasium.make("eai/Benchmark-v1", benchmark="lamps:lamps", slip=0.1)

Importing this module registers the environments. Every option of
`eai.agents.environment.make` is an option of `gymnasium.make`. `IDS` lists the names of the environments of
the package's own benchmarks.
"""

from __future__ import annotations

from typing import NoReturn

from eai.base.errors import make_install_command
from eai.benchmarks.registry import CAPITALISED

__all__ = ["ANY", "IDS", "AnyTextSpace", "TextEnvironment", "make"]

ANY = "eai/Benchmark-v1"
"""Name of the registered environment for any benchmark; the option ``benchmark`` chooses the benchmark."""

IDS = {f"eai/{title}-v1": name for name, title in CAPITALISED.items()}
"""Name of a registered environment -> name of the package's own benchmark that it plays."""

try:
    import gymnasium

    from eai.agents.environment import AnyTextSpace, TextEnvironment, make
except ImportError as _error:
    _MISSING = _error

    def __getattr__(name: str) -> NoReturn:
        """Raise an error that says how to install gymnasium, if a name of this module needs gymnasium."""
        if name not in __all__:
            raise AttributeError(f"module 'eai.agents.gym' has no attribute {name!r}")
        raise ImportError(f"environments need gymnasium: {make_install_command('envs')}") from _MISSING

else:
    _MAKER = "eai.agents.environment:make"
    gymnasium.register(ANY, entry_point=_MAKER)
    for _id, _name in IDS.items():
        gymnasium.register(_id, entry_point=_MAKER, kwargs={"benchmark": _name})
