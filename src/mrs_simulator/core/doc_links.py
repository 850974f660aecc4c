"""Links from errors to the pages of the documentation that explain them.

The attribute ``page`` of an error, or of its class, names the page; ``explained_by`` sets it on errors
that leave a function.
"""

import contextlib

from mrs_simulator.core.doc_pages import reference

OF_FAILED = reference("docs/verdict.md")
OF_SELF_CONSISTENT = reference("docs/claims.md#a-law-that-states-nothing")
OF_NOT_JUDGED = reference("docs/verdict.md#why-a-claim-is-not-judged")


@contextlib.contextmanager
def explained_by(page, kind=ValueError):
    """Give an error of this ``kind`` that leaves the block, or the decorated function, the ``page`` for it.

    A page that an inner block gave is kept, since it is nearer to the cause; that of a class is not.
    """
    try:
        yield
    except kind as error:
        if "page" not in vars(error):
            error.page = page
        raise


def page_of(error):
    """Return the page that explains ``error``, "" if none is known.

    Its own comes first, then that of an error which led to it, as far as ``explained_by`` gave one,
    then that of its class.
    """
    link = error
    while link is not None:
        if "page" in vars(link):
            return link.page
        link = link.__cause__ or link.__context__
    return getattr(error, "page", "")


def with_page(error):
    """Return what ``error`` says, with the page that explains it where there is one."""
    page = page_of(error)
    return "{} (see {})".format(words(error), reference(page)) if page else words(error)


def words(error):
    """Return what ``error`` says, also where users wrote its class and its ``__str__`` raises."""
    try:
        return str(error)
    except (Exception, SystemExit) as fault:
        return "its __str__ raised {}".format(type(fault).__name__)


def named(error):
    """Return the kind of ``error`` and what it says."""
    return "{}: {}".format(type(error).__name__, words(error))
