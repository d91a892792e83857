// Long messages between ranks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.hpp"
#include "base/ranks.hpp"

namespace isoextract::mesh {

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

// Calls use(rank, bytes) with the bytes of every rank, in the order of the ranks. Besides its own bytes, a rank has
// those of one other rank in memory at a time. All ranks must call this function. Fails as `use` does, and as
// Ranks::gather().
template <class Use>
[[nodiscard]] Result<void> for_each_rank(Ranks& ranks, std::string_view own, const Use& use) {
  constexpr std::uint64_t kMessage = std::uint64_t{64} << 20U;  // messages of 2 GiB are too long for MPI
  const std::vector<std::uint64_t> own_length{own.size()};
  std::vector<std::uint64_t> lengths;
  for (const std::string& length : TRY(ranks.gather(bytes_of(own_length)))) {
    lengths.push_back(values_of<std::uint64_t>(length).front());
  }
  for (int rank = 0; rank < ranks.size(); ++rank) {
    std::string bytes;
    do {
      const std::string_view rest = own.substr(std::min(own.size(), bytes.size()));
      const auto gathered = TRY(ranks.gather(rank == ranks.rank() ? rest.substr(0, kMessage) : std::string_view()));
      bytes += gathered[static_cast<std::size_t>(rank)];
    } while (bytes.size() < lengths[static_cast<std::size_t>(rank)]);
    TRY(use(rank, std::string_view(bytes)));
  }
  return {};
}

}  // namespace isoextract::mesh
