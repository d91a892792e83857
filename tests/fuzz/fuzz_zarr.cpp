// The libFuzzer target of the Zarr plug-in: the input is a hierarchy (zarr_entries.hpp), read in this process with all
// grids listed and a box of each looked at.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/requirements.hpp"
#include "fuzz/zarr_entries.hpp"
#include "zarr_store.hpp"
#include "zarr_volume.hpp"

namespace isoextract {
namespace {

using isoextract_zarr::Bytes;
using isoextract_zarr::Value;

constexpr std::uint64_t kMemory = std::uint64_t{64} << 20;

class MemoryValue final : public Value {
 public:
  explicit MemoryValue(const Bytes& bytes) : Value(bytes.size()), bytes_(bytes) {}

 private:
  void read_checked(std::uint64_t offset, std::span<std::byte> to) const override {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
  }
  const Bytes& bytes_;
};

class MemoryStore final : public isoextract_zarr::Store {
 public:
  explicit MemoryStore(std::span<const std::byte> input) {
    while (input.size() >= 3) {
      const auto key = std::to_integer<std::size_t>(input[0]) % fuzz::kZarrKeys.size();
      const std::size_t size = std::to_integer<std::size_t>(input[1]) | std::to_integer<std::size_t>(input[2]) << 8;
      input = input.subspan(3);
      const std::span value = input.first(std::min(size, input.size()));
      values_[std::string(fuzz::kZarrKeys[key])].assign(value.begin(), value.end());
      input = input.subspan(value.size());
    }
  }

  [[nodiscard]] std::unique_ptr<Value> find(const std::string& key) const override {
    const auto found = values_.find(key);
    return found == values_.end() ? nullptr : std::make_unique<MemoryValue>(found->second);
  }
  [[nodiscard]] std::vector<std::string> folders(const std::string& group) const override {
    std::set<std::string> names;
    const std::string prefix = group.empty() ? "" : group + '/';
    for (const auto& [key, value] : values_) {
      const std::size_t slash = key.find('/', prefix.size());
      if (key.starts_with(prefix) && slash != std::string::npos) {
        names.insert(key.substr(prefix.size(), slash - prefix.size()));
      }
    }
    return {names.begin(), names.end()};
  }
  [[nodiscard]] std::string file_of(const std::string& key) const override { return key; }

 private:
  std::map<std::string, Bytes> values_;
};

// Grants the memory of a small machine.
struct Host {
  std::atomic<std::uint64_t> used{0};
  isoextract_plugin_host calls{this,
                               [](void* self, std::uint64_t bytes) {
                                 auto& taken = static_cast<Host*>(self)->used;
                                 if (bytes > kMemory || taken + bytes > kMemory) return 1;
                                 taken += bytes;
                                 return 0;
                               },
                               [](void* self, std::uint64_t bytes) { static_cast<Host*>(self)->used -= bytes; },
                               [](void*, std::uint64_t) -> void* { return nullptr; }, [](void*) { return 0; }};
};

// Reads at most 64 samples along each axis, from the middle on.
void look_at(isoextract_plugin::VolumeFile& file, std::size_t grid, std::int64_t component, const Host& host) {
  const isoextract_plugin::Grid& info = file.grids[grid];
  constexpr std::uint64_t kMost = 64;
  isoextract_volume_selection selection{};
  selection.grid = grid;
  selection.volume = info.volumes - 1;
  selection.component = component;
  std::uint64_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fuzz::require(info.dims[axis] > 0);
    selection.count[axis] = std::min(kMost, info.dims[axis]);
    selection.first[axis] = (info.dims[axis] - selection.count[axis]) / 2;
    count *= selection.count[axis];
  }
  std::vector<double> box(count);  // no sample is larger
  selection.box = box.data();
  try {
    const auto facts = file.read(selection, host.calls);
    fuzz::require(facts.parts_read <= facts.parts);
  } catch (const isoextract_zarr::ReadError& error) {
    fuzz::require(error.what()[0] != '\0');
  } catch (const std::bad_alloc&) {
    // The host refused the memory.
  }
}

void read_one(std::span<const std::byte> input) {
  Host host;
  // An odd size chooses another level.
  const std::uint64_t level = input.size() % 2;
  try {
    const auto file = isoextract_zarr::open_hierarchy(std::make_unique<MemoryStore>(input), 0, level, host.calls);
    constexpr std::size_t kMostGrids = 8;
    for (std::size_t grid = 0; grid < std::min(file->grids.size(), kMostGrids); ++grid) {
      if (file->grids[grid].sample_type == ISOEXTRACT_NOT_SCALAR) continue;
      look_at(*file, grid, 0, host);
      if (file->grids[grid].components > 1) look_at(*file, grid, ISOEXTRACT_COMPONENT_LENGTH, host);
    }
  } catch (const isoextract_zarr::ReadError& error) {
    fuzz::require(error.what()[0] != '\0');
  } catch (const std::bad_alloc&) {
    // The host refused the memory.
  }
  fuzz::require(host.used == 0);
}

}  // namespace
}  // namespace isoextract

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isoextract::read_one({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
