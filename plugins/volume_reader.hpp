// Shared code of plug-ins that read volumes, in C++: a plug-in derives from VolumeFile, and volume_plugin() makes the
// table of C functions (volume_plugin.h) of it. Everything here may throw; the C functions turn exceptions into error
// texts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <volume_plugin.h>

namespace isoextract_plugin {

// Why a file cannot be read: what was expected and what was found, without the file's name.
struct ReadError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The samples are spaced unevenly, and Request::resamples is not set.
struct UnevenError : ReadError {
  using ReadError::ReadError;
};

// Memory that is reserved in the host, and released when this object ends.
class HostMemory {
 public:
  explicit HostMemory(const isoextract_plugin_host& host) : host_(host) {}
  HostMemory(const HostMemory&) = delete;
  HostMemory& operator=(const HostMemory&) = delete;
  ~HostMemory() {
    if (bytes_ > 0) host_.release(host_.self, bytes_);
  }

  // Throws std::bad_alloc if the host refuses.
  void take(std::uint64_t bytes) {
    if (bytes == 0) return;
    if (host_.reserve(host_.self, bytes) != 0) throw std::bad_alloc();
    bytes_ += bytes;
  }
  // Leaves the memory reserved until the host frees the call's results.
  void keep() { bytes_ = 0; }

 private:
  const isoextract_plugin_host& host_;
  std::uint64_t bytes_ = 0;
};

// Throws if the host wants the call to end.
inline void check_cancelled(const isoextract_plugin_host& host) {
  if (host.is_cancelled(host.self) != 0) throw ReadError("cancelled");
}

struct Label {
  std::int64_t value = 0;
  std::string name;
  std::array<double, 3> color{};
  bool has_color = false;
};

// Members as in isoextract_volume_grid. volume_times has no effect unless it has one time for each volume.
struct Grid {
  std::string name;
  std::string type_name;
  std::string world_space;
  std::string length_unit;
  std::int32_t sample_type = ISOEXTRACT_NOT_SCALAR;
  std::int32_t kind = ISOEXTRACT_DENSITY;
  bool is_sampled = false;
  bool has_placement = true;
  std::array<std::uint64_t, 3> dims{};
  std::array<double, 12> index_to_world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  double slope = 1;
  double intercept = 0;
  std::uint64_t components = 1;
  std::string component_names;
  std::uint64_t volumes = 1;
  std::vector<double> volume_times;
  std::string time_unit;
  std::vector<Label> labels;
};

// Facts about a read besides the samples.
struct ReadFacts {
  std::string note;
  std::uint64_t parts_read = 0;
  std::uint64_t parts = 0;
};

// An opened file. The constructor of a derived class fills the members; read() reads samples.
class VolumeFile {
 public:
  VolumeFile() = default;
  VolumeFile(const VolumeFile&) = delete;
  VolumeFile& operator=(const VolumeFile&) = delete;
  virtual ~VolumeFile() = default;

  std::string format;
  std::string creator;
  std::string note;
  std::vector<Grid> grids;
  std::vector<std::string> files;

  // Fills selection.box. The selection has been checked against the grid.
  virtual ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) = 0;
};

// The request as C++ values.
struct Request {
  std::string path;
  std::vector<std::string> files;
  std::uint64_t volume = 0;
  std::uint64_t level = 0;
  std::array<double, 3> spacing{};
  bool resamples = false;
};

inline std::uint64_t sample_size(std::int32_t type) {
  switch (type) {
    case ISOEXTRACT_U8:
    case ISOEXTRACT_I8: return 1;
    case ISOEXTRACT_U16:
    case ISOEXTRACT_I16:
    case ISOEXTRACT_F16: return 2;
    case ISOEXTRACT_U32:
    case ISOEXTRACT_I32:
    case ISOEXTRACT_F32: return 4;
    case ISOEXTRACT_F64: return 8;
    default: throw ReadError("expected samples of a known type, found type " + std::to_string(type));
  }
}

// Returns the sample type of a selection's box: the type of the grid, or a float type for lengths of vectors.
inline std::int32_t selected_type(const Grid& grid, const isoextract_volume_selection& selection) {
  if (selection.component != ISOEXTRACT_COMPONENT_LENGTH) return grid.sample_type;
  const bool wide =
      grid.sample_type == ISOEXTRACT_F64 || grid.sample_type == ISOEXTRACT_I32 || grid.sample_type == ISOEXTRACT_U32;
  return wide ? ISOEXTRACT_F64 : ISOEXTRACT_F32;
}

