// The libFuzzer target of conditions on particles (--select): parses the input, and evaluates it for a few particles.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "fuzz/requirements.hpp"
#include "points/selection.hpp"

namespace isoextract {
namespace {

using fuzz::require;
using points::SelectionExpression;

constexpr std::size_t kParticles = 6;

points::ParticleSet some_particles() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  points::ParticleSet set;
  set.label = "particles";
  set.positions = Buffer<glm::dvec3>(kParticles);
  const auto add = [&](const std::string& name, std::size_t components, const std::vector<float>& values) {
    points::ParticleAttribute attribute{name, components, Buffer<float>(components * kParticles)};
    for (std::size_t i = 0; i < attribute.values.size(); ++i) attribute.values[i] = values[i % values.size()];
    set.attributes.push_back(std::move(attribute));
  };
  for (std::size_t i = 0; i < kParticles; ++i) set.positions[i] = static_cast<double>(i) * glm::dvec3(1, -1e300, 0.1);
  add("type", 1, {1, 2, 3, 1, 2, 1});
  add("T", 1, {0.1F, kNan, kInfinity, -0.0F, 1e38F, -kInfinity});
  add("v", 3, {1, 2, 3, kNan, 0, 1e38F, kInfinity});
  add("odd name", 2, {0, 1});
  points::ParticleWords words{"species", {"O", "H", "", "x", "C a", "1"}, Buffer<std::uint32_t>(kParticles)};
  for (std::uint32_t i = 0; i < kParticles; ++i) words.indices[i] = i;
  set.words.push_back(std::move(words));
  return set;
}

// Returns the indices, or nothing if the set does not allow the condition.
std::optional<std::vector<std::uint32_t>> chosen_by(const points::ParticleSet& set,
                                                    const SelectionExpression& condition, const Context& context) {
  const auto chosen = points::choose_particles(set, condition, context);
  if (!chosen) {
    fuzz::require_refusal(chosen.error(), set.label);
    return std::nullopt;
  }
  return std::vector<std::uint32_t>((*chosen)->values.begin(), (*chosen)->values.end());
}

void evaluate_one(std::string_view text) {
  static const points::ParticleSet set = some_particles();
  const auto condition = SelectionExpression::parse(text);
  if (!condition) {
    require(condition.error().code == ErrorCode::usage && !condition.error().message.empty());
    return;
  }
  require(text.size() <= points::kMaxSelectionBytes);
  for (const points::SelectionName& name : condition->names()) require(!name.names.empty());
  const Context context(MemoryBudget(std::uint64_t{8} << 20));
  const auto chosen = chosen_by(set, *condition, context);
  if (chosen) {
    require(std::ranges::is_sorted(*chosen) && std::ranges::adjacent_find(*chosen) == chosen->end());
    require(chosen->empty() || chosen->back() < kParticles);
    // The opposite chooses the others, unless the text is too long or too deep for three more bytes and a level.
    if (const auto opposite = SelectionExpression::parse(fmt::format("!({})", text))) {
      const auto others = chosen_by(set, *opposite, context);
      require(others && others->size() + chosen->size() == kParticles);
    }
  }
  require(context.memory().reserved() == 0);
}

}  // namespace
}  // namespace isoextract

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isoextract::evaluate_one({reinterpret_cast<const char*>(data), size});
  return 0;
}
