// NumPy's archives of arrays (.npz): ZIP files whose members are NPY files. A member is selected like a grid; only the
// headers of other members are read.
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "volume_io/detail/dense_reading.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/formats/npy_volume.hpp"
#include "volume_io/formats/zip_directory.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kMemberEnd = ".npy";
constexpr std::string_view kZipMagic("PK\3\4", 4);

// An array of an archive, from its header.
struct NpzArray {
  SamplePiece piece;  // the whole member
  NpyHeader header;
};

std::string member_name(const files::InputFile& file, const ZipMember& member) {
  return fmt::format("{}: '{}'", file.name(), printable(member.name, kMaxLabel));
}

Result<NpzArray> read_array(const files::InputFile& file, const ZipMember& member) {
  auto piece = TRY(find_member_bytes(file, member));
  // Nearly all headers fit into the first, small size.
  constexpr std::size_t kMostHeaders = 4096;
  for (const std::size_t count : {kMostHeaders, static_cast<std::size_t>(kMaxNpyHeader)}) {
    const auto start = TRY(first_bytes_of(file, piece, count));
    auto header = parse_npy_header(member_name(file, member), start, member.sizes.inflated);
    if (header) return NpzArray{std::move(piece), std::move(*header)};
    if (start.size() < count || count == kMaxNpyHeader) return tl::unexpected(std::move(header.error()));
  }
  return fail(ErrorCode::input, member_name(file, member) + ": expected an NPY header, found none");
}

// Verifies the checksum of an uncompressed member; compressed ones are verified while they are decompressed.
Result<void> check_stored(const files::InputFile& file, const ZipMember& member, const SamplePiece& piece) {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;
  const auto reserved = TRY(file.context().reserve(kBlock, file.name() + ": its checksum"));
  std::vector<std::byte> block(kBlock);
  auto crc = ::crc32(0, nullptr, 0);
  for (std::uint64_t at = 0; at < member.sizes.inflated; at += kBlock) {
    TRY(file.context().check());
    const auto part = std::span(block).first(static_cast<std::size_t>(std::min(kBlock, member.sizes.inflated - at)));
    TRY(file.read_at(piece.offset + at, part));
    crc = ::crc32_z(crc, reinterpret_cast<const Bytef*>(part.data()), part.size());
  }
  if (crc == member.sizes.crc) return {};
  return fail(ErrorCode::input, fmt::format("{} is damaged: its checksum is {:08x}; the ZIP directory states {:08x}",
                                            member_name(file, member), crc, member.sizes.crc));
}

std::vector<ZipMember> arrays_of(std::vector<ZipMember> members) {
  std::erase_if(members, [](const ZipMember& member) { return !member.name.ends_with(kMemberEnd); });
  return members;
}

std::string name_of(const ZipMember& member) { return member.name.substr(0, member.name.size() - kMemberEnd.size()); }

// Describes a member; unreadable ones are listed as grids that are not scalar.
GridInfo describe(const files::InputFile& file, const ZipMember& member, const ReadOptions& options) {
  GridInfo info;
  info.name = name_of(member);
  const auto array = read_array(file, member);
  if (!array) {
    info.type = "unreadable";
    return info;
  }
  const auto dense = npy_volume(member_name(file, member), array->header, options);
  if (dense) return grid_of(*dense, std::move(info.name));
  info.type = fmt::format("{} ({})", printable(array->header.descr, 40), fmt::join(array->header.shape, ", "));
  return info;
}

Result<std::vector<GridInfo>> list_arrays(const files::InputFile& file, const std::vector<ZipMember>& members,
                                          const ReadOptions& options) {
  std::vector<GridInfo> grids;
  for (const ZipMember& member : members) {
    TRY(file.context().check());
    grids.push_back(describe(file, member, options));
  }
  label_grids(grids);
  return grids;
}

class NpzFormat final : public VolumeFormat {
 public:
  NpzFormat()
      : VolumeFormat({.id = "npz",
                      .title = "NumPy archive of arrays, stored or packed",
                      .extensions = {".npz"},
                      .has_grids = true,
                      .has_volumes = true,
                      .has_components = true,
                      .has_axis_order = true}) {}

  // Other formats are ZIP files too; the first member's name identifies this one.
  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    constexpr std::size_t kNameLength = 26;
    constexpr std::size_t kName = 30;
    if (start.packed || start.bytes.size() < kName || !files::starts_with(start.bytes, kZipMagic)) return false;
    const std::size_t length = std::to_integer<std::size_t>(start.bytes[kNameLength]) |
                               std::to_integer<std::size_t>(start.bytes[kNameLength + 1]) << 8;
    if (length < kMemberEnd.size() || start.bytes.size() - kName < length) return false;
    return files::starts_with(start.bytes.subspan(kName + length - kMemberEnd.size()), kMemberEnd);
  }

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                   const Context& context) const override {
    const auto file = TRY(files::InputFile::open(input, context));
    auto members = TRY(read_zip_directory(file));
    return list_arrays(file, arrays_of(std::move(members)), options);
  }

  [[nodiscard]] Result<std::vector<std::filesystem::path>> files(const std::string& input,
                                                                 const ReadOptions& /*options*/,
                                                                 const Context& /*context*/) const override {
    return std::vector<std::filesystem::path>{input};
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    const auto file = TRY(files::InputFile::open(input, context));
    auto all = TRY(read_zip_directory(file));
    const std::vector<ZipMember> members = arrays_of(std::move(all));
    auto grids = TRY(list_arrays(file, members, options));
    // For a selected or single array, the reader gives the best error message.
    if (options.grid || grids.size() == 1) {
      for (GridInfo& grid : grids) grid.scalar = true;
    }
    const auto chosen = TRY(choose_grid(file.name(), grids, options.grid));
    const ZipMember& member = members[chosen];
    auto array = TRY(read_array(file, member));
    auto dense = TRY(npy_volume(member_name(file, member), array.header, options));
    dense.format = "NPZ";
    const SamplePiece member_piece = array.piece;
    (array.piece.packed() ? array.piece.skip : array.piece.offset) += array.header.data_offset;
    dense.pieces = {std::move(array.piece)};
    auto field = read_dense(file, std::move(dense), name_of(member), options);
    if (!field) return field;
    if (!member_piece.packed()) {
      TRY(check_stored(file, member, member_piece));
    }
    field->grids = grids.size();
    field->grid = grids[chosen].label;
    return field;
  }
};

}  // namespace

const VolumeFormat& npz_format() {
  static const NpzFormat format;
  return format;
}

}  // namespace isoextract::volume_io
