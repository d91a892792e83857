#include "bench/stability_cases.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace isoextract::bench {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr glm::ivec3 kDims(12);

template <class T, class F>
StabilityScene scene(double iso, const F& value, const glm::ivec3& dims = kDims) {
  auto values = std::make_shared<std::vector<T>>();
  for (int k = 0; k < dims.z; ++k) {
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) {
        const double v = value(glm::ivec3(i, j, k));
        if constexpr (std::is_same_v<T, field::Half>) {
          values->push_back(field::Half(static_cast<float>(v)));
        } else {
          values->push_back(static_cast<T>(v));
        }
      }
    }
  }
  StabilityScene result;
  result.field.name = "stability";
  result.field.source = "stability";
  const void* data = values->data();
  result.field.samples = field::DenseSamples{field::sample_type_of<T>(), dims, std::move(values), data};
  result.options.iso = iso;
  return result;
}

// Returns the distance to a sphere in kDims that passes through no sample; positive inside.
double ball(const glm::ivec3& p) { return 3.7 - glm::length(glm::dvec3(p) - glm::dvec3(5.3, 5.6, 5.1)); }
double side(const glm::ivec3& p) { return ball(p) > 0 ? 1 : -1; }

// Returns a pseudo-random integer from 0 to `count` - 1.
int scattered(const glm::ivec3& p, int count) {
  const auto hash = static_cast<std::uint32_t>(p.x * 73856093 ^ p.y * 19349663 ^ p.z * 83492791);
  return static_cast<int>((hash * 2654435761U >> 12) % static_cast<std::uint32_t>(count));
}
double wobble(const glm::ivec3& p) { return scattered(p, 101) / 101.0; }

StabilityScene placed_ball(const field::Affine& frame) {
  StabilityScene result = scene<float>(0, ball);
  result.options.output_from_index = frame;
  return result;
}

StabilityScene with(StabilityScene scene, StabilityOutcome outcome) {
  scene.outcome = outcome;
  return scene;
}

StabilityScene open(StabilityScene scene) {
  scene.closed = false;
  return scene;
}

field::Affine moved(field::Affine frame, const glm::dvec3& offset) {
  frame.offset = offset;
  return frame;
}

const field::Affine kOblique{glm::dmat3(1, 0.25, 0, -0.5, 2, 0, 0.3, 0.125, 0.5), glm::dvec3(3, -4, 5)};

// Puts NaN and both infinities among ordinary values.
StabilityScene ball_with_nan(extract::NanPolicy policy) {
  StabilityScene result = scene<float>(0, [](const glm::ivec3& p) {
    const int lot = scattered(p, 40);
    return lot == 0 ? kNan : lot == 1 ? kInfinity : lot == 2 ? -kInfinity : ball(p);
  });
  result.options.nan = policy;
  return open(std::move(result));
}

// The extreme values of a type and their neighbors, at an iso value that many samples have.
template <class T>
StabilityScene limits_of() {
  using Limits = std::numeric_limits<T>;
  return scene<T>(Limits::max() - 1, [](const glm::ivec3& p) {
    if (ball(p) > 0) return static_cast<double>(Limits::max());
    return static_cast<double>(scattered(p, 2) == 0 ? Limits::lowest() : static_cast<T>(Limits::max() - 1));
  });
}

constexpr std::string_view kTies =
    "t is 0 at samples that have the iso value, so that vertices of different edges coincide: zero-area triangles";
constexpr std::string_view kSurvives = "survives";

