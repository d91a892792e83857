// Suravikin, Korobitsyn: Visualization of a scalar field by dynamic construction of an isosurface (in Russian;
// docs/papers.md). Corners of tetrahedra by vertex number alone: vertex 4 * (6 * (512 * site + cell) + tetrahedron) +
// corner.

flat out ivec3 corner_low;   // relative to the site's lowest sample
flat out uvec2 corner_bits;
flat out int corner_site;    // number in the draw; -1 if the cell is outside the region

void main() {
  int tetrahedron = (gl_VertexID >> 2) % 6;
  int cell = (gl_VertexID >> 2) / 6;
  Site site = site_of(cell >> 9);
  ivec3 low = cell_position(cell & 511);
  corner_site = -1;
  corner_low = low + axis_bits(tetrahedron_corners[4 * tetrahedron + (gl_VertexID & 3)]);
  corner_bits = uvec2(0u);
  if (!in_region(site.origin + low)) return;
  corner_site = site.number;
  corner_bits = sample_bits(site, site.origin + corner_low);
}
