// Timokhin, Mikhaylyuk: Method to extract isosurfaces on the GPU by means of programmable tessellation. Programming and
// Computer Software 46 (3), 2020. Evaluation stage: converts the position in the patch to the cell. The 0.5 is the
// epsilon of the paper against rounding.

layout(quads, equal_spacing, point_mode) in;

flat in ivec3 patch_origin[];
flat in ivec2 patch_size[];

flat out ivec3 cell;

void main() {
  ivec2 within = ivec2(gl_TessCoord.xy * vec2(patch_size[0] - 1) + 0.5);
  cell = patch_origin[0] + ivec3(within, 0);
}