constexpr std::array kCases{
    StabilityCase{"float-max", "Samples of 3e38 and -3e38: their difference is beyond float32.",
                  "f1 - f0 is infinite, t is 0, and vertices coincide at samples", true,
                  [] { return scene<float>(0, [](auto p) { return 3e38 * side(p) * (1 - 0.1 * wobble(p)); }); }},
    StabilityCase{"double-max", "Samples of 1.7e308 and -1.7e308: their difference is beyond double.",
                  "the samples themselves become infinite, and t is not a number", true,
                  [] { return scene<double>(0, [](auto p) { return 1.7e308 * side(p) * (1 - 0.1 * wobble(p)); }); }},
    StabilityCase{
        "float-subnormal", "Odd multiples of the least float32 around 0.",
        "survives on hardware that keeps subnormal numbers; hardware that flushes them to 0 divides 0 by 0", false,
        [] {
          return scene<float>(0, [](auto p) { return 1.401298464324817e-45 * (2 * std::floor(20 * ball(p)) + 1); });
        }},
    StabilityCase{
        "double-subnormal", "Odd multiples of the least double around 0.", "all samples become 0, and t is 0 / 0", true,
        [] {
          return scene<double>(
              0, [](auto p) { return std::numeric_limits<double>::denorm_min() * (2 * std::floor(20 * ball(p)) + 1); });
        }},
    StabilityCase{
        "jump", "Jumps of 1e30 over one edge, from samples at 1.",
        "t rounds to an end of the edge, and vertices coincide at that end", true,
        [] { return scene<float>(0, [](auto p) { return ball(p) > 0            ? 1.0
                                                        : scattered(p, 2) == 0 ? -1e30
                                                                               : -1.0; }); }},
    StabilityCase{"grazing", "Inside samples that pass the iso value by 1e-9 of a step.",
                  "t rounds to 1, and the vertices around a sample coincide at it", true,
                  [] { return scene<float>(0, [](auto p) { return ball(p) > 0 ? 1e-9 : -1 - wobble(p); }); }},
    StabilityCase{"near-flat", "A field of 1 that varies by 1e-12.", "all samples become 1, and t is 0 / 0", true,
                  [] { return scene<double>(1, [](auto p) { return 1 + 1e-12 * ball(p); }); }},
    StabilityCase{"offset", "A field of 1e7 that varies by 1e-3.",
                  "float32 has steps of 1 at 1e7: all samples become equal, and t is 0 / 0", true,
                  [] { return scene<double>(1e7, [](auto p) { return 1e7 + 2e-4 * ball(p); }); }},
    StabilityCase{
        "wide-integers", "32-bit integers around 4e9 that differ by less than 256.",
        "float32 has steps of 256 there: samples become equal, and t is 0 / 0", true,
        [] { return scene<std::uint32_t>(4e9 + 0.5, [](auto p) { return 4e9 + std::floor(10 * ball(p)); }); }},
    StabilityCase{"far-frame", "A frame 1e7 units away, with a spacing of 0.01.",
                  "float32 has steps of 1 at 1e7: hundreds of samples share one position", true,
                  [] {
                    return placed_ball(moved(field::scaling(glm::dvec3(0.01)), {1e7, -1e7, 1e7}));
                  }},
    StabilityCase{"far-oblique", "A rotated and sheared frame 1e7 units away.",
                  "float32 has steps of 1 at 1e7: a vertex is anywhere in its cell", true,
                  [] {
                    return placed_ball(moved(kOblique, {1e7, 2e7, -3e7}));
                  }},
    StabilityCase{"far-thin", "A spacing of 1 to 1e6, with the fine axis far from 0.",
                  "float32 has steps of five samples along the fine axis", true,
                  [] {
                    return placed_ball(moved(field::scaling({100, 0.0001, 100}), {0, 6000, 0}));
                  }},
    StabilityCase{"spacing-1000", "A spacing of 1 to 1000.", kSurvives, false,
                  [] {
                    return placed_ball(field::scaling({0.001, 1, 1}));
                  }},
    StabilityCase{"mirrored", "A frame that mirrors: the extractor must reverse the winding of triangles.", kSurvives,
                  false,
                  [] {
                    return placed_ball(moved(field::scaling({-1, 1, 1}), {2, 3, 4}));
                  }},
    StabilityCase{"sheared", "A frame with oblique axes.", kSurvives, false, [] { return placed_ball(kOblique); }},
    StabilityCase{
        "iso-at-min", "The iso value is the least sample, which most samples have.", kTies, true,
        [] { return scene<std::uint8_t>(0, [](auto p) { return std::max(0.0, std::round(40 * ball(p))); }); }},
    StabilityCase{"iso-at-max", "The iso value is the greatest sample: nothing is inside.", kSurvives, false,
                  [] {
                    return with(scene<std::uint8_t>(9, [](auto p) { return ball(p) > 0 ? 9 : 0; }),
                                StabilityOutcome::nothing);
                  }},
    StabilityCase{"constant-at-iso", "Every sample is the iso value: nothing is inside.", kSurvives, false,
                  [] { return with(scene<float>(1, [](auto) { return 1.0; }), StabilityOutcome::nothing); }},
    StabilityCase{"constant-inside", "Every sample is inside: the mesh is the cap alone.", kSurvives, false,
                  [] { return with(scene<float>(0, [](auto) { return 1.0; }), StabilityOutcome::cap_only); }},
    StabilityCase{"checkerboard", "Inside and outside alternate along every axis.", kSurvives, false,
                  [] { return open(scene<std::uint8_t>(0.5, [](auto p) { return (p.x + p.y + p.z) % 2; })); }},
    StabilityCase{"checkerboard-tie", "A checkerboard whose outside samples have the iso value.", kTies, true,
                  [] { return open(scene<std::uint8_t>(0, [](auto p) { return (p.x + p.y + p.z) % 2; })); }},
    StabilityCase{"thin-shell", "A shell of one voxel.", kSurvives, false,
                  [] {
                    return scene<float>(
                        0, [](auto p) { return std::abs(ball(p)) < 0.5 ? 1 + wobble(p) : -1 - wobble(p); });
                  }},
    StabilityCase{"small-integers", "Random integers from 0 to 4 at the iso value 2.", kTies, true,
                  [] { return open(scene<std::uint8_t>(2, [](auto p) { return scattered(p, 5); })); }},
    StabilityCase{"oblique-ties", "Random integers at the iso value 2, in an oblique frame 1e7 units away.", kTies,
                  true,
                  [] {
                    StabilityScene result = open(scene<std::uint8_t>(2, [](auto p) { return scattered(p, 5); }));
                    result.options.output_from_index = moved(kOblique, {1e7, 2e7, -3e7});
                    result.voxels = 1e-4;
                    return result;
                  }},
    StabilityCase{"long-rows", "Rows of 2000 samples, most at the iso value: float32 is coarse at their ends.", kTies,
                  true,
                  [] {
                    StabilityScene result = scene<std::uint8_t>(1,
                                                                [](auto p) {
                                                                  const bool core = p.x > 0 && p.x < 1999 && p.y > 0 &&
                                                                                    p.y < 3 && p.z > 0 && p.z < 3;
                                                                  return core ? scattered(p, 3) : 1;
                                                                },
                                                                {2000, 4, 4});
                    result.voxels = 2e-3;
                    return result;
                  }},
    StabilityCase{"u8-limits", "0, 254 and 255 at the iso value 254.", kTies, true, limits_of<std::uint8_t>},
    StabilityCase{"i8-limits", "-128, 126 and 127 at the iso value 126.", kTies, true, limits_of<std::int8_t>},
    StabilityCase{"u16-limits", "0, 65534 and 65535 at the iso value 65534.", kTies, true, limits_of<std::uint16_t>},
    StabilityCase{"i16-limits", "-32768, 32766 and 32767 at the iso value 32766.", kTies, true,
                  limits_of<std::int16_t>},
    StabilityCase{"half-limits", "Halves of 65504 and -65504.", kSurvives, false,
                  [] { return scene<field::Half>(0, [](auto p) { return 65504 * side(p); }); }},
    StabilityCase{"infinities", "Every sample is infinite.", "infinity - infinity: t is not a number", true,
                  [] { return scene<float>(0, [](auto p) { return kInfinity * side(p); }); }},
    StabilityCase{"nan-outside", "Scattered NaN and infinities, NaN taken as outside.",
                  "t is not a number beside NaN and infinities", true,
                  [] { return ball_with_nan(extract::NanPolicy::outside); }},
    StabilityCase{"nan-hole", "Scattered NaN and infinities, NaN left as holes.", "t is not a number beside infinities",
                  true, [] { return ball_with_nan(extract::NanPolicy::hole); }},
    StabilityCase{"all-nan", "Every sample is NaN, taken as outside.", kSurvives, false,
                  [] {
                    StabilityScene result = scene<float>(0, [](auto) { return kNan; });
                    result.options.nan = extract::NanPolicy::outside;
                    return with(std::move(result), StabilityOutcome::nothing);
                  }},
    StabilityCase{"two-by-two", "2 x 2 x 40 samples: one row of cells.", kSurvives, false,
                  [] {
                    StabilityScene result = open(scene<float>(
                        0, [](auto p) { return std::sin(p.z * 0.7 + 0.3) + 0.1 * p.x - 0.2 * p.y; }, {2, 2, 40}));
                    result.voxels = 5e-5;
                    return result;
                  }},
    StabilityCase{
        "one-by-one", "1 x 1 x 40 samples, which span no cell.", kSurvives, false,
        [] {
          return with(scene<float>(0, [](auto p) { return p.z - 20.5; }, {1, 1, 40}), StabilityOutcome::refusal);
        }},
};

}  // namespace

std::span<const StabilityCase> stability_cases() { return kCases; }

}  // namespace isoextract::bench
