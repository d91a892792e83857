#include "convert/attribute_source.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "field/point_samples.hpp"
#include "files/file_bytes.hpp"
#include "points/attribute_sampling.hpp"
#include "volumes/volume_format.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::convert {
namespace {

constexpr std::array<std::string_view, 3> kAxes{"[x]", "[y]", "[z]"};

bool names_file(const std::string& text) {
  const std::string lower = lower_case(text);
  for (const volumes::VolumeFormat* format : volumes::volume_formats()) {
    const volumes::FormatDescription& about = format->about();
    if (!about.prefix.empty() && text.starts_with(about.prefix)) return true;
    for (const std::string& extension : about.extensions) {
      if (lower.size() > extension.size() && lower.ends_with(extension)) return true;
    }
  }
  std::error_code none;
  const auto status = std::filesystem::status(text, none);
  if (std::filesystem::is_directory(status)) return text.find('/') != std::string::npos;
  return std::filesystem::exists(status);
}

// How a place is read, and what messages call it.
struct Reading {
  std::string input;
  volumes::ReadOptions read;
  std::string shown;
};

Result<Reading> reading_of(const SourceOptions& options, const AttributePlace& place, const Context& context) {
  Reading reading;
  if (place.file.empty()) {
    reading.input = options.input;
    reading.read = options.read;
    reading.read.component.reset();  // these two say what the samples of the surface are
    reading.read.no_data.reset();
  } else {
    reading.input = place.file;
    if (options.read.volume) {
      const auto several = volumes::count_volumes(place.file, {}, context);
      if (!several) return tl::unexpected(several.error());
      if (*several > 1) reading.read.volume = options.read.volume;
    }
  }
  reading.read.grid = place.grid;
  reading.shown = files::shown_input_name(reading.input);
  if (place.grid) reading.shown += fmt::format(": {}", printable(*place.grid));
  return reading;
}

// The grid of vectors that is meant as a whole; empty where a scalar one is.
Result<std::string> vector_grid(const Reading& reading, const Context& context) {
  auto listed = volumes::list_grids(reading.input, reading.read, context);
  if (!listed) return tl::unexpected(std::move(listed.error()));
  const auto is_vector = [](const volumes::GridInfo& grid) { return grid.type.starts_with("vec3"); };
  if (!reading.read.grid) {
    return listed->size() == 1 && is_vector(listed->front()) ? listed->front().label : std::string();
  }
  for (const volumes::GridInfo& grid : *listed) {
    if (is_vector(grid) && (grid.label == *reading.read.grid || grid.name == *reading.read.grid)) return grid.label;
  }
  return std::string();
}

Result<VolumeAttribute> read_volume_attribute(const SourceOptions& options, const AttributeChoice& choice,
                                              const field::ScalarField& input, const Context& context) {
  const AttributePlace place = attribute_place(choice);
  if (place.file.empty() && input.grids == 0) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected a file with grids, of which '{}' would be one, found {}", input.source,
                            printable(choice.from), input.format),
                "an attribute can be read from another file");
  }
  auto reading = reading_of(options, place, context);
  if (!reading) return tl::unexpected(std::move(reading.error()));
  const auto vectors = vector_grid(*reading, context);
  if (!vectors) return tl::unexpected(vectors.error());
  VolumeAttribute attribute;
  attribute.choice = choice;
  const std::size_t count = vectors->empty() ? 1 : kAxes.size();
  for (std::size_t c = 0; c < count; ++c) {
    if (!vectors->empty()) reading->read.grid = *vectors + std::string(kAxes[c]);
    auto field = volumes::read_volume(reading->input, reading->read, context);
    if (!field) return tl::unexpected(std::move(field.error()));
    field->name = reading->shown;
    attribute.components.push_back(std::move(*field));
    if (auto go_on = context.check(); !go_on) return tl::unexpected(std::move(go_on.error()));
  }
  return attribute;
}

