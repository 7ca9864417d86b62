"""Checks that every class of model/ with a Carry (model/base/checkpoint.h) carries all its members, or that the member
is listed here with the reason. A forgotten member makes the daemon that takes over differ from the one that it replaces,
and that shows only much later."""

import os
import re
import subprocess
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# FILE CLASS: members that are not state: fixed when the object is made, or written in every frame before they are
# read.
NOT_CARRIED = {
    # Skeletons and options; the poses of this frame.
    'model/feet/feet.h Feet': ['in_legs_', 'legs_', 'options_', 'in_', 'out_'],
    # This frame's.
    'model/feet/feet.h Leg': ['longer', 'fit_m', 'yields', 'pitch', 'ankle_m', 'carries', 'rise_m', 'beyond_m'],
    # Skeletons and options; the input of this frame.
    'model/stylist/avatar.h Avatar': ['performer_', 'avatar_', 'ground_', 'hold_', 'ground_tau_s_', 'performer_tail_',
                                      'avatar_tail_', 'performed_'],
    # The skeleton's rest pose.
    'model/stylist/input_guard.h InputGuard': ['rest_'],
    # Skeleton and options; this frame's pose; the humanoid's offsets; Rest is the caller's to say.
    'model/stylist/stylist_impl.h Impl': ['binding', 'options', 'seen', 'offsets_in', 'offsets_out', 'rests', 'measured'],
}
# A class whose state is carried by another class: FILE CLASS, and that Carry's file and class.
CARRIED_BY = {'model/stylist/stylist_impl.h Impl': ('model/stylist/stylist.cpp', 'Stylist'),
              'model/net/stgcn_causal/network.h State': ('model/net/stgcn_causal/network.cpp', 'Network')}


def without_comments(text):
    return re.sub(r'//[^\n]*', '', text)


def block(text, start):
    """The index behind the brace that closes the one at `start`."""
    depth = 0
    for i in range(start, len(text)):
        depth += {'{': 1, '}': -1}.get(text[i], 0)
        if depth == 0:
            return i + 1
    raise AssertionError('a brace is not closed')


def classes(text):
    """(name, body) of every class and struct, nested ones, too."""
    for found in re.finditer(r'\b(?:class|struct)\s+(?:[A-Z]\w*::)?(\w+)[^;{()]*\{', text):
        yield found.group(1), text[found.end():block(text, found.end() - 1) - 1]


def members(body):
    """The data members of a class's body."""
    while True:  # nested types and functions with a body go, innermost last
        found = re.search(r'\b(?:class|struct|enum|union)\b[^;{()]*\{|\)[\w\s]*\{|\)\s*:[^;{]*\{', body)
        if not found:
            break
        end = block(body, found.end() - 1)
        body = body[:found.start()] + (')' if body[found.start()] == ')' else '') + ';' + body[end:]
    body = re.sub(r'\b(?:public|private|protected):', ';', body)
    body = re.sub(r'\balignas\(\w+\)', '', body)
    while re.search(r'\{[^{}]*\}', body):
        body = re.sub(r'\{[^{}]*\}', '', body)  # initial values
    while re.search(r'<[^<>;()]*>', body):
        body = re.sub(r'<[^<>;()]*>', '', body)
    names = []
    for statement in body.split(';'):
        statement = ' '.join(statement.split())
        while re.search(r'(?<![=!<>])=(?!=)[^;,()]*\([^()]*\)', statement):  # = Vec3::Zero()
            statement = re.sub(r'((?<![=!<>])=(?!=)[^;,()]*)\([^()]*\)', r'\1', statement)
        if not statement or 'operator' in statement or '(' in statement or ')' in statement:
            continue
        if re.match(r'(?:using|static|friend|enum|struct|class|typedef|template|STYLED_)\b', statement):
            continue
        for declared in statement.split(','):
            name = re.search(r'(\w+)(?:\[[^\]]*\])*$', declared.split('=')[0].strip())
            if name and ' ' in ' ' + statement:
                names.append(name.group(1))
    return names


