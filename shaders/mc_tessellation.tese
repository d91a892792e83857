// Timokhin, Mikhaylyuk: Method to extract isosurfaces on the GPU by means of programmable tessellation. Programming and
// Computer Software 46 (3), 2020. Evaluation stage: converts the position in the patch to the cell. The 0.5 is the
// epsilon of the paper against rounding.

layout(quads, equal_spacing, point_mode) in;

flat out ivec2 cell_thread;

uniform int first_site;  // of this draw

void main() {
  int along_u = int(gl_TessCoord.x * 63.0 + 0.5);
  int along_v = int(gl_TessCoord.y * 7.0 + 0.5);
  cell_thread = ivec2(first_site + gl_PrimitiveID, along_v << 6 | along_u);
}
