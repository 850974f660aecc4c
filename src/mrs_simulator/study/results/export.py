"""Exports: the verdict as a LaTeX or CSV table, the run as a ``.mat`` file."""

import csv
import functools
import importlib.util
import io
import os
import re

from mrs_simulator.study.draw.style import NARROW, look
from mrs_simulator.verdict.verdict import outcome_of

TABLES = ("tex", "csv")
COLUMNS = ("check", "predicted", "measured", "tolerance", "outcome", "note", "question")
OUTCOMES = {True: "passed", False: "failed", None: "not judged"}
SHORT_OUTCOMES = {True: "passed", False: "failed", None: "--"}
RELATIONS = ("at most", "at least")
MAT_FILE = "run.mat"
NO_SCIPY = "--mat: wanted the Python package scipy"
ESCAPED = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\n": " ",
    "\u2013": "--",
    "\u2014": "---",
    "\u2018": "`",
    "\u2019": "'",
    "\u2026": r"\ldots{}",
    "\u00b0": r"\ensuremath{^\circ}",
    "\u00b1": r"\ensuremath{\pm}",
    "\u00b2": r"\ensuremath{^2}",
    "\u00b3": r"\ensuremath{^3}",
    "\u00b5": r"\ensuremath{\mu}",
    "\u00b7": r"\ensuremath{\cdot}",
    "\u00d7": r"\ensuremath{\times}",
    "\u2208": r"\ensuremath{\in}",
    "\u2260": r"\ensuremath{\neq}",
    "\u2264": r"\ensuremath{\leq}",
    "\u2265": r"\ensuremath{\geq}",
    "\u221e": r"\ensuremath{\infty}",
}
SYMBOL_NAMES = (
    "alpha|beta|gamma|delta|epsilon|eps|eta|theta|kappa|lambda|mu|pi|rho|sigma|tau|phi|omega"
)
# Symbols as claims write them: lambda_max, w^T, tau.
SYMBOL = re.compile(r"\b({})(?:_(\w+))?\b|\^T\b".format(SYMBOL_NAMES))
LARGEST_LETTER = 0x17F  # up to which LaTeX has the accented letters of Latin scripts
WIDTH, NARROW_WIDTH = 0.38, 0.3  # [-] of the line for checks' names, which may take more lines
LONGEST_CELL = 12  # [-] letters of a text in a cell of numbers; a longer one goes into a note
# Of a table as wide as one of two columns: smaller letters, less room between them.
NARROW_SIZE = (r"  \scriptsize", r"  \setlength{\tabcolsep}{2.5pt}")


class ExportError(ValueError):
    """An export that cannot be made; the message names it and what was wanted."""

    page = "docs/scenarios.md#tables-for-papers-and-other-programs"


def table_kinds(text):
    """Return the kinds of table in ``text``, ``tex`` or ``tex,csv``; ``ExportError`` for another."""
    kinds = [kind.strip() for kind in text.split(",") if kind.strip()]
    for kind in kinds:
        if kind not in TABLES:
            raise ExportError("--table {!r}: wanted {}".format(kind, " or ".join(TABLES)))
    return kinds


def write_tables(verdict, out, kinds, narrow=False):
    """Write ``verdict.tex`` and ``verdict.csv`` to ``out``, those in ``kinds``; return the paths.

    ``narrow``: as of :func:`verdict_latex`.
    """
    makers = {"tex": functools.partial(verdict_latex, narrow=narrow), "csv": verdict_csv}
    paths = []
    for kind in kinds:
        paths.append(os.path.join(out, "verdict." + kind))
        with open(paths[-1] + ".part", "w", encoding="utf-8", newline="") as file:
            file.write(makers[kind](verdict))
        os.replace(paths[-1] + ".part", paths[-1])
    return paths


