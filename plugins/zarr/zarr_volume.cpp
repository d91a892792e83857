#include "zarr_volume.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "zarr_images.hpp"

namespace isoextract_zarr {
namespace {

using isoextract_plugin::Grid;

constexpr std::uint64_t kMostChannels = 1024;
constexpr std::uint64_t kMostChunkFiles = 10000;
constexpr std::array<Axis::Kind, 3> kSpace{Axis::Kind::x, Axis::Kind::y, Axis::Kind::z};

// Units of length that OME-Zarr names, in picometers, which makes the ratios of metric units exact.
constexpr std::array<std::pair<std::string_view, double>, 12> kUnits{{{"angstrom", 1e2},
                                                                      {"picometer", 1},
                                                                      {"nanometer", 1e3},
                                                                      {"micrometer", 1e6},
                                                                      {"millimeter", 1e9},
                                                                      {"centimeter", 1e10},
                                                                      {"decimeter", 1e11},
                                                                      {"meter", 1e12},
                                                                      {"kilometer", 1e15},
                                                                      {"inch", 25.4e9},
                                                                      {"foot", 304.8e9},
                                                                      {"yard", 914.4e9}}};

// Returns 0 for an unknown unit.
double picometers_of(const std::string& unit) {
  const auto* const found = std::ranges::find(kUnits, unit, [](const auto& entry) { return entry.first; });
  return found == kUnits.end() ? 0 : found->second;
}

// The image and channel that hold a grid's samples.
struct Source {
  std::size_t image = 0;
  std::uint64_t channel = 0;
};

ArrayBox box_of(const Image& image, std::uint64_t channel, std::uint64_t volume) {
  ArrayBox box;
  box.fixed.assign(image.axes.size(), 0);
  for (std::size_t i = 0; i < 3; ++i) {
    box.axes[i] = image.axis_of(kSpace[i]);
    box.count[i] = image.length_of(kSpace[i]);
  }
  if (const int axis = image.axis_of(Axis::Kind::channel); axis != kNoAxis) {
    box.fixed[static_cast<std::size_t>(axis)] = channel;
  }
  if (const int axis = image.axis_of(Axis::Kind::time); axis != kNoAxis) {
    box.fixed[static_cast<std::size_t>(axis)] = volume;
  }
  return box;
}

// Returns why no surface can be extracted from an image; empty if one can.
std::string problem_of(const Image& image) {
  std::string problem = image.array.metadata.unsupported_feature;
  for (std::size_t i = 0; problem.empty() && i < image.axes.size(); ++i) {
    if (image.axes[i].kind != Axis::Kind::other || image.array.metadata.shape[i] == 1) continue;
    const std::string& name = image.axes[i].name;
    problem = fmt::format("an axis '{}' that is neither space, time nor channel",
                          name.empty() ? std::to_string(i) : shown(name));
  }
  if (problem.empty()) return problem;
  return fmt::format("the array '{}' has {}, which this reader does not support", shown(image.array.path), problem);
}

// Sets the placement. Converts all axes to one unit: the first that x, y or z states.
void place(const Image& image, Grid& grid, std::vector<std::string>& notes) {
  grid.has_placement = image.has_placement;
  std::string unit;
  for (std::size_t row = 0; row < 3; ++row) {
    const int axis = image.axis_of(kSpace[row]);
    if (axis == kNoAxis) continue;
    const auto at = static_cast<std::size_t>(axis);
    const std::string& own = image.axes[at].unit;
    if (unit.empty()) unit = own;
    double factor = 1;
    if (own != unit && !own.empty()) {
      if (picometers_of(own) > 0 && picometers_of(unit) > 0) {
        factor = picometers_of(own) / picometers_of(unit);
        notes.push_back(
            fmt::format("the reader converts axis '{}' from {} to {}", shown(image.axes[at].name), own, unit));
      } else {
        notes.push_back(fmt::format("the reader does not convert axis '{}' from '{}' to '{}'",
                                    shown(image.axes[at].name), shown(own), shown(unit)));
      }
    }
    grid.index_to_world[4 * row + row] = image.scale[at] * factor;
    grid.index_to_world[4 * row + 3] = image.translation[at] * factor;
  }
  grid.length_unit = unit;
}

void set_times(const Image& image, Grid& grid) {
  const int axis = image.axis_of(Axis::Kind::time);
  if (axis == kNoAxis) return;
  constexpr std::uint64_t kMostTimes = std::uint64_t{1} << 20;
  const auto at = static_cast<std::size_t>(axis);
  grid.volumes = image.array.metadata.shape[at];
  grid.time_unit = image.axes[at].unit;
  const bool is_stated = image.scale[at] != 1 || image.translation[at] != 0 || !grid.time_unit.empty();
  if (!image.times.empty()) {
    grid.volume_times = image.times;
  } else if (is_stated && grid.volumes <= kMostTimes) {
    for (std::uint64_t volume = 0; volume < grid.volumes; ++volume) {
      grid.volume_times.push_back(image.scale[at] * static_cast<double>(volume) + image.translation[at]);
    }
  }
}

// Names of an image's channels: those of its metadata if they are all there and different, otherwise c0, c1, ...
std::vector<std::string> channel_names(const Image& image) {
  const std::uint64_t count = image.length_of(Axis::Kind::channel);
  std::vector<std::string> names = image.channel_names;
  names.resize(count);
  const std::set<std::string> different(names.begin(), names.end());
  if (count == 1 || (different.size() == count && !different.contains(""))) return names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = fmt::format("c{}", i);
  return names;
}

class ZarrFile final : public isoextract_plugin::VolumeFile {
 public:
  ZarrFile(std::unique_ptr<Store> store, std::uint64_t volume, std::uint64_t level, const isoextract_plugin_host& host)
      : store_(std::move(store)) {
    Hierarchy hierarchy(*store_, host);
    Images found = find_images(hierarchy, level);
    format = found.format;
    creator = found.creator;
    images_ = std::move(found.images);
    if (std::ranges::all_of(images_, [](const Image& image) { return !problem_of(image).empty(); })) {
      throw ReadError(problem_of(images_.front()));
    }
    for (std::size_t i = 0; i < images_.size(); ++i) add_image(i, found.notes);
    files.assign(hierarchy.files().begin(), hierarchy.files().end());
    add_chunk_files(volume, found.notes);
    for (const std::string& text : found.notes) note += (note.empty() ? "" : "; ") + text;
  }

