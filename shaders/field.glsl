// Reads samples as bits and converts them to values. All comparisons use integers and all arithmetic uses doubles, so
// that subnormal, huge and NaN samples give the same result on every device.
//
// SAMPLE_U8 ... SAMPLE_F64: the sample type, stored as unsigned bits (f64: two words, low word first).
// FIELD_DENSE: a toroidal window over a dense array. FIELD_SPARSE: leaves of 8x8x8 samples in an atlas.

uniform isamplerBuffer sites;  // xyz of each site of the draw: its lowest sample

#ifdef FIELD_DENSE
uniform usampler3D field_window;
uniform ivec3 window_base;  // the sample that texel (0, 0, 0) would hold if the window had never moved
uniform ivec3 window_size;
#else
uniform usampler3D leaf_atlas;
uniform isamplerBuffer neighbors;  // 3x3x3 places for each site, x fastest: a slot of the atlas, or ~number of a
                                    // constant
uniform usamplerBuffer constants;   // values of places without a leaf
#endif

struct Site {
  int number;  // number in the draw
  ivec3 origin;
};

Site site_of(int number) { return Site(number, texelFetch(sites, number).xyz); }

// Returns the bits of sample `p`, which must be a corner of a cell of the site, or next to one.
uvec2 sample_bits(Site site, ivec3 p) {
#ifdef FIELD_DENSE
  return texelFetch(field_window, (p - window_base) % window_size, 0).xy;
#else
  ivec3 local = p - site.origin;
  ivec3 place = (local >> 3) + 1;
  int slot = texelFetch(neighbors, 27 * site.number + place.x + 3 * place.y + 9 * place.z).x;
  if (slot < 0) return texelFetch(constants, ~slot).xy;
  ivec3 slots = textureSize(leaf_atlas, 0) >> 3;
  ivec3 leaf = ivec3(slot % slots.x, slot / slots.x % slots.y, slot / (slots.x * slots.y));
  return texelFetch(leaf_atlas, 8 * leaf + (local & 7).zyx, 0).xy;
#endif
}

// ---- which side

uniform uvec2 inside_from;  // ordered keys, both ends included; low word first
uniform uvec2 inside_to;

// Returns a key that has the order of the numbers that the bits stand for.
uvec2 ordered_key(uvec2 bits) {
#if defined(SAMPLE_I8)
  return uvec2(bits.x ^ 0x80u, 0u);
#elif defined(SAMPLE_I16)
  return uvec2(bits.x ^ 0x8000u, 0u);
#elif defined(SAMPLE_I32)
  return uvec2(bits.x ^ 0x80000000u, 0u);
#elif defined(SAMPLE_F16)
  return uvec2((bits.x & 0x8000u) != 0u ? ~bits.x & 0xFFFFu : bits.x | 0x8000u, 0u);
#elif defined(SAMPLE_F32)
  return uvec2((bits.x & 0x80000000u) != 0u ? ~bits.x : bits.x | 0x80000000u, 0u);
#elif defined(SAMPLE_F64)
  return (bits.y & 0x80000000u) != 0u ? ~bits : bits | uvec2(0u, 0x80000000u);
#else
  return uvec2(bits.x, 0u);
#endif
}

bool at_least(uvec2 a, uvec2 b) { return a.y > b.y || (a.y == b.y && a.x >= b.x); }

// NaN is never inside: its keys lie beyond those of the infinities.
bool is_inside(uvec2 bits) {
  uvec2 key = ordered_key(bits);
  return at_least(key, inside_from) && at_least(inside_to, key);
}

bool is_nan_sample(uvec2 bits) {
#if defined(SAMPLE_F16)
  return (bits.x & 0x7FFFu) > 0x7C00u;
#elif defined(SAMPLE_F32)
  return (bits.x & 0x7FFFFFFFu) > 0x7F800000u;
#elif defined(SAMPLE_F64)
  uint high = bits.y & 0x7FFFFFFFu;
  return high > 0x7FF00000u || (high == 0x7FF00000u && bits.x != 0u);
#else
  return false;
#endif
}

// ---- values

double power_of_two(int exponent) { return packDouble2x32(uvec2(0u, uint(exponent + 1023) << 20)); }

// Converts a float with `mantissa_bits` and an exponent biased by `bias` to double. The exponent `all_ones` means
// infinity or NaN.
double widen(uint sign, uint exponent, uint all_ones, uint mantissa, int mantissa_bits, int bias) {
  if (exponent == 0u) {
    double magnitude = double(mantissa) * power_of_two(1 - bias - mantissa_bits);
    return sign != 0u ? -magnitude : magnitude;
  }
  uint wide = exponent == all_ones ? 0x7FFu : uint(int(exponent) - bias + 1023);
  uint high = sign << 31 | wide << 20 | (mantissa << (23 - mantissa_bits)) >> 3;
  return packDouble2x32(uvec2(mantissa << (23 - mantissa_bits) << 29, high));
}

double stored_number(uvec2 bits) {
#if defined(SAMPLE_I8)
  return double(int(bits.x << 24) >> 24);
#elif defined(SAMPLE_I16)
  return double(int(bits.x << 16) >> 16);
#elif defined(SAMPLE_I32)
  return double(int(bits.x));
#elif defined(SAMPLE_F16)
  return widen(bits.x >> 15 & 1u, bits.x >> 10 & 31u, 31u, bits.x & 0x3FFu, 10, 15);
#elif defined(SAMPLE_F32)
  return widen(bits.x >> 31, bits.x >> 23 & 255u, 255u, bits.x & 0x7FFFFFu, 23, 127);
#elif defined(SAMPLE_F64)
  return packDouble2x32(bits);
#else
  return double(bits.x);
#endif
}

#ifdef SCALED
uniform double value_slope;
uniform double value_intercept;
#endif

double field_value(uvec2 bits) {
#ifdef SCALED
  precise double value = value_slope * stored_number(bits);
  value = value + value_intercept;
  return value;
#else
  return stored_number(bits);
#endif
}

// ---- cells of a site

uniform ivec3 first_cell;  // of the region; leaves may begin before it
uniform ivec3 last_cell;

bool in_region(ivec3 cell) { return all(greaterThanEqual(cell, first_cell)) && all(lessThanEqual(cell, last_cell)); }

// Returns the position of cell `number` of the 512 of a site. SWIZZLE: in groups of 2x2x2 (Suravikin and Korobitsyn;
// docs/papers.md), otherwise row by row.
ivec3 cell_position(int number) {
#ifdef SWIZZLE
  ivec3 within = ivec3(number, number >> 1, number >> 2) & 1;
  ivec3 group = ivec3(number >> 3, number >> 5, number >> 7) & 3;
  return 2 * group + within;
#else
  return ivec3(number, number >> 3, number >> 6) & 7;
#endif
}

ivec3 axis_bits(int bits) { return ivec3(bits, bits >> 1, bits >> 2) & 1; }
