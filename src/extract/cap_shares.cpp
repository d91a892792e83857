#include "extract/cap_shares.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace isoextract::extract {
namespace {

field::IndexBox with_slices(field::IndexBox box, int begin, int end) {
  box.min.z = std::max(box.min.z, begin);
  box.max.z = std::max(std::min(box.max.z, end - 1), box.min.z - 1);
  return box;
}

std::uint32_t count_at(std::string_view counts, std::size_t row) {
  std::uint32_t count = 0;
  std::memcpy(&count, counts.data() + row * sizeof count, sizeof count);
  return count;
}

}  // namespace

field::IndexBox own_part(const field::IndexBox& box, const std::optional<RankSlices>& share) {
  return share ? with_slices(box, share->begin, share->end) : box;
}

field::IndexBox part_behind(const field::IndexBox& box, const std::optional<RankSlices>& share) {
  const int begin = share ? share->end : box.max.z + 1;
  const bool has_slices = share && share->begin < share->end;
  return with_slices(box, begin, has_slices ? begin + 1 : begin);
}

field::IndexBox used_part(const field::IndexBox& box, const std::optional<RankSlices>& share) {
  const bool has_slices = share && share->begin < share->end;
  return has_slices ? with_slices(box, share->begin, share->end + 1) : own_part(box, share);
}

CapRows::CapRows(const field::IndexBox& box) : min_(box.min) {
  for (int face = 0; face < 6; ++face) {
    first_[static_cast<std::size_t>(face)] = count_;
    count_ += static_cast<std::size_t>(box.dims()[BoxFace::of(face).v]);
  }
}

Result<CapPlaces> place_in_cap(const std::vector<std::uint32_t>& counts, const std::optional<RankSlices>& share) {
  const std::string_view own(reinterpret_cast<const char*>(counts.data()), counts.size() * sizeof(std::uint32_t));
  std::vector<std::string> told;
  if (share) told = TRY(share->ranks->gather(own));
  const std::size_t rank = share ? static_cast<std::size_t>(share->ranks->rank()) : 0;
  CapPlaces places;
  places.first_of_rows.reserve(counts.size());
  for (std::size_t row = 0; row < counts.size(); ++row) {
    std::uint64_t first = places.all;
    for (std::size_t r = 0; r < told.size(); ++r) {
      if (r == rank) first = places.all;
      places.all += count_at(told[r], row);
    }
    if (!share) places.all += counts[row];
    places.first_of_rows.push_back(first);
    if (counts[row] == 0) continue;
    if (!places.runs.empty() && places.runs.back().first + places.runs.back().count == first) {
      places.runs.back().count += counts[row];
    } else {
      places.runs.push_back({first, counts[row]});
    }
  }
  return places;
}

}  // namespace isoextract::extract
