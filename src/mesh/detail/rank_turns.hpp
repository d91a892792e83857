// Long messages between ranks.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.hpp"
#include "base/ranks.hpp"

namespace isoextract::mesh {

// Calls use(rank, bytes) with the bytes of every rank, in the order of the ranks. At a time, the bytes of one other
// rank are in memory. All ranks must call this function. Fails as `use` does, and as Ranks::gather().
template <class Use>
[[nodiscard]] Result<void> for_each_rank(Ranks& ranks, std::string_view own, const Use& use) {
  for (int rank = 0; rank < ranks.size(); ++rank) {
    const auto told = TRY(ranks.gather(rank == ranks.rank() ? own : std::string_view()));
    TRY(use(rank, std::string_view(told[static_cast<std::size_t>(rank)])));
  }
  return {};
}

template <class T>
[[nodiscard]] std::string_view bytes_of(const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
[[nodiscard]] std::vector<T> values_of(std::string_view bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

}  // namespace isoextract::mesh
