"""Exports: the verdict as LaTeX and CSV tables, the run for pandas and MATLAB."""

import csv
import io
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from mrs_simulator.study.results.export import (
    ExportError,
    table_kinds,
    verdict_csv,
    verdict_latex,
    write_mat,
)
from mrs_simulator.study.results.report import main as report
from mrs_simulator.study.results.report import read_run
from mrs_simulator.study.run.command import main as experiment

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOUR = os.path.join(ROOT, "scenarios", "paper_four.yaml")


def check(name, predicted, measured, tolerance, passed, note=""):
    return dict(
        name=name,
        predicted=predicted,
        measured=measured,
        tolerance=tolerance,
        passed=passed,
        note=note,
        question="theorem",
    )


VERDICT = {
    "title": "50 % & more_of",
    "outcome": "failed",
    "passed": False,
    "reason": "",
    "checks": [
        check("|1 - gain Tc| < 1", "holds", "holds", None, True),
        check("drift of w^T p [m]", 0.0, 1.25e-7, 0.01, False),
        check("longest edge [m]", 4.0, 3.5, 0.0, True, "at most"),
        check("rate [1/s]", 0.5, None, 0.025, None, "does not apply: edges_lossy"),
    ],
}


def test_the_latex_table_line_by_line():
    lines = verdict_latex(VERDICT).splitlines()
    assert r"  \caption{50 \% \& more\_of: failed.}" in lines
    assert (
        r"  \raggedright \textbar{}1 - gain Tc\textbar{} \textless{} 1 & holds & holds & -- & passed \\"
        in lines
    )
    assert (
        r"  \raggedright drift of w\ensuremath{^T} p [m] & $0$ & $1.25 \times 10^{-7}$ & $0.01$ & failed \\"
        in lines
    )
    assert r"  \raggedright longest edge [m] & $\leq$ $4$ & $3.5$ & $0$ & passed \\" in lines
    assert (
        r"  \raggedright rate [1/s]\textsuperscript{a} & $0.5$ & -- & $0.025$ & not judged \\"
        in lines
    )
    assert r"  \textsuperscript{a}\,does not apply: edges\_lossy" in lines


# Title, names and notes with whatever LaTeX minds.
NASTY = "\\ { } & % $ # _ ^ ~ < > | \" ' 1\u00b0 \u2264 \u00fc \u03bb \u0416 \t two\nlines"
MANY = {
    **VERDICT,
    "title": NASTY,
    "outcome": "not_judged",
    "reason": NASTY,
    "checks": [
        check(
            "{} of lambda_max, tau and w^T p {}".format(row, NASTY), 1e-300, -1e9, 0.5, None, note
        )
        for row, note in enumerate(["note {}: {}".format(k, NASTY) for k in range(30)])
    ],
}


def test_what_latex_minds_is_escaped():
    text = verdict_latex(MANY)
    assert r"\ensuremath{\lambda_{\mathrm{max}}}, \ensuremath{\tau} and w\ensuremath{^T} p" in text
    row = next(line for line in text.splitlines() if line.startswith(r"  \raggedright 0 of"))
    escaped = (
        r"\textbackslash{} \{ \} \& \% \$ \# \_ \textasciicircum{} \textasciitilde{} \textless{} "
        r"\textgreater{} \textbar{}"
    )
    assert (
        escaped in row and r"1\ensuremath{^\circ} \ensuremath{\leq}" in row and "two lines" in row
    )
    assert r"\texttt{U+03BB} \texttt{U+0416} \texttt{U+0009}" in row
    assert r"\textsuperscript{ad}\,note 29" in text  # after z come aa, ab, ...
    stripped = re.sub(r"\\.", "", text)  # of commands and escaped letters
    assert stripped.count("{") == stripped.count("}")
    assert not re.search(r"[#~|<>\x80-\xbf\u0180-\uffff]", stripped)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no LaTeX")
