import qrcode from 'qrcode-generator';

const BORDER = 4; // modules of white that readers need around it

/** A QR code: the side in modules, border included, and its dark modules as an SVG path. */
export function qrOf(text: string): { side: number; path: string } {
  const code = qrcode(0, 'M');
  code.addData(text);
  code.make();
  const count = code.getModuleCount();
  let path = '';
  for (let row = 0; row < count; ++row) {
    for (let column = 0; column < count; ++column) {
      if (code.isDark(row, column)) path += `M${column + BORDER} ${row + BORDER}h1v1h-1z`;
    }
  }
  return { side: count + 2 * BORDER, path };
}
