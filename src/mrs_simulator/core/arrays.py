"""Arrays that others may read and not change."""


def read_only(array):
    """Return a view of ``array`` through which it cannot be changed."""
    view = array.view()
    view.flags.writeable = False
    return view
