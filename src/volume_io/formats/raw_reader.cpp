#include <fmt/format.h>

#include "base/checked.hpp"
#include "files/file_start.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/formats/raw_file.hpp"

namespace isoextract::volume_io {
namespace {

// Returns the sample types for which `bytes` is one volume of `count` samples: "u16, i16, f16"; may be empty.
std::string fitting_types(std::uint64_t count, std::uint64_t bytes) {
  std::string types;
  for (const field::SampleType type : {field::SampleType::u8, field::SampleType::i8, field::SampleType::u16,
                                       field::SampleType::i16, field::SampleType::u32, field::SampleType::i32,
                                       field::SampleType::f16, field::SampleType::f32, field::SampleType::f64}) {
    if (count * field::sample_size(type) == bytes)
      types += fmt::format("{}{}", types.empty() ? "" : " or ", field::sample_type_name(type));
  }
  return types;
}

// Suggests changes of the layout that would fit the file's size.
Hint fitting_layout(const files::InputFile& file, const RawLayout& layout, std::uint64_t expected) {
  const std::uint64_t found = file.size() - std::min(file.size(), layout.skip);
  const std::string types = fitting_types(expected / field::sample_size(layout.type), found);
  if (!types.empty()) return {Remedy::try_value, Setting::sample_type, types + " (the size would fit)"};
  if (file.size() > expected) {
    return {Remedy::try_value, Setting::skipped_bytes,
            fmt::format("{} (if the file begins with a header of that size)", file.size() - expected)};
  }
  if (layout.skip == 0) return {Remedy::check, Setting::raw_layout};
  return {{Remedy::check, Setting::raw_layout}, {Remedy::lower, Setting::skipped_bytes}};
}

}  // namespace

Result<DenseFile> open_raw(const files::InputFile& file, const RawLayout& layout, AxisOrder order) {
  std::array<std::uint64_t, 3> sizes{};
  for (int axis = 0; axis < 3; ++axis) {
    if (layout.dims[axis] < 1) {
      return fail(ErrorCode::usage,
                  fmt::format("the dims of a raw file: expected three numbers from 1 on, found {},{},{}", layout.dims.x,
                              layout.dims.y, layout.dims.z));
    }
    sizes[static_cast<std::size_t>(axis)] = static_cast<std::uint64_t>(layout.dims[axis]);
  }
  const auto dims = TRY(checked_dims(file.name(), sizes, layout.type));
  TRY(check_volume_count(file.name(), dims, layout.type, layout.components));
  const std::uint64_t expected = sample_bytes(dims, layout.type) * layout.components;
  const auto total = checked_sum(expected, layout.skip);
  const std::uint64_t found = file.size() - std::min(file.size(), layout.skip);
  if (!total || *total > file.size() || found % expected != 0) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected {} bytes ({} bytes to skip, then {}), or more volumes of {} bytes each after these, "
                    "found {}",
                    file.name(), total ? std::to_string(*total) : "more than 2^64", layout.skip,
                    describe_samples(dims, layout.type) +
                        (layout.components > 1 ? fmt::format(" of {} components", layout.components) : ""),
                    expected, file.size()),
        fitting_layout(file, layout, expected));
  }
  DenseFile dense;
  dense.volumes = found / expected;
  dense.components = layout.components;
  dense.components_interleaved = !layout.planar;
  TRY(check_volume_count(file.name(), dims, layout.type, found / sample_bytes(dims, layout.type)));
  if (dense.volumes > 1) {
    const std::string types = fitting_types(expected / field::sample_size(layout.type), found);
    if (!types.empty())
      dense.other_interpretation = {Remedy::try_value, Setting::sample_type, types + " (as one volume)"};
  }
  dense.format = "raw";
  dense.type = layout.type;
  dense.dims = dims;
  dense.endian = layout.endian;
  dense.x_slowest = order == AxisOrder::xyz;
  dense.pieces = {{file.path(), layout.skip}};
  dense.size_is_exact = true;
  dense.frame.stated = false;
  return dense;
}

namespace {

class RawFormat final : public DenseFormat {
 public:
  RawFormat()
      : DenseFormat({.id = "raw",
                     .title = "samples without a header",
                     .extensions = {".raw"},
                     .has_volumes = true,
                     .has_components = true,
                     .has_axis_order = true,
                     .needs_layout = true}) {}

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file, const ReadOptions& options) const override {
    return open_raw(file, *options.raw, options.axis_order.value_or(AxisOrder::zyx));
  }
};

}  // namespace

const VolumeFormat& raw_format() {
  static const RawFormat format;
  return format;
}

}  // namespace isoextract::volume_io
