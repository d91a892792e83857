#include "convert/simulation_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/number_text.hpp"
#include "field/blur.hpp"

namespace isoextract::convert {
namespace {

// The values of one image flag.
struct ImageFlag {
  std::span<const float> values;
  std::size_t stride = 1;

  [[nodiscard]] double of(std::size_t particle) const { return static_cast<double>(values[particle * stride]); }
};

// Finds the flag of an edge: an attribute of its own, or a component of the vector "i".
std::optional<ImageFlag> find_image_flag(const points::ParticleSet& particles, std::size_t edge) {
  for (const points::ParticleAttribute& attribute : particles.attributes) {
    if (attribute.name == kImageFlags[edge] && attribute.components == 1) return ImageFlag{attribute.values.span(), 1};
    if (attribute.name == "i" && attribute.components == 3)
      return ImageFlag{std::span<const float>(attribute.values.span()).subspan(std::min(edge, attribute.values.size())),
                       3};
  }
  return std::nullopt;
}

// Removes the image flags that unwrap() asked for if they are components of the vector "i", too.
void drop_repeated_flags(points::ParticleSet& particles) {
  const auto is_vector = [](const points::ParticleAttribute& attribute) {
    return attribute.name == "i" && attribute.components == 3;
  };
  if (std::ranges::none_of(particles.attributes, is_vector)) return;
  std::erase_if(particles.attributes, [](const points::ParticleAttribute& attribute) {
    const auto is_its_name = [&](const char* flag) { return attribute.name == flag; };
    return attribute.components == 1 && std::ranges::any_of(kImageFlags, is_its_name);
  });
}

Result<void> unwrap(points::ParticleSet& particles) {
  points::SimulationBox& box = *particles.box;
  std::array<ImageFlag, 3> flags;
  for (std::size_t edge = 0; edge < 3; ++edge) {
    const auto flag = find_image_flag(particles, edge);
    if (!flag) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected the image flags ix, iy and iz to unwrap the positions, found no {}",
                              particles.label, kImageFlags[edge]),
                  {"write ix, iy and iz in the simulation",
                   {Remedy::leave_out, Setting::unwrapping, "the particles then stay where they are"}});
    }
    flags[edge] = *flag;
  }
  const field::Affine fractions = box.world_from_fractions().inverse();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    glm::dvec3& p = particles.positions[i];
    if (!is_finite(p)) continue;
    const glm::dvec3 fraction = fractions(p);
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const auto k = static_cast<glm::length_t>(edge);
      const double crossings = flags[edge].of(i);
      if (crossings == 0) continue;
      // Particles in the box can have moved a little out of it since the simulation last wrapped them.
      if (!(std::abs(fraction[k] - 0.5) < 1)) {
        return fail(ErrorCode::input,
                    fmt::format("{}: expected positions in the box to unwrap, found particle {} outside of it at "
                                "{} with the image flag {} = {}: the file has unwrapped positions",
                                particles.label, i, point_text(p), kImageFlags[edge], crossings),
                    {Remedy::leave_out, Setting::unwrapping});
      }
      p += crossings * box.edges[k];
    }
  }
  box.periodic = {false, false, false};
  drop_repeated_flags(particles);
  return {};
}

}  // namespace

Result<void> apply_box_options(const BoxOptions& options, points::ParticleSet& particles) {
  if (options.bounds) {
    const glm::dvec3 size = options.bounds->max - options.bounds->min;
    const auto periodic = particles.box ? particles.box->periodic : points::SimulationBox().periodic;
    particles.box = {options.bounds->min, glm::dmat3(size.x, 0, 0, 0, size.y, 0, 0, 0, size.z), periodic};
    if (!particles.box->is_valid()) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected a box with sides longer than 0, found {}", particles.label,
                              box_text(*particles.box)),
                  {Remedy::change, Setting::simulation_box});
    }
  }
  if (!particles.box && (options.is_periodic() || options.unwrap)) {
    return fail(ErrorCode::input, fmt::format("{}: expected the box of the simulation, found none", particles.label),
                {Remedy::give, Setting::simulation_box});
  }
  if (particles.box && options.periodic) particles.box->periodic = *options.periodic;
  return options.unwrap ? unwrap(particles) : Result<void>();
}

int filter_reach(const SourceOptions& options) {
  double reach = 0;
  for (const FilterStep& step : options.filters) reach += static_cast<double>(step.reach);
  for (const BlurStep& step : options.blurs) {
    const double deviation = step.in_world_units ? field::kMaxBlurSigma : std::min(step.size, field::kMaxBlurSigma);
    reach += step.kind == BlurKind::median ? step.size : std::ceil(3 * deviation);
  }
  constexpr double kMost = 1 << 16;
  return static_cast<int>(std::min(reach, kMost));
}

Result<field::IndexBox> common_region(const field::IndexBox& period, const std::optional<field::IndexBox>& requested,
                                      const std::string& label) {
  if (!requested) return period;
  const field::IndexBox common{glm::max(period.min, requested->min), glm::min(period.max, requested->max)};
  if (glm::all(glm::lessThan(common.min, common.max))) return common;
  return fail(ErrorCode::input, fmt::format("{}: the region contains no cell of the periodic box", label),
              {Remedy::check, Setting::region, "it has to overlap the box of the simulation"});
}

}  // namespace isoextract::convert
