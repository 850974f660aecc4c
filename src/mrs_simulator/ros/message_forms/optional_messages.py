"""Message packages that a system may lack: what of them is there."""

import importlib
from typing import NamedTuple, Tuple


class Offer(NamedTuple):
    """Topics or services that need a message package."""

    package: str
    kind: str  # "msg" or "srv"
    types: Tuple[str, ...]
    names: Tuple[str, ...]  # of the topics or services, as users know them


def found(offers):
    """Return ``(types, missing)``: classes by name, and the ``offers`` that cannot be made here."""
    types, missing = {}, []
    for offer in offers:
        try:
            module = importlib.import_module("{}.{}".format(offer.package, offer.kind))
            types.update({name: getattr(module, name) for name in offer.types})
        except (ImportError, AttributeError):
            missing.append(offer)
    return types, missing


def missing_text(preset, missing):
    """Return what a ``preset`` goes without, "" where nothing is ``missing``."""
    if not missing:
        return ""
    parts = [
        "{} ({}.{})".format(", ".join(offer.names), offer.package, offer.kind) for offer in missing
    ]
    packages = sorted({offer.package for offer in missing})
    return "preset {}: {} not installed; left out: {}".format(
        preset, ", ".join(packages) + (" is" if len(packages) == 1 else " are"), "; ".join(parts)
    )
