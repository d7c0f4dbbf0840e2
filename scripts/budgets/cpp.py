"""Classes and templates of C++ sources, by a tokenizer that knows brackets and no types.

Macros are not expanded, and conditions of the preprocessor not taken: all branches count.
"""
import collections
import re

Class = collections.namedtuple("Class", "name members virtuals private")  # counts: data members, virtual functions, private functions
Template = collections.namedtuple("Template", "name parameters")

TOKEN = re.compile(r'[A-Za-z_]\w*|\.?\d(?:[\w.]|\'\w|[eEpP][+-])*|::|->|&&|\|\||[<>=!+\-*/&|^%]=|\S')
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|(?:u8|[uUL])?R"([^ ()\\\t\n]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*', re.S | re.M)
OPEN, CLOSE = "([{", ")]}"
TYPES = ("class", "struct", "union", "enum")
NO_DECLARATION = ("using", "typedef", "friend", "static_assert", "static", "extern")


def tokens(text):
    """Words and signs of a source, without comments, strings, character literals and directives."""
    return TOKEN.findall(SKIPPED.sub(lambda m: " " if m[0][0] in "/#" or m[0].lstrip().startswith("#") else " 0 ", text))


def after(words, k):
    """Behind the bracket that closes the one at k."""
    depth = 0
    while k < len(words):
        depth += (words[k] in OPEN) - (words[k] in CLOSE)
        k += 1
        if depth == 0:
            break
    return k


def after_angles(words, k):
    """Behind the > that closes the < at k, or k where none does: it is no bracket then."""
    depth, i = 0, k
    while i < len(words):
        if words[i] in OPEN:
            i = after(words, i)
            continue
        if words[i] in (";", *CLOSE):
            return k
        depth += (words[i] == "<") - (words[i] == ">")
        i += 1
        if depth == 0:
            return i
    return k


def template_head(words, k):
    """(behind the <...> of the template at k, its parameters)"""
    end, count, i = after_angles(words, k + 1), 0, k + 2
    if end == k + 1:
        return k + 1, 0
    while i < end - 1:
        count = max(count, 1)
        if words[i] in OPEN:
            i = after(words, i)
        elif words[i] == "<" and after_angles(words, i) > i:
            i = after_angles(words, i)
        else:
            count += words[i] == ","
            i += 1
    return end, count


def outer(words):
    """Tokens outside of all brackets; of a bracket only the sign that opens it."""
    found, k = [], 0
    while k < len(words):
        found.append(words[k])
        if words[k] in OPEN:
            k = after(words, k)
        elif words[k] == "<" and k and re.match(r"[A-Za-z_]", words[k - 1]):
            k = max(after_angles(words, k), k + 1)
        else:
            k += 1
    return found


def without_heads(words):
    """A declaration without attributes, template<...> and its requires clause at its start."""
    k = 0
    while k < len(words):
        if words[k:k + 2] == ["[", "["]:
            k = after(words, k)
        elif words[k] == "alignas":
            k = after(words, k + 1)
        elif words[k] == "template":
            k, _ = template_head(words, k)
        elif words[k] == "requires":
            k = after_clause(words, k)
        else:
            break
    return words[k:]


def after_clause(words, k):
    """Behind the requires clause at k: brackets, requires expressions and concepts, joined by && and ||."""
    while k < len(words) and words[k] in ("requires", "&&", "||", "!"):
        k += 1
        if words[k:k + 2] == ["requires", "{"]:
            k = after(words, k + 1)
        elif words[k:k + 2] == ["requires", "("]:
            k = after(words, after(words, k + 1))
        elif words[k:k + 1] == ["("]:
            k = after(words, k)
        elif k < len(words) and words[k] != "!":
            k += 1
            while words[k:k + 1] == ["::"]:
                k += 2
            if words[k:k + 1] == ["<"]:
                k = max(after_angles(words, k), k + 1)
    return k


def is_function(words):
    """Of a declaration without body: whether a bracket comes before any initial value."""
    if "operator" in words:
        return True
    found = outer(words)
    for k, word in enumerate(found):
        if word in ("=", "{", ":"):
            return False
        if word == "(" and k and found[k - 1] not in ("decltype", "alignas", "noexcept", "requires", "explicit", "__launch_bounds__"):
            return found[k + 1:k + 2] != ["*"] and not points_to_function(words)
    return False


def points_to_function(words):
    return any(words[k:k + 2] == ["(", "*"] for k in range(len(words))) and ")" in words and words[words.index(")") + 1:][:1] == ["("]


def type_at(words):
    """Index of class, struct, union or enum that this declaration defines, or None."""
    for k, word in enumerate(outer(words)):
        if word in ("(", "="):
            return None
        if word in TYPES:
            return words.index(word)
    return None


