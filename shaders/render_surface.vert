// Computes triangle corners from gl_VertexID alone, placed in a tile of the picture whose rows run downward.
uniform int first_triangle;  // of this draw
uniform int vertex_base;
uniform dvec3 view_offset;
uniform dvec2 clip_scale;  // view space to clip space of the tile
uniform dvec2 clip_shift;
uniform double near_depth;

bool is_finite(uvec3 bits) { return all(notEqual(bits & 0x7f800000u, uvec3(0x7f800000u))); }

void main() {
  uvec3 corners = texelFetch(triangle_corners, first_triangle + gl_VertexID / 3).xyz;
  bool finite = true;
  for (int c = 0; c < 3; ++c) {
    finite = finite && is_finite(texelFetch(vertex_positions, int(corners[c] + uint(vertex_base))).xyz);
  }
  if (!finite) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // outside the clip volume
    return;
  }
  Triangle triangle = triangle_of(corners, vertex_base, view_offset);
  int corner = gl_VertexID % 3;
  dvec3 p = corner == 0 ? triangle.a : corner == 1 ? triangle.b : triangle.c;
  double depth = -p.z;
  // z clips only the part behind half of the near depth; the fragments are tested against both depth limits.
  gl_Position = vec4(vec2(clip_scale * p.xy + clip_shift * depth), float(depth - near_depth), float(depth));
}