// Options say what is read of the input. Hints at them mislead where it is about an attribute, which has none.
Hint hint_of_attribute(Hint hint) {
  switch (hint.remedy) {
    case Remedy::choose_grid:
    case Remedy::choose_grid_number: return "an attribute is one of the file's grids" + hint.text;
    case Remedy::leave_out_grid: return "leave the name of a grid out: there is one volume in the file";
    case Remedy::describe_raw: return "attributes are read from files that say what is in them";
    default: return hint;
  }
}

// The vertices in the world of the input.
Result<std::shared_ptr<ReservedBuffer<glm::dvec3>>> world_positions(const field::Affine& world_from_output,
                                                                    const mesh::Mesh& mesh, const Context& context) {
  auto places = make_reserved_buffer<glm::dvec3>(mesh.positions.size(), context, "places of vertices");
  if (!places) return places;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.positions.size(), 4096), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      (*places)->values[v] = world_from_output(mesh.position(v));
    }
  });
  return places;
}

mesh::Attribute float_attribute(const std::string& name, std::size_t components, std::size_t vertices) {
  mesh::Attribute made;
  made.name = name;
  made.components = components;
  made.values = Buffer<std::byte>(components * vertices * sizeof(float));
  return made;
}

using Records = std::vector<AttributeRecord>;

void take_attributes(std::vector<mesh::Attribute>&& added, Reservation memory, mesh::Mesh& mesh) {
  std::ranges::move(added, std::back_inserter(mesh.attributes));
  mesh.memory.take(std::move(memory));
}

Result<Records> add_of_particles(const ParticleAttributes& source, std::span<const glm::dvec3> places, mesh::Mesh& mesh,
                                 const Context& context) {
  if (places.empty()) {  // there may be no particles either, and so no radius
    for (std::size_t a = 0; a < source.attributes.size(); ++a) {
      const std::size_t components = source.particles.attributes[source.attributes[a]].components;
      mesh.attributes.push_back(float_attribute(source.choices[a].name, components, 0));
    }
    return Records();
  }
  auto sampled = points::sample_attributes(source.particles, source.attributes, places, source.radius,
                                           source.smoothing_length, context);
  if (!sampled) return tl::unexpected(std::move(sampled.error()));
  std::uint64_t bytes = 0;
  for (const points::SampledAttribute& attribute : sampled->attributes) bytes += attribute.values.size_bytes();
  auto memory = context.reserve(bytes, "attributes of vertices");
  if (!memory) return tl::unexpected(std::move(memory.error()));
  Records records;
  std::vector<mesh::Attribute> added;
  for (std::size_t a = 0; a < sampled->attributes.size(); ++a) {
    const points::SampledAttribute& attribute = sampled->attributes[a];
    mesh::Attribute& made =
        added.emplace_back(float_attribute(source.choices[a].name, attribute.components, places.size()));
    if (!made.values.empty()) std::memcpy(made.values.data(), attribute.values.data(), attribute.values.size_bytes());
    AttributeRecord& record = records.emplace_back();
    record.name = made.name;
    record.source = fmt::format("{}: {}", printable(source.particles.label), printable(source.choices[a].from));
    record.components = made.components;
    record.out_of_reach = sampled->out_of_reach;
  }
  take_attributes(std::move(added), std::move(*memory), mesh);
  return records;
}

