#include "simulate/water_fields.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::simulate {
namespace {

constexpr int kMaxLayers = 1 << 16;

// Makes a field over the cells with `layers` layers; `fill(y, k, row)` fills its rows.
template <class T, class Fill>
Result<field::ScalarField> make_field(const WaterAutomaton& automaton, const std::string& name, int layers,
                                      const glm::dvec3& spacing, field::SampleType type, const Context& context,
                                      const Fill& fill) {
  const glm::ivec3 dims{automaton.size(), layers};
  field::DenseSamples samples;
  samples.type = type;
  samples.dims = dims;
  auto made = TRY(make_reserved_buffer<T>(samples.count(), context, fmt::format("the volume of the {}", name)));
  T* const values = made->values.data();
  for_each_index(layers, [&](int k) {
    for (int y = 0; y < dims.y; ++y) fill(y, k, values + std::ptrdiff_t{dims.x} * (y + std::ptrdiff_t{dims.y} * k));
  });
  samples.data = values;
  samples.owner = std::move(made);
  field::ScalarField field;
  field.name = name;
  field.source = "the simulation";
  field.index_to_world.linear = glm::dmat3(1.0);
  for (int axis = 0; axis < 3; ++axis) field.index_to_world.linear[axis][axis] = spacing[axis];
  field.index_to_world.offset = 0.5 * spacing;
  field.samples = std::move(samples);
  return field;
}

// Returns the fraction of the voxel from height k to k + 1 that a column of this height fills.
double filled(double height, int k) { return std::clamp(height - k, 0.0, 1.0); }

Result<field::ScalarField> volume_of(const WaterAutomaton& automaton, bool of_water, int layers,
                                     const glm::dvec3& spacing, const Context& context) {
  return make_field<float>(automaton, of_water ? "water" : "terrain", layers, spacing, field::SampleType::f32, context,
                           [&](int y, int k, float* row) {
                             const auto land = automaton.terrain(y);
                             const auto water = automaton.water(y);
                             for (std::size_t x = 0; x < land.size(); ++x) {
                               const double below = filled(land[x], k);
                               const double part =
                                   of_water ? filled(land[x] + std::max(water[x], 0.0), k) - below : below;
                               row[x] = static_cast<float>(part);
                             }
                           });
}

Result<field::ScalarField> height_map_field(const WaterAutomaton& automaton, bool of_water, const glm::dvec3& spacing,
                                            const Context& context) {
  return make_field<double>(automaton, of_water ? "water" : "terrain", 1, spacing, field::SampleType::f64, context,
                            [&](int y, int /*k*/, double* row) {
                              std::ranges::copy(of_water ? automaton.water(y) : automaton.terrain(y), row);
                            });
}

}  // namespace

std::vector<std::string> field_names(WaterOutput content) {
  switch (content) {
    case WaterOutput::water: return {"water"};
    case WaterOutput::terrain: return {"terrain"};
    case WaterOutput::both:
    case WaterOutput::heights: break;
  }
  return {"terrain", "water"};
}

Result<int> count_layers(const WaterAutomaton& automaton) {
  const WaterExtremes found = automaton.extremes();
  const double top = std::max(found.highest_land, found.highest_water);
  if (!found.finite) {
    return fail(ErrorCode::output,
                fmt::format("step {}: found water depths or energies that are not finite", automaton.steps_done()));
  }
  if (!(top < kMaxLayers)) {
    return fail(ErrorCode::output,
                fmt::format("step {}: expected a height of terrain plus water below {} cells, found {:.6g}",
                            automaton.steps_done(), kMaxLayers, top));
  }
  return std::max(static_cast<int>(std::ceil(top)), 0) + 1;
}

Result<std::vector<field::ScalarField>> water_fields(const WaterAutomaton& automaton, WaterOutput content, int layers,
                                                     const glm::dvec3& spacing, const Context& context) {
  std::vector<field::ScalarField> fields;
  for (const std::string& name : field_names(content)) {
    const bool of_water = name == "water";
    auto field = TRY(content == WaterOutput::heights ? height_map_field(automaton, of_water, spacing, context)
                                                     : volume_of(automaton, of_water, layers, spacing, context));
    fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace isoextract::simulate
