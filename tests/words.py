#!/usr/bin/env python3
"""Which comments, texts and names a reader new to the code has to read twice. Prints a table: per folder
its comment lines, how many of them are marked, and the share; then every hit as `FILE:LINE: FOUND: WRITE`.
Fails when a folder has more than 0.3 % of its comment lines marked, when a text that a user sees is marked,
or when the code has one of the names in NAMES. `--all` prints every hit, also of folders within the share.

It reads what git tracks: C++, protobuf, TypeScript, C#, Python, CMake, shell and TOML. Documents (.md) are
not looked at. Pinned by tests/documents/test_words.py, which shows that each entry finds its sentence."""

import bisect
import collections
import io
import pathlib
import re
import subprocess
import sys
import tokenize

MOST_MARKED = 0.003  # share of a folder's comment lines
FEW = 1  # a folder of few lines may have so many marked

SLASHES = ("h", "cpp", "proto", "ts", "cs", "mjs", "js", "css")
HASHES = ("py", "sh", "cmake", "txt", "toml", "awk")

# (pattern, what to write instead). Letters match in either case.
MARKS = [
    # People without a role.
    (r"\b(somebody|someone|nobody|anybody|whoever|whomever)\b", "the role: a user, a client, no performer"),
    (r"\b(of|to|for|from|by) whom\b", "a sentence that begins with its subject"),
    (r"\b(for|to|of|by|from|than|so that|that|because|if) who (?!is\b)[a-z]+s\b",
     "for clients that, for users who"),
    # Clauses in place of a noun.
    (r"(?:^|(?<=[.;!] ))(?!What to\b)(What|Who|Whose|Whom)\b(?![^.!]*\?)", "the thing itself: The data that, The client that"),
    (r"\bwhat (comes|came|goes|went|arrives?|arrived|follows|waits|lies|lacks)\b", "the data that arrives, the rest"),
    (r"\bwhatever (comes|came|arrives|happens)\b", "for any input"),
    (r"\bwhat becomes? of\b|\bwhat became of\b|\bwhat has become\b|\bcame of (it|them|that)\b|\bcomes of it\b",
     "the result, the fate"),
    (r"\bwhat [a-z]+ makes? of\b|\bwhat is made of\b", "the output of"),
    (r"\bwhat (it|they|this|that|he|she) (says?|tells?|said|told|gives?|gave)\b", "the content, the result"),
    # The subject's words: programs do not speak.
    (r"\b(says?|said) so\b", "reports it"),
    (r"\b(is|are|was|were|be|been) (told|said)\b", "is reported, is logged, receives"),
    (r"\b(says?|said|tells?|told|hears?|heard|knows) of\b", "reports about, receives"),
    (r"\b(is|are|was|were|be|been) asked\b", "is requested, is queried"),
    (r"\basked of\b|\basks of\b", "requested from"),
    (r"\blooks? (whether|if|after|for what)\b", "checks whether"),
    # Passive and infinitive turns.
    (r"\bto be (seen|had|said|told|heard)\b", "visible, available"),
    (r"\b(is|are|was|were) wanted\b", "is needed, is requested"),
    (r"\bshall\b", "must, can, will"),
    # Predicates without an article.
    (r"(?<!\bthere )(?<!\bit )\bis no (?!longer\b|more\b|other\b|way\b|room\b|need\b)[a-z]+", "is not a"),
    (r"\bit is no (?!longer\b|more\b)[a-z]+", "it is not a"),
    (r"\b(that|which|it|this) is none\b|(?<!there )\bare (?-i:none)\b", "that is invalid, is not one"),
    # Adverbs and verbs that have a plain form.
    (r"\banew\b", "again, restarts"),
    (r"\b(go|went|gone|going) on (as|with|until|where|from|to|being|exactly|alone|then|for|in|by)\b"
     r"|\bgoes on\b", "continues"),
    (r"\b(has|have|had|having) come\b", "has arrived"),
    (r"\bcomes? here\b|\bcame here\b", "arrives"),
    (r"\b(handed|handing) (on|over|out)\b|\bhands (on|over|out)\b", "passes"),
    (r"\b(passes|passed) over\b", "skips"),
    (r"\bgives? (back|way)\b|\bgave (back|way)\b|\bgiving way\b", "returns, is replaced"),
    (r"\b(lets?|letting) (\w+ )?go\b", "releases"),
    (r"\b(does|do|did) (it )?again\b", "repeats"),
    (r"\bstands? in for each other\b", "a pair, each of which can take over"),
    (r"\bwanders?\b", "changes slowly"),
    (r"\bmend(s|ed)?\b", "fixes"),
    (r"\bin (such|so) (many|much|long)\b|\b(for|after|at most|within|beyond|above|by) so (many|much|long)\b",
     "this many, this long"),
    (r"\bso (many|much|long) (of|seconds|frames|bytes|times)\b", "this many"),
    (r"\bin vain\b|\bhitherto\b|\bthereof\b|\btherein\b|\bwhence\b|\bwhereof\b|\bwherein\b|\blest\b|\balbeit\b"
     r"|\bnaught\b|\bhence(forth|forward)\b|\bas yet\b|\bof late\b|\bof old\b|\bere\b|\bforthwith\b|\bsave that\b",
     "without success, until now, in it, so that not"),
    (r"\bas ever\b|\bever (more|less) \w+", "as usual, increasingly"),
    (r"\bother(s)? than (that|those) of\b", "differs from"),
    (r"\bthe other one(?!s)\b|\bthis one's\b", "the other daemon, the other client"),
    (r"\bas (\w+ ){1,2}(has|have) (it|them)\b", "as in"),
    (r"\bis apart\b|\bare apart from\b", "is separate"),
    (r"\bor else\b", "otherwise"),
    (r"\bbut for\b", "except for"),
    (r"\bsays? what\b(?! was expected| is wrong| was found| is expected| is missing)", "states"),
    (r"\bhow (it|they) (goes|go|went|fares?)\b", "the progress"),
    (r"\bto keep\b(?=[.;,]|$)", "to store"),
]