Result<Records> add_of_volumes(const std::vector<VolumeAttribute>& attributes, std::span<const glm::dvec3> places,
                               mesh::Mesh& mesh, const Context& context) {
  std::size_t components = 0;
  for (const VolumeAttribute& attribute : attributes) components += attribute.components.size();
  auto memory = context.reserve(components * places.size() * sizeof(float), "attributes of vertices");
  if (!memory) return tl::unexpected(std::move(memory.error()));
  Records records;
  std::vector<mesh::Attribute> added;
  for (const VolumeAttribute& attribute : attributes) {
    const std::size_t count = attribute.components.size();
    mesh::Attribute& made = added.emplace_back(float_attribute(attribute.choice.name, count, places.size()));
    const std::span<float> values(reinterpret_cast<float*>(made.values.data()), count * places.size());
    AttributeRecord& record = records.emplace_back();
    record.name = made.name;
    record.source = attribute.components.front().name;
    record.components = count;
    for (std::size_t c = 0; c < count && !places.empty(); ++c) {
      const field::ScalarField& field = attribute.components[c];
      const auto counts = field::sample_points(field, places, values.subspan(c), count, context);
      if (!counts) return tl::unexpected(counts.error());
      if (auto whole = volumes::check_not_lost(field); !whole) return tl::unexpected(std::move(whole.error()));
      record.outside = std::max(record.outside, counts->outside);
      record.not_finite = std::max(record.not_finite, counts->not_finite);
    }
  }
  take_attributes(std::move(added), std::move(*memory), mesh);
  return records;
}

}  // namespace

AttributePlace attribute_place(const AttributeChoice& choice) {
  const std::string& from = choice.from;
  if (from == choice.name) return {{}, from};
  if (names_file(from)) return {from, std::nullopt};
  if (from.ends_with(']')) {
    for (std::size_t at = from.find('['); at != std::string::npos; at = from.find('[', at + 1)) {
      const std::string file = from.substr(0, at);
      if (at > 0 && names_file(file)) return {file, from.substr(at + 1, from.size() - at - 2)};
    }
  }
  return {{}, from};
}

Result<std::vector<VolumeAttribute>> read_volume_attributes(const SourceOptions& options,
                                                            const field::ScalarField& input, const Context& context) {
  std::vector<VolumeAttribute> attributes;
  for (const AttributeChoice& choice : options.attributes) {
    auto attribute = read_volume_attribute(options, choice, input, context);
    if (!attribute) {
      attribute.error().message =
          fmt::format("the attribute '{}': {}", printable(choice.name), attribute.error().message);
      attribute.error().hint = hint_of_attribute(std::move(attribute.error().hint));
      return tl::unexpected(std::move(attribute.error()));
    }
    attributes.push_back(std::move(*attribute));
  }
  return attributes;
}

Result<std::vector<std::filesystem::path>> attribute_files(const SourceOptions& options, const Context& context) {
  std::vector<std::filesystem::path> all;
  for (const AttributeChoice& choice : options.attributes) {
    const AttributePlace place = attribute_place(choice);
    if (place.file.empty()) continue;
    volumes::ReadOptions read;
    read.grid = place.grid;
    auto files = volumes::list_input_files(place.file, read, context);
    if (!files) return files;
    all.insert(all.end(), files->begin(), files->end());
  }
  return all;
}

Result<std::vector<AttributeRecord>> add_attributes(const AttributeSource& source, mesh::Mesh& mesh,
                                                    const Context& context) {
  const auto places = world_positions(source.world_from_output, mesh, context);
  if (!places) return tl::unexpected(places.error());
  const std::span<const glm::dvec3> at = (*places)->values.span();
  const auto* particles = std::get_if<ParticleAttributes>(&source.from);
  auto records = particles != nullptr
                     ? add_of_particles(*particles, at, mesh, context)
                     : add_of_volumes(std::get<std::vector<VolumeAttribute>>(source.from), at, mesh, context);
  if (!records) return records;
  for (AttributeRecord& record : *records) record.vertices = at.size();
  return records;
}

std::vector<std::string> notes_of(const AttributeRecord& record, const std::string& label) {
  const std::string start = fmt::format("{} iso {}: ", label, record.iso);
  std::vector<std::string> notes;
  if (record.outside > 0) {
    notes.push_back(fmt::format("{}{} of {} vertices lie outside of {}; their '{}' is that at its border", start,
                                record.outside, record.vertices, record.source, printable(record.name)));
  }
  if (record.not_finite > 0) {
    notes.push_back(fmt::format("{}the attribute '{}' is no finite number at {} of {} vertices, as {} has some", start,
                                printable(record.name), record.not_finite, record.vertices, record.source));
  }
  return notes;
}

}  // namespace isoextract::convert
