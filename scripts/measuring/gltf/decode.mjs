// How long glTF files take to be read and unpacked, by the decoders that browsers use.
//
//   node decode.mjs RUNS FILE.glb...
//
// Prints JSON: for each file the milliseconds of each run after a first, and its triangles and vertices.
// Needs: npm ci --prefix scripts/measuring/gltf
import { readFileSync } from 'node:fs';
import { NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import draco3d from 'draco3dgltf';
import { MeshoptDecoder } from 'meshoptimizer';

const [runs, ...files] = process.argv.slice(2);
await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  'draco3d.decoder': await draco3d.createDecoderModule(),
  'meshopt.decoder': MeshoptDecoder,
});

const found = [];
for (const file of files) {
  const bytes = new Uint8Array(readFileSync(file));
  const milliseconds = [];
  let triangles = 0;
  let vertices = 0;
  for (let run = 0; run <= Number(runs); run++) {
    const start = performance.now();
    const document = await io.readBinary(bytes);
    const time = performance.now() - start;
    if (run > 0) {
      milliseconds.push(time);
      continue;
    }
    for (const mesh of document.getRoot().listMeshes()) {
      for (const primitive of mesh.listPrimitives()) {
        triangles += primitive.getIndices().getCount() / 3;
        vertices += primitive.getAttribute('POSITION').getCount();
      }
    }
  }
  found.push({ triangles, vertices, milliseconds });
}
console.log(JSON.stringify(found));
