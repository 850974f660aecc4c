"""Qt 5: ``QtCore``, ``QtGui``, ``QtWidgets``, by the binding that there is.

That is ``python_qt_binding``, which rqt chooses, wherever it is installed, else PyQt5 itself.  Both
have the same classes; ``Signal`` and ``Slot`` are what PyQt5 calls ``pyqtSignal`` and ``pyqtSlot``.
"""

import importlib
import sys

MODULES = ("QtCore", "QtGui", "QtWidgets")
MISSING = "the window needs PyQt5: pip install PyQt5, or Debian's python3-pyqt5 ({})"


def _loaded(name):
    """Return the module ``name`` of Qt; ``ImportError`` that says what to install."""
    try:
        return importlib.import_module("python_qt_binding." + name)
    except ImportError:
        try:
            return importlib.import_module("PyQt5." + name)
        except ImportError as error:
            raise ImportError(MISSING.format(error)) from None


for _name in MODULES:
    _module = _loaded(_name)
    if _name == "QtCore" and not hasattr(_module, "Signal"):
        _module.Signal, _module.Slot = _module.pyqtSignal, _module.pyqtSlot
    globals()[_name] = sys.modules["{}.{}".format(__name__, _name)] = _module