def verdict_csv(verdict):
    """Return the checks of ``verdict`` as CSV, a line for each, numbers with all their digits."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for check in verdict["checks"]:
        values = [check[key] for key in ("predicted", "measured", "tolerance")]
        row = [check["name"], *values, OUTCOMES[check["passed"]]]
        row += [check.get("note", ""), check["question"]]
        table.writerow(["" if value is None else value for value in row])
    return text.getvalue()


def verdict_latex(verdict, narrow=False):
    """Return ``verdict`` as a LaTeX ``table`` in the manner of the package booktabs.

    Wants ``\\usepackage{booktabs}``, and fits a page's text of 12 cm; ``narrow``: one of two columns, of
    8 cm.  A bound has its relation sign before the predicted number; why a check was not judged
    stands in a note below.
    """
    digits, outcomes = (3, SHORT_OUTCOMES) if narrow else (4, OUTCOMES)
    notes, rows = [], []
    for check in verdict["checks"]:
        measured, mark = check["measured"], _mark(check.get("note", ""), notes)
        if isinstance(measured, str) and len(measured) > LONGEST_CELL:
            measured, mark = None, mark + _mark(measured, notes)
        relation = {"at most": r"$\leq$ ", "at least": r"$\geq$ "}.get(check.get("note"), "")
        cells = [
            r"\raggedright " + _text(check["name"]) + mark,
            relation + _number(check["predicted"], digits),
            _number(measured, digits),
            _number(check["tolerance"], digits),
            outcomes[check["passed"]],
        ]
        rows.append("  " + " & ".join(cells) + r" \\")
    caption = "{}: {}".format(_text(verdict["title"] or "Run"), _outcome(verdict))
    lines = [
        r"\begin{table}",
        r"  \centering",
        r"  \caption{" + caption + "}",
        *(NARROW_SIZE if narrow else (r"  \footnotesize",)),
        r"  \begin{tabular}{@{}p{"
        + str(NARROW_WIDTH if narrow else WIDTH)
        + r"\linewidth}rrrl@{}}",
        r"  \toprule",
        r"  Check & Predicted & Measured & Tolerance & Outcome \\",
        r"  \midrule",
        *rows,
        r"  \bottomrule",
        r"  \end{tabular}",
        *_footnotes(notes),
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _mark(note, notes):
    """Return the mark of a ``note``, which is added to ``notes``; "" for a relation or none."""
    if not note or note in RELATIONS:
        return ""
    if note not in notes:
        notes.append(note)
    return _superscript(notes.index(note))


def _superscript(row):
    return r"\textsuperscript{" + _letters(row) + "}"


def _letters(row):
    """Return a, b, ... z, aa, ab, ... for ``row`` from 0."""
    before, letter = divmod(row, 26)
    return (_letters(before - 1) if before else "") + chr(ord("a") + letter)


def _footnotes(notes):
    if not notes:
        return []
    marked = [_superscript(row) + r"\," + _text(note) for row, note in enumerate(notes)]
    return [
        r"  \par\smallskip",
        r"  \begin{minipage}{\linewidth}\footnotesize\raggedright",
        *("  " + note + r"\\" for note in marked[:-1]),
        "  " + marked[-1],
        r"  \end{minipage}",
    ]


def _outcome(verdict):
    reason = verdict.get("reason", "")
    text = outcome_of(verdict).replace("_", " ")
    return text + (" (" + _text(reason) + ")" if reason else "") + "."


def _text(value):
    """Return ``value`` as LaTeX text, with symbols that claims spell out as mathematics."""
    text, parts, end = str(value), [], 0
    for found in SYMBOL.finditer(text):
        parts += [_escaped(text[end : found.start()]), _symbol(found)]
        end = found.end()
    return "".join([*parts, _escaped(text[end:])])


def _symbol(found):
    letter, index = found.groups()
    if letter is None:
        return r"\ensuremath{^T}"
    letter = "\\" + {"eps": "varepsilon", "epsilon": "varepsilon"}.get(letter, letter)
    if index is None:
        return r"\ensuremath{" + letter + "}"
    index = index if index.isdigit() else r"\mathrm{" + index.replace("_", r"\_") + "}"
    return r"\ensuremath{" + letter + "_{" + index + "}}"


def _escaped(text):
    return "".join(ESCAPED.get(letter) or _letter(letter) for letter in text)


def _letter(letter):
    """Return ``letter`` as LaTeX knows it, the number of one that it does not know."""
    if ord(letter) <= LARGEST_LETTER and letter.isprintable():
        return letter
    return r"\texttt{U+" + format(ord(letter), "04X") + "}"


def _number(value, digits=4):
    """Return a number of so many significant ``digits`` in LaTeX, a text as it is, a dash for none."""
    if value is None:
        return "--"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return _text(value)
    mantissa, e, exponent = "{:.{}g}".format(value, digits).partition("e")
    if not e:
        return "${}$".format(mantissa)
    return r"${} \times 10^{{{}}}$".format(mantissa, int(exponent))


def write_mat(run, out):
    """Write ``run.mat``, the run's arrays for MATLAB and Octave, to ``out`` by scipy; return its path.

    ``time`` (m, 1) [s], ``robots`` (1, n), ``pose`` (m, n, 3), ``hand`` (m, n, 2), ``command`` (m, n, 2).
    Raises ``ExportError`` where scipy is not installed.
    """
    try:
        from scipy.io import savemat
    except ImportError:
        raise ExportError(NO_SCIPY) from None
    path = os.path.join(out, MAT_FILE)
    arrays = {name: getattr(run, name) for name in ("pose", "hand", "command")}
    arrays.update(time=run.time.reshape(-1, 1), robots=run.robots.reshape(1, -1))
    with open(path + ".part", "wb") as file:
        savemat(file, arrays, do_compression=True)
    os.replace(path + ".part", path)
    return path


def add_exports(parser):
    """Give ``parser`` the options ``--table`` and ``--mat``, which :func:`write_exports` takes."""
    parser.add_argument(
        "--table", default="", metavar="KINDS", help="write verdict.tex, verdict.csv: tex,csv"
    )
    parser.add_argument("--mat", action="store_true", help="write run.mat, by scipy")


def check_exports(arguments):
    """Raise ``ExportError`` for options of :func:`add_exports` that cannot be met."""
    table_kinds(arguments.table)
    if arguments.mat and importlib.util.find_spec("scipy") is None:
        raise ExportError(NO_SCIPY)


def write_exports(arguments, run, verdict):
    """Write what the options of :func:`add_exports` ask for to ``arguments.out``; return the paths.

    ``run``: a function that returns the ``Run``, called where it is wanted.
    """
    narrow = look(arguments.width).width < NARROW
    paths = write_tables(verdict, arguments.out, table_kinds(arguments.table), narrow)
    return paths + ([write_mat(run(), arguments.out)] if arguments.mat else [])
