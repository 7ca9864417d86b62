#!/usr/bin/env python3
"""Gives the files that CPack has collected the form that Debian and licences ask for. CPack calls it before it packs.

    finish_packages.py BUILD MAINTAINER TREES [OF]

OF is what the packages' version has after the version: +deb12. TREES has a folder for each package, whose name is that of the folder with usr/share/doc/NAME/copyright. Each gets its changelog (of
CHANGELOG.md), the stanzas of debian/copyright that are about its files, and, where it has programs, the copyright
files of the libraries that are compiled in. Links of its documents lead to what it has. Manual pages and changelogs are compressed. A file that no stanza is about ends
it with an error, and so does a part of the page without a notice."""
import datetime
import glob
import gzip
import json
import os
import re
import subprocess
import sys
import textwrap

HERE = os.path.dirname(os.path.abspath(__file__))
# Debian's packages of the language itself. GCC's Runtime Library Exception, and section 5 of the LGPL 2.1 about what
# headers bring, ask nothing of programs; the kernel's headers have its note about system calls.
LANGUAGE = re.compile(r'^(libc6-dev|linux-libc-dev|libstdc\+\+-\d+-dev|libgcc-\d+-dev|libc\+\+.*)$')


def read(*path):
    with open(os.path.join(*path), encoding='utf-8') as text:
        return text.read()


# Copyright files -----------------------------------------------------------------------------------------------------

def paragraphs(copyright):
    """[{field: text}] of a machine-readable copyright file, the header first; with 'text', the paragraph as it is."""
    found = []
    for paragraph in re.split(r'\n\s*\n', copyright.strip()):
        fields = dict(re.findall(r'^([\w-]+):[ ]?(.*(?:\n .*)*)', paragraph, re.MULTILINE))
        found.append({**fields, 'text': paragraph})
    return found


def matches(pattern, path):
    """Whether a pattern of a Files field means a path: * and ?, which also stand for a slash."""
    translated = ''.join({'*': '.*', '?': '.'}.get(letter, re.escape(letter)) for letter in pattern)
    return re.fullmatch(translated, path) is not None


def stanza_of(stanzas, path):
    """The paragraph about a path: the last that names it; None: no paragraph does."""
    about = [stanza for stanza in stanzas
             if any(matches(pattern, path) for pattern in stanza.get('Files', '').split())]
    return about[-1] if about else None


def complaints(copyright, paths):
    """The errors of a package's copyright file about its files; []: none."""
    stanzas = paragraphs(copyright)
    texts = {stanza['License'].split('\n')[0] for stanza in stanzas if 'License' in stanza and 'Files' not in stanza}
    wrong = []
    for path in sorted(paths):
        stanza = stanza_of(stanzas, path)
        if stanza is None:
            wrong.append(f'{path}: no stanza of systemd/debian/copyright is about it')
            continue
        for field in ('Copyright', 'License'):
            if not stanza.get(field, '').strip():
                wrong.append(f'{path}: its stanza has no {field}')
        wrong += [f'{path}: {licence} has no text' for licence in stanza.get('License', '').split(' and ')
                  if licence not in texts]
    return wrong


def copyright_for(copyright, paths):
    """The copyright file of a package: the stanzas that are about its files, and the licences that they name."""
    stanzas = paragraphs(copyright)
    used = [stanza_of(stanzas, path) for path in paths]
    named = {licence for stanza in used if stanza for licence in stanza.get('License', '').split(' and ')}
    kept = [stanza['text'] for stanza in stanzas
            if 'Format' in stanza or stanza in used or ('Files' not in stanza and stanza.get('License', '').split('\n')[0] in named)]
    return '\n\n'.join(kept) + '\n'


# Compiled-in libraries -------------------------------------------------------------------------------------------------

def compiled_headers(build):
    """The headers outside of the tree that a build's programs include."""
    listed = subprocess.run(['ninja', '-C', build, '-t', 'deps'], capture_output=True, text=True, check=True).stdout
    # Without links: those of Debian's alternatives are of no package.
    return sorted({os.path.realpath(path) for path in re.findall(r'^ +(/usr/(?:local/)?include/\S+)', listed, re.MULTILINE)})


