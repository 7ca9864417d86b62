#!/usr/bin/env python3
"""The word list (tests/words.py) finds each kind of sentence and name that it is for, at the right line, and
leaves plain ones alone."""

import contextlib
import io
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import words

# At least one for each entry of MARKS.
BAD = [
    "Waits until somebody connects.",
    "A port on which nobody listens.",
    "The performer of whom the hands are.",
    "For who subscribes it is cheap.",
    "What the rig sends is kept.",
    "The frame is dropped. Who comes late gets the next.",
    "It counts what arrives.",
    "Bounded, whatever comes.",
    "The page shows what becomes of it.",
    "The pose that comes of it.",
    "The bytes that what libzmq makes of them.",
    "It reads what it says.",
    "Reads until the sender says so.",
    "The daemon is told to stop.",
    "Each frame tells of the one before.",
    "The phone is asked to send.",
    "Nothing is asked of it.",
    "It looks whether the file is there.",
    "The effect is to be seen in the strips.",
    "The style that is wanted.",
    "The daemon shall stop.",
    "The message is no text.",
    "It is no error.",
    "A rotation that is none.",
    "The client starts anew.",
    "The leader goes on with the next.",
    "The motion goes on.",
    "The frame has come.",
    "The request comes here.",
    "The batch is handed on.",
    "Unknown fields are passed over: it passes over them.",
    "The old performer gives way.",
    "The daemon lets it go.",
    "The client does it again.",
    "A daemon that stands in for each other one.",
    "The rotation wanders.",
    "The next release mends it.",
    "It waits for so long.",
    "There is room for so many bytes.",
    "The call was in vain.",
    "As ever, the frame is late.",
    "Weights other than those of the set.",
    "The first daemon and the other one.",
    "The joints as the file has them.",
    "The table is apart.",
    "Close it or else it leaks.",
    "Exact but for rounding.",
    "The reply says what it lacks.",
    "The window shows how it goes.",
    "The newest frames are those to keep.",
]

GOOD = [
    "Duplicates are dropped and counted.",
    "The daemon stops after 2 s without a frame.",
    "Returns false if no client is subscribed.",
    "There is no room for another performer.",
    "The file is no longer open.",
    "There is no need to lock.",
    "What to write instead.",
    "What does a replay need? The recording.",
    "The value that `handed_on` has, and `what comes` in backticks.",
    "A user who calibrates stands still.",
    "The error says what was expected.",
    "The client continues with the next frame.",
    "The queue keeps the newest frames.",
]

BAD_NAMES = ["bool Take(int x);", "if (queue.Takes(x)) {", "State::kTaken", "bool Taken() const;", "said_ = 1;",
             "told_ns_ = 0;", "struct SessionWish {", "HoldBack held;", "void OnNews(int x);", "MoveOn(out);",
             "GiveBack(out);", "JudgeFrame(out);", "struct Way {", "SayHowItGoes();", "tells_all_ = true;"]

GOOD_NAMES = ["bool Accept(int x);", "TakeCheckpoint(id);", "State::kAccepted", "logged_ = 1;", "RecordTake(x);",
              "wishes = 1;", "Newsletter();", "OnNotice(x);", "SubtakenX();"]

CPP = '''// The daemon stops.
#include <x>
/* A first line.
   Nobody listens
   there. */
int Take(int x) {  // the port on which
                   // nobody listens
  Print("Take( nobody listens to this port");
  Log("nobody");
}
'''

PYTHON = '''"""A document.

The first line. Nobody listens."""
text = "nobody listens to this"
said_ = 1  # waits for somebody
name = "said_"
'''

SHELL = '''#!/usr/bin/env bash
# The port on which nobody
# listens.
echo "${x#nobody}"  # goes on as before
'''


def found(hits):
    return [(hit.line, hit.found) for hit in hits]


