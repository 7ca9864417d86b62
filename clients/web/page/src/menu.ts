// The menu of a made style: rename, export, remove.
import { h, setText } from './dom.js';
import { nameFault } from './names.js';
import type { App } from './app.js';
import type { Examples } from './examples.js';

export class StyleMenu {
  readonly element = h('div', { className: 'menu', hidden: true });
  private opener: HTMLElement | undefined;

  constructor(private readonly app: App, private readonly examples: Examples) {
    this.element.addEventListener('keydown', (event) => this.onKey(event));
    addEventListener('pointerdown', ({ target }) => {
      if (!this.element.hidden && target instanceof Node && !this.element.contains(target)) this.close(false);
    });
    addEventListener('resize', () => this.close(false));
    addEventListener('wheel', ({ target }) => {
      if (!(target instanceof Node && this.element.contains(target))) this.close(false);
    }, { passive: true });
  }

  open(name: string, opener: HTMLElement): void {
    if (!this.element.hidden && this.opener === opener) return this.close();
    this.opener = opener;
    opener.setAttribute('aria-expanded', 'true');
    const item = (words: string, action: () => void) =>
      h('button', { role: 'menuitem', 'data-menu': words.replace(/\W/g, '').toLowerCase(), onclick: action }, words);
    const act = (action: () => Promise<void>) => () => {
      this.close();
      void action();
    };
    this.element.setAttribute('role', 'menu');
    this.element.setAttribute('aria-label', name);
    this.element.replaceChildren(
      item('Rename …', () => this.rename(name)),
      item('Export', act(() => this.examples.save(name))),
      item('Remove', act(() => this.examples.remove(name))));
    this.element.hidden = false;
    this.place(opener);
    (this.element.firstElementChild as HTMLElement).focus();
  }

  close(back = true): void {
    if (this.element.hidden) return;
    this.element.hidden = true;
    this.opener?.setAttribute('aria-expanded', 'false');
    if (back) this.opener?.focus();
    this.opener = undefined;
  }

  private place(opener: HTMLElement): void {
    const at = opener.getBoundingClientRect(), { offsetWidth, offsetHeight } = this.element;
    this.element.style.left = `${Math.max(6, Math.min(at.right - offsetWidth, innerWidth - offsetWidth - 6))}px`;
    const below = at.bottom + 4;
    this.element.style.top = `${below + offsetHeight < innerHeight ? below : Math.max(6, at.top - offsetHeight - 4)}px`;
  }

  private rename(name: string): void {
    const input = h('input', { type: 'text', value: name, maxLength: 40, 'aria-label': `New name of ${name}`, spellcheck: false, autocomplete: 'off' });
    const fault = h('p', { className: 'hint bad', role: 'alert' });
    const form = h('form', {
      onsubmit: (event: Event) => {
        event.preventDefault();
        const to = input.value.trim();
        const wrong = nameFault(to, this.app.taken()) || (to !== name && this.app.taken().made.has(to) ? `There is a style ${to} already.` : '');
        setText(fault, wrong);
        if (wrong) return input.focus();
        this.close();
        if (to !== name) void this.examples.rename(name, to);
      },
    }, input, h('button', { type: 'submit' }, 'Rename'), fault);
    this.element.setAttribute('role', 'dialog');
    this.element.replaceChildren(form);
    if (this.opener) this.place(this.opener);
    input.select();
  }

  private onKey(event: KeyboardEvent): void {
    if (event.key === 'Escape') this.close();
    else if (event.key === 'Tab' && this.element.getAttribute('role') === 'menu') this.close();
    else if (/^Arrow(Up|Down)$|^Home$|^End$/.test(event.key) && this.element.getAttribute('role') === 'menu') {
      const items = [...this.element.children] as HTMLElement[];
      const at = items.indexOf(document.activeElement as HTMLElement);
      const next = event.key === 'Home' ? 0 : event.key === 'End' ? -1 : at + (event.key === 'ArrowDown' ? 1 : -1);
      items.at(next % items.length)!.focus();
      event.preventDefault();
    }
    event.stopPropagation(); // the page's keys are not for this dialog
  }
}
