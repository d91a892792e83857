// Timokhin, Mikhaylyuk: Method to extract isosurfaces on the GPU by means of programmable tessellation. Programming and
// Computer Software 46 (3), 2020. Control stage: a patch covers up to D x D cells of a layer, D = the highest
// tessellation level + 1, and becomes a grid of that many vertices.

layout(vertices = 1) out;

flat in uint patch_number[];

uniform ivec3 grid;
uniform ivec2 patches;    // m_p, n_p
uniform int patch_cells;  // D

flat out ivec3 patch_origin[];
flat out ivec2 patch_size[];

void main() {
  int g = int(patch_number[0]);
  int layer = g / (patches.x * patches.y);
  int within = g - layer * patches.x * patches.y;
  ivec2 origin = patch_cells * ivec2(within % patches.x, within / patches.x);
  // The tessellator treats an inner level of 0 or 1 next to larger ones as 2. So narrow patches get three vertices a
  // row; those beyond the grid end at once.
  ivec2 size = max(min(ivec2(patch_cells), grid.xy - origin), 3);
  patch_origin[gl_InvocationID] = ivec3(origin, layer);
  patch_size[gl_InvocationID] = size;
  vec2 levels = vec2(size - 1);
  gl_TessLevelInner[0] = levels.x;
  gl_TessLevelInner[1] = levels.y;
  gl_TessLevelOuter[0] = levels.y;
  gl_TessLevelOuter[1] = levels.x;
  gl_TessLevelOuter[2] = levels.y;
  gl_TessLevelOuter[3] = levels.x;
}
