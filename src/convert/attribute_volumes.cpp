#include "convert/attribute_volumes.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "convert/placement.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/volume_format.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

constexpr std::array<std::string_view, 3> kAxes{"[x]", "[y]", "[z]"};

bool names_file(const std::string& text) {
  const std::string lower = to_lower(text);
  for (const volume_io::VolumeFormat* format : volume_io::volume_formats()) {
    const volume_io::FormatDescription& about = format->about();
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

// Returns whether `file` is a path at which no file exists.
bool lacks_file(const std::string& file) {
  std::error_code none;
  return !file.empty() && !file.starts_with(field::kDemoPrefix) && !std::filesystem::exists(file, none);
}

bool is_input_file(const std::string& file, const std::string& input) {
  std::error_code none;
  return file.empty() || file == input || std::filesystem::equivalent(file, input, none);
}

using GridList = std::vector<volume_io::GridInfo>;

bool is_vector(const volume_io::GridInfo& grid) { return grid.type.starts_with("vec3"); }

// Returns the labels of the three scalar grids that are the components of `name`: "vel.x", "vel.y", "vel.z". Houdini
// names unmerged volumes like that. "_" or nothing may stand in place of ".". Returns nullopt unless all three exist.
std::optional<std::array<std::string, 3>> grids_of_axes(const GridList& grids, const std::string& name) {
  for (const std::string_view between : {".", "_", ""}) {
    std::array<std::string, 3> labels;
    for (std::size_t axis = 0; axis < labels.size(); ++axis) {
      const std::string wanted = to_lower(fmt::format("{}{}{}", name, between, "xyz"[axis]));
      const auto is_meant = [&](const volume_io::GridInfo& grid) {
        return !is_vector(grid) && to_lower(grid.name) == wanted && grid.name.starts_with(name);
      };
      if (std::ranges::count_if(grids, is_meant) == 1) labels[axis] = std::ranges::find_if(grids, is_meant)->label;
    }
    if (std::ranges::none_of(labels, &std::string::empty)) return labels;
  }
  return std::nullopt;
}

// Returns whether the file has neither the grid, nor the vector grid that would contain it, nor the three grids of its
// components. Returns false if the file cannot be read.
bool lacks_grid(const SourceOptions& options, const AttributeLocation& place, const Context& context) {
  if (!place.grid) return false;
  const bool of_input = is_input_file(place.file, options.input);
  const auto listed = volume_io::list_grids(of_input ? options.input : place.file,
                                            of_input ? options.read : volume_io::ReadOptions(), context);
  const std::string whole = place.grid->substr(0, place.grid->rfind('['));
  const auto is_meant = [&](const volume_io::GridInfo& grid) {
    return grid.matches_name(*place.grid) || grid.matches_name(whole);
  };
  return listed && std::ranges::none_of(*listed, is_meant) && !grids_of_axes(*listed, *place.grid);
}

// Input and options for reading one attribute, and the name that messages use.
struct Reading {
  std::string input;
  volume_io::ReadOptions read;
  std::string shown;
};

volume_io::ReferenceVolume beside(const field::ScalarField& input, const AttributeChoice& choice) {
  volume_io::ReferenceVolume other;
  other.source = input.source;
  if (const auto* dense = std::get_if<field::DenseSamples>(&input.samples)) other.dims = dense->dims;
  other.index_to_world = input.index_to_world;
  other.spacing = choice.spacing;
  other.origin = choice.origin;
  return other;
}

Result<Reading> reading_of(const SourceOptions& options, const AttributeChoice& choice, const AttributeLocation& place,
                           const field::ScalarField& input, const Context& context) {
  Reading reading;
  if (is_input_file(place.file, options.input)) {
    reading.input = options.input;
    reading.read = options.read;
  } else {
    reading.input = place.file;
    const auto format = TRY(volume_io::format_of(place.file, {}, context));
    if (format.has_axis_order) reading.read.axis_order = options.read.axis_order;
    if (options.read.volume) {
      const auto several = TRY(volume_io::count_volumes(place.file, reading.read, context));
      if (several > 1) reading.read.volume = options.read.volume;
    }
  }
  reading.read.grid = place.grid;
  if (choice.volume) reading.read.volume = choice.volume;
  reading.read.component = choice.component;
  if (choice.spacing) reading.read.spacing = choice.spacing;
  if (choice.origin) reading.read.origin = choice.origin;
  reading.read.beside = beside(input, choice);
  reading.read.no_data = choice.no_data ? choice.no_data : options.read.no_data;
  reading.read.no_data_for_dense_only = true;
  reading.shown = files::input_label(reading.input);
  if (choice.volume) reading.shown += fmt::format(":volume={}", *choice.volume);
  if (place.grid) reading.shown += fmt::format(": {}", printable(*place.grid));
  return reading;
}

// Notes that an attribute of the input's shape states another placement: either placement may be wrong.
void note_other_place(const field::ScalarField& input, VolumeAttribute& attribute) {
  const field::ScalarField& field = attribute.components.front();
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  const auto* of_input = std::get_if<field::DenseSamples>(&input.samples);
  if (dense == nullptr || of_input == nullptr || dense->dims != of_input->dims) return;
  if (attribute.choice.spacing || attribute.choice.origin || field.index_to_world == input.index_to_world) return;
  attribute.notes.push_back(
      {NoteId::attribute_placement,
       fmt::format(
           "{} and {} have equal dimensions but different placements; the conversion uses the placement of each file",
           field.source, input.source)});
}

// Returns the file's name for its world and unit: "LPS, mm".
std::string world_text(const field::ScalarField& field) {
  std::string text = printable(field.world_space, 40);
  if (field.length_unit.empty()) return text;
  return fmt::format("{}{}{}", text, text.empty() ? "" : ", ", printable(field.length_unit, 40));
}

// Moves an attribute into the input's world if the two files state different patient spaces or units.
void move_to_world_of(const field::ScalarField& input, VolumeAttribute& attribute) {
  const field::ScalarField& first = attribute.components.front();
  if (attribute.choice.spacing || attribute.choice.origin || first.source == input.source) return;
  const auto map = map_between_worlds(first, input);
  if (!map) return;
  attribute.notes.push_back(
      {NoteId::attribute_placement,
       fmt::format("{} states world coordinates in {}; the conversion transforms them to the world of {}, {}",
                   first.source, world_text(first), input.source, world_text(input))});
  for (field::ScalarField& field : attribute.components) field.index_to_world = map->after(field.index_to_world);
}

// The three grids that hold the components of a vector.
struct VectorGrids {
  std::array<std::string, 3> components;
  std::optional<AttributeKind> stated_kind;
  bool in_voxels = false;
};

// Returns the components of the chosen vector grid, or else the three scalar grids of its axes. Returns nullopt if the
// choice means a scalar grid.
Result<std::optional<VectorGrids>> vector_grids(const Reading& reading, const Context& context) {
  const auto listed = TRY(volume_io::list_grids(reading.input, reading.read, context));
  const std::optional<std::string>& wanted = reading.read.grid;
  if (!wanted && listed.size() != 1) return std::nullopt;
  bool is_there = !wanted;
  for (const volume_io::GridInfo& grid : listed) {
    if (wanted && !grid.matches_name(*wanted)) continue;
    is_there = true;
    if (!is_vector(grid)) continue;
    VectorGrids vectors{{}, grid.kind_of_vectors, grid.vectors_in_voxels};
    std::ranges::transform(kAxes, vectors.components.begin(),
                           [&](std::string_view axis) { return grid.label + std::string(axis); });
    return vectors;
  }
  auto of_axes = is_there ? std::nullopt : grids_of_axes(listed, *wanted);
  if (!of_axes) return std::nullopt;
  return VectorGrids{std::move(*of_axes), std::nullopt, false};
}

// Returns the grid that `read` chooses; nothing if there is none, several, or an error, which reading reports.
std::optional<volume_io::GridInfo> listed_grid(const std::string& input, const volume_io::ReadOptions& read,
                                               const Context& context) {
  const auto listed = volume_io::list_grids(input, read, context);
  if (!listed) return std::nullopt;
  const auto is_meant = [&](const volume_io::GridInfo& grid) {
    return grid.scalar && (!read.grid || grid.matches_name(*read.grid));
  };
  if (std::ranges::count_if(*listed, is_meant) != 1) return std::nullopt;
  return *std::ranges::find_if(*listed, is_meant);
}

// Returns the number of components if the grid's samples have two to four and the choice names none of them. An array
// of four axes holds vectors or volumes: it holds vectors if its grid then has the input's shape and the choice names
// no volume. Sets the options that read vectors.
std::optional<std::uint64_t> vector_size(const AttributeChoice& choice, const field::ScalarField& input,
                                         const Context& context, Reading& reading) {
  constexpr std::uint64_t kMost = 4;
  if (choice.component) return std::nullopt;
  const auto fits = [](std::uint64_t components) { return components > 1 && components <= kMost; };
  const auto plain = listed_grid(reading.input, reading.read, context);
  if (!plain || plain->components > 1) {
    return plain && fits(plain->components) ? std::optional(plain->components) : std::nullopt;
  }
  const auto* dense = std::get_if<field::DenseSamples>(&input.samples);
  if (plain->volumes == 1 || choice.volume || dense == nullptr) return std::nullopt;
  volume_io::ReadOptions read = reading.read;
  read.volume.reset();
  read.component = volume_io::ComponentChoice{0};
  const auto vectors = listed_grid(reading.input, read, context);
  const bool is_vector = vectors && fits(vectors->components) && vectors->volumes == 1 &&
                         vectors->box == field::IndexBox{glm::ivec3(0), dense->dims - 1};
  if (!is_vector) return std::nullopt;
  reading.read = std::move(read);
  return vectors->components;
}

Result<VolumeAttribute> read_volume_attribute(const SourceOptions& options, const AttributeChoice& choice,
                                              const field::ScalarField& input, const Context& context) {
  const AttributeLocation place = attribute_location(choice);
  if (place.file.empty() && input.grids == 0) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a file with grids, to read the attribute from its grid '{}', found {}",
                            input.source, printable(choice.from), input.format),
                "name the file that has the attribute: NAME=FILE");
  }
  auto reading = TRY(reading_of(options, choice, place, input, context));
  const auto vectors = TRY(vector_grids(reading, context));
  VolumeAttribute attribute;
  attribute.choice = choice;
  const std::optional<VectorGrids>& whole = vectors;
  const auto size = whole ? std::nullopt : vector_size(choice, input, context, reading);
  const std::size_t count = whole ? kAxes.size() : static_cast<std::size_t>(size.value_or(1));
  if (whole) {
    attribute.stated_kind = whole->stated_kind;
    attribute.in_voxels = whole->in_voxels;
  }
  for (std::size_t c = 0; c < count; ++c) {
    if (whole) reading.read.grid = whole->components[c];
    if (size) reading.read.component = volume_io::ComponentChoice{static_cast<std::int64_t>(c)};
    auto field = TRY(volume_io::read_volume(reading.input, reading.read, context));
    field.name = reading.shown;
    attribute.components.push_back(std::move(field));
    TRY(context.check());
  }
  attribute.notes = attribute.components.front().notes;
  move_to_world_of(input, attribute);
  note_other_place(input, attribute);
  return attribute;
}

