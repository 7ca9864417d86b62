// The notices of what the page is made of, as notices.txt of the page: each npm package of which a module is in
// it, and what those packages depend on, because some (three-vrm) come with their parts already inside. The build
// fails where a package has no licence text. packages.json lists the same for build_page.sh's callers.
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';

const RULE = '='.repeat(80);
const TYPES = /^@types\/|\/types-/; // declarations alone: no code of theirs is in the page

// The folder and name of the npm package that a module's file is of; undefined: the page's own.
export function packageOf(file) {
  const found = /^(.*\/node_modules\/((?:@[^/]+\/)?[^/]+))\//.exec(file.split('?')[0].replace(/^\0/, ''));
  return found ? { folder: found[1], name: found[2] } : undefined;
}

// A package's folder, as node finds it from another one's.
function folderOf(name, from) {
  for (let at = from; ; at = dirname(at)) {
    const folder = join(at, 'node_modules', name);
    if (existsSync(join(folder, 'package.json'))) return folder;
    if (at === dirname(at)) throw new Error(`${name}, which ${from} needs, is not installed`);
  }
}

// A comment that begins a source and claims a copyright, without the comment's signs; '': none.
export function claim(source) {
  const comment = /^\s*(\/\*[^]*?\*\/|(?:\/\/[^\n]*\n)+)/.exec(source)?.[1] ?? '';
  if (!/copyright|@license/i.test(comment)) return '';
  return comment.replace(/^\/\*+!?|\*+\/$/g, '').split('\n').map((line) => line.replace(/^ ?(\/\/|\*)? ?/, '').replace(/^-+$/, ''))
    .join('\n').trim();
}

// The licence's text of a package: its own file, the claims of its modules, and for what only names a licence
// (texts: by its short name) that licence's words.
export function licenceText(folder, { name, license }, sources, texts) {
  const own = readdirSync(folder).filter((file) => /^(licen[cs]e|copying|notice)/i.test(file)).sort()
    .map((file) => readFileSync(join(folder, file), 'utf8').trim());
  const claims = [...new Set(sources.map(claim))].filter((text) => text !== '');
  const words = license.replace(/[()]/g, '').split(' AND ');
  const missing = own.length > 0 ? [] : words.filter((word) => !claims.some((text) => text.includes('Redistribution and use'))
    || word !== 'BSD-3-Clause');
  const told = missing.map((word) => {
    if (!(word in texts)) throw new Error(`${name}: has no licence file, and no text of ${word} is known`);
    if (claims.length === 0) throw new Error(`${name}: has no licence file, and no source that claims a copyright`);
    return texts[word];
  });
  return [...own, ...claims, ...told].join('\n\n');
}

export function notices(texts) {
  return {
    name: 'styled-notices',
    apply: 'build',
    generateBundle(_, bundle) {
      const found = new Map(); // folder -> the sources of its modules
      const add = (folder) => found.get(folder) ?? found.set(folder, []).get(folder);
      for (const chunk of Object.values(bundle)) {
        for (const file of Object.keys(chunk.modules ?? {})) {
          const of = packageOf(file);
          if (of) add(of.folder).push(readFileSync(file.split('?')[0].replace(/^\0/, ''), 'utf8'));
        }
      }
      for (const [folder] of found) { // grows on the way
        const { dependencies = {} } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
        for (const name of Object.keys(dependencies)) if (!TYPES.test(name)) add(folderOf(name, folder));
      }
      const packages = [];
      let text = 'The page of styleweb (Apache-2.0, the authors of styled) has parts of the packages below in it, which are\n'
        + 'other people\'s. Their sources are at the addresses given, and in the npm registry by name and version.\n';
      for (const [folder, sources] of [...found].sort()) {
        const of = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
        const licence = of.license.replace(/[()]/g, '');
        const source = (of.repository?.url ?? of.repository ?? '').replace(/^git\+/, '');
        packages.push({ name: of.name, version: of.version, licence, source });
        text += `\n${RULE}\n${of.name} ${of.version}, ${licence}\n${RULE}\n\nSource: ${source}\n\n${licenceText(folder, of, sources, texts)}\n`;
      }
      this.emitFile({ type: 'asset', fileName: 'notices.txt', source: text });
      this.emitFile({ type: 'asset', fileName: 'packages.json', source: `${JSON.stringify(packages, null, 1)}\n` });
    },
  };
}
