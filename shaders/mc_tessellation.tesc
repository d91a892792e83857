// Timokhin, Mikhaylyuk: Method to extract isosurfaces on the GPU by means of programmable tessellation. Programming and
// Computer Software 46 (3), 2020. Control stage: one patch is one site, and becomes a grid of 64x8 vertices, one for
// each cell.

layout(vertices = 1) out;

void main() {
  gl_TessLevelInner[0] = 63.0;
  gl_TessLevelInner[1] = 7.0;
  gl_TessLevelOuter[0] = 7.0;
  gl_TessLevelOuter[1] = 63.0;
  gl_TessLevelOuter[2] = 7.0;
  gl_TessLevelOuter[3] = 63.0;
}