// Returns whether a setting reads the input only: there is none like it for the file of an attribute.
bool is_of_input(const Step& step) {
  constexpr std::array kOfInput{Setting::particle_method, Setting::height_field, Setting::even_spacing, Setting::level,
                                Setting::input_format};
  return std::ranges::find(kOfInput, step.setting) != kOfInput.end();
}

// Says what the attribute can be read from.
std::string fitting_volume(const AttributeChoice& choice, const field::ScalarField& input) {
  std::string text = fmt::format("give the attribute '{}' the file of a volume", printable(choice.name));
  if (const auto* dense = std::get_if<field::DenseSamples>(&input.samples)) {
    text += fmt::format(", such as one with the {} x {} x {} samples of {} along x, y and z", dense->dims.x,
                        dense->dims.y, dense->dims.z, input.source);
  }
  return text;
}

// Rewords hints about options of the input as hints about the settings of an attribute, which are different ones.
Hint hint_of_attribute(Hint hint, const AttributeChoice& choice, const field::ScalarField& input) {
  if (std::erase_if(hint.steps, is_of_input) > 0) hint.steps.emplace_back(fitting_volume(choice, input));
  for (Step& step : hint.steps) {
    switch (step.setting) {
      case Setting::grid:
        step = step.remedy == Remedy::choose ? "choose one of the file's grids for the attribute" + step.text
                                             : "leave the name of a grid out: " + step.text;
        break;
      case Setting::raw_layout:
        step = "use a file format that states dimensions and sample type: an attribute cannot come from a raw file";
        break;
      case Setting::volume: step.setting = Setting::attribute_volume; break;
      case Setting::component: step.setting = Setting::attribute_component; break;
      case Setting::spacing_and_origin: step.setting = Setting::attribute_spacing_and_origin; break;
      default: break;
    }
  }
  return hint;
}

}  // namespace

