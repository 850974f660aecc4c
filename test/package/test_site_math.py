"""Formulas of the pages as MathML, as the site shows them."""

import os
import re
import sys
import xml.etree.ElementTree as ElementTree

import pytest
from documentation import DOCS, ROOT, page

sys.path.insert(0, os.path.join(ROOT, "tools"))
try:
    import site_math
finally:
    sys.path.remove(os.path.join(ROOT, "tools"))

PAGES = sorted(
    os.path.join("protocols", name) for name in os.listdir(os.path.join(DOCS, "protocols"))
)


def shown(formula):
    """Return what a reader sees of ``formula``, without its spaces, where it is below and above."""
    return "".join(ElementTree.fromstring(site_math.mathml(formula)).itertext())


@pytest.mark.parametrize(
    "formula, text",
    [
        ("u_i = gain sum_j a_ij (p_j - p_i)", "ui=gain∑jaij(pj−pi)"),
        ("0 <= eps < 2/lambda_max", "0≤ε<2λmax"),
        ("alpha_i*", "αi∗"),
        ("-L_ff^-1 L_fl p_l", "−Lff−1Lflpl"),
        ("u = -gain L p_hat", "u=−gainLp^"),
        ("|1 - gain Tc mu| < 1", "|1−gainTcμ|<1"),
    ],
)
def test_a_formula_has_its_signs(formula, text):
    assert shown(formula) == text


def test_fractions_and_roots_lose_their_brackets():
    text = site_math.mathml("z/(a + b)")
    assert "<mfrac><mrow><mi>z</mi></mrow><mrow><mi>a</mi>" in text and "(" not in text[30:]
    assert "<msqrt>" in site_math.mathml("sqrt(U^2 - V^2)")
    assert "(" in site_math.mathml("(a, b)/c")[30:]  # of a vector they stay
    both = site_math.mathml("(a)(b)/(c)(d)")  # the factor before the bar alone is above it
    assert both.count("<mfrac>") == 1 and "<mfrac><mrow><mi>b</mi></mrow>" in both


@pytest.mark.parametrize("name", PAGES)
def test_every_formula_of_a_protocol_s_page_is_read(name):
    law = page(name).partition("## Parameters")[0]
    for code in set(re.findall(r"`([^`\n]+)`", law)):
        if site_math.is_formula(code):
            ElementTree.fromstring(site_math.mathml(code))


@pytest.mark.parametrize(
    "code", ["gain", "bearing_formation", "my_law.py", "0:5", "self.topology", "neighbour_sum()"]
)
def test_names_stay_code(code):
    assert not site_math.is_formula(code)
    html = "<p><code>{}</code></p>".format(code)
    assert site_math.typeset(html) == html


def test_blocks_of_code_and_titles_stay_and_cells_lose_their_backslash():
    for html in ("<pre><code>a_i = b</code></pre>", "<h1><code>a_i</code></h1>"):
        assert site_math.typeset(html) == html
    assert site_math.typeset(r"<td><code>\|p_i\|</code></td>").startswith("<td><math aria-label=")


def test_paragraphs_that_are_set_in_are_displayed_and_code_is_not():
    markdown = (
        "Here\n\n    u = a b\n\nand\n\n```sh\n\n    u = a b\n\n```\n\n    no: $formula\n\nend\n"
    )
    found = site_math.displayed(markdown)
    assert found.count('<math display="block"') == 1
    assert "```sh\n\n    u = a b" in found and "    no: $formula" in found
