// Fragments of surfaces. OPAQUE: stores the nearest fragment of each pixel, its triangle and its depth. Otherwise:
// handles the fragments of transparent surfaces in front of it. They are first counted, then listed.
uniform int first_triangle;
uniform int vertex_base;
uniform dvec3 view_offset;
uniform double near_depth;
uniform double far_depth;

layout(binding = 0) uniform atomic_uint met;

#ifdef OPAQUE
layout(location = 0) out uint nearest_triangle;
layout(location = 1) out float nearest_depth;
#else
uniform bool list_them;
uniform usampler2D opaque_triangles;
uniform sampler2D opaque_depths;
layout(r32ui, binding = 0) uniform uimage2D places;  // fragment counts; then positions of the next fragment
layout(std430, binding = 1) writeonly buffer Fragments { uvec2 fragments[]; };  // bits of the depth, triangle
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint number = uint(first_triangle + gl_PrimitiveID);
  Triangle triangle = triangle_of(texelFetch(triangle_corners, int(number)).xyz, vertex_base, view_offset);
  dvec3 normal = cross(triangle.b - triangle.a, triangle.c - triangle.a);
  double towards = dot(normal, direction_of(pixel));
  if (towards == 0.0lf) discard;  // the triangle is seen edge-on
  // The rasterizer snaps corners to a subpixel grid, so a pixel may lie beyond an edge. The depth stays within that of
  // the corners.
  dvec3 depths = -dvec3(triangle.a.z, triangle.b.z, triangle.c.z);
  double depth = clamp(dot(normal, triangle.a) / towards, min(depths.x, min(depths.y, depths.z)),
                       max(depths.x, max(depths.y, depths.z)));
  if (!(depth >= near_depth && depth <= far_depth)) discard;
#ifdef OPAQUE
  atomicCounterIncrement(met);
  nearest_triangle = number;
  nearest_depth = float(depth);
  gl_FragDepth = float(depth / far_depth);
#else
  if (!list_them) atomicCounterIncrement(met);
  // Without an opaque fragment the depth is infinite.
  float nearest = texelFetch(opaque_depths, pixel, 0).r;
  if (float(depth) > nearest) discard;
  if (float(depth) == nearest && number > texelFetch(opaque_triangles, pixel, 0).r) discard;
  uint at = imageAtomicAdd(places, pixel, 1u);
  if (list_them) fragments[at] = uvec2(floatBitsToUint(float(depth)), number);
#endif
}