def name_of(words):
    """Of a class: its head is `class [[...]] Name final : bases`."""
    k = 1
    while k < len(words) and (words[k] in ("alignas", "class", "struct") or words[k] in OPEN):
        k = after(words, k) if words[k] in OPEN else k + 1
    return words[k] if k < len(words) and re.match(r"[A-Za-z_]", words[k]) else "(no name)"


def name_of_function(words):
    """What a template declares: the class, or the word before the first bracket or sign."""
    rest = without_heads(words)
    kind = type_at(rest)
    if kind is not None:
        return name_of(rest[kind:])
    if rest[:1] in (["using"], ["concept"]):
        return rest[1] if len(rest) > 1 else ""
    found = outer(rest)
    if "operator" in found:
        return "operator"
    for k, word in enumerate(found[1:], 1):
        if word in ("(", "=", "{", ";") and re.match(r"[A-Za-z_]", found[k - 1]) and found[k - 1] not in ("requires", "decltype", "explicit", "noexcept", "__launch_bounds__"):
            return found[k - 1]
    return found[0] if found else ""


def declaration(words, k):
    """(tokens up to the body or the end, where its body begins or None, behind it) of the declaration at k."""
    start, initialisers = k, False
    while k < len(words):
        word = words[k]
        if word == ";":
            return words[start:k], None, k + 1
        if word == ":" and words[k - 1] in (")", "noexcept", "const") and "(" in words[start:k] and type_at(without_heads(words[start:k])) is None:
            initialisers = True
        if word != "{":
            k = after(words, k) if word in OPEN else k + 1
            continue
        head = words[start:k]
        of_type = type_at(without_heads(head)) is not None
        if of_type or not initialisers and is_function(without_heads(head)) or initialisers and words[k - 1] in (")", "}"):
            if not of_type and wants_expression(head):
                k = after(words, k)
                continue
            return head, k, after(words, k)
        if head[:1] == ["namespace"] or head[:1] == ["extern"] or "concept" in head and "=" not in head:
            return head, k, after(words, k)
        k = after(words, k)
    return words[start:k], None, k


def wants_expression(head):
    """requires(T t) {...} of a clause: no body."""
    depth = 0
    for k in range(len(head) - 1, -1, -1):
        depth += (head[k] in CLOSE) - (head[k] in OPEN)
        if depth == 0:
            return k > 0 and (head[k] == "requires" or head[k] in OPEN and head[k - 1] == "requires" and head[k - 2] in ("requires", "=", "&&", "||"))
    return False


class Reader:
    def __init__(self, text):
        self.classes, self.templates = [], []
        self.scope(tokens(text), "")

    def scope(self, words, outside):
        """Of a file or namespace."""
        k = 0
        while k < len(words):
            if words[k] in (";", "}"):
                k += 1
                continue
            head, body, k = declaration(words, k)
            self.note_templates(head)
            rest = without_heads(head)
            if body is None:
                continue
            if rest[:1] in (["namespace"], ["extern"]) or rest[:2] == ["inline", "namespace"]:
                self.scope(words[body + 1:k - 1], outside)
            elif (kind := type_at(rest)) is not None:
                k = self.of_type(rest[kind:], words, body, k, outside)[1]

    def of_type(self, head, words, body, k, outside):
        """(data members that are declared behind it, where the next declaration begins)"""
        if head[0] != "enum":
            name = name_of(head)
            self.body(words[body + 1:k - 1], head[0], f"{outside}::{name}" if outside else name)
        behind, _, end = declaration(words, k)
        return (commas(behind) if behind else 0), end

    def note_templates(self, head):
        k = 0
        while k < len(head):
            if head[k] == "template" and head[k + 1:k + 2] == ["<"]:
                end, count = template_head(head, k)
                if count:
                    self.templates.append(Template(name_of_function(head), count))
                k = end
            elif head[k] in OPEN:
                k = after(head, k)
            else:
                k += 1

    def body(self, words, kind, name):
        private, k = kind == "class", 0
        members = virtuals = hidden = 0
        while k < len(words):
            if words[k] in ("public", "private", "protected") and words[k + 1:k + 2] == [":"]:
                private, k = words[k] == "private", k + 2
                continue
            if words[k] == ";":
                k += 1
                continue
            head, block, k = declaration(words, k)
            self.note_templates(head)
            rest = without_heads(head)
            found = type_at(rest)
            if block is not None and found is not None:
                more, k = self.of_type(rest[found:], words, block, k, name)
                members += more
            elif rest and rest[0] not in NO_DECLARATION or "virtual" in rest[:2] or rest[:1] == ["static"] and is_function(rest):
                if is_function(rest):
                    virtuals += "virtual" in rest and "~" not in rest
                    hidden += private
                elif found is None or len(outer(rest)) > found + 2:
                    members += commas(rest) if "static" not in rest[:3] else 0
        self.classes.append(Class(name, members, virtuals, hidden))


def commas(words):
    """Names of a declaration of data."""
    return 1 + outer(words).count(",")