def carry_of(name, body, sources):
    """The body of the class's Carry, here or in its source; None if it has none."""
    here = re.search(r'\bCarry\(Checkpoint[^)]*\)[^;{]*([;{])', body)
    if not here:
        return None
    if here.group(1) == '{':
        return body[here.end() - 1:block(body, here.end() - 1)]
    there = re.search(r'\b' + name + r'::Carry\([^)]*\)[^;{]*\{', sources)
    return sources[there.end() - 1:block(sources, there.end() - 1)] if there else None


def read(file):
    path = os.path.join(ROOT, file)
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8') as opened:
        return without_comments(opened.read())


def forgotten(file, header, sources):
    """FILE CLASS: the members that Carry does not name; or that its body is neither in the header nor in the source."""
    found = {}
    header = without_comments(header)
    for name, body in classes(header):
        own = body
        for inner, inner_body in classes(body):
            if 'Carry(' in inner_body:
                own = own.replace(inner_body, '')
        carry = carry_of(name, own, without_comments(sources))
        if f'{file} {name}' in CARRIED_BY:
            other, of_class = CARRIED_BY[f'{file} {name}']
            carry = carry_of(of_class, 'void Carry(Checkpoint& c);', read(other))
        if carry is None:
            if re.search(r'\bCarry\(Checkpoint', own):
                found[f'{file} {name}'] = ['the body of Carry']
            continue
        # A structured binding that names every member carries none of them.
        carry = re.sub(r'\bauto\s*&\s*\[[^\]]*\]\s*=\s*\*this;', '', carry)
        missing = [member for member in members(own) if not re.search(r'\b' + member + r'\b', carry)]
        if missing:
            found[f'{file} {name}'] = missing
    return found


class Carry(unittest.TestCase):

    def headers(self):
        listed = subprocess.run(['git', '-C', ROOT, 'grep', '-l', r'\bCarry(', '--', 'model/*.h'],
                                capture_output=True, text=True, check=True).stdout.split()
        listed = [file for file in listed if file != 'model/base/checkpoint.h']
        return sorted({*listed, *(of.split()[0] for of in CARRIED_BY)})

    def test_every_member_is_carried_or_named_here(self):
        found = {}
        for file in self.headers():
            found.update(forgotten(file, read(file), read(file[:-2] + '.cpp')))
        self.maxDiff = None
        self.assertEqual(NOT_CARRIED, found)

    def test_a_forgotten_member_is_found(self):
        header = """
            class Stage {
             public:
              void Carry(Checkpoint& c) noexcept { c(value_, parts_); }
              float value() const { return value_; }
             private:
              struct Part { float kept = 0, lost = 0; void Carry(Checkpoint& c) noexcept; };
              float value_ = 0, velocity_ = 0;  // of now
              std::array<Part, 2> parts_{};
            };"""
        self.assertEqual({'a.h Stage': ['velocity_'], 'a.h Part': ['lost']},
                         forgotten('a.h', header, 'void Stage::Part::Carry(Checkpoint& c) noexcept { c(kept); }'))

    def test_a_member_that_is_only_bound_is_found(self):
        header = 'struct Stage { float a = 0, b = 0; void Carry(Checkpoint& c) { auto& [a, b] = *this; c(a); } };'
        self.assertEqual({'a.h Stage': ['b']}, forgotten('a.h', header, ''))

    def test_a_carry_without_a_body_is_found(self):
        header = 'struct Stage { float value_ = 0; void Carry(Checkpoint& c) noexcept; };'
        self.assertEqual({'a.h Stage': ['the body of Carry']}, forgotten('a.h', header, ''))

    def test_it_reads_the_classes_there_are(self):
        self.assertGreater(len(self.headers()), 20)


if __name__ == '__main__':
    unittest.main()
