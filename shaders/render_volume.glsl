// A volume of bricks: 8x8x8 cells, 9 samples a side, as positions in the table of the transfer function. Invisible
// bricks are not stored. Nodes have 16 bricks a side. A program with an emission has this file twice, the second time
// with the names of render_emission_names.glsl.
uniform isampler3D nodes;          // node number; -1: invisible; below -1: ~slot - 1 if the node has only one slot
uniform isamplerBuffer bricks;     // bricks of all nodes, z fastest: slot in the atlas, or -1
uniform sampler3D atlas;
uniform samplerBuffer transfer;    // red, green, blue, extinction; of an emission red, green, blue, the largest of them
uniform ivec3 first_node;
uniform ivec3 atlas_slots;         // along each axis
uniform ivec3 first_cell;
uniform ivec3 last_cell;
uniform dvec3 box_min;             // in index space
uniform dvec3 box_max;
uniform dvec3 volume_eye;
uniform dmat3 index_of_view;       // of directions

#ifndef EMISSION_NAMES
const int kBrickSamples = 9;
const float kNanThreshold = 2e30;  // positions are smaller; larger values mean NaN

// The brick or node of the last sample.
struct Brick {
  ivec3 at;     // in bricks
  int shift;    // of cell numbers to `at`: 3, or 7 for a whole node
  int slot;     // -1: invisible
  ivec3 texel;  // of its first sample
};
#endif

Brick find_brick(ivec3 cell) {
  ivec3 brick = cell >> 3;
  int node = texelFetch(nodes, (brick >> 4) - first_node, 0).r;
  if (node == -1) return Brick(cell >> 7, 7, -1, ivec3(0));
  int slot = ~node - 1;
  if (node >= 0) {
    ivec3 in_node = brick & 15;
    slot = texelFetch(bricks, node << 12 | in_node.x << 8 | in_node.y << 4 | in_node.z).r;
  }
  int row = slot / atlas_slots.x;
  ivec3 place = ivec3(slot - row * atlas_slots.x, row % atlas_slots.y, row / atlas_slots.y);
  return Brick(brick, 3, slot, kBrickSamples * place);
}

// Returns color and extinction at a point in the cell.
vec4 entry_at(Brick brick, ivec3 cell, vec3 t) {
  ivec3 at = brick.texel + (cell & 7);
  vec4 low = vec4(texelFetch(atlas, at, 0).r, texelFetch(atlas, at + ivec3(0, 1, 0), 0).r,
                  texelFetch(atlas, at + ivec3(0, 0, 1), 0).r, texelFetch(atlas, at + ivec3(0, 1, 1), 0).r);
  vec4 high = vec4(texelFetch(atlas, at + ivec3(1, 0, 0), 0).r, texelFetch(atlas, at + ivec3(1, 1, 0), 0).r,
                   texelFetch(atlas, at + ivec3(1, 0, 1), 0).r, texelFetch(atlas, at + ivec3(1, 1, 1), 0).r);
  vec4 most = max(low, high);
  if (max(max(most.x, most.y), max(most.z, most.w)) > kNanThreshold) return vec4(0.0);
  vec4 along_x = low + t.x * (high - low);
  vec2 along_y = along_x.xz + t.y * (along_x.yw - along_x.xz);
  float position = clamp(along_y.x + t.z * (along_y.y - along_y.x), 0.0, float(kEntries - 1));
  int below = int(position);
  vec4 entry = texelFetch(transfer, below);
  return entry + (position - float(below)) * (texelFetch(transfer, min(below + 1, kEntries - 1)) - entry);
}

// Returns the depths between which the ray is in the box, within the given range. y <= x: nowhere.
dvec2 depths_in_box(dvec3 along, double enter, double leave) {
  for (int axis = 0; axis < 3; ++axis) {
    double low = box_min[axis] - volume_eye[axis];
    double high = box_max[axis] - volume_eye[axis];
    if (along[axis] == 0.0lf) {
      if (low > 0.0lf || high < 0.0lf) return dvec2(0.0lf);
      continue;
    }
    double a = low / along[axis];
    double b = high / along[axis];
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  }
  return dvec2(enter, leave);
}

// Returns the first slab whose middle may lie beyond the brick; one slab too early does no harm.
int slab_beyond(Brick brick, dvec3 along, double enter, double depth_step, int k, int slabs) {
  double leave = 1e300lf;
  for (int axis = 0; axis < 3; ++axis) {
    if (along[axis] == 0.0lf) continue;
    int face = (brick.at[axis] + (along[axis] > 0.0lf ? 1 : 0)) << brick.shift;
    leave = min(leave, (double(face) - volume_eye[axis]) / along[axis]);
  }
  double number = (leave - enter) / depth_step;
  double next = ceil(number - 0.5lf - 1e-9lf * (1.0lf + abs(number)));
  if (!(next > double(k + 1))) return k + 1;
  // The last slab is shorter, so its middle is nearer.
  return next < double(slabs - 1) ? int(next) : max(k + 1, slabs - 1);
}
