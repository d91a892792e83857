// Writes and reads Zarr v3 arrays with zarrita, which shares no code with the program.
//
// Usage: node zarrita.mjs write ARRAY JOB.json SAMPLES
//        node zarrita.mjs read ARRAY SAMPLES
//
// ARRAY is a folder. JOB.json has zarrita's options of create(). SAMPLES is a file of little-endian numbers in C order,
// which `write` reads and `read` makes. Needs: npm ci --prefix tests/zarr

import { readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';

let zarr;
let FileSystemStore;
try {
  zarr = await import('zarrita');
  FileSystemStore = (await import('@zarrita/storage/fs')).default;
} catch (error) {
  if (error.code !== 'ERR_MODULE_NOT_FOUND') throw error;
  console.error('zarrita is not installed: run npm ci --prefix tests/zarr');
  process.exit(1);
}

const [command, folder, ...files] = process.argv.slice(2);
const store = new FileSystemStore(resolve(folder));
if (command === 'write') {
  const options = JSON.parse(readFileSync(files[0]));
  const array = await zarr.create(store, options);
  const bytes = new Uint8Array(readFileSync(files[1])).buffer;
  const types = {
    uint8: Uint8Array, uint16: Uint16Array, int16: Int16Array, int32: Int32Array, float32: Float32Array, float64: Float64Array,
  };
  const data = new types[options.dtype](bytes);
  const stride = options.shape.map((_, axis) => options.shape.slice(axis + 1).reduce((a, b) => a * b, 1));
  await zarr.set(array, options.shape.map(() => null), { data, shape: options.shape, stride });
} else {
  const array = await zarr.open(store, { kind: 'array' });
  const { data, shape, stride } = await zarr.get(array);
  const inOrder = data.slice();
  for (let i = 0; i < data.length; ++i) {
    let rest = i;
    let from = 0;
    for (let axis = shape.length - 1; axis >= 0; --axis) {
      from += (rest % shape[axis]) * stride[axis];
      rest = Math.floor(rest / shape[axis]);
    }
    inOrder[i] = data[from];
  }
  writeFileSync(files[0], new Uint8Array(inOrder.buffer));
}
