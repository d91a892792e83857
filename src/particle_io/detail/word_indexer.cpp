#include <fmt/format.h>

#include "base/printable.hpp"
#include "particle_io/detail/particle_columns.hpp"

namespace isoextract::particle_io {

void WordIndexer::put(std::size_t particle, std::string_view word) {
  if (to_.too_many) return;
  if (word != last_ || to_.words.empty()) {
    last_ = word;
    const auto [at, is_new] = indices_.try_emplace(last_, static_cast<std::uint32_t>(to_.words.size()));
    last_index_ = at->second;
    if (is_new) {
      bytes_ += word.size();
      to_.words.emplace_back(word);
    }
    if (to_.words.size() > kMaxDistinctWords || bytes_ > kMaxWordBytes) return give_up();
  }
  to_.indices[particle] = last_index_;
}

void WordIndexer::give_up() {
  if (wanted_) {
    throw InvalidParticleFile(
        fmt::format("expected at most {} different words with at most {} bytes in all in '{}', found more",
                    kMaxDistinctWords, kMaxWordBytes, printable(to_.name, 80)));
  }
  to_.too_many = true;
  to_.words.clear();
  to_.indices = Buffer<std::uint32_t>();
}

}  // namespace isoextract::particle_io
