"""For the site: formulas as the pages write them, ``u_i = gain sum_j a_ij (p_j - p_i)``, as MathML.

Browsers typeset MathML by themselves: no script, no font and no network is needed.
"""

import re
from html import escape

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "theta": "θ", "lambda": "λ",
    "mu": "μ", "nu": "ν", "pi": "π", "sigma": "σ", "tau": "τ", "psi": "ψ", "eta": "η", "omega": "ω",
}  # fmt: skip
SIGNS = {"sum": "∑", "int": "∫"}
WORDS = {"cos", "sin", "exp", "max", "min", "arg", "Re", "Im", "sqrt"}
RELATIONS = {"<=": "≤", ">=": "≥", "->": "→", "-": "−", "*": "·"}
TOKEN = re.compile(
    r"\s+|(?P<number>\d+(?:\.\d+)?)|(?P<name>[A-Za-z]+)|(?P<other><=|>=|->|\.\.\.|[-+*/^_=<>()|',.:\[\]])"
)
OPENING, CLOSING = "([", ")]"
CODE = re.compile(r"(<pre\b.*?</pre>|<h1\b.*?</h1>)|<code>([^<]*)</code>", re.S)


class NoFormula(ValueError):
    """The text is not of this notation."""


def is_formula(text):
    """Return whether a span of code is a formula, and no name of a parameter or a file."""
    if re.search(r"[\"{}\\$:@#%]|\w\.\w|\w\(self|--|\w__", text):
        return False
    subscripted = re.fullmatch(r"([A-Za-z]+)_(\w+)", text)
    if subscripted:
        base = subscripted.group(1)
        return (len(base) == 1 or base in GREEK) and len(subscripted.group(2)) < 4
    return bool(re.search(r"[ ^/|*'()<>=+]", text)) and not re.fullmatch(r"\w+\(?\)?", text)


def mathml(text, display=False):
    """Return the formula ``text`` as MathML; raises ``NoFormula`` where it is none."""
    inner = _Reader(text).formula()
    kind = ' display="block"' if display else ""
    return '<math{} aria-label="{}">{}</math>'.format(kind, escape(text, quote=True), inner)


def typeset(html):
    """Return ``html`` with MathML in place of the spans of code that are formulas."""

    def formula(found):
        text = found.group(2)
        if text is None:
            return found.group(0)
        text = text.replace("\\|", "|")  # of a table's cell
        plain = "<code>{}</code>".format(text)
        for name, sign in (("&lt;", "<"), ("&gt;", ">"), ("&quot;", '"'), ("&amp;", "&")):
            text = text.replace(name, sign)
        try:
            return mathml(text) if is_formula(text) else plain
        except NoFormula:
            return plain

    return CODE.sub(formula, html)


def displayed(markdown):
    """Return ``markdown`` with MathML in place of paragraphs that are set in, each line a formula."""

    def block(found):
        lines = [line.strip() for line in found.group(1).strip("\n").split("\n")]
        try:
            rows = [mathml(line, display=True) for line in lines if line]
        except NoFormula:
            return found.group(0)
        return '\n\n<div class="formula">{}</div>\n\n'.format("".join(rows))

    pieces = re.split(r"(^```.*?^```$)", markdown, flags=re.M | re.S)
    indented = re.compile(r"(?:(?<=\n)|^)\n((?: {4}[^\n]*\n(?:\n(?= {4}))?)+)(?=\n)")
    return "".join(
        piece if piece.startswith("```") else indented.sub(block, piece) for piece in pieces
    )


