// One libFuzzer target a volume format: the input is a whole file, read as the format the target is built for, with all
// samples looked at. Files of plug-ins are read in this process, not in a child process as the program does.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "field/statistics.hpp"
#include "fuzz/fuzz_format.hpp"
#include "fuzz/requirements.hpp"
#include "support/temp_folder.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract {
namespace {

using fuzz::kFormat;

std::string file_name(const std::string& bytes) {
  if (kFormat == "nifti") return bytes.starts_with("\x1F\x8B") ? "volume.nii.gz" : "volume.nii";
  return "volume." + std::string(fuzz::kExtension);
}

// The first 16 bytes choose the layout of a raw file.
volume_io::RawLayout take_layout(const std::uint8_t*& data, std::size_t& size) {
  std::array<std::uint8_t, 16> head{};
  const std::size_t taken = std::min(size, head.size());
  std::copy_n(data, taken, head.begin());
  data += taken;
  size -= taken;
  volume_io::RawLayout layout;
  for (int axis = 0; axis < 3; ++axis) std::memcpy(&layout.dims[axis], head.data() + 4 * axis, 4);
  layout.type = static_cast<field::SampleType>(head[12] % 9);
  layout.endian = head[13] % 2 == 0 ? std::endian::little : std::endian::big;
  layout.skip = head[14];
  return layout;
}

void look_at(const std::string& input, volume_io::ReadOptions options,
             const std::optional<volume_io::ComponentChoice>& component, const Context& context) {
  options.component = component;
  const auto field = volume_io::read_volume(input, options, context);
  if (!field) {
    fuzz::require(!field.error().message.empty());
    return;
  }
  fuzz::require(field::measure_statistics(*field, nullptr, field::WithPercentiles::no).samples == 0 ||
                field->index_to_world.is_invertible());
}

void read_one(const std::uint8_t* data, std::size_t size) {
  static const test::TempFolder folder;  // detached data can only be found within it
  volume_io::ReadOptions options;
  const volume_io::VolumeFormat* format = volume_io::find_volume_format(kFormat);
  fuzz::require(format != nullptr);
  options.format = format->about().id;
  const std::uint64_t most_mebibytes = fuzz::kExtension == "zip" ? 32 : 8;  // unpacking takes 16 MiB by itself
  const Context context(MemoryBudget(most_mebibytes << 20));
  if (format->about().needs_layout) options.raw = take_layout(data, size);

  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::string input = format->about().prefix + bytes;
  if (format->about().prefix.empty()) {
    input = folder / file_name(bytes);
    test::write_bytes(input, bytes);
  }
  const auto grids = volume_io::list_grids(input, options, context);
  // A file with several grids needs a choice: the first scalar one.
  if (grids && grids->size() > 1) {
    const auto scalar =
        std::find_if(grids->begin(), grids->end(), [](const volume_io::GridInfo& grid) { return grid.scalar; });
    if (scalar != grids->end()) options.grid = scalar->label;
  }
  // Likewise one of several volumes and components: the last, which lies behind all others; and the length of all.
  if (grids && !grids->empty()) {
    const auto chosen = std::ranges::find_if(*grids, [&](const volume_io::GridInfo& grid) {
      return options.grid ? grid.label == *options.grid : grid.scalar;
    });
    if (chosen != grids->end() && chosen->volumes > 1) {
      options.volume = static_cast<std::int64_t>(chosen->volumes - 1);
    }
    if (chosen != grids->end() && chosen->components > 1) {
      look_at(input, options, volume_io::ComponentChoice(), context);
      options.component = volume_io::ComponentChoice{static_cast<std::int64_t>(chosen->components - 1)};
    }
  }
  look_at(input, options, options.component, context);
  // What arrays do not say of themselves. An odd byte chooses, so that it is always the same for one input.
  const bool odd = size > 0 && data[size - 1] % 2 == 1;
  if (!format->about().has_axis_order || !odd) return;
  options.axis_order = volume_io::AxisOrder::xyz;
  options.no_data = 7;
  look_at(input, options, volume_io::ComponentChoice{0}, context);
}

}  // namespace
}  // namespace isoextract

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isoextract::read_one(data, size);
  return 0;
}
