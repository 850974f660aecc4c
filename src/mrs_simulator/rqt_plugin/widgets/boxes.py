"""Rows and columns of widgets, and pages made of a column."""

from mrs_simulator.rqt_plugin.qt.QtWidgets import QHBoxLayout, QLayout, QVBoxLayout, QWidget


def row_of(*parts, owner=None, margins=None, **properties):
    """Return a layout with ``parts`` from left to right: widgets, layouts, and numbers for empty room.

    A part may be a tuple of widget or layout, its share of the room that is left over, and its alignment; a
    number is the share of the empty room.  ``owner``: the widget that is laid out; ``margins`` [px]: one
    for all sides, or of left, top, right and bottom, by default the style's; ``properties``: of Qt's.
    """
    return _filled(QHBoxLayout, parts, owner, margins, properties)


def column_of(*parts, owner=None, margins=None, **properties):
    """Return a layout with ``parts`` below each other, as :func:`row_of` has them side by side."""
    return _filled(QVBoxLayout, parts, owner, margins, properties)


def page_of(*parts, margins=4):
    """Return a widget with ``parts`` below each other, as :func:`column_of` takes them."""
    widget = QWidget()
    column_of(*parts, owner=widget, margins=margins)
    return widget


def _filled(kind, parts, owner, margins, properties):
    layout = kind(**properties) if owner is None else kind(owner, **properties)
    if margins is not None:
        layout.setContentsMargins(*((margins,) * 4 if isinstance(margins, int) else margins))
    for part in parts:
        part, *place = part if isinstance(part, tuple) else (part,)
        if isinstance(part, int):
            layout.addStretch(part)
        elif isinstance(part, QLayout):
            layout.addLayout(part, *place)
        else:
            layout.addWidget(part, *place)
    return layout
