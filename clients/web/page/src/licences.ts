// What may be used commercially, and whom to credit: a dialog behind the header's version.
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
  const parts: [string, string][] = [
    ['For commercial use, with the credits below', named(CommercialUse.YES)],
    ['Not for commercial use', named(CommercialUse.NO)],
    ['Not known: read the licence, or that of the example', named(CommercialUse.UNSPECIFIED)],
  ];
  for (const { file, licence, credit } of list.terms) parts.push([`${file}: ${licence || 'no licence is given'}`, credit]);
  const own = new Map<string, string[]>();
  for (const { name, licence, credit, made } of list.styles) {
    if (made || !licence || list.terms.some((terms) => terms.licence === licence && terms.credit === credit)) continue;
    const text = credit ? `${licence}; ${credit}` : licence;
    own.set(text, [...(own.get(text) ?? []), name]);
  }
  for (const [text, names] of own) parts.push([names.join(', '), text]);
  return parts.filter(([title, text]) => text || title.includes(':'));
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