# (pattern in code, what to write instead, files in which it stays and why).
NAMES = [
    (r"\bTakes?\(", "the one verb that is meant: Accept, Apply, Pop, Decode, Sample, Add", {}),
    (r"\bk?Taken\b", "kAccepted", {}),
    (r"\b(said|told)_\w*", "logged_, printed_, advertised_", {}),
    (r"\b\w*Wish(es)?\b", "Request, Options", {}),
    (r"\b\w*HoldBack\w*\b", "InputBuffer", {}),
    (r"\b(On)?News\b", "Notice", {}),
    (r"\bMoveOn\b", "UpdateTravel", {}),
    (r"\bGiveBack\b", "FallBackToInput", {}),
    (r"\bJudgeFrame\b", "CheckTiming", {}),
    (r"\b(struct|class) Way\b", "Scratch", {}),
    (r"\bSayHowItGoes\b", "ReportStatus", {}),
    (r"\btells_all_|\bdecided_\b|\bfeeds_\b", "resend_state_, an argument", {}),
]

Hit = collections.namedtuple("Hit", "file line found write")


def kind_of(name):
    if name.endswith(".css.in"):
        return None
    return name.removesuffix(".in").rsplit(".", 1)[-1]


LITERAL = re.compile(r'R"(\w*)\((?:.|\n)*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|`(?:\\.|[^`\\])*`'
                     r"|//[^\n]*|/\*(?:.|\n)*?\*/")


def split_slashes(text):
    """(comments, texts, code) of a language with // and /* */: [(line, string)], [(line, string)], string."""
    comments, texts, code, at = [], [], [], 0
    for match in LITERAL.finditer(text):
        piece, line = match[0], text.count("\n", 0, match.start()) + 1
        # A digit's separator and an apostrophe in a regular expression are no literals.
        if piece[0] == "'" and match.start() and text[match.start() - 1].isalnum():
            continue
        code.append(text[at:match.start()])
        at = match.end()
        if piece.startswith(("//", "/*")):
            own = not text[text.rfind("\n", 0, match.start()) + 1:match.start()].strip()
            for i, part in enumerate(piece.split("\n")):
                comments.append((line + i, re.sub(r"^\s*(//+|/\*+|\*/?)\s?|\*/\s*$", "", part), own or i > 0))
        else:
            texts.append((line, piece.strip("\"'`")))
        code.append("\n" * piece.count("\n") or " ")
    code.append(text[at:])
    return comments, texts, "".join(code)


def split_python(text):
    comments, texts, code = [], [], text.split("\n")
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (tokenize.TokenError, IndentationError):
        return [], [], text
    for token in tokens:
        line = token.start[0]
        if token.type == tokenize.COMMENT:
            own = not token.line[:token.start[1]].strip()
            comments.append((line, token.string.lstrip("# "), own))
            code[line - 1] = code[line - 1][:token.start[1]]
        elif token.type == tokenize.STRING:
            if re.match(r"[rfRF]?(\"\"\"|''')", token.string):
                for i, part in enumerate(token.string.split("\n")):
                    comments.append((line + i, part.strip().strip("\"'"), True))
            else:
                texts.append((line, re.sub(r"^\w*[\"']|[\"']$", "", token.string)))
            for i in range(token.start[0], token.end[0] + 1):
                code[i - 1] = re.sub(r"\"[^\"]*\"|'[^']*'", "''", code[i - 1]) if token.start[0] == token.end[0] else ""
    return sorted(comments), texts, "\n".join(code)


