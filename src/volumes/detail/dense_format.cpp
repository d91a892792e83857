#include "volumes/detail/dense_format.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "volumes/detail/grid_choice.hpp"

namespace isoextract::volumes {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 62;  // of what one file holds

// Mapped where that can be; else read, into memory that is reserved. A mapping needs none of its own: the system keeps
// what is in use of it and drops the rest where memory is short.
Result<field::DenseSamples> load_samples(const files::InputFile& file, DenseFile& dense, std::uint64_t volume,
                                         const SampleSource& source) {
  const Context& context = file.context();
  if (!dense.x_slowest) {
    if (auto mapped = map_samples(source, context)) {
      const auto mapping = std::make_shared<const files::MappedFile>(std::move(*mapped));
      return field::DenseSamples{dense.type, dense.dims, mapping, mapping->data(), true, &mapping->lost()};
    }
  }
  const std::uint64_t needed = source.bytes + (dense.x_slowest ? transpose_bytes(dense.dims, source.sample_size) : 0);
  auto memory = context.reserve(needed, fmt::format("{}: {}", file.name(), describe_samples(dense.dims, dense.type)));
  if (!memory) return tl::unexpected(memory.error());

  auto read = dense.x_slowest ? read_samples_transposed(source, dense.dims, context) : read_samples(source, context);
  if (!read) return tl::unexpected(read.error());
  if (read->more_in_gzip && volume + 1 == dense.volumes)
    dense.notes.emplace_back("bytes after the samples were not read");
  memory->shrink(source.bytes);
  const auto owned = std::make_shared<const ReservedBuffer<std::byte>>(
      ReservedBuffer<std::byte>{std::move(read->data), std::move(*memory)});
  return field::DenseSamples{dense.type, dense.dims, owned, owned->values.data(), false};
}

Result<field::ScalarField> load_dense(const files::InputFile& file, DenseFile&& dense, const ReadOptions& options) {
  const auto volume = choose_volume(file.name(), dense.volumes, options.volume);
  if (!volume) return tl::unexpected(volume.error());
  std::string what = describe_samples(dense.dims, dense.type);
  if (dense.volumes > 1) what += fmt::format(" in each of {} volumes", dense.volumes);
  SampleSource source;
  source.pieces = std::move(dense.pieces);
  source.bytes = sample_bytes(dense.dims, dense.type) * dense.volumes;
  source.sample_size = field::sample_size(dense.type);
  source.swap_bytes = dense.endian != std::endian::native && source.sample_size > 1;

  const auto extra = check_source(source, what, file.context());
  if (!extra) return tl::unexpected(extra.error());
  if (*extra > 0) {
    if (dense.size_is_exact) {
      return fail(ErrorKind::input, fmt::format("{}: expected {} bytes ({}), found {} more after them", file.name(),
                                                source.bytes, what, *extra));
    }
    dense.notes.push_back(fmt::format("{} bytes after the samples were not read", *extra));
  }
  const auto one = volume_of(source, *volume, dense.volumes, dense.interleaved);
  if (!one) return tl::unexpected(one.error());
  auto samples = load_samples(file, dense, *volume, *one);
  if (!samples) return tl::unexpected(samples.error());

  field::ScalarField field;
  field.source = file.name();
  field.name = stem_of(file.path());
  field.format = std::move(dense.format);
  field.world_space = std::move(dense.world_space);
  field.scale = dense.scale;
  field.notes = std::move(dense.notes);
  field.samples = std::move(*samples);
  if (auto placed = set_frame(field, dense.frame, options); !placed) return tl::unexpected(placed.error());
  return field;
}

}  // namespace

Result<std::vector<GridInfo>> DenseFormat::list(const std::string& input, const ReadOptions& options,
                                                const Context& context) const {
  const auto file = files::InputFile::open(input, context);
  if (!file) return tl::unexpected(file.error());
  const auto dense = open_header(*file, options);
  if (!dense) return tl::unexpected(dense.error());
  if (options.volume) {
    const auto chosen = choose_volume(file->name(), dense->volumes, options.volume);
    if (!chosen) return tl::unexpected(chosen.error());
  }
  GridInfo grid = dense_grid(stem_of(file->path()), dense->dims, dense->type);
  grid.volumes = dense->volumes;
  return std::vector{std::move(grid)};
}

Result<std::vector<std::filesystem::path>> DenseFormat::files(const std::string& input, const ReadOptions& options,
                                                              const Context& context) const {
  const auto file = files::InputFile::open(input, context);
  if (!file) return tl::unexpected(file.error());
  const auto dense = open_header(*file, options);
  if (!dense) return tl::unexpected(dense.error());
  std::vector<std::filesystem::path> files{input};
  for (const SamplePiece& piece : dense->pieces) files.push_back(piece.path);
  return files;
}

Result<field::ScalarField> DenseFormat::open(const std::string& input, const ReadOptions& options,
                                             const Context& context) const {
  const auto file = files::InputFile::open(input, context);
  if (!file) return tl::unexpected(file.error());
  auto dense = open_header(*file, options);
  if (!dense) return tl::unexpected(dense.error());
  return load_dense(*file, std::move(*dense), options);
}

Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                field::SampleType type) {
  constexpr std::uint64_t kMaxSize = 0x7fffffff;
  const auto bytes = checked_product(sizes[0], sizes[1], sizes[2], std::uint64_t{field::sample_size(type)});
  const bool fits = std::ranges::all_of(sizes, [](std::uint64_t size) { return size >= 1 && size <= kMaxSize; });
  if (!fits || !bytes || *bytes > kMaxBytes) {
    return fail(ErrorKind::input, fmt::format("{}: expected sizes from 1 to {} along each axis, found {}x{}x{}", file,
                                              kMaxSize, sizes[0], sizes[1], sizes[2]));
  }
  return glm::ivec3(static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2]));
}

Result<void> check_volume_count(const std::string& file, const glm::ivec3& dims, field::SampleType type,
                                std::uint64_t count) {
  const auto bytes = checked_product(sample_bytes(dims, type), count);
  if (count > 0 && bytes && *bytes <= kMaxBytes) return {};
  return fail(ErrorKind::input, fmt::format("{}: expected from 1 to {} volumes of {}, found {}", file,
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

std::string stem_of(const std::filesystem::path& path) {
  if (files::is_standard_input(path)) return "stdin";
  std::filesystem::path stem = path.stem();
  if (path.extension() == ".gz") stem = stem.stem();
  return stem.string();
}

}  // namespace isoextract::volumes
