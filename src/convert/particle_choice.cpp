#include "convert/particle_choice.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "points/element_radii.hpp"
#include "points/selection.hpp"

namespace isoextract::convert {

namespace {

// Moves every stride-th index to the front, and returns their number.
std::size_t every_nth(std::span<std::uint32_t> indices, std::uint64_t stride) {
  if (stride >= indices.size()) return std::min<std::size_t>(indices.size(), 1);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < indices.size(); i += static_cast<std::size_t>(stride)) indices[kept++] = indices[i];
  return kept;
}

}  // namespace

std::vector<particle_io::AttributeOfCondition> attributes_of_condition(const ParticleOptions& options) {
  std::vector<particle_io::AttributeOfCondition> attributes;
  if (options.element_radii) {
    particle_io::AttributeOfCondition element{{}, false, {}};
    element.names.assign(points::kElementAttributes.begin(), points::kElementAttributes.end());
    element.names.emplace_back(points::kAtomName);
    attributes.push_back(std::move(element));
    attributes.push_back({{std::string(points::kResidueName)}, false, {}});
  }
  if (!options.select) return attributes;
  const auto condition = points::SelectionExpression::parse(*options.select);
  if (!condition) return attributes;  // keep_chosen() reports the error
  for (points::SelectionName& name : condition->names()) {
    attributes.push_back({std::move(name.names), name.required, std::move(name.mark)});
  }
  return attributes;
}

Result<std::optional<ParticleCount>> keep_chosen(points::ParticleSet& particles, const ParticleOptions& options,
                                                 const Context& context) {
  if (!options.select && options.stride == 1) return std::nullopt;
  // Chooses all particles without a condition: "1 == 1" is always true.
  const auto condition = TRY(points::SelectionExpression::parse(options.select.value_or("1 == 1")));
  const auto indices = TRY(points::choose_particles(particles, condition, context));
  const std::size_t count = every_nth(indices->values.span(), options.stride);
  const ParticleCount counts{count, particles.size()};
  if (counts.chosen < counts.of) {
    particles = TRY(points::take_particles(particles, indices->values.span().first(count), context));
  }
  return counts;
}

Result<void> give_element_radii(particle_io::ParticleFile& file, const SourceOptions& options, const Context& context) {
  if (!options.particles.element_radii) return {};
  const std::string& asked = options.placement.unit;
  const auto unit = find_length_unit(asked.empty() || asked == kFileUnit ? file.length_unit : asked);
  const LengthUnit angstrom = *find_length_unit("angstrom");
  const auto stated = TRY(points::set_element_radii(file.particles, *options.particles.element_radii,
                                                    unit ? unit_ratio(angstrom, *unit) : 1, context));
  const std::string label = printable(file.particles.label);
  if (stated == points::kAtomName) {
    file.notes.push_back({NoteId::element_radii,
                          fmt::format("{}: the names of the atoms give their elements: the first letter, or the whole "
                                      "name if it is that of the residue",
                                      label)});
  }
  if (!unit) {
    file.notes.push_back(
        {NoteId::element_radii,
         fmt::format("{}: the radii of the elements are in angstrom, because the file states no known unit of length",
                     label)});
  }
  return {};
}

std::optional<field::Box> region_of_particles(const SourceOptions& options) {
  const bool needs_all = options.resamples() || options.placement.space == Space::index;
  return needs_all ? std::nullopt : options.roi;
}

std::string why_none_chosen(const ParticleCount& count, const ParticleOptions& options) {
  return fmt::format("the condition '{}' chooses none of {} particles", printable(options.select.value_or(""), 200),
                     count.of);
}

}  // namespace isoextract::convert
