#include "base/nearest_name.hpp"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract {
namespace {

constexpr std::size_t kMaxShownName = 80;  // bytes

// Returns the edit distance: insertions, deletions, replacements and swaps of letters from a to b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
      }
    }
  }
  return cost[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(std::string_view text, const std::vector<std::string>& candidates) {
  if (text.size() < 2) return {};  // every other letter is one replacement away
  const std::size_t tolerance = std::max<std::size_t>(1, text.size() / 3);
  std::string best;
  std::size_t best_distance = tolerance + 1;
  for (const std::string& candidate : candidates) {
    const bool is_prefix = text.size() >= 3 && candidate.starts_with(text);
    const std::size_t distance = is_prefix ? 0 : edit_distance(text, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view text, const std::vector<std::string>& candidates) {
  const std::string near = nearest_name(text, candidates);
  return near.empty() ? "" : fmt::format(" (did you mean '{}'?)", printable(near, kMaxShownName));
}

}  // namespace isoextract
