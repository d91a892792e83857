// Computes the light of a surface point: ambient, Lambert and specular terms (render/scene.hpp, ShadingModel).
struct Surface {
  double offset_x, offset_y, offset_z;  // offset of stored positions in view space
  uint first_triangle;
  int vertex_base;
  int normal_base;  // -1: flat shading
  int color_base;  // -1: the color of the surface
  float red, green, blue, opacity;
};

layout(std430, binding = 0) readonly buffer Surfaces { Surface surfaces[]; };
uniform int surface_count;
uniform samplerBuffer vertex_normals;
uniform samplerBuffer vertex_colors;  // linear light, straight alpha

const int kMaxLights = 8;
uniform int light_count;
uniform vec3 light_towards[kMaxLights];  // in view space
uniform vec3 light_colors[kMaxLights];
uniform vec4 shading_terms;  // ambient, diffuse, specular, shininess
uniform mat3 rotation;       // maps world directions to view space

struct Shade {
  vec3 color;
  float opacity;
  vec3 normal;  // in world space, toward the eye
};

int surface_of(uint triangle) {
  int low = 0;
  int high = surface_count;
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (surfaces[middle].first_triangle <= triangle) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

Shade shade(uint number, dvec3 direction) {
  Surface surface = surfaces[surface_of(number)];
  uvec3 corners = texelFetch(triangle_corners, int(number)).xyz;
  Triangle triangle =
      triangle_of(corners, surface.vertex_base, dvec3(surface.offset_x, surface.offset_y, surface.offset_z));

  // Weights of the corners where the ray meets the plane. A pixel just beyond an edge gets the weights of a point on
  // the edge.
  dvec3 plane = cross(triangle.b - triangle.a, triangle.c - triangle.a);
  double side = dot(plane, direction) < 0.0lf ? -1.0lf : 1.0lf;
  dvec3 weights = max(side * dvec3(dot(cross(triangle.b, triangle.c), direction),
                                   dot(cross(triangle.c, triangle.a), direction),
                                   dot(cross(triangle.a, triangle.b), direction)), 0.0lf);
  double sum = weights.x + weights.y + weights.z;
  vec3 share = sum > 0.0lf ? vec3(weights / sum) : vec3(1.0 / 3.0);

  vec3 to_eye = vec3(-normalize(direction));
  vec3 flat_normal = vec3(normalize(plane * -side));
  vec3 normal = flat_normal;
  if (surface.normal_base >= 0) {
    ivec3 at = ivec3(corners) + surface.normal_base;
    vec3 between = share.x * texelFetch(vertex_normals, at.x).xyz + share.y * texelFetch(vertex_normals, at.y).xyz +
                   share.z * texelFetch(vertex_normals, at.z).xyz;
    float size = length(between);
    if (size > 0.0 && size < 1e30) normal = rotation * (between / size);
    if (dot(normal, flat_normal) < 0.0) normal = -normal;
  }

  vec4 base = vec4(surface.red, surface.green, surface.blue, 1.0);
  if (surface.color_base >= 0) {
    ivec3 at = ivec3(corners) + surface.color_base;
    base = share.x * texelFetch(vertex_colors, at.x) + share.y * texelFetch(vertex_colors, at.y) +
           share.z * texelFetch(vertex_colors, at.z);
  }
  vec3 light = base.rgb * shading_terms.x;
  for (int l = 0; l < light_count; ++l) {
    float lambert = dot(normal, light_towards[l]);
    if (!(lambert > 0.0)) continue;
    vec3 half_way = light_towards[l] + to_eye;
    float size = length(half_way);
    float gloss = size > 0.0 ? max(dot(normal, half_way) / size, 0.0) : 0.0;
    float shine = gloss > 0.0 ? pow(gloss, shading_terms.w) : 0.0;
    light += light_colors[l] * (base.rgb * (shading_terms.y * lambert) + shading_terms.z * shine);
  }
  return Shade(light, clamp(surface.opacity * base.a, 0.0, 1.0), transpose(rotation) * normal);
}