// Calls use(T{}) with the C++ type of samples; T is std::uint16_t for half floats, whose bits are only copied.
template <class F>
decltype(auto) with_sample_type(std::int32_t type, F&& use) {
  switch (type) {
    case ISOEXTRACT_U8: return use(std::uint8_t{});
    case ISOEXTRACT_I8: return use(std::int8_t{});
    case ISOEXTRACT_U16:
    case ISOEXTRACT_F16: return use(std::uint16_t{});
    case ISOEXTRACT_I16: return use(std::int16_t{});
    case ISOEXTRACT_U32: return use(std::uint32_t{});
    case ISOEXTRACT_I32: return use(std::int32_t{});
    case ISOEXTRACT_F32: return use(float{});
    case ISOEXTRACT_F64: return use(double{});
    default: throw ReadError("expected samples of a known type, found type " + std::to_string(type));
  }
}

// Samples of a grid in memory. Component c of sample (i, j, k) is the element i * step[0] + j * step[1] + k * step[2] +
// c * component_step of `data`.
struct SamplesInMemory {
  const void* data = nullptr;
  std::array<std::int64_t, 3> step{};
  std::int64_t component_step = 1;
};

// Returns the layout of a box of samples with x fastest and the components of a sample beside each other.
inline SamplesInMemory interleaved_samples(const void* data, const std::array<std::uint64_t, 3>& dims,
                                           std::uint64_t components) {
  const auto c = static_cast<std::int64_t>(components);
  const auto x = static_cast<std::int64_t>(dims[0]);
  const auto y = static_cast<std::int64_t>(dims[1]);
  return {data, {c, c * x, c * x * y}, 1};
}

namespace detail {

template <class T, class Use>
void visit_box(const SamplesInMemory& from, const isoextract_volume_selection& selection, Use&& use) {
  const T* const data = static_cast<const T*>(from.data);
  std::size_t to = 0;
  for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
    for (std::uint64_t y = 0; y < selection.count[1]; ++y) {
      const T* at = data + static_cast<std::int64_t>(selection.first[0]) * from.step[0] +
                    static_cast<std::int64_t>(selection.first[1] + y) * from.step[1] +
                    static_cast<std::int64_t>(selection.first[2] + z) * from.step[2];
      for (std::uint64_t x = 0; x < selection.count[0]; ++x, at += from.step[0]) use(to++, at);
    }
  }
}

}  // namespace detail

// Fills the selection's box from samples that are all in memory. Throws ReadError for lengths of vectors
// (ISOEXTRACT_COMPONENT_LENGTH) of half floats.
inline void fill_box(const Grid& grid, const SamplesInMemory& from, const isoextract_volume_selection& selection) {
  with_sample_type(grid.sample_type, [&]<class T>(T) {
    if (selection.component != ISOEXTRACT_COMPONENT_LENGTH) {
      T* const to = static_cast<T*>(selection.box);
      const std::int64_t offset = selection.component * from.component_step;
      detail::visit_box<T>(from, selection, [&](std::size_t i, const T* sample) { to[i] = sample[offset]; });
      return;
    }
    if (grid.sample_type == ISOEXTRACT_F16) throw ReadError("lengths of half floats are not supported");
    const auto length = [&](const T* sample) {
      double sum = 0;
      for (std::uint64_t c = 0; c < grid.components; ++c) {
        const double value =
            grid.slope * static_cast<double>(sample[static_cast<std::int64_t>(c) * from.component_step]) +
            grid.intercept;
        sum += value * value;
      }
      return std::sqrt(sum);
    };
    if (selected_type(grid, selection) == ISOEXTRACT_F64) {
      auto* const to = static_cast<double*>(selection.box);
      detail::visit_box<T>(from, selection, [&](std::size_t i, const T* sample) { to[i] = length(sample); });
    } else {
      auto* const to = static_cast<float*>(selection.box);
      detail::visit_box<T>(from, selection,
                           [&](std::size_t i, const T* sample) { to[i] = static_cast<float>(length(sample)); });
    }
  });
}

