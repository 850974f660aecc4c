"""What a package's modules define, found by folder."""

import importlib
import pkgutil


def classes_in(package, base):
    """Return the subclasses of ``base`` that the modules of ``package``, a name, define, a list.

    They are in the order of the modules' names, and in each as they are written.
    """
    folder = importlib.import_module(package).__path__
    names = sorted(module.name for module in pkgutil.iter_modules(folder, package + "."))
    return [
        each
        for name in names
        for each in vars(importlib.import_module(name)).values()
        if isinstance(each, type) and issubclass(each, base) and each.__module__ == name
    ]
