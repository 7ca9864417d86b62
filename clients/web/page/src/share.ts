// Links to this page for OBS and for a phone.
import type { App } from './app.js';
import { dialog, type Dialog } from './dialog.js';
import { h, setText, svg } from './dom.js';
import { isOwnMachine, obsLink, pageLink, type Framing } from './links.js';
import { qrOf } from './qr.js';
import type { Stage } from './stage.js';

// Dark on light, whatever the page's colours: not all readers support the inverse.
function codeOf(text: string): SVGElement {
  const { side, path } = qrOf(text);
  return svg('svg', { viewBox: `0 0 ${side} ${side}`, class: 'qr', role: 'img', 'aria-label': 'QR code of the page link', 'shape-rendering': 'crispEdges' },
    svg('rect', { width: String(side), height: String(side), fill: '#fff' }), svg('path', { d: path, fill: '#000' }));
}

/** A link in a field, with a button that copies it. */
function copied(label: string, name: string): { element: HTMLElement; show(link: string): void } {
  const field = h('input', { type: 'text', readOnly: true, 'aria-label': label, 'data-link': name, onfocus: () => field.select() });
  const done = h('span', { className: 'hint', role: 'status' });
  const button = h('button', { className: 'go', 'data-copy': name, onclick: () => void copy() }, `Copy ${label}`);
  const copy = async () => {
    try {
      // Pages of other machines without TLS have no clipboard; they may still copy what is selected.
      if (navigator.clipboard) await navigator.clipboard.writeText(field.value);
      else {
        field.select();
        if (!document.execCommand('copy')) throw new Error();
      }
      setText(done, 'Copied.');
    } catch {
      field.select();
      setText(done, 'This browser does not let the page copy: press Ctrl+C.');
    }
  };
  return {
    element: h('div', { className: 'copied' }, field, button, done),
    show: (link) => {
      field.value = link;
      setText(done, '');
    },
  };
}

export function share(app: App, stage: Stage, token: string | undefined): Dialog {
  const page = location.href, own = isOwnMachine(page);
  const obs = copied('OBS link', 'obs'), phone = copied('page link', 'page');
  const who = h('p', {}), kept = h('p', {}), code = h('div', { className: 'code' });
  const framing = h('select', { name: 'framing' },
    ...[['', 'Full body'], ['half', 'Half: from the hips'], ['bust', 'Bust: head and shoulders']].map(([value, words]) => h('option', { value }, words)));
  const mirror = h('input', { type: 'checkbox', name: 'mirror' });
  const picture = h('div', { className: 'picture' }, h('label', {}, 'Framing', framing), h('label', {}, mirror, ' picture mirrored'));
  const risk = h('p', { className: 'warn', hidden: !token },
    'These links contain the token. Anyone who has one can do everything that you can do here. Do not show it on air; ' +
    'OBS writes them into its scene file. For viewers run a second styleweb with --watch-only and a token of its own.');
  const far = own
    ? h('p', {}, `This page is at ${location.host}, which no phone can reach. Start styleweb with --listen 0.0.0.0:7080 ` +
        "--token-file FILE, and open the page by this machine's name or address.")
    : h('div', {}, h('p', {}, 'Scan it with a phone in the same network:'), code, phone.element);
  const made = dialog('OBS and phone', 'share',
    h('h3', {}, 'OBS'), who, picture, obs.element,
    h('p', {}, 'In OBS: Sources, +, Browser; paste the link as URL, width 1920, height 1080.'), kept,
    h('h3', {}, 'Phone'), far, risk);
  const fill = () => {
    const performer = app.selected;
    const avatar = stage.performers.get(performer)?.avatar?.name ?? '';
    setText(who, `Only ${performer || 'the first performer'}${avatar ? ` as ${avatar}` : ''}, on a transparent background.`);
    setText(kept, avatar ? `OBS keeps avatars apart from this browser: if it shows a plain body, choose Interact there, click into the picture and give it ${avatar} once.`
      : 'Drop a .vrm on the page first, and the link names it.');
    obs.show(obsLink(page, { performer, avatar, background: 'transparent', mirror: mirror.checked,
                             ...(framing.value ? { framing: framing.value as Framing } : {}) }, token));
    if (!own) {
      const link = pageLink(page, token);
      phone.show(link);
      code.replaceChildren(codeOf(link));
    }
  };
  for (const choice of [framing, mirror]) choice.addEventListener('change', fill);
  const show = () => {
    fill();
    made.show();
  };
  return { ...made, show };
}
