"""Formulas in plain text as MathML, which browsers set without a font or a script.

``A W^2 cos(tilt) - C w_3 W + m g l = 0``: a space multiplies, digits behind a letter and ``_`` lower, ``^`` raises,
``'``, ``_dot`` and ``_ddot`` are dots, ``x`` is the cross product, ``w`` and ``W`` are omegas (not as an
index), words stand upright.
``a b / c d`` divides the whole product by all that follows, ``a/b`` without spaces its neighbours only; formulas with a
semicolon between them stand below each other. A line may break behind a comma in no bracket, else before such a sign.
"""

import re
from collections.abc import Collection
from html import escape

from ..base.errors import InputError

LETTERS = "alpha beta gamma delta theta lambda lam mu rho tau phi psi pi w W".split()
GREEK = dict(zip(LETTERS, "αβγδθλλμρτφψπωΩ", strict=True))
SIGNS = {"-": "−", "+-": "±", "<=": "≤", ">=": "≥", "~": "∼", "x": "×", ".": "·"}
DOTS = {"'": "˙", "_dot": "˙", "''": "¨", "_ddot": "¨"}
FUNCTIONS = ("sin", "cos", "tan", "cot", "acos", "atan2", "cd", "det", "mod")
CLOSING = {"(": ")", "|": "|"}
PRODUCT_ENDS = ("", "=", "<=", ">=", "~", "+", "-", "+-", ",", ":")  # of a product
PIECE_PATTERN = re.compile(r"(\s*)(\d+(?:\.\d+)?|[A-Za-z]+\d*(?:_[A-Za-z0-9]+)?'*|\+-|<=|>=|\S)")
NAME_PATTERN = re.compile(r"([A-Za-z]+?)(\d*)(_d?dot|'*)(?:_(\w+?))?(_d?dot|'*)")
SPACE = '<mspace width=".3em"></mspace>'
THIN = '<mspace width=".2em"></mspace>'


def mathml(text: str, symbols: Collection[str] = ()) -> str:
    """Return one paragraph for each formula of a text, with ``data-symbol`` at those symbols; raise ValueError where a
    bracket stays open.
    """
    return "".join(f"<p>{Reader(line, symbols).formula()}</p>" for line in text.split(";"))


def letters(text: str) -> set[str]:
    """Return the symbols of formulas without their dots: names of one letter, with or without an index; not x, which
    may be the cross product.
    """
    pieces = {without_dots(piece) for line in text.split(";") for _, piece in PIECE_PATTERN.findall(line)}
    return {piece for piece in pieces if piece not in ("x", "pi", *FUNCTIONS) and "<mi>" in name(piece)}


def without_dots(piece: str) -> str:
    """Return a symbol without dots for derivatives."""
    return re.sub(r"_d?dot$", "", piece.rstrip("'"))


