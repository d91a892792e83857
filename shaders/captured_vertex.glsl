// Computes the vertex on a crossed grid edge for transform feedback. The arithmetic is that of
// extract/edge_geometry.hpp, in the same order and in double.

#ifdef COUNTING
// The count pass needs only the number of vertices.
void set_vertex(Site site, ivec3 low, int direction, uvec2 bits0, uvec2 bits1, uint decided_later) {}
#else
out vec3 position;       // in the mesh's local frame
flat out uint edge_key;  // site in the draw << 16 | decided later << 15 | direction << 12 | z << 8 | y << 4 | x
#ifdef NORMALS_GRADIENT
out vec3 normal;
#endif
#ifdef NORMALS_FLAT
out vec3 normal;
#endif

uniform double iso_value;
uniform double edge_margin;
uniform dvec3 local_x, local_y, local_z, local_offset;  // columns of the map from indices to local coordinates

bool is_finite(double value) { return (unpackDouble2x32(value).y & 0x7FF00000u) != 0x7FF00000u; }

bool is_nan(double value) {
  uvec2 words = unpackDouble2x32(value);
  uint high = words.y & 0x7FFFFFFFu;
  return high > 0x7FF00000u || (high == 0x7FF00000u && words.x != 0u);
}

uint exponent_field(double value) { return unpackDouble2x32(value).y >> 20 & 0x7FFu; }

// Returns value * 2^600 for values below 2^-255. Works on the bits, because devices may treat subnormal numbers as
// zero.
double enlarged(double value) {
  uvec2 words = unpackDouble2x32(value);
  uint exponent = words.y >> 20 & 0x7FFu;
  if (exponent != 0u) return packDouble2x32(uvec2(words.x, words.y + (600u << 20)));
  double mantissa = double(words.y & 0xFFFFFu) * power_of_two(32) + double(words.x);
  double magnitude = mantissa * power_of_two(600 - 1074);
  return words.y >> 31 != 0u ? -magnitude : magnitude;
}

// Returns the parameter of the crossing on an edge from value f0 to f1 (linear, as in Suravikin and Korobitsyn;
// docs/papers.md), at least edge_margin away from both ends.
double edge_crossing(double f0, double f1) {
  double t;
  bool finite0 = is_finite(f0);
  bool finite1 = is_finite(f1);
  if (finite0 && finite1) {
    double iso = iso_value;
    uint largest = max(max(exponent_field(f0), exponent_field(f1)), exponent_field(iso));
    if (largest >= 0x700u) {  // keeps the difference and its reciprocal in range
      double smaller = power_of_two(-600);
      f0 = f0 * smaller;
      f1 = f1 * smaller;
      iso = iso * smaller;
    } else if (largest < 0x300u) {
      f0 = enlarged(f0);
      f1 = enlarged(f1);
      iso = enlarged(iso);
    }
    precise double above = iso - f0;
    precise double whole = f1 - f0;
    precise double ratio = above / whole;
    t = ratio;
  } else if (finite0 == finite1 || is_nan(f0) || is_nan(f1)) {
    t = 0.5lf;
  } else {
    t = finite0 ? 0.0lf : 1.0lf;
  }
  return min(max(t, edge_margin), 1.0lf - edge_margin);
}

vec3 local_position(dvec3 p) {
  precise dvec3 mapped = local_x * p.x;
  mapped = mapped + local_y * p.y;
  mapped = mapped + local_z * p.z;
  mapped = mapped + local_offset;
  return vec3(mapped);
}

#ifdef NORMALS_GRADIENT
uniform dvec3 covector_x, covector_y, covector_z;  // columns of the map from gradients to outward normals
#ifdef FIELD_DENSE
uniform ivec3 last_sample;  // of the whole field
#endif

double number_at(Site site, ivec3 p) { return stored_number(sample_bits(site, p)); }

double infinity() { return packDouble2x32(uvec2(0u, 0x7FF00000u)); }

