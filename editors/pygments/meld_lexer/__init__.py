"""Colours for Meld in everything that uses Pygments: Sphinx, LaTeX (minted), pygmentize."""

from pygments.lexer import RegexLexer, bygroups, include, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Whitespace

__all__ = ["MeldLexer"]

NAME = r"[a-z][A-Za-z0-9_?']*(?:-[A-Za-z0-9_?']+)*"
# A declaration starts a line, or stands behind the full stop of another one.
START = r"(?:^|(?<=\.))"
VARIABLE = r"[A-Z_][A-Za-z0-9_?']*"
BEGIN = r"(?<![A-Za-z0-9_?'-])"
END = r"(?![A-Za-z0-9_?'-])"
# What makes `type` and its like a word of the language: a fact of that name has a bracket with arguments behind it.
DECLARES = END + r"(?!\s*(?::-|-o|\(\s*(?:[A-Z_@#]|\))))"


class MeldLexer(RegexLexer):
    """Meld, as Claymeld compiles it."""

    name = "Meld"
    aliases = ["meld"]
    filenames = ["*.meld"]
    mimetypes = ["text/x-meld"]
    url = "https://www.cs.cmu.edu/~claytronics/"

    tokens = {
        "gap": [
            (r"\ufeff", Whitespace),
            (r"[^\S\n]+|\n", Whitespace),
            (r"(?://|;;).*$", Comment.Single),
            (r"/\*", Comment.Multiline, "comment"),
        ],
        "comment": [
            (r"/\*", Comment.Multiline, "#push"),
            (r"\*/", Comment.Multiline, "#pop"),
            (r"[^*/]+|[*/]", Comment.Multiline),
        ],
        "string": [
            (r'"', String.Double, "#pop"),
            (r"\\(?:x[0-9A-Fa-f]{2}|[^\n])", String.Escape),
            (r'[^"\\\n]+|\\', String.Double),
            (r"\n", Whitespace, "#pop"),
        ],
        "root": [
            (START + r"([ \t]*)(type|extern|import)" + DECLARES, bygroups(Whitespace, Keyword.Declaration), "declaration"),
            (START + r"([ \t]*)(const|fun)(?=\s+[A-Za-z])", bygroups(Whitespace, Keyword.Declaration)),
            (START + r"([ \t]*)(node|export|module|priority|prio|index|compact|data|allocator)" + END + r'(?=[ \t]+[a-z@"])',
             bygroups(Whitespace, Keyword.Declaration)),
            include("gap"),
            (r'(#include)([ \t]*)("[^"\n]*"|<[^>\n]*>)', bygroups(Keyword.Namespace, Whitespace, String)),
            (BEGIN + r'(include)([ \t]+)(#[^ \t\r\n,()"]+)', bygroups(Keyword.Namespace, Whitespace, String)),
            (BEGIN + r'(?:include|use)(?=\s*")', Keyword.Namespace),
            include("values"),
        ],
        # A declaration ends at its full stop.
        "declaration": [
            include("gap"),
            (r'"', String.Double, "string"),
            (r"\.", Punctuation, "#pop"),
            (words(("route", "linear", "action", "sensed", "persistent", "virtual", "while", "from", "as"), BEGIN, END), Keyword),
            (words(("bool", "int", "float", "string", "node", "catom", "module", "addr", "list", "set", "array", "vec3", "type"),
                   BEGIN, END), Keyword.Type),
            (words(("min", "max", "sum", "count", "first", "any", "set_union", "union", "append", "avg", "and", "or"), BEGIN,
                   END + r"(?!\()"), Name.Builtin),
            (BEGIN + r"(?:min_k|max_k)" + END, Name.Builtin),
            (NAME + r"(?=\s*\()", Name.Function),
            (NAME, Name),
            (VARIABLE, Name.Variable),
            (r"\[\s*(?:<-|->)", Operator),
            (r":\(|[][(){},:;|]", Punctuation),
            (r"[-+*/%^=<>~@#!?$]|[0-9]+", Operator),
        ],
        "values": [
            (r'"', String.Double, "string"),
            (r"@[ \t]*\+[ \t]*-?[0-9]+(?:\.[0-9]+)?[A-Za-z]*", Number),
            (r"@world\b|@arg[0-9]+", Name.Builtin.Pseudo),
            (r"[@#][0-9]+", Name.Constant),
            (r"@[a-z][A-Za-z0-9_-]*", Name.Decorator),
            (r"[0-9]+(?:\.[0-9]+(?:[eE][-+]?[0-9]+)?|[eE][-+]?[0-9]+)", Number.Float),
            (r"[0-9]+", Number.Integer),
            (words(("true", "false", "nil"), BEGIN, END), Keyword.Constant),
            (BEGIN + r"(?:then|else|otherwise|end|in)" + END + r"(?!\()|" + BEGIN + "if" + END + r"(?!\s*\((?!.*\bthen\b))", Keyword),
            (BEGIN + r"(?:let(?=\s+[A-Z])|not(?=\s*[(!?$]|\s+[a-z])|forall(?=\s+[a-z!?$])|(?:exists|create)(?=\s+[A-Z_]))", Keyword),
            (BEGIN + r"delta(?=\s*\(\s*[A-Z][A-Za-z0-9_]*\s*;)", Keyword),
            (BEGIN + r"(?:min|max|sum|count|collect|custom|avg|and|or|first|any|asc|desc|random)" + END +
             r"(?=\s*(?:=>|:(?!-)|[A-Z][A-Za-z0-9_]*\s*(?:[:|]|=>)|[a-z]))", Name.Builtin),
            (BEGIN + r"(?:min_k|max_k)" + END + r"(?=\s*\()", Name.Builtin),
            (NAME + r"(?=\s*\()", Name.Function),
            (NAME, Name.Constant),
            (r"_(?![A-Za-z0-9_?'])", Name.Builtin.Pseudo),
            (VARIABLE, Name.Variable),
            (r":-|-o(?![A-Za-z0-9_?'-])|=>|->|\[\s*(?:<-|->)", Operator.Word),
            (r"::|<>|!=|<=|>=|==|&&|\|\||\+\+|[-+*/%^=<>~!?$]", Operator),
            (r":\(|[][(){},:;|.]", Punctuation),
        ],
    }
