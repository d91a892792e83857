// The triangles of all surfaces, numbered consecutively, as the camera sees them: in view space, in units of the
// distance from eye to target. Decisions and positions are computed in double, as on the CPU.
uniform usamplerBuffer triangle_corners;  // vertex numbers in the mesh of the surface
uniform usamplerBuffer vertex_positions;  // as bits: comparing floats does not detect NaN reliably
uniform dmat3 view_linear;                // of stored positions
uniform dvec2 to_corner;                  // x, y of the direction (z = -1) through the picture's upper left corner
uniform dvec2 per_pixel;
uniform ivec2 tile_first;                 // the picture's pixel at the tile's pixel (0, 0)

struct Triangle {
  dvec3 a, b, c;
};

Triangle triangle_of(uvec3 corners, int vertex_base, dvec3 view_offset) {
  uvec3 at = corners + uvec3(vertex_base);
  dvec3 a = dvec3(uintBitsToFloat(texelFetch(vertex_positions, int(at.x)).xyz));
  dvec3 b = dvec3(uintBitsToFloat(texelFetch(vertex_positions, int(at.y)).xyz));
  dvec3 c = dvec3(uintBitsToFloat(texelFetch(vertex_positions, int(at.z)).xyz));
  return Triangle(view_linear * a + view_offset, view_linear * b + view_offset, view_linear * c + view_offset);
}

// Returns the view direction through the center of a pixel of the tile, with z = -1: depth is the parameter along it.
dvec3 direction_of(ivec2 pixel) {
  dvec2 center = dvec2(tile_first + pixel) + 0.5lf;
  return dvec3(to_corner.x + per_pixel.x * center.x, to_corner.y - per_pixel.y * center.y, -1.0lf);
}
