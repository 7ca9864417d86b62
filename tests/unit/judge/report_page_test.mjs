// The script of styleeval's report runs to its end, whichever kind of network was judged: an
// exception would silently leave out all that follows it. Node has no browser: the document here
// keeps elements and their text, and draws nothing.
//   node report_page_test.mjs REPOSITORY
import assert from 'node:assert';
import fs from 'node:fs';
import test from 'node:test';

const root = process.argv[2];
const read = file => fs.readFileSync(`${root}/${file}`, 'utf8');
const page = read('model/train/judge/report_page.html');

class Element {
  constructor() { Object.assign(this, {children: [], textContent: '', value: '1', checked: true}); }
  setAttribute() {}
  append(...children) { this.children.push(...children); }
  replaceChildren() { this.children = []; }
  text() { return [this.textContent, ...this.children.map(c => c.text())].join(' '); }
}

// The document after the page's script has run on these figures.
function show(figures) {
  const script = page.slice(page.lastIndexOf('<script>') + '<script>'.length, page.lastIndexOf('</script>'));
  const data = {weights: 'w', manifest: 'm', figures, scenes: [], parents: [-1, 0], head: 1, rate_hz: 30};
  assert(script.includes('/*DATA*/null'));
  const byId = {};
  const document = {
    createElement: () => new Element(), createElementNS: () => new Element(),
    getElementById: id => byId[id] ??= new Element(), querySelector: () => new Element(), documentElement: {},
  };
  const names = ['document', 'getComputedStyle', 'devicePixelRatio', 'addEventListener', 'requestAnimationFrame'];
  new Function(...names, script.replace('/*DATA*/null', JSON.stringify(data)))(
    document, () => ({getPropertyValue: () => ''}), 1, () => {}, () => {});
  return id => byId[id]?.text() ?? '';
}

const share = {value: 0.5, low: 0.4, high: 0.6, windows: 10, worst: 0.1};
const style = {
  sra: share, sra_of_real: share, cra: share, cra_of_inputs: share, expression: 0.5, expression_cosine: 0.5,
  by_content: {walk: {sra: 0.5}}, taken_for: {old: 1},
};
const set = title => ({title, styles: {old: style}});
const common = {
  judges_on_real: {style: share, content: share}, baseline: set('baseline'), styled: set('styled'),
  glossary: [['SRA', 'the first term'], ['-', 'the last term']],
};
const variety = {distance_cm: 1, recognized: 1, content_recognized: 1, windows: 3, styles: {old: 1}};
const ofClips = {
  ...common, mean: set('by the mean code'), noise: set('by noise'),
  codes: {
    noise: variety, examples: variety, real_cm: 2, real_contents: {walk: 2}, consistency: 0, intensity: null,
    following: {slope: 1, cosine: 1, examples: 4, halves: 1},
    interpolation: {monotone: 1, pairs: 1, quarter: 0.25, half: 0.5, three_quarters: 0.75, largest_step: 1},
  },
  mixed_acts: {seconds: 33.3, acts: {wave: {
    sra_mixed: 0.1234, sra_mixed_spread: 0.051, sra_alone: 0.25, sra_offset: 0.2, cra_mixed: 0.5, cra_alone: 0.5,
    cra_offset: 0.7, cra_input: null, windows: 72}}},
};

test('weights that run live', () => {
  const text = show({...common, long: set('after 60 s'), mixed: set('contents mixed')});
  assert.match(text('tables'), /contents mixed/);
  assert.doesNotMatch(text('tables'), /Mixed acts/);
  assert.match(text('glossary'), /the first term.*the last term/);
});

test('weights that need whole clips', () => {
  const text = show(ofClips);
  assert.match(text('live'), /by noise/);
  assert.match(text('tables'), /APD cm/);
  assert.match(text('tables'), /Mixed acts in one clip of 33 s/);
  assert.match(text('tables'), /wave\s+0\.12 ±0\.05\s+0\.25\s+0\.20\s+0\.50\s+0\.50\s+0\.70\s+-\s+72/);
  assert.match(text('glossary'), /the first term.*the last term/);
});

test('no weights', () => {
  const {styled, ...without} = common;
  assert.match(show(without)('glossary'), /the last term/);
});

test('what styleeval writes beside sets of figures is under no key of a set', () => {
  const keys = page.match(/for \(const key of \[([^\]]*)\]\) \{\s+const set/)[1].match(/\w+/g);
  assert(keys.includes('styled'));
  const sources = ['styleeval.cpp', 'styleeval_live.cpp', 'styleeval_synthetic.cpp'];
  const others = sources.flatMap(name => [...read(`model/tools/${name}`).matchAll(/json\["(\w+)"\]/g)].map(m => m[1]));
  assert(others.includes('codes') && others.includes('spoilt'));
  assert.deepStrictEqual(others.filter(key => keys.includes(key)), []);
});