def split_hashes(text):
    comments, code = [], []
    for number, line in enumerate(text.split("\n"), 1):
        match = re.search(r"(?:^|\s)#(?!!)\s?(.*)", line)
        if match:
            comments.append((number, match[1], not line[:match.start()].strip()))
        code.append(line[:match.start()] if match else line)
    return comments, [], "\n".join(code)


def split(name, text):
    kind = kind_of(name)
    if kind in SLASHES:
        return split_slashes(text)
    if kind == "py":
        return split_python(text)
    return split_hashes(text)


def paragraphs(comments):
    """[(lines, text)]: comment lines that follow one another, joined; `lines` has (offset, line) of each."""
    found, last = [], None
    for line, text, own in comments:
        new = (last is None or line != last + 1 or not own or not text.strip() or
               re.match(r"\s*([-*|] |\d+\. )|\s{2,}", text))
        if new:
            found.append(([], ""))
        lines, joined = found[-1]
        joined += " " if joined else ""
        lines.append((len(joined), line))
        found[-1] = (lines, joined + text.strip())
        last = line
    return found


COMPILED = [(re.compile(pattern, re.IGNORECASE if not pattern.startswith("(?:^") else 0), write)
            for pattern, write in MARKS]


def marks(text):
    """[(offset, found, write)] of a comment or a text."""
    text = re.sub(r"`[^`]*`", lambda m: "_" * len(m[0]), text)  # names in backticks are quoted
    return sorted((match.start(), match[0].strip(), write) for pattern, write in COMPILED
                  for match in pattern.finditer(text))


def names(text, file=""):
    """[(offset, found, write)] of code without comments and texts."""
    return [(match.start(), match[0], write) for pattern, write, stays in NAMES if file not in stays
            for match in re.finditer(pattern, text)]


def is_prose(text):
    return len(re.findall(r"[A-Za-z]{2,} (?=[A-Za-z]{2,})", text)) >= 2


def scan(name, text):
    """(number of comment lines, hits in comments, hits in texts, hits in names) of one file."""
    comments, texts, code = split(name, text)
    in_comments = []
    for lines, joined in paragraphs(comments):
        starts = [offset for offset, _ in lines]
        for offset, found, write in marks(joined):
            line = lines[bisect.bisect_right(starts, offset) - 1][1]
            in_comments.append(Hit(name, line, found, write))
    in_texts = [Hit(name, line, found, write) for line, piece in texts if is_prose(piece)
                for _, found, write in marks(piece)]
    in_names = []
    if kind_of(name) in ("h", "cpp", "cs", "ts", "mjs", "py"):
        in_names = [Hit(name, code.count("\n", 0, offset) + 1, found, write)
                    for offset, found, write in names(code, name)]
    return len({line for line, text, _ in comments if text.strip()}), in_comments, in_texts, in_names


def folder_of(name):
    return "/".join(name.split("/")[:-1][:2]) or "."


def wanted(name):
    kind = kind_of(name)
    if kind in HASHES and kind != "py":
        return kind != "txt" or name.endswith("CMakeLists.txt")
    return kind in SLASHES or kind == "py"


OWN = ("tests/words.py", "tests/documents/test_words.py")  # they quote what they look for


def main(arguments, root=pathlib.Path(__file__).resolve().parent.parent):
    files = subprocess.run(["git", "-C", str(root), "ls-files"], capture_output=True, text=True,
                           check=True).stdout.split()
    lines, marked = collections.Counter(), collections.defaultdict(list)
    texts, in_names = [], []
    for name in files:
        if not wanted(name) or name in OWN or not (root / name).is_file():
            continue
        count, in_comments, in_texts, named = scan(name, (root / name).read_text(errors="replace"))
        folder = folder_of(name)
        lines[folder] += count
        marked[folder] += in_comments
        in_names += named
        if not name.startswith("tests/") and "/test" not in name:
            texts += in_texts
    bad, marked_lines, failed = [], 0, bool(texts or in_names)
    print(f"{'folder':24} {'comment lines':>14} {'marked':>7} {'share':>7}")
    for folder in sorted(lines):
        count = len({(hit.file, hit.line) for hit in marked[folder]})
        too_many = count > max(FEW, MOST_MARKED * lines[folder])
        if count:
            print(f"{folder:24} {lines[folder]:14} {count:7} {100 * count / lines[folder]:6.2f} %"
                  f"{'  too many' if too_many else ''}")
        if too_many or "--all" in arguments:
            bad += marked[folder]
        marked_lines += count
        failed = failed or too_many
    total = sum(lines.values())
    print(f"{'all':24} {total:14} {marked_lines:7} {100 * marked_lines / max(total, 1):6.2f} %")
    for hit in bad + texts + in_names:
        print(f"{hit.file}:{hit.line}: {hit.found}: {hit.write}")
    if texts:
        print(f"{len(texts)} marked words in texts that users see")
    if in_names:
        print(f"{len(in_names)} names that another word says better")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
