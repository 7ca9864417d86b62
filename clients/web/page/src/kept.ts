// The avatars that this browser stores, in IndexedDB, by file name, and which performer wears
// which.
const BASE = 'styled', FILES = 'avatars';
const WORN = 'styled.worn'; // JSON in localStorage: file name by performer

function promised<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('the browser stores nothing'));
  });
}

async function within<T>(mode: IDBTransactionMode, action: (files: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  const opening = indexedDB.open(BASE, 1);
  opening.onupgradeneeded = () => opening.result.createObjectStore(FILES);
  const base = await promised(opening);
  try {
    const transaction = base.transaction(FILES, mode);
    const whole = new Promise<void>((resolve, reject) => {
      transaction.oncomplete = () => resolve();
      transaction.onabort = () => reject(transaction.error ?? new Error('the browser has no room for it'));
    });
    const [result] = await Promise.all([promised(action(transaction.objectStore(FILES))), whole]);
    return result;
  } finally {
    base.close();
  }
}

/** Stores the file under its name; rejects if the browser has no room or stores nothing. */
export async function keep(file: File): Promise<void> {
  await within('readwrite', (files) => files.put(file, file.name));
}

/** The file that was kept under this name. */
export async function keptFile(name: string): Promise<File | undefined> {
  const found: unknown = await within('readonly', (files) => files.get(name));
  return found instanceof File ? found : undefined;
}

function read(): Record<string, unknown> {
  try {
    const worn: unknown = JSON.parse(localStorage.getItem(WORN) ?? '{}');
    return typeof worn === 'object' && worn !== null ? { ...worn } : {};
  } catch {
    return {};
  }
}

/** The last avatar that the performer wore here; '' if none. */
export function lastWorn(performer: string): string {
  const name = read()[performer];
  return typeof name === 'string' ? name : '';
}

/** `name` '': nothing. */
export function noteWorn(performer: string, name: string): void {
  const { [performer]: _, ...others } = read();
  try {
    localStorage.setItem(WORN, JSON.stringify(name ? { ...others, [performer]: name } : others));
  } catch {
    // No room, or not permitted: then it is not stored.
  }
}