  isoextract_plugin::ReadFacts read(const isoextract_volume_selection& selection,
                                    const isoextract_plugin_host& host) override {
    const Source& source = sources_.at(selection.grid);
    const Image& image = images_[source.image];
    ArrayBox box = box_of(image, source.channel, selection.volume);
    const std::uint64_t parts = count_chunks(image.array, box);
    std::copy_n(selection.first, 3, box.first.begin());
    std::copy_n(selection.count, 3, box.count.begin());
    const Conversion conversion{selection.component, image.slope, image.intercept};
    const ChunkCount count = read_box(*store_, image.array, box, conversion, selection.box, host);
    isoextract_plugin::ReadFacts facts;
    facts.parts_read = count.read;
    facts.parts = parts;
    return facts;
  }

 private:
  void add_image(std::size_t index, std::vector<std::string>& notes) {
    const Image& image = images_[index];
    const DataType& type = image.array.metadata.type;
    Grid grid;
    grid.type_name = type.name;
    for (std::size_t i = 0; i < 3; ++i) grid.dims[i] = image.length_of(kSpace[i]);
    grid.slope = image.slope;
    grid.intercept = image.intercept;
    if (const std::string problem = problem_of(image); problem.empty()) {
      grid.sample_type = sample_type_of(type);
    } else {
      notes.push_back(problem);
    }
    if (type.kind == DataType::Kind::complex) {
      grid.components = 2;
      grid.component_names = "real imaginary";
    }
    place(image, grid, notes);
    set_times(image, grid);
    grid.labels = image.labels;
    const std::uint64_t channels = image.length_of(Axis::Kind::channel);
    if (channels > kMostChannels) {
      notes.push_back(fmt::format("the reader lists only the first {} of {} channels of '{}'", kMostChannels, channels,
                                  shown(image.name)));
    }
    const std::vector<std::string> names = channels > kMostChannels ? std::vector<std::string>() : channel_names(image);
    for (std::uint64_t channel = 0; channel < std::min(channels, kMostChannels); ++channel) {
      const std::string name = names.empty() ? fmt::format("c{}", channel) : names[channel];
      // Uses the name of a single channel only if the image has no name.
      grid.name = channels == 1 && !image.name.empty() ? image.name : join(image.name, name);
      grids.push_back(grid);
      sources_.push_back({index, channel});
    }
  }

  // Adds the chunk files of the volume that will be read, if there are at most kMostChunkFiles.
  void add_chunk_files(std::uint64_t volume, std::vector<std::string>& notes) {
    std::set<std::string> chunk_files;  // channels may share chunks
    std::uint64_t left = kMostChunkFiles;
    for (std::size_t i = 0; i < grids.size(); ++i) {
      if (grids[i].sample_type == ISOEXTRACT_NOT_SCALAR || volume >= grids[i].volumes) continue;
      const Image& image = images_[sources_[i].image];
      const ArrayBox box = box_of(image, sources_[i].channel, volume);
      const bool are_few = visit_chunk_keys(image.array, box, left, [&](const std::string& key) {
        --left;
        const std::string file = store_->file_of(key);
        if (!file.empty() && store_->find(key) != nullptr) chunk_files.insert(file);
      });
      if (!are_few && !store_->file_of("").empty()) {
        notes.push_back(
            fmt::format("a resumed batch notices changes of the metadata only, because there are more than {} chunks",
                        kMostChunkFiles));
        break;
      }
    }
    files.insert(files.end(), chunk_files.begin(), chunk_files.end());
  }

  std::unique_ptr<Store> store_;
  std::vector<Image> images_;
  std::vector<Source> sources_;
};

}  // namespace

std::unique_ptr<isoextract_plugin::VolumeFile> open_hierarchy(std::unique_ptr<Store> store, std::uint64_t volume,
                                                              std::uint64_t level, const isoextract_plugin_host& host) {
  return std::make_unique<ZarrFile>(std::move(store), volume, level, host);
}

}  // namespace isoextract_zarr
