// Suravikin, Korobitsyn: Visualization of a scalar field by dynamic construction of an isosurface (in Russian;
// docs/papers.md). The input is one tetrahedron as four vertices with adjacency, the output a strip of up to two
// triangles.

layout(lines_adjacency) in;
#ifdef NORMALS_FLAT
layout(triangle_strip, max_vertices = 6) out;
#else
layout(triangle_strip, max_vertices = 4) out;
#endif

flat in ivec3 corner_low[];
flat in uvec2 corner_bits[];
flat in int corner_site[];

void set_crossing(Site site, int ends, uint decided_later) {
  int a = ends >> 2;
  int b = ends & 3;
  ivec3 step = corner_low[b] - corner_low[a];
  if (step.x + step.y + step.z < 0) {  // edges lead upward along each of their axes
    int lower = b;
    b = a;
    a = lower;
    step = -step;
  }
  set_vertex(site, corner_low[a], step.x | step.y << 1 | step.z << 2, corner_bits[a], corner_bits[b],
             decided_later);
}

void main() {
  if (corner_site[0] < 0) return;
  int index = 0;
  for (int corner = 0; corner < 4; ++corner) index = index << 1 | int(is_inside(corner_bits[corner]));
  if (index == 0 || index == 15) return;
  Site site = site_of(corner_site[0]);
  uint decided_later = 0u;
#ifdef NAN_HOLES
  // The first and last corners of every tetrahedron are corners 0 and 7 of the cell.
  decided_later = uint(is_hole(site, min(corner_low[0], corner_low[3])));
#endif
  int strip = tetrahedron_strips[index];
  int count = strip >> 16;
#ifdef NORMALS_FLAT
  vec3 corners[4];
  for (int v = 0; v < count; ++v) {
    set_crossing(site, strip >> (4 * v) & 15, decided_later);
    corners[v] = position;
  }
  // A quad is emitted as two separate triangles, because each has its own normal.
  for (int first = 0; first + 2 < count; ++first) {
    vec3 turned = cross(corners[first + 1] - corners[first], corners[first + 2] - corners[first]);
    vec3 face = normalize(first == 0 ? turned : -turned);
    for (int v = 0; v < 3; ++v) {
      int at = first == 0 || v == 0 ? first + v : first + 3 - v;
      set_crossing(site, strip >> (4 * at) & 15, decided_later);
      normal = face;
      EmitVertex();
    }
    EndPrimitive();
  }
#else
  for (int v = 0; v < count; ++v) {
    set_crossing(site, strip >> (4 * v) & 15, decided_later);
    EmitVertex();
  }
  EndPrimitive();
#endif
}
