"""Handling of bad input, shared by the package's programs."""

import contextlib
import sys

from mrs_simulator.core.doc_links import with_page
from mrs_simulator.core.writing import is_of_output
from mrs_simulator.study.draw.style import MISSING

BAD_INPUT = 2  # exit code


@contextlib.contextmanager
def refusing_bad_input(program, *more):
    """End the program, with exit code 2 and one line, where what it was given is wrong.

    The line ends with the page of the documentation that explains it, where the error names one.
    ``ValueError``, ``OSError`` and the errors in ``more`` count as that, but not one of standard output;
    a missing matplotlib, too.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name != "matplotlib":
            raise
        print("{}: {}".format(program, MISSING), file=sys.stderr)
        sys.exit(BAD_INPUT)
    except (ValueError, OSError, *more) as error:
        if is_of_output(error):
            raise
        print("{}: {}".format(program, _said(error)), file=sys.stderr)
        sys.exit(BAD_INPUT)


def _said(error):
    """Return what ``error`` says, that of a file without its number."""
    if isinstance(error, FileExistsError):  # where a directory was to be made
        return "{}: is a file, wanted a directory".format(error.filename)
    if isinstance(error, OSError) and error.filename is not None:
        return "{}: {}".format(error.filename, error.strerror)
    return with_page(error)