def packages_of(paths):
    """{package: version} of Debian's packages that files are from. A file of none is an error: its licence is unknown."""
    owners = set()
    for at in range(0, len(paths), 1000):
        done = subprocess.run(['dpkg-query', '--search', *paths[at:at + 1000]], capture_output=True, text=True,
                              check=False, env=dict(os.environ, LC_ALL='C.UTF-8'))
        if done.returncode != 0:
            raise SystemExit('finish_packages.py: compiled in, and of no Debian package: ' + done.stderr.strip())
        for line in done.stdout.splitlines():
            owners.update(owner.split(':')[0] for owner in line.rpartition(': ')[0].split(', '))
    if not owners:
        return {}
    shown = subprocess.run(['dpkg-query', '--show', '--showformat', '${Package} ${Version}\n', *sorted(owners)],
                           capture_output=True, text=True, check=True).stdout
    return dict(line.split() for line in shown.splitlines())


def third_party(build):
    """The copyright files of the libraries whose code is compiled into the programs, one after the other."""
    parts = ['Parts of these libraries are compiled into the programs. Each has its copyright file of Debian here;\n'
             'the Debian source package of that version is its source.\n']
    for package, version in sorted(packages_of(compiled_headers(build)).items()):
        if not LANGUAGE.match(package):
            parts.append(f'{"=" * 80}\n{package} {version}\n{"=" * 80}\n\n{read("/usr/share/doc", package, "copyright")}')
    return '\n'.join(parts)


# The page ------------------------------------------------------------------------------------------------------------

def page_complaints(notices, packages, licences):
    """The npm packages of a page that its notices leave out, and licences that the copyright file does not name.

    packages: {name: (version, licence)}."""
    headings = re.findall(r'^=+\n(\S+) (\S+), (.+)\n=+\n\n(?=\S)', notices, re.MULTILINE)
    told = {name: (version, licence) for name, version, licence in headings}
    wrong = [f'{name} {of[0]} ({of[1]}): is in the page, and not in its notices' for name, of in sorted(packages.items())
             if told.get(name) != of]
    named = {word for _, licence in packages.values() for word in re.findall(r'[\w.-]+', licence) if word != 'AND'}
    return wrong + [f'{licence}: is of the page, and not in the copyright file' for licence in sorted(named - licences)]


def locked_packages(lock):
    """{name: (version, licence)} of what the page depends on by package-lock.json, types apart: those are no code."""
    entries = json.loads(lock)['packages']
    found, ahead = {}, list(entries['web/page']['dependencies']) + list(entries['js'].get('dependencies', {}))
    while ahead:
        name = ahead.pop()
        of = entries.get(f'node_modules/{name}')
        if name in found or '/types-' in name or name.startswith('@types/') or of is None or of.get('link'):
            continue
        if name == 'ws':  # styled-client's, in Node alone: browsers have their own
            continue
        found[name] = (of['version'], of['license'].strip('()'))
        ahead += of.get('dependencies', {})
    return found


# Documents -----------------------------------------------------------------------------------------------------------

def documents_of(packages):
    """{file of the tree: its name in share/doc} of packages.cmake."""
    return {file: name for name, file in re.findall(r'\b([\w-]+\.md)=([\w/.-]+\.md)\b', packages)}


def as_shipped(text, file, documents, here):
    """A document of the tree as a package has it: links to documents that lie `here`, beside it, have their names there;
    of other links to files the path in the sources is left, of pictures the description."""
    def link(found):
        picture, words, target = found.groups()
        path, _, anchor = target.partition('#')
        if not path or '://' in path:
            return found[0]
        path = os.path.normpath(os.path.join(os.path.dirname(file), path))
        if documents.get(path) in here:
            return f'[{words}]({documents[path]}{"#" if anchor else ""}{anchor})'
        return f'(Picture: {words})' if picture else f'{words} (`{path}` of the sources)'
    return re.sub(r'(!?)\[((?:\\.|[^\]\\])*)\]\(([^)\s]+)\)', link, text)


# Packages ------------------------------------------------------------------------------------------------------------

