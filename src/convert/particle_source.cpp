#include "convert/particle_source.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "convert/attribute_source.hpp"
#include "convert/detail/mesh_source.hpp"
#include "convert/particle_choice.hpp"
#include "convert/simulation_box.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "points/sphere_set.hpp"

namespace isoextract::convert {
namespace {

using Format = std::optional<particle_io::ParticleFormatDescription>;

// Rejects options of volumes, which have no effect on particles.
Result<void> check_no_volume_options(const SourceOptions& options, const Format& format) {
  const volume_io::ReadOptions& read = options.read;
  std::string given;
  const auto add = [&](bool is_given, std::string_view setting) {
    if (is_given) given += fmt::format("{}{}", given.empty() ? "" : ", ", setting);
  };
  add(read.grid && !(format && format->has_grids), "grid");
  add(read.raw.has_value(), "layout");
  add(read.component.has_value(), "component");
  add(read.axis_order.has_value(), "axis order");
  add(read.no_data.has_value(), "no-data value");
  add(read.spacing.has_value(), "spacing");
  add(read.origin.has_value(), "origin");
  add(read.kind || options.away_from_zero, "inside");
  if (given.empty()) return {};
  return fail(ErrorCode::usage,
              fmt::format("{}: the input has particles, which do not have these settings of volumes: {}",
                          files::input_label(options.input), given),
              {Remedy::leave_out, Setting::volume_options});
}

Format particle_format(const std::string& id) {
  const auto formats = particle_io::particle_format_descriptions();
  const auto found = std::ranges::find(formats, id, &particle_io::ParticleFormatDescription::id);
  return found == formats.end() ? Format() : Format(*found);
}

Result<std::vector<std::filesystem::path>> list_mask_files(const SourceOptions& options, const Context& context) {
  std::vector<std::filesystem::path> files;
  for (const std::string& mask : options.masks) {
    const auto of_mask = TRY(volume_io::list_input_files(mask, options.read, context));
    files.insert(files.end(), of_mask.begin(), of_mask.end());
  }
  return files;
}

}  // namespace

Result<bool> is_particles(const SourceOptions& options, const Context& context) {
  if (options.read.flat || options.mesh || !options.masks.empty()) return false;
  const bool expected = options.particles.expected;
  const auto volume = TRY(volume_io::is_certainly_volume(options.input, options.read, context));
  if (volume && !expected && options.read.format) return false;
  Format particles;
  if (options.read.format) {
    particles = particle_format(*options.read.format);
  } else if (!options.read.raw && !options.input.starts_with(field::kDemoPrefix)) {
    auto detected = particle_io::detect_particles(options.input, particle_read_options(options), context);
    if (!detected && volume && !expected) return false;
    if (!detected) return tl::unexpected(std::move(detected.error()));
    particles = std::move(*detected);
  }
  // The content or the name of the chosen grid decides if the format holds both volumes and points.
  if (volume && !expected && !(particles && particles->has_grids)) return false;
  if (!particles && volume) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: expected particles, because the options or the output are for particles; found a volume",
                    files::input_label(options.input)),
        Hint{{Remedy::leave_out, Setting::particle_options}, {Remedy::change, Setting::output_name}});
  }
  if (!particles && !expected) return false;  // the reader's message says best what the file is not
  TRY(check_no_volume_options(options, particles));
  return true;
}

Result<std::vector<std::filesystem::path>> list_source_files(const SourceOptions& options, const Context& context) {
  if (options.mesh) return list_mesh_files(options.input, context);
  const auto particles = TRY(is_particles(options, context));
  if (particles) return std::vector<std::filesystem::path>{options.input};
  auto files = options.masks.empty() ? volume_io::list_input_files(options.input, options.read, context)
                                     : list_mask_files(options, context);
  if (!files) return files;
  auto more = attribute_files(options, context);
  if (!more) return more;
  files->insert(files->end(), more->begin(), more->end());
  return files;
}

Result<std::vector<files::FilePart>> list_source_parts(const SourceOptions& options, const Context& context) {
  if (options.mesh) {
    std::vector<files::FilePart> parts;
    for (const std::filesystem::path& file : list_mesh_files(options.input, context)) parts.push_back({file, {}});
    return parts;
  }
  const auto particles = TRY(is_particles(options, context));
  if (particles) {
    auto part = TRY(particle_io::find_frame_part(options.input, particle_read_options(options), context));
    return std::vector{std::move(part)};
  }
  if (!options.masks.empty()) {
    std::vector<files::FilePart> whole;
    const auto masks = TRY(list_mask_files(options, context));
    for (const std::filesystem::path& file : masks) whole.push_back({file, {}});
    return whole;
  }
  auto parts = volume_io::list_input_parts(options.input, options.read, context);
  if (!parts) return parts;
  const auto more = TRY(attribute_files(options, context));
  for (const std::filesystem::path& file : more) parts->push_back({file, {}});
  return parts;
}