class Reader:
    """Pieces of one formula from the left: (whether a space stands before it, text)."""

    def __init__(self, text: str, symbols: Collection[str] = ()) -> None:
        self.text, self.symbols = text, symbols
        self.pieces = [(bool(space), piece) for space, piece in PIECE_PATTERN.findall(text)][::-1]
        self.inside: dict[str, str] = {}  # what stands in the brackets read so far

    @property
    def coming(self) -> tuple[bool, str]:
        """Return the next piece."""
        return self.pieces[-1] if self.pieces else (True, "")

    def take(self) -> str:
        """Read the next piece."""
        return self.pieces.pop()[1]

    def formula(self) -> str:
        """Return the whole formula, a ``<math>`` element a term: browsers break lines between these only, at commas
        first.
        """
        terms = [term.replace("<mo>", '<mo form="infix">', k > 0) for k, term in enumerate(self.terms(""))]
        clauses = [""]
        for term in terms:
            clauses[-1] += f'<math displaystyle="true">{term}</math> '
            if term.endswith(sign(",")):
                clauses.append("")
        return " ".join(f"<span>{clause.strip()}</span>" for clause in clauses if clause)

    def sequence(self, closing: str) -> str:
        """Return products and the signs between them, up to a closing bracket or the end."""
        return "".join(self.terms(closing))

    def terms(self, closing: str) -> list[str]:
        """Return products, each with the signs before it; a comma belongs to what it ends."""
        terms, open_ = [""], False  # whether a product follows the signs of the last term
        while self.coming[1] not in ("", closing):
            if self.coming[1] not in PRODUCT_ENDS:
                terms[-1] += self.product(closing)
                open_ = True
            elif open_ and self.coming[1] not in ",:":
                terms.append(sign(self.take()))
                open_ = False
            else:
                terms[-1] += sign(self.take())
        return terms

    def product(self, closing: str) -> str:
        """Return factors; a slash between spaces divides all of them by all that follow."""
        factors = ""
        while self.coming[1] not in (*PRODUCT_ENDS, closing):
            if self.coming[1] == "/":
                self.take()
                return self.fraction(factors, self.product(closing))
            found = sign(self.take()) if self.coming[1] in ("x", ".") else self.quotient(closing)
            beside = factors and (factors.endswith("</mtext>") or found.startswith("<mtext>"))
            factors += (SPACE if beside else "") + found
        return factors

    def quotient(self, closing: str) -> str:
        """Return factors without a space between them, divided by others where a slash follows as close."""
        above = self.factors(closing)
        if self.coming != (False, "/"):
            return above
        self.take()
        return self.fraction(above, self.factors(closing))

    def factors(self, closing: str) -> str:
        """Return factors without a space between them, the first of them in any case."""
        found = self.power()
        while not self.coming[0] and self.coming[1] not in (*PRODUCT_ENDS, closing, "/", ")"):
            found += self.power()
        return found

    def power(self) -> str:
        """Return a number, name or bracket with its exponent."""
        piece = self.take()
        if piece == "sqrt":
            found = f"<msqrt>{self.bracket(self.take())[1]}</msqrt>"
        elif piece in CLOSING:
            found, inside = self.bracket(piece)
            self.inside[found] = inside if piece == "(" else found
        else:
            found = f"<mn>{piece}</mn>" if piece[0].isdigit() else name(piece)
            if (symbol := without_dots(piece)) in self.symbols:
                found = f'<mrow data-symbol="{symbol}">{found}</mrow>'
        if self.coming == (False, "^"):
            self.take()
            raised = self.bracket(self.take())[1] if self.coming[1] == "(" else self.power()
            found = f"<msup>{found}<mrow>{raised}</mrow></msup>"
        return f"{THIN}{found}{THIN if self.coming[0] else ''}" if piece in FUNCTIONS else found

    def bracket(self, opening: str) -> tuple[str, str]:
        """Return a bracket with its content; it is as tall as the fractions in it."""
        inside = self.sequence(CLOSING.get(opening, ""))
        if self.coming[1] != CLOSING.get(opening):
            raise InputError(f"formula '{self.text.strip()}': '{opening}' is not closed; write e.g. sqrt(2)")
        tall = str("<mfrac>" in inside).lower()
        ends = [f'<mo stretchy="{tall}">{end}</mo>' for end in (opening, self.take())]
        return f"<mrow>{ends[0]}{inside}{ends[1]}</mrow>", inside

    def fraction(self, above: str, below: str) -> str:
        """Return a fraction; its line replaces a bracket."""
        above, below = (self.inside.get(part, part) for part in (above, below))
        return f"<mfrac><mrow>{above}</mrow><mrow>{below}</mrow></mfrac>"


def name(text: str) -> str:
    """Return a letter with index and dots, a function, or a word."""
    if text in FUNCTIONS:
        return f"<mi>{text}</mi>"
    found = NAME_PATTERN.fullmatch(text)
    if not found:
        return sign(text)
    letter, digits, dots, lowered, late = found.groups()
    if len(letter) > 1 and letter not in GREEK:
        return f"<mtext>{text}</mtext>"
    base = f"<mi>{GREEK.get(letter, letter)}</mi>"
    if dots or late:
        base = f'<mover accent="true">{base}<mo stretchy="false">{DOTS[dots or late]}</mo></mover>'
    index = digits or lowered
    if not index:
        return base
    lowered = index if index in ("w", "W") else GREEK.get(index, index)  # I_w is that of a wheel
    return f"<msub>{base}<mi>{lowered}</mi></msub>"


def sign(text: str) -> str:
    """Return an operator, a bracket or a comma."""
    return f"<mo>{escape(SIGNS.get(text, text))}</mo>"
