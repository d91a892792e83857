// Writes OpenVDB files through the host's callbacks; equal grids give equal bytes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>

#include <grid_tools_plugin.h>
#include "openvdb_parts.hpp"

namespace isoextract_openvdb {

// Returns a hash of the content in the form of a UUID. OpenVDB would use a random one, but equal grids must give equal
// files.
inline std::string content_name(const std::vector<openvdb::FloatGrid::Ptr>& grids, const isoextract_vdb_job& job) {
  std::array<std::uint64_t, 2> sums{0x9e3779b97f4a7c15U, 0xc2b2ae3d27d4eb4fU};
  const auto add = [&](std::uint64_t word) {
    for (std::uint64_t& sum : sums) {
      sum = (sum ^ word) * 0xff51afd7ed558ccdU;
      word = sum ^= sum >> 32U;
    }
  };
  const auto add_float = [&](float value) { add(std::bit_cast<std::uint32_t>(value)); };
  const auto add_place = [&](const openvdb::Coord& at) {
    for (int axis = 0; axis < 3; ++axis) add(static_cast<std::uint64_t>(at[axis]));
  };
  for (std::size_t g = 0; g < grids.size(); ++g) {
    const isoextract_named_grid& named = job.grids[g];
    const openvdb::FloatGrid& grid = *grids[g];
    for (const char c : std::string_view(named.name)) add(static_cast<unsigned char>(c));
    for (const double number : named.grid.index_to_world) add(std::bit_cast<std::uint64_t>(number));
    add(static_cast<std::uint64_t>(named.grid.kind));
    add(job.is_half != 0 ? 1 : 0);
    add_float(grid.background());
    visit_tiles(grid.tree(), [&](const auto& tile) {
      add_place(tile.getCoord());
      add(tile.getLevel());
      add_float(tile.getValue());
    });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
      add_place(leaf->origin());
      for (openvdb::Index n = 0; n < kLeafValues; ++n) add_float(leaf->getValue(n));
    }
  }
  std::array<char, 33> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx%016llx", static_cast<unsigned long long>(sums[0]),
                static_cast<unsigned long long>(sums[1]));
  std::string name(digits.data());
  for (const std::size_t at : {8, 13, 18, 23}) name.insert(at, 1, '-');
  return name;
}

// Passes bytes to the host; supports seeking to written positions if the job can overwrite. Replaces OpenVDB's UUID by
// `name`: it follows a signature of 8 bytes, 12 bytes of versions and a flag of 1 byte.
class HostStream : public std::streambuf {
 public:
  HostStream(const isoextract_vdb_job& job, std::string name) : job_(job), name_(std::move(name)) {}
  [[nodiscard]] bool failed() const { return failed_; }

 protected:
  std::streamsize xsputn(const char* given, std::streamsize count) override {
    const auto n = static_cast<std::uint64_t>(count);
    std::string renamed;
    const char* bytes = given;
    if (place_ < kNameBegins + name_.size() && place_ + n > kNameBegins) {
      renamed.assign(given, n);
      for (std::uint64_t i = 0; i < n; ++i) {
        const std::uint64_t at = place_ + i;
        if (at >= kNameBegins && at < kNameBegins + name_.size()) renamed[i] = name_[at - kNameBegins];
      }
      bytes = renamed.data();
    }
    const std::uint64_t in_place = std::min(n, size_ - place_);
    if (in_place > 0) failed_ |= job_.overwrite(job_.sink, place_, bytes, in_place) != 0;
    if (n > in_place && !failed_) failed_ |= job_.append(job_.sink, bytes + in_place, n - in_place) != 0;
    if (failed_) return 0;
    place_ += n;
    size_ = std::max(size_, place_);
    return count;
  }

  int_type overflow(int_type symbol) override {
    const char byte = traits_type::to_char_type(symbol);
    return xsputn(&byte, 1) == 1 ? symbol : traits_type::eof();
  }

  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode which) override {
    const std::uint64_t base = from == std::ios_base::beg ? 0 : from == std::ios_base::end ? size_ : place_;
    return seekpos(static_cast<off_type>(base) + offset, which);
  }

  pos_type seekpos(pos_type place, std::ios_base::openmode /*which*/) override {
    const off_type wanted = place;
    if (wanted < 0 || static_cast<std::uint64_t>(wanted) > size_) return {off_type(-1)};
    if (static_cast<std::uint64_t>(wanted) < size_ && job_.overwrite == nullptr) return {off_type(-1)};
    place_ = static_cast<std::uint64_t>(wanted);
    return place;
  }

 private:
  static constexpr std::uint64_t kNameBegins = 21;

  const isoextract_vdb_job& job_;
  std::string name_;
  std::uint64_t place_ = 0;
  std::uint64_t size_ = 0;
  bool failed_ = false;
};

// Gives access to the protected writer of io::File and io::Stream, to use another stream.
class HostArchive : public openvdb::io::Archive {
 public:
  void put(std::ostream& stream, const openvdb::GridCPtrVec& grids, bool with_places) const {
    write(stream, grids, with_places);
  }
};

}  // namespace isoextract_openvdb
