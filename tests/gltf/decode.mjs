// node decode.mjs FOLDER...
//
// Decodes every .glb and .gltf of the folders with glTF Transform, the decoders of Draco and meshoptimizer in it, and
// compares packed files with plain ones: "NAME_flat", "NAME_far", ... of a way of packing NAME have the triangles and,
// within a hundredth, the bounds of the samples that are not packed. Ends with 1 where one differs or cannot be decoded,
// with 2 if nothing could be checked. Needs: npm ci --prefix tests/gltf

import { readdirSync } from 'node:fs';
import { basename, extname, join } from 'node:path';

let NodeIO, getBounds, ALL_EXTENSIONS, draco3d, MeshoptDecoder;
try {
  ({ NodeIO, getBounds } = await import('@gltf-transform/core'));
  ({ ALL_EXTENSIONS } = await import('@gltf-transform/extensions'));
  draco3d = (await import('draco3dgltf')).default;
  ({ MeshoptDecoder } = await import('meshoptimizer'));
} catch {
  console.error('glTF Transform is not installed: run npm ci --prefix tests/gltf');
  process.exit(2);
}

// How the names of packed samples end, and the plain sample of the same mesh.
const PLAIN = { _flat: 'flat', _far: 'far', _smooth: 'smooth', '': 'normals' };
const WAYS = /^(draco|quantized|meshopt|meshopt_quantized|meshopt_quantized_ordered|ordered)(_flat|_far|_smooth|_attributes|)$/;

await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  'draco3d.decoder': await draco3d.createDecoderModule(),
  'meshopt.decoder': MeshoptDecoder,
});

async function factsOf(path) {
  const document = await io.read(path);
  let triangles = 0;
  let attributes = 0;
  for (const mesh of document.getRoot().listMeshes()) {
    for (const primitive of mesh.listPrimitives()) {
      const indices = primitive.getIndices();
      triangles += (indices ?? primitive.getAttribute('POSITION')).getCount() / 3;
      attributes += primitive.listSemantics().length;
      if (indices && Math.max(...indices.getArray()) >= primitive.getAttribute('POSITION').getCount()) {
        throw new Error('an index of a vertex that is not there');
      }
    }
  }
  const scene = document.getRoot().listScenes()[0];
  // What is hidden at first is nowhere.
  const still = scene && document.getRoot().listAnimations().length === 0;
  return { triangles, attributes, bounds: still ? getBounds(scene) : null };
}

function near(a, b) {
  if (!a || !b) return a === b;
  return ['min', 'max'].every((side) => a[side].every((x, axis) => Math.abs(x - b[side][axis]) < 0.01));
}

let checked = 0;
let bad = 0;
for (const folder of process.argv.slice(2)) {
  for (const name of readdirSync(folder).filter((file) => /\.(glb|gltf)$/.test(file)).sort()) {
    const extension = extname(name);
    const way = basename(name, extension).match(WAYS);
    if (!way) continue;
    checked += 1;
    try {
      const facts = await factsOf(join(folder, name));
      const plain = PLAIN[way[2]];
      const expected = plain && (await factsOf(join(folder, plain + extension)));
      if (expected && (facts.triangles !== expected.triangles || !near(facts.bounds, expected.bounds))) {
        throw new Error(`${JSON.stringify(facts)} instead of ${JSON.stringify(expected)}`);
      }
      if (way[2] === '_attributes' && facts.attributes < 6) throw new Error(`${facts.attributes} attributes`);
    } catch (error) {
      bad += 1;
      console.log(`${name}: ${error.message}`);
    }
  }
}
console.log(`${checked} packed files, ${bad} bad`);
process.exit(checked === 0 ? 2 : bad === 0 ? 0 : 1);