@pytest.mark.parametrize(
    "verdict, narrow",
    [(VERDICT, False), (VERDICT, True), (MANY, False)],
    ids=["page", "column", "nasty"],
)
def test_latex_takes_the_table(tmp_path, verdict, narrow):
    text = "\\documentclass%s{article}\\usepackage{booktabs}\\begin{document}\n%s\\end{document}\n"
    text %= "[twocolumn]" if narrow else "", verdict_latex(verdict, narrow)
    (tmp_path / "t.tex").write_text(text, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "t.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stdout[-2000:].decode(errors="replace")
    log = (tmp_path / "t.log").read_text(errors="replace")
    assert "Overfull" not in log or verdict is MANY  # it fits the narrow page of article


def test_a_long_text_stands_in_a_note_below_the_latex_table():
    ended = "1.00 s the law failed: RuntimeError: gone"
    text = verdict_latex(dict(VERDICT, checks=[check("ended", "complete", ended, None, False)]))
    assert r"  \raggedright ended\textsuperscript{a} & complete & -- & -- & failed \\" in text
    assert r"\textsuperscript{a}\,1.00 s the law failed: RuntimeError: gone" in text


def test_the_csv_table_has_all_digits():
    rows = list(csv.DictReader(io.StringIO(verdict_csv(VERDICT))))
    assert [row["outcome"] for row in rows] == ["passed", "failed", "passed", "not judged"]
    assert float(rows[1]["measured"]) == 1.25e-7 and rows[3]["measured"] == ""
    assert rows[0]["question"] == "theorem"


def test_an_unknown_table_is_refused_before_the_run(tmp_path, capsys):
    assert table_kinds("tex, csv") == ["tex", "csv"] and table_kinds("") == []
    with pytest.raises(ExportError, match="'html': wanted tex or csv"):
        table_kinds("html")
    with pytest.raises(SystemExit) as ended:
        experiment([FOUR, "--out", str(tmp_path / "run"), "--table", "html"])
    assert ended.value.code == 2 and not (tmp_path / "run").exists()
    assert "wanted tex or csv" in capsys.readouterr().err


@pytest.fixture(scope="module")
def run_directory(tmp_path_factory):
    """A short run with its tables, by the command."""
    out = tmp_path_factory.mktemp("exported")
    arguments = [FOUR, "--out", str(out), "--duration", "1", "--table", "tex,csv"]
    with pytest.raises(SystemExit):
        experiment(arguments)
    return out


def test_the_commands_write_tables_on_request(run_directory, tmp_path, capsys):
    made = {name: (run_directory / name).read_text() for name in ("verdict.tex", "verdict.csv")}
    assert made["verdict.tex"].startswith("\\begin{table}") and made["verdict.csv"].startswith(
        "check,"
    )
    arguments = [str(run_directory / "run.csv"), "--out", str(tmp_path), "--formats", ""]
    with pytest.raises(SystemExit):
        report(arguments + ["--table", "csv"])
    assert (tmp_path / "verdict.csv").read_text() == made["verdict.csv"]
    assert not (tmp_path / "verdict.tex").exists()
    assert "exported: " in capsys.readouterr().out


def test_pandas_reads_a_run_in_one_line(run_directory):
    pandas = pytest.importorskip("pandas")
    table = pandas.read_csv(str(run_directory / "run.csv"), float_precision="round_trip")
    run = read_run(str(run_directory / "run.csv"))
    wide = table.pivot(index="time", columns="robot", values="alpha_x")
    np.testing.assert_array_equal(wide.to_numpy(), run.hand[:, :, 0])


def test_scipy_writes_the_arrays_for_matlab(run_directory, tmp_path):
    io_of_scipy = pytest.importorskip("scipy.io")
    run = read_run(str(run_directory / "run.csv"))
    found = io_of_scipy.loadmat(write_mat(run, str(tmp_path)))
    np.testing.assert_array_equal(found["hand"], run.hand)
    np.testing.assert_array_equal(found["time"][:, 0], run.time)
    assert found["robots"].tolist() == [[1, 2, 3, 4]]
