// A dialog over the page. The browser keeps the focus within, closes it by Esc, and returns the
// focus afterwards.
import { h } from './dom.js';

export interface Dialog {
  element: HTMLDialogElement;
  show(): void;
  toggle(): void;
}

let named = 0;

export function dialog(title: string, className: string, ...children: (Node | string)[]): Dialog {
  const close = h('button', { className: 'close', 'aria-label': 'Close', onclick: () => element.close() }, '×');
  const heading = h('h2', { id: `dialog-${++named}` }, title);
  const element: HTMLDialogElement = h('dialog', { className: `dialog ${className}`, 'aria-labelledby': heading.id },
    h('div', { className: 'sheet' }, h('div', { className: 'title' }, heading, close), ...children));
  // The sheet covers all but the edge of the dialog, so a click on the dialog itself is outside of it.
  element.addEventListener('click', ({ target }) => target === element && element.close());
  const show = () => {
    if (!element.open) element.showModal();
  };
  return { element, show, toggle: () => (element.open ? element.close() : show()) };
}

/** A dialog is open: keys are for it. */
export function inDialog(): boolean {
  return document.querySelector('dialog[open]') !== null;
}