class Words(unittest.TestCase):
    def test_each_bad_sentence_is_marked(self):
        for sentence in BAD:
            with self.subTest(sentence):
                self.assertTrue(words.marks(sentence))

    def test_each_entry_marks_a_bad_sentence(self):
        for pattern, write in words.COMPILED:
            with self.subTest(write, pattern=pattern.pattern):
                self.assertTrue(any(pattern.search(sentence) for sentence in BAD))

    def test_good_sentences_are_not_marked(self):
        for sentence in GOOD:
            with self.subTest(sentence):
                self.assertEqual([], words.marks(sentence))

    def test_each_bad_name_is_found(self):
        for code in BAD_NAMES:
            with self.subTest(code):
                self.assertTrue(words.names(code))

    def test_each_entry_finds_a_bad_name(self):
        for pattern, write, _ in words.NAMES:
            with self.subTest(write):
                self.assertTrue(any(write == hit[2] for code in BAD_NAMES for hit in words.names(code)), pattern)

    def test_good_names_are_not_found(self):
        for code in GOOD_NAMES:
            with self.subTest(code):
                self.assertEqual([], words.names(code))

    def test_an_exception_is_for_its_file_only(self):
        kept, words.NAMES = words.NAMES, [(r"\bTake\(", "Accept", {"a.cpp": "the wire's name"})]
        self.addCleanup(setattr, words, "NAMES", kept)
        self.assertEqual([], words.names("Take(x)", "a.cpp"))
        self.assertTrue(words.names("Take(x)", "b.cpp"))

    def test_comments_texts_and_code_of_cpp_are_separate(self):
        lines, comments, texts, names = words.scan("a.cpp", CPP)
        self.assertEqual(6, lines)
        self.assertEqual([(4, "Nobody"), (7, "nobody")], found(comments))
        self.assertEqual([(8, "nobody")], found(texts), "one word is not a text")
        self.assertEqual([(6, "Take(")], found(names))

    def test_comments_texts_and_code_of_python_are_separate(self):
        lines, comments, texts, names = words.scan("a.py", PYTHON)
        self.assertEqual(3, lines)
        self.assertEqual([(3, "Nobody"), (5, "somebody")], found(comments))
        self.assertEqual([(4, "nobody")], found(texts))
        self.assertEqual([(5, "said_")], found(names))

    def test_comments_of_a_script_are_read(self):
        lines, comments, _, _ = words.scan("a.sh", SHELL)
        self.assertEqual(3, lines)
        self.assertEqual([(2, "nobody"), (4, "goes on")], found(comments))

    def test_a_sentence_is_found_across_lines(self):
        text = "// The pose that the client was\n// asked for.\n"
        self.assertEqual([(1, "was asked")], found(words.scan("a.h", text)[1]))

    def run_on(self, files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            subprocess.run(["git", "init", "-q", folder], check=True)
            subprocess.run(["git", "-C", folder, "add", "."], check=True)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                code = words.main([], root)
            return code, printed.getvalue()

    def test_a_folder_within_the_share_passes(self):
        code, printed = self.run_on({"daemon/x/a.h": "// A frame.\n" * 20 + "// nobody\n"})
        self.assertEqual(0, code, printed)

    def test_a_folder_above_the_share_fails_with_file_and_line(self):
        code, printed = self.run_on({"daemon/x/a.h": "// A frame.\n" * 500 + "// nobody\n\n// somebody\n"})
        self.assertEqual(1, code)
        self.assertIn("daemon/x/a.h:501: nobody: ", printed)
        self.assertIn("daemon/x/a.h:503: somebody: ", printed)

    def test_one_text_or_one_name_fails(self):
        for code in ('Log("the port nobody listens to");\n', "bool Take(int x);\n"):
            with self.subTest(code):
                self.assertEqual(1, self.run_on({"daemon/x/a.cpp": code})[0])

    def test_texts_of_tests_are_not_read(self):
        code, printed = self.run_on({"tests/unit/a.cpp": 'Log("the port nobody listens to");\n'})
        self.assertEqual(0, code, printed)


if __name__ == "__main__":
    unittest.main()
