// Checks a .vrm file by its bytes only, before a library fails on it.

// The bones that a humanoid requires, in VRM 0.x and 1.0 alike.
const REQUIRED = [
  'hips', 'spine', 'head',
  'leftUpperArm', 'leftLowerArm', 'leftHand', 'rightUpperArm', 'rightLowerArm', 'rightHand',
  'leftUpperLeg', 'leftLowerLeg', 'leftFoot', 'rightUpperLeg', 'rightLowerLeg', 'rightFoot',
];
const JSON_CHUNK = 0x4e4f534a;
const WANTED = 'expected a VRM 0.x or 1.0 avatar: binary glTF 2.0 with a humanoid in it';

type Fields = Record<string, unknown>;
const isFields = (value: unknown): value is Fields => typeof value === 'object' && value !== null;
const fieldsOf = (value: unknown): Fields => (isFields(value) ? value : {});

// The bones of the file; undefined if it has no humanoid.
function bonesOf(gltf: unknown): Set<string> | undefined {
  const extensions = fieldsOf(fieldsOf(gltf).extensions);
  const { humanBones } = fieldsOf(fieldsOf(extensions.VRMC_vrm ?? extensions.VRM).humanoid);
  if (Array.isArray(humanBones)) return new Set(humanBones.map((bone) => String(fieldsOf(bone).bone)));
  return isFields(humanBones) ? new Set(Object.keys(humanBones)) : undefined;
}

function wrongIn(bytes: ArrayBuffer): [string, string?] | undefined {
  const view = new DataView(bytes);
  if (bytes.byteLength < 20 || new TextDecoder().decode(bytes.slice(0, 4)) !== 'glTF') {
    return ['is not a VRM file: it does not begin like binary glTF'];
  }
  const version = view.getUint32(4, true), length = view.getUint32(8, true), jsonBytes = view.getUint32(12, true);
  if (version !== 2) return [`is not a VRM file: it is binary glTF of version ${version}`];
  if (length > bytes.byteLength) return [`is not complete: it has ${bytes.byteLength} of ${length} bytes`];
  if (view.getUint32(16, true) !== JSON_CHUNK || 20 + jsonBytes > length) {
    return ['is damaged: its first part is not the description'];
  }
  let gltf: unknown;
  try {
    gltf = JSON.parse(new TextDecoder().decode(bytes.slice(20, 20 + jsonBytes)));
  } catch (error) {
    return ['is damaged: its description is not JSON', (error as Error).message];
  }
  const bones = bonesOf(gltf);
  if (!bones) return ['is glTF, but not a VRM avatar: it has no humanoid'];
  const missing = REQUIRED.filter((bone) => !bones.has(bone));
  return missing.length > 0 ? [`is not a complete humanoid: it has no ${missing.join(', ')}`] : undefined;
}

function sentence(name: string, [what, words]: [string, string?]): string {
  return `${name} ${what}; ${WANTED}${words ? ` (${words})` : ''}`;
}

/** The error of the file, in a sentence; '' if no problem is found. */
export function vrmFault(name: string, bytes: ArrayBuffer): string {
  const wrong = wrongIn(bytes);
  return wrong ? sentence(name, wrong) : '';
}

/** The same for a file that a library could not read, with the library's message. */
export function unreadable(name: string, error: unknown): string {
  return sentence(name, ['cannot be read, something in it is damaged', error instanceof Error ? error.message : String(error)]);
}