def debian_changelog(changelog, package, maintainer, of=''):
    """CHANGELOG.md in the format of Debian's changelogs. of: what the package's version has after the newest version; it gets
    an entry of its own, as rebuilds of Debian do."""
    entries = []
    for part in re.split(r'^## ', changelog, flags=re.MULTILINE)[1:]:
        version, day = re.match(r'(\S+) \((\d{4}-\d\d-\d\d)\)\n', part).groups()
        changes = re.findall(r'^- .*(?:\n  .*)*', part, re.MULTILINE)
        date = datetime.datetime.strptime(day, '%Y-%m-%d').strftime('%a, %d %b %Y 00:00:00 +0000')
        lines = ''.join(textwrap.fill(' '.join(change[2:].replace('`', '').split()), 78, initial_indent='  * ',
                                      subsequent_indent='    ', break_on_hyphens=False) + '\n' for change in changes)
        if of and not entries:
            entries.append(f'{package} ({version}{of}) unstable; urgency=medium\n\n  * Built for {of[1:]}.\n\n -- {maintainer}  {date.replace("00:00:00", "00:00:01")}\n')
        entries.append(f'{package} ({version}) unstable; urgency=medium\n\n{lines}\n -- {maintainer}  {date}\n')
    return '\n'.join(entries)


def files_of(tree):
    return sorted(os.path.relpath(os.path.join(folder, name), tree)
                  for folder, _, names in os.walk(tree) for name in names)


def write(path, text, packed=False):
    data = text.encode('utf-8')
    with open(path, 'wb') as out:
        out.write(gzip.compress(data, 9, mtime=0) if packed else data)


def finish(tree, build, maintainer, notices_of_programs=None, of=''):
    """One package; returns the complaints about it. notices_of_programs: third_party(build), if it was made already."""
    documents, = glob.glob(os.path.join(tree, 'usr/share/doc/*/copyright'))
    documents = os.path.dirname(documents)
    name = os.path.basename(documents)
    if any(path.startswith('usr/bin/') or '/libstyled.so.' in path for path in files_of(tree)):
        write(os.path.join(documents, 'third-party.gz'), notices_of_programs or third_party(build), packed=True)
    write(os.path.join(documents, 'changelog.gz'), debian_changelog(read(HERE, 'CHANGELOG.md'), name, maintainer, of), packed=True)
    news = os.path.join(HERE, 'debian', name + '.NEWS')
    if os.path.exists(news):
        write(os.path.join(documents, 'NEWS.Debian.gz'), read(news).replace('@MAINTAINER@', maintainer), packed=True)
    shipped = documents_of(read(HERE, 'packages.cmake'))
    here = set(os.listdir(documents))
    for file, as_name in shipped.items():
        at = os.path.join(documents, as_name)
        if os.path.exists(at) and read(at) == read(HERE, '..', file):
            write(at, as_shipped(read(at), file, shipped, here))
    for path in files_of(tree):
        if re.search(r'/man/man\d/[^/]+\.\d$', path):
            subprocess.run(['gzip', '-9nf', os.path.join(tree, path)], check=True)
    every = read(HERE, 'debian/copyright')
    paths = files_of(tree)
    own = copyright_for(every, paths)
    write(os.path.join(documents, 'copyright'), own)
    wrong = complaints(own, paths)
    page = os.path.join(tree, 'usr/share/styled/web')
    if os.path.isdir(page):
        licences = {stanza.get('License', '').split('\n')[0] for stanza in paragraphs(own)}
        packages = {**locked_packages(read(build, 'npm/package-lock.json')),
                    **{of['name']: (of['version'], of['licence']) for of in json.loads(read(build, 'npm/web/page/packages.json'))}}
        notices = os.path.join(page, 'notices.txt')
        wrong += page_complaints(read(notices) if os.path.exists(notices) else '', packages, licences)
    return [f'{name}: {complaint}' for complaint in wrong]


def main(build, maintainer, trees, of=''):
    wrong, programs = [], third_party(build)
    for part in sorted(os.listdir(trees)):
        tree = os.path.join(trees, part)
        if os.path.isdir(os.path.join(tree, 'usr/share/doc')):
            wrong += finish(tree, build, maintainer, programs, of)
    if wrong:
        raise SystemExit('\n'.join(wrong))


if __name__ == '__main__':
    if len(sys.argv) not in (4, 5):
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
