// Casts one ray a pixel through the volume and past the surfaces: steps 2 to 7 of the model (render/renderer.hpp).
// VOLUME and SURFACES tell which of them exist, EMISSION whether the volume emits light.
layout(location = 0) out vec4 picture_color;  // premultiplied
layout(location = 1) out vec3 picture_normal;
layout(location = 2) out float picture_depth;
layout(location = 3) out uvec4 picture_counts;  // rays in the volume, samples taken, skipped, terminated

// Software drivers stop loops after a fixed number of rounds. The first count then has this bit set.
const uint kCutOff = 2u;

uniform double near_depth;
uniform double far_depth;
uniform double unit;
uniform double world_step;
uniform double unit_lengths;    // unit lengths of the transfer function in a world unit
uniform float least_light;      // a ray with less light left ends
uniform vec4 background;        // straight alpha

#ifdef SURFACES
const uint kNone = 0xffffffffu;
uniform usampler2D opaque_triangles;
uniform sampler2D opaque_depths;
uniform bool has_lists;
uniform usampler2D list_counts;
uniform usampler2D list_ends;
layout(std430, binding = 1) buffer Fragments { uvec2 fragments[]; };

bool is_before(uvec2 a, uvec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }  // depths are positive

// Shell sort with Knuth's gaps: most lists are short, but some may be long. Returns false if the driver stopped it.
bool sort(uint begin, uint count) {
  uint gap = 1u;
  while (gap < count / 3u) gap = 3u * gap + 1u;
  for (; gap > 0u; gap /= 3u) {
    for (uint i = gap; i < count; ++i) {
      uvec2 moved = fragments[begin + i];
      uint to = i;
      while (to >= gap && is_before(moved, fragments[begin + to - gap])) {
        fragments[begin + to] = fragments[begin + to - gap];
        to -= gap;
      }
      fragments[begin + to] = moved;
    }
  }
  return gap == 0u;
}
#endif

// The accumulated color and counts.
vec3 color = vec3(0.0);
float light = 1.0;  // light left
bool settled = false;
bool found_depth = false;
double depth_found = 0.0lf;
vec3 normal_found = vec3(0.0);

bool has_ended() { return light <= 0.0 || light < least_light; }

void add(vec3 added, float opacity) {
  color += light * opacity * added;
  light *= 1.0 - opacity;
}

void settle(double depth, vec3 normal) {
  found_depth = true;
  depth_found = depth;
  normal_found = normal;
}

// Returns 1 - exp(-x), accurately also for small x.
float taken_by(float x) {
  return x < 0.125 ? x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0))))) : 1.0 - exp(-x);
}