class _Reader:
    """Reads a formula from left to right."""

    def __init__(self, text):
        self._tokens, at = [], 0
        while at < len(text):
            found = TOKEN.match(text, at)
            if not found:
                raise NoFormula(text)
            self._tokens.append(
                found.group(0) if found.group(0).strip() else " " * len(found.group(0))
            )
            at = found.end()
        self._at = 0

    def _peek(self, ahead=0):
        place = self._at + ahead
        return self._tokens[place] if place < len(self._tokens) else ""

    def _take(self):
        self._at += 1
        return self._tokens[self._at - 1]

    def formula(self, until=""):
        """Return the MathML of what comes, up to one of the signs ``until``."""
        parts = []
        while self._peek() and self._peek() not in (until or "\0"):
            token = self._peek()
            if token.isspace():
                parts.append(_space(len(self._take()), parts))
            elif token == "/" and parts:
                self._take()
                parts.append(self._fraction(_last(parts)))
            elif _is_sign(token):
                sign = self._take()
                parts.append("<mo>{}</mo>".format(escape(RELATIONS.get(sign, sign))))
            else:
                parts.append(self._scripted())
        return "".join(parts)

    def _fraction(self, above):
        while self._peek().isspace():
            self._take()
        if not self._peek():
            raise NoFormula("/")
        below = self._scripted()
        return "<mfrac>{}{}</mfrac>".format(_bare(above), _bare(below))

    def _scripted(self):
        """Return an atom with what stands below and above it."""
        plain = self._peek()
        base, below, above = self._atom(), "", ""
        while True:
            token, following = self._peek(), self._peek(1)
            if token == "_":
                self._take()
                if self._peek() == "hat":
                    self._take()
                    base = '<mover accent="true">{}<mo>^</mo></mover>'.format(base)
                else:
                    below = self._script()
            elif token == "^":
                self._take()
                above += self._script()
            elif token == "'":
                self._take()
                above += "<mo>′</mo>"
            elif token in ("*", "+") and plain not in ")|" and not _begins(following):
                above += "<mo>{}</mo>".format("∗" if self._take() == "*" else "+")
            else:
                break
        if below and above:
            return "<msubsup>{}{}{}</msubsup>".format(base, _row(below), _row(above))
        if below:
            return "<msub>{}{}</msub>".format(base, _row(below))
        return "<msup>{}{}</msup>".format(base, _row(above)) if above else base

    def _script(self):
        sign = "<mo>−</mo>" if self._peek() == "-" and self._take() else ""
        if self._peek() == "(":
            self._take()
            inner = self.formula(")")
            self._end(")")
            return sign + inner
        return sign + _name(self._take(), joined=True)

    def _atom(self):
        token = self._take()
        if token in OPENING:
            inner = self.formula(CLOSING)
            return _fenced(token, inner, self._end(CLOSING))
        if token == "|":
            inner = self.formula("|")
            return _fenced("|", inner, self._end("|"))
        if token == "sqrt" and self._peek() == "(":
            self._take()
            inner = self.formula(")")
            self._end(")")
            return "<msqrt>{}</msqrt>".format(inner)
        if token in WORDS and self._peek() == "(":
            return "<mrow><mi>{}</mi>{}</mrow>".format(token, self._atom())
        if not token or not (token.isalnum() or token == "..."):
            raise NoFormula(token)
        return _name(token)

    def _end(self, signs):
        if not self._peek() or self._peek() not in signs:
            raise NoFormula("wanted one of " + signs)
        return self._take()


def _is_sign(token):
    return token in "+-*=<>,:.'/" or token in ("<=", ">=", "->")


def _begins(token):
    """Return whether a factor begins with ``token``."""
    return bool(token) and (token.isalnum() or token in OPENING)


def _name(token, joined=False):
    """Return a name or a number; ``joined``: letters of indices, each for itself."""
    if token[0].isdigit():
        return "<mn>{}</mn>".format(token)
    if token in SIGNS:
        return "<mo>{}</mo>".format(SIGNS[token])
    if token in GREEK:
        return "<mi>{}</mi>".format(GREEK[token])
    if token in ("Tc", "dq"):
        return "<msub><mi>T</mi><mi>c</mi></msub>" if token == "Tc" else "<mi>d</mi><mi>q</mi>"
    if joined and len(token) == 2 and token.islower():
        return "".join("<mi>{}</mi>".format(letter) for letter in token)
    return "<mi>{}</mi>".format(escape(token))


def _space(width, parts):
    return '<mspace width="{}em"/>'.format(2 if width > 2 else 0.2) if parts else ""


def _last(parts):
    """Take the last factor from ``parts``."""
    while parts and parts[-1].startswith("<mspace"):
        parts.pop()
    if not parts:
        raise NoFormula("/")
    return parts.pop()


def _fenced(begin, inner, end):
    high = "" if "<mfrac>" in inner else ' stretchy="false"'
    text = "<mrow><mo{0}>{1}</mo>{2}<mo{0}>{3}</mo></mrow>"
    return text.format(high, begin, inner, end)


def _bare(part):
    """Return a factor of a fraction without its brackets."""
    found = re.fullmatch(r"<mrow><mo[^>]*>\(</mo>(.*)<mo[^>]*>\)</mo></mrow>", part, re.S)
    bare = found and _balanced(found.group(1)) and "<mo>,</mo>" not in found.group(1)
    return _row(found.group(1)) if bare else _row(part)


def _balanced(inner):
    depth = 0
    for sign in re.findall(r"<mo[^>]*>([()])</mo>", inner):
        depth += 1 if sign == "(" else -1
        if depth < 0:
            return False
    return True


def _row(inner):
    return "<mrow>{}</mrow>".format(inner)
