// A dialog behind the header's version: the styles that may be used commercially, and the names to credit.
import { CommercialUse, type ListReply, type StyleInfo } from 'styled-client';

import type { App } from './app.js';
import { type Dialog, dialog } from './dialog.js';
import { h } from './dom.js';

/** Of a card's title; '' where the licence says nothing. */
export function licenceText({ licence, commercialUse }: StyleInfo): string {
  if (!licence) return '';
  return commercialUse === CommercialUse.NO ? `licence ${licence}, not for commercial use` : `licence ${licence}`;
}

/** Paragraphs: title and text. */
export function licenceParts(list: ListReply): [string, string][] {
  const named = (use: CommercialUse) =>
    list.styles.filter((info) => !info.neutral && info.commercialUse === use).map(({ name }) => name).join(', ');
  const uses: [string, string][] = [
    ['For commercial use, with the credits below', named(CommercialUse.YES)],
    ['Not for commercial use', named(CommercialUse.NO)],
    ['Not known: read the licence, or that of the example', named(CommercialUse.UNSPECIFIED)],
  ];
  const parts = uses.filter(([, names]) => names);
  for (const { file, licence, credit } of list.terms) parts.push([`${file}: ${licence || 'no licence is given'}`, credit]);
  const own = new Map<string, string[]>();
  for (const { name, licence, credit, made, neutral } of list.styles) {
    if (made || neutral || !licence || list.terms.some((terms) => terms.licence === licence && terms.credit === credit)) continue;
    const text = credit ? `${licence}; ${credit}` : licence;
    own.set(text, [...(own.get(text) ?? []), name]);
  }
  return [...parts, ...[...own].map(([text, names]): [string, string] => [names.join(', '), text])];
}

export function licencesDialog(app: App): Dialog {
  const body = h('div', { className: 'licences' });
  const made = dialog('Licences', 'licences-of', body);
  const show = () => {
    const parts = app.list ? licenceParts(app.list) : [];
    body.replaceChildren(
      ...parts.map(([title, text]) => h('section', {}, h('h3', {}, title), h('p', {}, text))),
      h('p', { className: 'hint' }, app.list ? 'The programs are Apache-2.0. A licence’s own text counts.' : 'The daemon has not answered yet.'));
    made.show();
  };
  return { element: made.element, show, toggle: () => (made.element.open ? made.element.close() : show()) };
}
