"""Mathematics as it is printed: Greek letters, indices, powers and relations."""

import html
import re

GREEK = {
    "alpha": "\u03b1",
    "beta": "\u03b2",
    "gamma": "\u03b3",
    "delta": "\u03b4",
    "eps": "\u03b5",
    "epsilon": "\u03b5",
    "theta": "\u03b8",
    "kappa": "\u03ba",
    "lambda": "\u03bb",
    "mu": "\u03bc",
    "sigma": "\u03c3",
    "tau": "\u03c4",
    "phi": "\u03c6",
    "omega": "\u03c9",
    "pi": "\u03c0",
}
LOW = str.maketrans(
    "0123456789aeijklmnoprstuvx",
    "\u2080\u2081\u2082\u2083\u2084\u2085\u2086\u2087\u2088\u2089\u2090\u2091\u1d62"
    "\u2c7c\u2096\u2097\u2098\u2099\u2092\u209a\u1d63\u209b\u209c\u1d64\u1d65\u2093",
)
HIGH = str.maketrans(
    "0123456789-nT",
    "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b\u207f\u1d40",
)
NAMES = re.compile(r"(?<![A-Za-z])({})(?![A-Za-z])".format("|".join(sorted(GREEK, key=len)[::-1])))
# A symbol's index is short; names of files and parameters with longer ones stay as they are.
INDEX = re.compile(
    r"(?<![A-Za-z0-9])([A-Za-z\u03b1-\u03c9])_([0-9aeijklmnoprstuvx]{1,2})(?![A-Za-z0-9_])"
)
POWER = re.compile(r"\^(-?[0-9]+|[nT])(?![A-Za-z0-9.])")
ROOT = re.compile(r"([A-Za-z\u03b1-\u03c9]+)\^0\.5(?![0-9])")
SYMBOL = re.compile(r"([A-Za-z]|v(?=[xy]$))([0-9xy]{0,2})$")  # of a parameter, with its index
RELATIONS = (("<=", "\u2264"), (">=", "\u2265"), ("!=", "\u2260"), (" +- ", " \u00b1 "))


def symbolic(text):
    """Return ``text`` with its symbols as mathematics is printed, lambda_2 as \u03bb\u2082."""
    text = NAMES.sub(lambda found: GREEK[found.group(1)], text.replace("lambda_", "\u03bb_"))
    text = INDEX.sub(lambda found: found.group(1) + found.group(2).translate(LOW), text)
    text = ROOT.sub("\u221a\\1", text)
    text = POWER.sub(lambda found: found.group(1).translate(HIGH), text)
    for plain, printed in RELATIONS:
        text = text.replace(plain, printed)
    return text


def printed_name(name):
    """Return the name of a parameter as rich text: c1 as a symbol with an index, leader_vx as words."""
    return " ".join(_printed_word(word) for word in name.split("_") if word) or html.escape(name)


def _printed_word(word):
    if word in GREEK:
        return "<i>{}</i>".format(GREEK[word])
    found = SYMBOL.match(word)
    if not found:
        return html.escape(word)
    symbol, index = found.groups()
    if not index:
        return "<i>{}</i>".format(symbol)
    index = index if index.isdigit() else "<i>{}</i>".format(index)
    return "<i>{}</i><sub>{}</sub>".format(symbol, index)
