"""Settings in the user's data directory, shared by all windows; without Qt and ROS."""

import json
import os

from mrs_simulator.core.writing import write_text
from mrs_simulator.scenario.reading import read_json


def user_directory():
    """Return the path of the product's directory among the user's data, which may not exist yet."""
    data = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    return os.path.join(data, "mrs_simulator")


def read_settings(path, usual):
    """Return the settings in the JSON file at ``path``, or ``usual`` where there are none.

    A setting whose name or type is not as in ``usual`` is left out.
    """
    try:
        kept = read_json(path)
    except (OSError, ValueError):
        kept = {}
    kept = kept if isinstance(kept, dict) else {}
    return {**usual, **{k: v for k, v in kept.items() if isinstance(v, type(usual.get(k)))}}


def write_settings(path, settings):
    """Write ``settings`` to the JSON file at ``path``; raises ``OSError``."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_text(path, json.dumps(settings, indent=2, sort_keys=True) + "\n")
