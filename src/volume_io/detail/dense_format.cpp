#include "volume_io/detail/dense_format.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/unpacked_files.hpp"
#include "volume_io/detail/dense_reading.hpp"
#include "volume_io/detail/grid_choice.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 62;  // limit of the content of one file

}  // namespace

Result<std::vector<GridInfo>> DenseFormat::list(const std::string& input, const ReadOptions& options,
                                                const Context& context) const {
  const auto file = TRY(files::InputFile::open(input, context));
  const auto dense = TRY(open_header(file, options));
  if (options.volume) {
    TRY(choose_volume(file.name(), dense.volumes, options.volume, dense.other_interpretation));
  }
  return std::vector{grid_of(dense, stem_of(file.path()))};
}

Result<std::vector<std::filesystem::path>> DenseFormat::files(const std::string& input, const ReadOptions& options,
                                                              const Context& context) const {
  const auto file = TRY(files::InputFile::open(input, context));
  const auto dense = TRY(open_header(file, options));
  std::vector<std::filesystem::path> files{input};
  for (const SamplePiece& piece : dense.pieces) files.push_back(piece.path);
  return files;
}

Result<std::vector<files::FilePart>> DenseFormat::parts(const std::string& input, const ReadOptions& options,
                                                        const Context& context) const {
  const auto file = TRY(files::InputFile::open(input, context));
  const auto dense = TRY(open_header(file, options));
  return find_volume_parts(file, dense, options);
}

Result<field::ScalarField> DenseFormat::open(const std::string& input, const ReadOptions& options,
                                             const Context& context) const {
  const auto file = TRY(files::InputFile::open(input, context));
  auto dense = TRY(open_header(file, options));
  return read_dense(file, std::move(dense), stem_of(file.path()), options);
}

Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                field::SampleType type) {
  constexpr std::uint64_t kMaxSize = 0x7fffffff;
  const auto bytes = checked_product(sizes[0], sizes[1], sizes[2], std::uint64_t{field::sample_size(type)});
  const bool fits = std::ranges::all_of(sizes, [](std::uint64_t size) { return size >= 1 && size <= kMaxSize; });
  if (!fits || !bytes || *bytes > kMaxBytes) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected sizes from 1 to {} along each axis and at most 2^62 bytes in all, found {}x{}x{}",
                    file, kMaxSize, sizes[0], sizes[1], sizes[2]));
  }
  return glm::ivec3(static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2]));
}

Result<void> check_volume_count(const std::string& file, const glm::ivec3& dims, field::SampleType type,
                                std::uint64_t count) {
  const auto bytes = checked_product(sample_bytes(dims, type), count);
  if (count > 0 && bytes && *bytes <= kMaxBytes) return {};
  return fail(ErrorCode::input, fmt::format("{}: expected from 1 to {} volumes of {}, found {}", file,
                                            kMaxBytes / sample_bytes(dims, type), describe_samples(dims, type), count));
}

std::uint64_t sample_bytes(const glm::ivec3& dims, field::SampleType type) {
  return static_cast<std::uint64_t>(dims.x) * static_cast<std::uint64_t>(dims.y) * static_cast<std::uint64_t>(dims.z) *
         field::sample_size(type);
}

std::string describe_samples(const glm::ivec3& dims, field::SampleType type) {
  return fmt::format("{}x{}x{} {} samples", dims.x, dims.y, dims.z, field::sample_type_name(type));
}

GridInfo dense_grid(std::string name, const glm::ivec3& dims, field::SampleType type) {
  GridInfo info;
  info.label = printable(name, kMaxLabel);
  info.name = std::move(name);
  info.type = field::sample_type_name(type);
  info.scalar = true;
  info.box = {glm::ivec3(0), dims - 1};
  info.voxels = sample_bytes(dims, type) / field::sample_size(type);
  return info;
}

GridInfo grid_of(const DenseFile& dense, std::string name) {
  GridInfo grid = dense_grid(std::move(name), dense.dims, dense.type);
  if (dense.wide != Integer64::none) grid.type = dense.wide == Integer64::i64 ? "i64" : "u64";
  grid.volumes = dense.volumes;
  grid.components = dense.components;
  grid.labels = dense.labels;
  grid.length_unit = dense.length_unit;
  grid.world_space = dense.world_space;
  grid.component_names = dense.component_names;
  return grid;
}

std::string stem_of(const std::filesystem::path& path) {
  if (files::is_standard_input(path)) return "stdin";
  // The folder of an unpacked archive has another name than the archive.
  std::error_code none;
  const std::filesystem::path source = files::packed_source(path);
  if (source != path && std::filesystem::is_directory(path, none)) return stem_of(source);
  return std::filesystem::path(files::name_without_packing(path.filename())).stem().string();
}

}  // namespace isoextract::volume_io
