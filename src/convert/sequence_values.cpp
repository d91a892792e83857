#include "convert/sequence_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/particle_choice.hpp"
#include "convert/particle_field.hpp"
#include "convert/particle_source.hpp"
#include "convert/simulation_box.hpp"
#include "field/statistics.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "points/particle_statistics.hpp"
#include "points/region.hpp"
#include "points/sphere_set.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

using edit::ValueRange;

constexpr ValueRange kNothing{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

ValueRange joined(const ValueRange& a, const ValueRange& b) { return {std::min(a[0], b[0]), std::max(a[1], b[1])}; }

// Returns the range of value(n) for n below `count`, without values that are not finite.
template <class Value>
ValueRange range_of(std::size_t count, const Value& value) {
  return reduce_ranges(
      count, 1 << 14, kNothing,
      [&](std::size_t begin, std::size_t end, ValueRange range) {
        for (std::size_t n = begin; n != end; ++n) {
          const double x = value(n);
          if (std::isfinite(x)) range = joined(range, {x, x});
        }
        return range;
      },
      joined);
}

std::optional<ValueRange> unless_empty(const ValueRange& range) {
  return range[0] <= range[1] ? std::optional(range) : std::nullopt;
}

// Returns a copy of the options without attributes, except the attribute of the colors.
SourceOptions only_color(const ConversionJob& job) {
  SourceOptions options = job.source;
  std::erase_if(options.attributes,
                [&](const AttributeChoice& choice) { return choice.name != *job.color->attribute; });
  return options;
}

Result<std::optional<ValueRange>> range_of_particles(const SourceOptions& options, const Context& context) {
  auto file = TRY(particle_io::read_particles(options.input, particle_read_options(options, true), context));
  TRY(keep_chosen(file.particles, options.particles, context));
  const auto found = TRY(find_attributes(file.particles, options.attributes, true));
  if (found.attributes.empty()) return std::nullopt;
  const points::ParticleAttribute& attribute = file.particles.attributes[found.attributes.front()];
  const std::size_t width = attribute.components;
  return unless_empty(range_of(file.particles.size(), [&](std::size_t n) {
    const std::span values = attribute.values.span().subspan(n * width, width);
    if (width == 1) return static_cast<double>(values[0]);
    double squared = 0;
    for (const float value : values) squared += static_cast<double>(value) * static_cast<double>(value);
    return std::sqrt(squared);
  }));
}

// Reads the particles without the attributes of vertices.
Result<particle_io::ParticleFile> read_positions(const SourceOptions& options, const Context& context) {
  SourceOptions only_positions = options;
  only_positions.attributes.clear();
  auto file = TRY(particle_io::read_particles(options.input, particle_read_options(only_positions), context));
  TRY(keep_chosen(file.particles, options.particles, context));
  TRY(give_element_radii(file, options, context));
  TRY(apply_box_options(options.particles.simulation_box, file.particles));
  if (const auto region = region_of_particles(options)) {
    TRY(points::keep_inside(file.particles, *region, context));
  }
  return file;
}

double sample_at(const field::ScalarField& field, const void* values, std::size_t n) {
  return field::visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return field.scale(static_cast<double>(static_cast<const T*>(values)[n]));
  });
}

// The stored samples of a field as runs of equal length.
struct SampleRuns {
  std::vector<std::pair<glm::ivec3, const void*>> runs;  // origin of the block, or dims of dense samples; first sample
  std::size_t length = 0;                                // samples in a run
};

SampleRuns runs_of(const field::ScalarField& field) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    return {{{dense->dims, dense->data}}, dense->count()};
  }
  SampleRuns runs{{}, std::size_t{1} << 9U};
  for (const field::SparseBlock& block : std::get<field::SparseSamples>(field.samples).blocks) {
    runs.runs.emplace_back(block.origin, block.values);
  }
  return runs;
}

// Returns the range of the vectors' lengths. If the components are stored in different blocks, returns the range from 0
// to a length that no vector exceeds.
ValueRange range_of_lengths(const std::vector<field::ScalarField>& components, Progress& progress) {
  std::vector<SampleRuns> stored;
  bool are_alike = true;
  for (const field::ScalarField& field : components) {
    stored.push_back(runs_of(field));
    are_alike = are_alike && std::ranges::equal(
                                 stored.front().runs, stored.back().runs, {}, [](const auto& run) { return run.first; },
                                 [](const auto& run) { return run.first; });
  }
  if (!are_alike) {
    double squared = 0;
    for (const field::ScalarField& field : components) {
      const auto statistics = field::measure_statistics(field, &progress, field::WithPercentiles::no);
      const double most = std::max(std::abs(statistics.min), std::abs(statistics.max));
      squared += most * most;
    }
    return {0, std::sqrt(squared)};
  }
  const std::size_t length = stored.front().length;
  return range_of(stored.front().runs.size() * length, [&](std::size_t n) {
    double squared = 0;
    for (std::size_t c = 0; c < components.size(); ++c) {
      const double x = sample_at(components[c], stored[c].runs[n / length].second, n % length);
      squared += x * x;
    }
    return std::sqrt(squared);
  });
}

Result<std::optional<ValueRange>> range_of_volume(const SourceOptions& options, const Context& context) {
  const auto field = TRY(volume_io::read_volume(options.input, options.read, context));
  const auto attributes = TRY(read_volume_attributes(options, field, true, context));
  if (attributes.found.empty()) return std::nullopt;
  const std::vector<field::ScalarField>& components = attributes.found.front().components;
  if (components.size() > 1) return unless_empty(range_of_lengths(components, context.progress()));
  const auto statistics =
      field::measure_statistics(components.front(), &context.progress(), field::WithPercentiles::no);
  if (statistics.samples == 0) return std::nullopt;
  return std::optional(ValueRange{statistics.min, statistics.max});
}

}  // namespace

Result<FoundRadius> find_radius(const SourceOptions& options, const Context& context) {
  const auto file = TRY(read_positions(options, context));
  FoundRadius found;
  found.particles = file.particles.size();
  found.has_attribute = points::has_radius_attribute(file.particles);
  found.radius = TRY(points::suggest_radius(file.particles, context));
  return found;
}

Result<std::optional<double>> find_sphere_spacing(const SourceOptions& options, const Context& context) {
  const auto file = TRY(read_positions(options, context));
  const SphereSpacing chosen = TRY(choose_sphere_spacing(file.particles, options, context));
  return chosen.spacing;
}

Result<std::optional<edit::ValueRange>> find_color_range(const ConversionJob& job, const Context& context) {
  if (job.source.mesh) {
    const auto file = TRY(mesh_io::read_mesh(job.source.input, context));
    const bool has_it = std::ranges::find(file.mesh.attributes, *job.color->attribute, &mesh::Attribute::name) !=
                        file.mesh.attributes.end();
    return has_it ? edit::range_of_attribute(file.mesh, *job.color->attribute) : std::nullopt;
  }
  const SourceOptions options = only_color(job);
  const auto particles = TRY(is_particles(options, context));
  return particles ? range_of_particles(options, context) : range_of_volume(options, context);
}

}  // namespace isoextract::convert
