// Marching cubes of one cell, for every way to make its thread: the geometry stage of Timokhin and Mikhaylyuk (2020;
// docs/papers.md). The triangle lists of the cases are an integer texture. An ambiguous cell emits its first variant,
// marked: it contains every crossed edge, and the CPU chooses the triangles (extract/asymptotic_decider.hpp).

layout(points) in;
layout(triangle_strip, max_vertices = 15) out;

flat in ivec2 cell_thread[];  // site in the draw, cell in the site

uniform usampler2D case_triangles;  // row: case; column 0: triangles | ambiguous << 7, then direction << 3 | corner

void main() {
  Site site = site_of(cell_thread[0].x);
  ivec3 low = cell_position(cell_thread[0].y);
  if (!in_region(site.origin + low)) return;
  uvec2 bits[8];
  int cell_case = 0;
  for (int corner = 0; corner < 8; ++corner) {
    bits[corner] = sample_bits(site, site.origin + low + axis_bits(corner));
    cell_case |= int(is_inside(bits[corner])) << corner;
  }
  if (cell_case == 0 || cell_case == 255) return;
  uint head = texelFetch(case_triangles, ivec2(0, cell_case), 0).x;
  uint decided_later = head >> 7;
#ifdef NAN_HOLES
  decided_later |= uint(is_hole(site, low));
#endif
  int vertices = 3 * int(head & 7u);
#ifdef NORMALS_FLAT
  for (int first = 0; first < vertices; first += 3) {
    vec3 corners[3];
    for (int pass = 0; pass < 2; ++pass) {
      for (int v = 0; v < 3; ++v) {
        int edge = int(texelFetch(case_triangles, ivec2(1 + first + v, cell_case), 0).x);
        int corner = edge & 7;
        int direction = edge >> 3;
        set_vertex(site, low + axis_bits(corner), direction, bits[corner], bits[corner | direction], decided_later);
        if (pass == 0) {
          corners[v] = position;
        } else {
          normal = normalize(cross(corners[1] - corners[0], corners[2] - corners[0]));
          EmitVertex();
        }
      }
    }
    EndPrimitive();
  }
#else
  for (int v = 0; v < vertices; ++v) {
    int edge = int(texelFetch(case_triangles, ivec2(1 + v, cell_case), 0).x);
    int corner = edge & 7;
    int direction = edge >> 3;
    set_vertex(site, low + axis_bits(corner), direction, bits[corner], bits[corner | direction], decided_later);
    EmitVertex();
    if (v % 3 == 2) EndPrimitive();
  }
#endif
}