AttributeLocation attribute_location(const AttributeChoice& choice) {
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

Result<VolumeAttributes> read_volume_attributes(const SourceOptions& options, const field::ScalarField& input,
                                                bool allow_missing, const Context& context) {
  VolumeAttributes attributes;
  for (const AttributeChoice& choice : options.attributes) {
    auto attribute = read_volume_attribute(options, choice, input, context);
    if (attribute) {
      attributes.found.push_back(std::move(*attribute));
      continue;
    }
    Error& error = attribute.error();
    error.message = fmt::format("the attribute '{}': {}", printable(choice.name), error.message);
    error.hint = hint_of_attribute(std::move(error.hint), choice, input);
    const AttributeLocation place = attribute_location(choice);
    const bool is_missing = lacks_file(place.file) || lacks_grid(options, place, context);
    if (!is_missing || !(allow_missing || choice.optional)) return tl::unexpected(std::move(error));
    attributes.missing.push_back({choice, std::move(error)});
  }
  return attributes;
}

Result<std::vector<std::filesystem::path>> attribute_files(const SourceOptions& options, const Context& context) {
  std::vector<std::filesystem::path> all;
  for (const AttributeChoice& choice : options.attributes) {
    const AttributeLocation place = attribute_location(choice);
    if (place.file.empty() || lacks_file(place.file)) continue;
    volume_io::ReadOptions read;
    read.grid = place.grid;
    auto files = volume_io::list_input_files(place.file, read, context);
    if (!files) return files;
    all.insert(all.end(), files->begin(), files->end());
  }
  return all;
}

}  // namespace isoextract::convert