// Returns the derivative along an axis, as sample_derivative() and boundary_derivative() do: central differences, or
// one-sided ones of the same order at the data boundary. Skips NaN neighbors; a difference of equal infinities is
// infinite.
double derivative(Site site, ivec3 p, int axis) {
  ivec3 unit = ivec3(0);
  unit[axis] = 1;
#ifdef FIELD_DENSE
  if (p[axis] == 0 || p[axis] == last_sample[axis]) {
    bool low = p[axis] == 0;
    ivec3 inward = low ? unit : -unit;
    double sign = low ? 1.0lf : -1.0lf;
    precise double near = number_at(site, p + inward);
    precise double here = number_at(site, p);
    if (is_nan(near)) return near;
    if (is_nan(here)) return here;
    if (last_sample[axis] == 1 || is_nan(number_at(site, p + 2 * inward))) {
      precise double step = near - here;
      return is_nan(step) ? infinity() : sign * step;
    }
    precise double change = 4.0lf * near - 3.0lf * here;
    change = change - number_at(site, p + 2 * inward);
    return is_nan(change) ? infinity() : sign * change / 2.0lf;
  }
#endif
  double low = number_at(site, p - unit);
  double high = number_at(site, p + unit);
  if (is_nan(low)) {
    if (is_nan(high)) return high;
    precise double step = high - number_at(site, p);
    return step;
  }
  if (is_nan(high)) {
    precise double step = number_at(site, p) - low;
    return step;
  }
  precise double change = high - low;
  return is_nan(change) ? infinity() : change / 2.0lf;
}

dvec3 gradient(Site site, ivec3 p) {
  return dvec3(derivative(site, p, 0), derivative(site, p, 1), derivative(site, p, 2));
}

bool has_nan(dvec3 v) { return is_nan(v.x) || is_nan(v.y) || is_nan(v.z); }

// Returns the outward unit normal; the direction of `out_step`, which leads outside, if the gradient is zero or not
// finite. If NaN leaves no gradient, returns that direction with length 2, which tells the CPU to find a normal
// (OutputPlacement::placeholder_normal()).
vec3 gradient_normal(Site site, ivec3 p, ivec3 step, double t, ivec3 out_step) {
  dvec3 along = local_x * double(out_step.x) + local_y * double(out_step.y) + local_z * double(out_step.z);
  vec3 outward = vec3(along / sqrt(dot(along, along)));
  dvec3 low_gradient = gradient(site, p);
  dvec3 high_gradient = gradient(site, p + step);
  bool beside_nan = is_nan(number_at(site, p)) || is_nan(number_at(site, p + step));
  if (beside_nan || has_nan(low_gradient) || has_nan(high_gradient)) return 2.0 * outward;
  dvec3 g = (1.0lf - t) * low_gradient + t * high_gradient;
  dvec3 mapped = covector_x * g.x + covector_y * g.y + covector_z * g.z;
  dvec3 size = abs(mapped);
  double largest = max(max(size.x, size.y), size.z);
  if (is_finite(mapped.x) && is_finite(mapped.y) && is_finite(mapped.z) && largest > 0.0lf) {
    dvec3 scaled = mapped / largest;
    return vec3(scaled / sqrt(dot(scaled, scaled)));
  }
  return outward;
}
#endif

// Sets the captured varyings to the vertex on the edge from the site's sample `low` along `direction`. `bits0` and
// `bits1` are the samples at its ends. The caller emits the vertex.
void set_vertex(Site site, ivec3 low, int direction, uvec2 bits0, uvec2 bits1, uint decided_later) {
  ivec3 step = axis_bits(direction);
  ivec3 p = site.origin + low;
  double t = edge_crossing(field_value(bits0), field_value(bits1));
  precise dvec3 along = t * dvec3(step);
  precise dvec3 at = dvec3(p) + along;
  position = local_position(at);
  edge_key = uint(site.number) << 16 | decided_later << 15 |
             uint(direction << 12 | low.z << 8 | low.y << 4 | low.x);
#ifdef NORMALS_GRADIENT
  normal = gradient_normal(site, p, step, t, is_inside(bits0) ? step : -step);
#endif
}
#endif

#ifdef NAN_HOLES
// Returns whether a corner of the cell is NaN. Such a cell has no triangles, but is captured and marked for the CPU: a
// cap may need its vertices.
bool is_hole(Site site, ivec3 low) {
  for (int corner = 0; corner < 8; ++corner) {
    if (is_nan_sample(sample_bits(site, site.origin + low + axis_bits(corner)))) return true;
  }
  return false;
}
#endif
