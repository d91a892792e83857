#include "convert/particle_source.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "points/attribute_sampling.hpp"
#include "points/sphere_set.hpp"

namespace isoextract::convert {
namespace {

// What is said of a volume and means nothing of particles.
Result<void> check_no_volume_options(const SourceOptions& options) {
  const volumes::ReadOptions& read = options.read;
  if (!read.grid && !read.raw && !read.spacing && !read.origin && !read.kind) return {};
  return fail(ErrorKind::usage,
              fmt::format("{}: this is read as particles, which have no grid, layout, spacing, origin or inside to be "
                          "chosen",
                          files::shown_input_name(options.input)),
              Remedy::leave_out_volumes);
}

bool is_particle_format(const std::string& id) {
  const auto formats = volumes::particle_format_descriptions();
  return std::ranges::find(formats, id, &volumes::ParticleFormatDescription::id) != formats.end();
}

// The vertices where the particles are.
Result<ReservedBuffer<glm::dvec3>> world_positions(const AttributeSource& source, const mesh::Mesh& mesh,
                                                   const Context& context) {
  auto places = make_reserved_buffer<glm::dvec3>(mesh.positions.size(), context, "places of vertices");
  if (!places) return tl::unexpected(std::move(places.error()));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.positions.size(), 4096), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      (*places)->values[v] = source.world_from_output(mesh.position(v));
    }
  });
  return std::move(**places);
}

}  // namespace

Result<bool> is_particles(const SourceOptions& options, const Context& context) {
  const bool expected = options.particles.expected;
  const auto volume = volumes::is_surely_volume(options.input, options.read, context);
  if (!volume) return tl::unexpected(volume.error());
  if (*volume && !expected) return false;
  bool particles = false;
  if (options.read.format) {
    particles = is_particle_format(*options.read.format);
  } else if (!options.read.raw && !options.input.starts_with(field::kDemoPrefix)) {
    const auto detected = volumes::detect_particles(options.input, particle_read_options(options), context);
    if (!detected) return tl::unexpected(detected.error());
    particles = detected->has_value();
  }
  if (!particles && *volume) {
    return fail(ErrorKind::usage,
                fmt::format("{}: this is a volume, and options of particles were given",
                            files::shown_input_name(options.input)),
                Remedy::leave_out_particles);
  }
  if (!particles && !expected) return false;  // where it is expected, the reader says best what it is not
  if (auto fine = check_no_volume_options(options); !fine) return tl::unexpected(std::move(fine.error()));
  return true;
}

Result<std::vector<std::filesystem::path>> list_source_files(const SourceOptions& options, const Context& context) {
  const auto particles = is_particles(options, context);
  if (!particles) return tl::unexpected(particles.error());
  if (*particles) return std::vector<std::filesystem::path>{options.input};
  return volumes::list_input_files(options.input, options.read, context);
}

Result<std::uint64_t> count_frames(const SourceOptions& options, const Context& context) {
  const auto particles = is_particles(options, context);
  if (!particles) return tl::unexpected(particles.error());
  if (!*particles) return volumes::count_volumes(options.input, options.read, context);
  volumes::ParticleReadOptions read = particle_read_options(options);
  read.frame.reset();
  const auto info = volumes::particle_info(options.input, read, context);
  if (!info) return tl::unexpected(info.error());
  return info->frames;
}

volumes::ParticleReadOptions particle_read_options(const SourceOptions& options) {
  volumes::ParticleReadOptions read;
  read.format = options.read.format;
  read.frame = options.read.volume;
  read.attributes = options.particles.attributes;
  read.columns = options.particles.columns;
  const bool are_spheres = points::method_info(options.particles.method).kind == field::FieldKind::level_set;
  if (are_spheres && !options.particles.radius) {
    read.first_of.assign(points::kRadiusAttributes.begin(), points::kRadiusAttributes.end());
  }
  return read;
}

points::FieldOptions field_options(const ParticleOptions& options, std::optional<double> only_iso) {
  points::FieldOptions field;
  field.method = options.method;
  field.radius = options.radius;
  field.cell_size = options.cell_size;
  field.smoothing_length = options.smoothing_length;
  field.weight = options.weight;
  field.deposit = options.deposit;
  field.bad = options.bad;
  field.leave_out_inside = only_iso;
  return field;
}

Result<std::vector<std::size_t>> find_attributes(const points::ParticleSet& particles,
                                                 const std::vector<std::string>& names) {
  std::vector<std::size_t> found;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(particles.attributes, name, &points::ParticleAttribute::name);
    if (at == particles.attributes.end()) {
      return fail(ErrorKind::input, fmt::format("{}: expected an attribute '{}', found none of that name",
                                                particles.label, printable(name)));
    }
    if (at->components > mesh::kMaxComponents) {
      return fail(ErrorKind::input,
                  fmt::format("{}: expected attributes of at most {} components, which a vertex can carry; '{}' has {}",
                              particles.label, mesh::kMaxComponents, printable(name), at->components),
                  Remedy::fewer_attributes);
    }
    found.push_back(static_cast<std::size_t>(at - particles.attributes.begin()));
  }
  return found;
}

Result<std::uint64_t> add_attributes(const AttributeSource& source, mesh::Mesh& mesh, const Context& context) {
  const auto places = world_positions(source, mesh, context);
  if (!places) return tl::unexpected(places.error());
  auto sampled = points::sample_attributes(source.particles, source.attributes, places->values.span(), source.radius,
                                           source.smoothing_length, context);
  if (!sampled) return tl::unexpected(std::move(sampled.error()));
  std::uint64_t bytes = 0;
  for (const points::SampledAttribute& attribute : sampled->attributes) bytes += attribute.values.size_bytes();
  auto memory = context.reserve(bytes, "attributes of vertices");
  if (!memory) return tl::unexpected(std::move(memory.error()));
  std::vector<mesh::Attribute> added;
  for (const points::SampledAttribute& attribute : sampled->attributes) {
    mesh::Attribute& made = added.emplace_back();
    made.name = attribute.name;
    made.components = attribute.components;
    made.values = Buffer<std::byte>(attribute.values.size_bytes());
    if (!made.values.empty()) std::memcpy(made.values.data(), attribute.values.data(), attribute.values.size_bytes());
  }
  for (mesh::Attribute& attribute : added) mesh.attributes.push_back(std::move(attribute));
  mesh.memory.take(std::move(*memory));
  return sampled->out_of_reach;
}

}  // namespace isoextract::convert