#ifdef EMISSION
// Adds the light that a part of a slab emits: `way` unit lengths long, with the extinction sigma and the opacity `taken`.
// The share (1 - exp(-tau)) / tau of it leaves the slab.
void add_glow(vec3 glow, float way, float sigma, float taken) {
  float tau = sigma * way;
  color += light * glow * (way * (tau > 1e-3 ? taken / tau : 1.0 - tau * (0.5 - tau / 6.0)));
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  dvec3 direction = direction_of(pixel);
  const double kNever = 1e300lf;
  double fragment_depth = kNever;
  bool is_whole = true;
#ifdef SURFACES
  uint fragment_triangle = kNone;
  uint opaque_triangle = texelFetch(opaque_triangles, pixel, 0).r;
  uint next = 0u;
  uint end = 0u;
  if (has_lists) {
    end = texelFetch(list_ends, pixel, 0).r;
    next = end - texelFetch(list_counts, pixel, 0).r;
    is_whole = sort(next, end - next);
  }
  bool fetch = true;
#endif
  uint rays = 0u;
  uint samples = 0u;
  uint skipped = 0u;
  int k = 0;
  int slabs = 0;
  bool inside = false;  // of a slab
  double first = 0.0lf;
  double last = 0.0lf;
  double from = 0.0lf;
  double middle = 0.0lf;
  vec4 entry = vec4(0.0);
  int all_slabs = 0;
  int before = 0;  // slabs in earlier parts of the ray
#ifdef VOLUME
  dvec3 along = index_of_view * direction;  // index steps per depth
  double world_length = length(direction) * unit;  // world length of one unit of depth
  double depth_step = world_step / world_length;
  float per_depth = float(world_length * unit_lengths);
  const Brick kNoBrick = Brick(ivec3(-2147483647), 3, -1, ivec3(0));
  Brick brick = kNoBrick;
#ifdef EMISSION
  dvec3 emission_along = emission_index_of_view * direction;
  volume_depths = depths_in_box(along, near_depth, far_depth);
  emission_depths = emission_depths_in_box(emission_along, near_depth, far_depth);
  Brick emission_brick = kNoBrick;
  vec4 glow = vec4(0.0);
  bool in_volume = false;  // for the current part of the ray
  bool in_emission = false;
  int part = -1;
  dvec2 limits = dvec2(0.0lf);
  for (int number = 0; number < 3; ++number) all_slabs += slabs_in(part_at(number), depth_step);
  rays = all_slabs > 0 ? 1u : 0u;
#else
  dvec2 limits = depths_in_box(along, near_depth, far_depth);
  if (limits.y > limits.x) {
    rays = 1u;
    slabs = int(ceil((limits.y - limits.x) / depth_step));
  }
  all_slabs = slabs;
#endif
#endif
  // Each round handles one of: a part of a slab, up to its end or to a fragment; a fragment outside the volume; a
  // skipped brick; the next part of a ray through an emission.
  for (;;) {
#ifdef SURFACES
    if (fetch) {
      fetch = false;
      if (next < end) {
        uvec2 fragment = fragments[next++];
        fragment_depth = double(uintBitsToFloat(fragment.x));
        fragment_triangle = fragment.y;
      } else {
        fragment_triangle = opaque_triangle;
        fragment_depth = opaque_triangle != kNone ? double(texelFetch(opaque_depths, pixel, 0).r) : kNever;
        opaque_triangle = kNone;
      }
    }
#endif
#ifdef EMISSION
    if (!inside && k >= slabs && part < 2) {
      before += slabs;
      ++part;
      limits = part_at(part);
      slabs = slabs_in(limits, depth_step);
      k = 0;
      in_volume = is_in(volume_depths, limits);
      in_emission = is_in(emission_depths, limits);
      continue;
    }
#endif
#ifdef VOLUME
    if (!inside && k < slabs) {
      first = limits.x + double(k) * depth_step;
      if (fragment_depth > first) {
        last = k + 1 < slabs ? limits.x + double(k + 1) * depth_step : limits.y;
        middle = first + (last - first) / 2.0lf;
        dvec3 index = volume_eye + middle * along;
        ivec3 cell = clamp(ivec3(floor(index)), first_cell, last_cell);
#ifdef EMISSION
        dvec3 emission_index = emission_eye + middle * emission_along;
        ivec3 emission_cell = clamp(ivec3(floor(emission_index)), emission_first_cell, emission_last_cell);
        if (in_volume && cell >> brick.shift != brick.at) brick = find_brick(cell);
        if (in_emission && emission_cell >> emission_brick.shift != emission_brick.at) {
          emission_brick = emission_find_brick(emission_cell);
        }
        bool absorbs = in_volume && brick.slot >= 0;
        bool shines = in_emission && emission_brick.slot >= 0;
        if (!absorbs && !shines) {
          int beyond = slabs;
          if (in_volume) beyond = slab_beyond(brick, along, limits.x, depth_step, k, slabs);
          if (in_emission) {
            beyond = min(beyond, emission_slab_beyond(emission_brick, emission_along, limits.x, depth_step, k, slabs));
          }
          skipped += uint(beyond - k);
          k = beyond;
          continue;
        }
        entry = vec4(0.0);
        if (absorbs) entry = entry_at(brick, cell, vec3(index - dvec3(cell)));
        glow = vec4(0.0);
        if (shines) {
          glow = emission_entry_at(emission_brick, emission_cell,
                          vec3(emission_index - dvec3(emission_cell)));
        }
#else
        if (cell >> brick.shift != brick.at) brick = find_brick(cell);
        if (brick.slot < 0) {
          int beyond = slab_beyond(brick, along, limits.x, depth_step, k, slabs);
          skipped += uint(beyond - k);
          k = beyond;
          continue;
        }
        entry = entry_at(brick, cell, vec3(index - dvec3(cell)));
#endif
        ++samples;
        inside = true;
        from = first;
      }
    }
#endif
    bool meets = fragment_depth < (inside ? last : kNever);
    if (!inside && !meets) break;
#ifdef VOLUME
#ifdef EMISSION
    bool has_effect = entry.a > 0.0 || glow.a > 0.0;
#else
    bool has_effect = entry.a > 0.0;
#endif
    if (inside && has_effect) {
      double to = meets ? fragment_depth : last;
      float taken = taken_by(entry.a * per_depth * float(max(to - from, 0.0lf)));
#ifdef EMISSION
      add_glow(glow.rgb, per_depth * float(max(to - from, 0.0lf)), entry.a, taken);
#endif
      add(entry.rgb, taken);
      if (!settled && light <= 0.5) {
        settled = true;
        settle(middle, vec3(0.0));
      }
      from = max(from, to);
    }
    if (!meets) {
      inside = false;
      ++k;
    }
    if (has_ended()) break;
#endif
#ifdef SURFACES
    if (meets) {
      Shade there = shade(fragment_triangle, direction);
      add(there.color, there.opacity);
      if (!settled && (light <= 0.5 || !found_depth)) {
        settled = light <= 0.5;
        settle(fragment_depth, there.normal);
      }
      if (has_ended()) break;
      fetch = true;
    }
#endif
  }
  // Does not use a flag that the loop sets at its exits: compilers assume after the loop that it is set.
  bool is_last_part = true;
#ifdef EMISSION
  is_last_part = part == 2;
#endif
  is_whole = is_whole && (has_ended() || (is_last_part && k >= slabs && fragment_depth >= kNever));
  int reached = before + (inside ? k + 1 : k);
  float left = has_ended() ? 0.0 : light;
  picture_color = vec4(color + left * background.a * background.rgb, 1.0 - left * (1.0 - background.a));
  picture_normal = normal_found;
  picture_depth = found_depth ? float(depth_found * unit) : uintBitsToFloat(0x7f800000u);
  picture_counts = uvec4(is_whole ? rays : rays | kCutOff, samples, skipped, uint(max(all_slabs - reached, 0)));
}
