#!/usr/bin/env python3
"""Prints a bill of materials of packages, SPDX 2.3 as JSON: each package with its files, their checksums and licences, the
Debian packages it depends on and was compiled with, and the npm packages of the page.

    sbom.py BUILD DEBS"""
import datetime
import glob
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile

import finish_packages

# Licences of our copyright file are SPDX's; "and" is AND there.
def expression(licence):
    return licence.replace(' and ', ' AND ')


def identifier(*words):
    return 'SPDXRef-' + '-'.join(re.sub(r'[^A-Za-z0-9.-]', '-', word) for word in words)


def digest(path, kind):
    with open(path, 'rb') as data:
        return hashlib.file_digest(data, kind).hexdigest()


def field(deb, name):
    return subprocess.run(['dpkg-deb', '-f', deb, name], capture_output=True, text=True, check=True).stdout.strip()


def package(name, version, licence='NOASSERTION', supplier='NOASSERTION', url='NOASSERTION', reference=None, **more):
    of = {'SPDXID': identifier('Package', name, version), 'name': name, 'versionInfo': version, 'supplier': supplier,
          'downloadLocation': url or 'NOASSERTION', 'filesAnalyzed': False, 'licenseConcluded': licence,
          'licenseDeclared': licence, 'copyrightText': 'NOASSERTION'}
    if reference:
        of['externalRefs'] = [{'referenceCategory': 'PACKAGE-MANAGER', 'referenceType': 'purl', 'referenceLocator': reference}]
    return {**of, **more}


def files_of(deb, tree):
    """The files of a package, each with the licence and copyright of its stanza."""
    subprocess.run(['dpkg-deb', '-x', deb, tree], check=True)
    name = field(deb, 'Package')
    stanzas = finish_packages.paragraphs(finish_packages.read(tree, 'usr/share/doc', name, 'copyright'))
    for path in finish_packages.files_of(tree):
        stanza = finish_packages.stanza_of(stanzas, path)
        at = os.path.join(tree, path)
        if os.path.islink(at):  # to a file of this package, or of the library's that it depends on
            continue
        yield {'SPDXID': identifier('File', name, path), 'fileName': './' + path,
               'checksums': [{'algorithm': kind.upper(), 'checksumValue': digest(at, kind)} for kind in ('sha1', 'sha256')],
               'licenseConcluded': expression(stanza['License']), 'licenseInfoInFiles': ['NOASSERTION'],
               'copyrightText': '\n'.join(line.strip() for line in stanza['Copyright'].splitlines())}


def bill(build, debs, date):
    """The whole document. debs: paths; date: a datetime in UTC."""
    packages, files, relations = {}, [], []

    def relate(one, kind, other):
        relations.append({'spdxElementId': one, 'relationshipType': kind, 'relatedSpdxElement': other})

    def add(of):
        packages.setdefault(of['SPDXID'], of)
        return of['SPDXID']

    def debian(name, version):
        return add(package(name, version, supplier='Organization: Debian', reference=f'pkg:deb/debian/{name}@{version}'))

    with open('/var/lib/dpkg/status', encoding='utf-8') as status:
        installed = dict(re.findall(r'^Package: (\S+)\n(?:.+\n)*?Version: (\S+)$', status.read(), re.MULTILINE))
    compiled = {name: version for name, version in
                finish_packages.packages_of(finish_packages.compiled_headers(build)).items() if not finish_packages.LANGUAGE.match(name)}
    ours = {field(deb, 'Package') for deb in debs}
    for deb in sorted(debs):
        name, version = field(deb, 'Package'), field(deb, 'Version')
        with tempfile.TemporaryDirectory() as tree:
            own = list(files_of(deb, tree))
        licences = ' AND '.join(sorted({word for of in own for word in of['licenseConcluded'].split(' AND ')}))
        sums = sorted(of['checksums'][0]['checksumValue'] for of in own)
        me = add(package(name, version, licences, supplier='Organization: ' + field(deb, 'Maintainer'), filesAnalyzed=True,
                         packageFileName=os.path.basename(deb), checksums=[{'algorithm': 'SHA256', 'checksumValue': digest(deb, 'sha256')}],
                         packageVerificationCode={'packageVerificationCodeValue': hashlib.sha1(''.join(sums).encode()).hexdigest()},
                         licenseInfoFromFiles=['NOASSERTION'], hasFiles=[of['SPDXID'] for of in own]))
        files += own
        relate('SPDXRef-DOCUMENT', 'DESCRIBES', me)
        for wanted in re.findall(r'(?:^|, )([a-z0-9.+-]+)', field(deb, 'Depends')):
            if wanted in installed and wanted not in ours:
                relate(me, 'DEPENDS_ON', debian(wanted, installed[wanted]))
        if any(of['fileName'].startswith('./usr/bin/') for of in own):
            for library, at in sorted(compiled.items()):
                relate(me, 'STATIC_LINK', debian(library, at))
        if any(of['fileName'].startswith('./usr/share/styled/web/') for of in own):
            for part in json.loads(finish_packages.read(build, 'npm/web/page/packages.json')):
                url = 'git+' + part['source'] if part['source'].startswith('https:') else part['source']
                relate(me, 'CONTAINS', add(package(part['name'], part['version'], part['licence'], url=url,
                                                   reference=f"pkg:npm/{part['name'].replace('@', '%40')}@{part['version']}")))
    version = field(debs[0], 'Version')
    return {'spdxVersion': 'SPDX-2.3', 'dataLicense': 'CC0-1.0', 'SPDXID': 'SPDXRef-DOCUMENT', 'name': f'styled-{version}',
            'documentNamespace': f'https://styled.invalid/spdx/{version}-' + hashlib.sha256(''.join(sorted(digest(deb, "sha256") for deb in debs)).encode()).hexdigest()[:16],
            'creationInfo': {'created': date.strftime('%Y-%m-%dT%H:%M:%SZ'), 'creators': ['Tool: styled-sbom.py']},
            'packages': list(packages.values()), 'files': files, 'relationships': relations}


if __name__ == '__main__':
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    made = bill(sys.argv[1], glob.glob(os.path.join(sys.argv[2], '*.deb')), datetime.datetime.now(datetime.timezone.utc))
    json.dump(made, sys.stdout, indent=1)
    print()
