// The vertices of a mesh that an edit keeps, and their new numbers: one bit for each vertex, and a count for 512 of
// them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isoextract::edit {

class KeptVertices {
 public:
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) {
    return (vertices / kBlock + 1) * (kBlock / 8 + sizeof(std::uint32_t));
  }

  KeptVertices() = default;
  // Keeps none of `vertices` vertices; the caller reserves bytes(). Throws std::bad_alloc.
  explicit KeptVertices(std::uint64_t vertices) : words_((vertices / kBlock + 1) * kWords) {}

  void keep(std::uint64_t vertex) { words_[vertex / 64] |= std::uint64_t{1} << vertex % 64; }
  // Counts the kept vertices; call once, after the last keep() and before number(). Returns their number.
  std::uint64_t count() {
    std::uint64_t all = 0;
    below_.resize(words_.size() / kWords);
    for (std::size_t w = 0; w < words_.size(); ++w) {
      if (w % kWords == 0) below_[w / kWords] = static_cast<std::uint32_t>(all);
      all += static_cast<std::uint64_t>(std::popcount(words_[w]));
    }
    return all;
  }

  [[nodiscard]] bool is_kept(std::uint64_t vertex) const { return (words_[vertex / 64] >> vertex % 64 & 1U) != 0; }
  // Returns how many vertices before this one are kept: its new number, if it is kept itself. `vertex` may be the
  // number of all vertices.
  [[nodiscard]] std::uint32_t number(std::uint64_t vertex) const {
    const std::size_t word = vertex / 64;
    std::uint32_t count = below_[word / kWords];
    for (std::size_t w = word / kWords * kWords; w < word; ++w) {
      count += static_cast<std::uint32_t>(std::popcount(words_[w]));
    }
    const std::uint64_t before = (std::uint64_t{1} << vertex % 64) - 1;
    return count + static_cast<std::uint32_t>(std::popcount(words_[word] & before));
  }

 private:
  static constexpr std::size_t kBlock = 512;  // vertices
  static constexpr std::size_t kWords = kBlock / 64;

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> below_;  // kept vertices before each block
};

}  // namespace isoextract::edit
