// The page's colours, light or dark as the browser prefers.

/** A colour of the page's scheme, by its name in style.css. */
export function schemeColor(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
export const lightScheme = matchMedia('(prefers-color-scheme: light)');