namespace detail {

inline std::string& problem() {
  thread_local std::string text;
  return text;
}

template <class F>
int catch_exceptions(F&& work) {
  int failure = ISOEXTRACT_READ_FAILED;
  try {
    work();
    return 0;
  } catch (const UnevenError& error) {
    problem() = error.what();
    failure = ISOEXTRACT_UNEVEN_SAMPLES;
  } catch (const std::bad_alloc&) {
    problem() = "not enough memory to read it";
  } catch (const std::exception& error) {
    problem() = error.what();
  } catch (...) {
    problem() = "the library failed and gave no reason";
  }
  std::ranges::replace(problem(), '\n', ' ');
  return failure;
}

// A file with the lists of the C interface.
struct Listed {
  std::unique_ptr<VolumeFile> file;
  std::vector<isoextract_volume_grid> grids;
  std::vector<std::vector<isoextract_volume_label>> labels;
  std::vector<const char*> files;
};

inline isoextract_volume_grid c_grid(const Grid& grid, std::vector<isoextract_volume_label>& labels) {
  for (const Label& label : grid.labels) {
    labels.push_back(
        {label.value, label.name.c_str(), {label.color[0], label.color[1], label.color[2]}, label.has_color ? 1 : 0});
  }
  isoextract_volume_grid c{};
  c.name = grid.name.c_str();
  c.type_name = grid.type_name.c_str();
  c.world_space = grid.world_space.c_str();
  c.length_unit = grid.length_unit.c_str();
  c.sample_type = grid.sample_type;
  c.kind = grid.kind;
  c.is_sampled = grid.is_sampled ? 1 : 0;
  c.has_placement = grid.has_placement ? 1 : 0;
  std::ranges::copy(grid.dims, c.dims);
  std::ranges::copy(grid.index_to_world, c.index_to_world);
  c.slope = grid.slope;
  c.intercept = grid.intercept;
  c.components = grid.components;
  c.component_names = grid.component_names.c_str();
  c.volumes = grid.volumes;
  c.volume_times = grid.volume_times.size() == grid.volumes ? grid.volume_times.data() : nullptr;
  c.time_unit = grid.time_unit.c_str();
  c.labels = labels.data();
  c.label_count = labels.size();
  return c;
}

inline void check_selection(const Grid& grid, const isoextract_volume_selection& selection) {
  bool fits = selection.box != nullptr && selection.volume < grid.volumes &&
              (selection.component == ISOEXTRACT_COMPONENT_LENGTH ||
               (selection.component >= 0 && static_cast<std::uint64_t>(selection.component) < grid.components));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fits = fits && selection.count[axis] > 0 && selection.first[axis] < grid.dims[axis] &&
           selection.count[axis] <= grid.dims[axis] - selection.first[axis];
  }
  if (!fits) throw ReadError("the file changed during the run: samples that it listed are missing");
}

}  // namespace detail

// Returns the table of a plug-in. `kOpen(const Request&, const isoextract_plugin_host&)` opens a file and returns a
// std::unique_ptr<VolumeFile>, never null; `kProbe(const unsigned char* start, std::size_t bytes, const std::string&
// path)` returns a bool.
template <auto kOpen, auto kProbe>
isoextract_volume_plugin_v4 volume_plugin(const char* id, const char* format) {
  isoextract_volume_plugin_v4 table{};
  table.version = ISOEXTRACT_VOLUME_PLUGIN_VERSION;
  table.id = id;
  table.format = format;
  table.probe = [](const unsigned char* start, std::size_t bytes, const char* path) {
    int found = 0;
    detail::catch_exceptions([&] { found = kProbe(start, bytes, path) ? 1 : 0; });
    return found;
  };
  table.list = [](const isoextract_volume_request* request, const isoextract_plugin_host* host,
                  isoextract_volume_list* list) {
    return detail::catch_exceptions([&] {
      Request wanted;
      wanted.path = request->path;
      wanted.files.assign(request->files, request->files + request->file_count);
      wanted.volume = request->volume;
      wanted.level = request->level;
      std::copy_n(request->spacing, 3, wanted.spacing.begin());
      wanted.resamples = request->resamples != 0;
      auto listed = std::make_unique<detail::Listed>();
      listed->file = kOpen(wanted, *host);
      const VolumeFile& file = *listed->file;
      listed->labels.resize(file.grids.size());
      for (std::size_t i = 0; i < file.grids.size(); ++i) {
        listed->grids.push_back(detail::c_grid(file.grids[i], listed->labels[i]));
      }
      for (const std::string& path : file.files) listed->files.push_back(path.c_str());
      *list = {file.format.empty() ? nullptr : file.format.c_str(),
               file.creator.c_str(),
               file.note.c_str(),
               listed->grids.data(),
               listed->grids.size(),
               listed->files.data(),
               listed->files.size(),
               listed.get()};
      static_cast<void>(listed.release());
    });
  };
  table.free_list = [](isoextract_volume_list* list) { delete static_cast<detail::Listed*>(list->owner); };
  table.open = [](const isoextract_volume_list* list, const isoextract_volume_selection* selection,
                  const isoextract_plugin_host* host, isoextract_volume_samples* samples) {
    return detail::catch_exceptions([&] {
      auto& listed = *static_cast<detail::Listed*>(list->owner);
      const Grid& grid = listed.file->grids.at(selection->grid);
      detail::check_selection(grid, *selection);
      auto facts = std::make_unique<ReadFacts>(listed.file->read(*selection, *host));
      const std::uint64_t count = selection->count[0] * selection->count[1] * selection->count[2];
      const std::uint64_t bytes = count * sample_size(selected_type(grid, *selection));
      *samples = {bytes, nullptr, facts->parts_read, facts->parts, facts->note.c_str(), facts.get()};
      static_cast<void>(facts.release());
    });
  };
  table.free_samples = [](isoextract_volume_samples* samples) { delete static_cast<ReadFacts*>(samples->owner); };
  table.error_text = [] { return static_cast<const char*>(detail::problem().c_str()); };
  return table;
}

}  // namespace isoextract_plugin