Result<FrameList> list_frames(const SourceOptions& options, const Context& context) {
  const auto particles = TRY(is_particles(options, context));
  if (!particles) return FrameList{TRY(volume_io::count_volumes(options.input, options.read, context))};
  particle_io::ParticleReadOptions read = particle_read_options(options);
  read.frame.reset();
  auto info = TRY(particle_io::list_particles(options.input, read, context));
  return FrameList{info.frames, std::move(info.times), std::move(info.notes)};
}

Result<particle_io::FrameTime> find_frame_time(const SourceOptions& options, const Context& context) {
  const auto particles = TRY(is_particles(options, context));
  if (!particles) return particle_io::FrameTime();
  return particle_io::find_frame_time(options.input, particle_read_options(options), context);
}

particle_io::ParticleReadOptions particle_read_options(const SourceOptions& options, bool allow_missing) {
  particle_io::ParticleReadOptions read;
  read.format = options.read.format;
  read.frame = options.read.volume;
  read.grid = options.read.grid;
  for (const AttributeChoice& choice : options.attributes) {
    std::vector<std::string>& names = choice.optional || allow_missing ? read.optional_attributes : read.attributes;
    if (std::ranges::find(names, choice.from) == names.end()) names.push_back(choice.from);
  }
  read.columns = options.particles.columns;
  read.condition = attributes_of_condition(options.particles);
  if (options.particles.simulation_box.unwrap) {
    // Optional, so that apply_box_options() says why they are missing.
    for (const char* flag : kImageFlags) {
      if (std::ranges::find(read.attributes, flag) == read.attributes.end())
        read.optional_attributes.emplace_back(flag);
    }
  }
  if (!options.particles.radius && !options.particles.element_radii) {
    read.first_scalar_of.assign(points::kRadiusAttributes.begin(), points::kRadiusAttributes.end());
  }
  return read;
}

points::FieldOptions field_options(const SourceOptions& options, std::optional<double> only_iso) {
  const ParticleOptions& particles = options.particles;
  points::FieldOptions field;
  field.method = particles.method;
  field.radius = particles.radius;
  field.suggested_radius = particles.sequence_radius;
  field.cell_size = particles.cell_size;
  field.smoothing_length = particles.smoothing_length;
  field.weight = particles.weight;
  field.deposit = particles.deposit;
  field.non_finite = particles.non_finite;
  field.tile_iso = only_iso;
  field.margin = filter_reach(options);
  return field;
}

Result<FoundAttributes> find_attributes(const points::ParticleSet& particles,
                                        const std::vector<AttributeChoice>& choices, bool allow_missing) {
  FoundAttributes found;
  for (const AttributeChoice& choice : choices) {
    if (choice.says_how_to_read()) {
      return fail(
          ErrorCode::usage,
          fmt::format("{}: the attribute '{}' has a setting for volumes (spacing, origin, no-data value, volume or "
                      "component), but the input has particles",
                      particles.label, printable(choice.name)),
          "leave ':spacing=', ':origin=', ':nodata=', ':volume=' and ':component=' out");
    }
    const std::string& name = choice.from;
    const auto at = std::ranges::find(particles.attributes, name, &points::ParticleAttribute::name);
    if (at == particles.attributes.end()) {
      Error error{
          ErrorCode::input,
          fmt::format("{}: expected an attribute '{}', found none of that name", particles.label, printable(name)),
          {}};
      if (!choice.optional && !allow_missing) return tl::unexpected(std::move(error));
      found.missing.push_back({choice, std::move(error)});
      continue;
    }
    if (at->components > mesh::kMaxComponents) {
      return fail(
          ErrorCode::input,
          fmt::format("{}: expected at most {} components, the limit of a vertex attribute; the attribute '{}' has {}",
                      particles.label, mesh::kMaxComponents, printable(name), at->components),
          {Remedy::leave_out, Setting::attribute});
    }
    found.choices.push_back(choice);
    found.attributes.push_back(static_cast<std::size_t>(at - particles.attributes.begin()));
  }
  return found;
}

}  // namespace isoextract::convert
