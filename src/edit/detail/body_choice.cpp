#include "edit/detail/body_choice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace isoextract::edit {
namespace {

using mesh::ComponentFacts;

// Returns the measure plus the largest loss through rounding, which moves each vertex by at most `rounding`.
double measured(const ComponentFacts& facts, ComponentMeasure measure, double rounding) {
  const auto triangles = static_cast<double>(facts.triangles);
  switch (measure) {
    case ComponentMeasure::triangles: return triangles;
    // Rounding changes an area by up to `rounding` times half the sum of the sides, which is at least 4.56 roots of the
    // area (equilateral). The factor 4 instead of 2.28 allows for longer sides.
    case ComponentMeasure::area: return facts.area + 4 * rounding * std::sqrt(triangles * facts.area);
    case ComponentMeasure::volume: break;
  }
  return facts.is_closed() ? std::abs(facts.volume) + facts.area * rounding : std::numeric_limits<double>::infinity();
}

// Returns how far a vertex may be from its exact position, in the space of `to_metric`: rounding to float32, plus the
// margin at the ends of grid edges, which is eight times the rounding.
double rounding_of(double resolution, const glm::dmat3& to_metric) {
  constexpr double kMarginAndRounding = 9;
  const double stretch = glm::length(to_metric[0]) + glm::length(to_metric[1]) + glm::length(to_metric[2]);
  return kMarginAndRounding * stretch * resolution;
}

std::vector<bool> staying(std::span<const ComponentFacts> facts, const Nesting& nesting, const BodySelection& options,
                          double rounding) {
  const std::size_t count = facts.size();
  std::vector<bool> stays(count, true);
  std::vector<bool> filled(count, false);  // cavities to fill, and then the components in them
  for (std::size_t i = 0; i < count; ++i) {
    const bool small = options.least && measured(facts[i], options.measure, rounding) < *options.least;
    if (!nesting.is_body(i)) {
      filled[i] = small || options.fill_cavities;
    } else if (small) {
      stays[i] = false;
    }
  }
  // Filling a cavity removes the bodies in it and fills their cavities, too.
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t around = nesting.within[i];
      const bool swallowed = nesting.is_body(i) ? around != Nesting::kNone && filled[around] : filled[nesting.body[i]];
      if (swallowed && !filled[i]) filled[i] = more = true;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (filled[i]) stays[i] = false;
  }
  if (options.largest) {
    std::vector<std::uint32_t> bodies = bodies_by_area(facts, nesting, stays);
    for (std::size_t i = *options.largest; i < bodies.size(); ++i) stays[bodies[i]] = false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!stays[nesting.body[i]]) stays[i] = false;
  }
  return stays;
}

BodyCounts counts_of(std::span<const ComponentFacts> facts, const Nesting& nesting, const std::vector<bool>& stays) {
  BodyCounts counts;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    if (!stays[i]) continue;
    ++counts.components;
    counts.bodies += nesting.is_body(i) ? 1 : 0;
    counts.triangles += facts[i].triangles;
  }
  return counts;
}

}  // namespace

Nesting Nesting::without_cavities(std::size_t components) {
  Nesting nesting;
  nesting.body.resize(components);
  std::iota(nesting.body.begin(), nesting.body.end(), 0U);
  nesting.within.assign(components, kNone);
  return nesting;
}

bool has_cavities(std::span<const ComponentFacts> facts) {
  return std::ranges::any_of(facts, &ComponentFacts::faces_inward);
}

mesh::ShellQuery shell_query(std::span<const ComponentFacts> facts) {
  mesh::ShellQuery question{.find_open = true};
  for (const ComponentFacts& one : facts) {
    question.facing.push_back(!one.is_closed()     ? mesh::Facing::open
                              : one.faces_inward() ? mesh::Facing::inward
                                                   : mesh::Facing::outward);
  }
  return question;
}

Nesting nesting_of(std::span<const ComponentFacts> facts, const std::vector<mesh::Surroundings>& surroundings) {
  Nesting nesting = Nesting::without_cavities(facts.size());
  const auto is_deeper = [&](std::uint32_t a, std::uint32_t b) {
    return surroundings[a].around.size() < surroundings[b].around.size();
  };
  // Returns the body around a cavity: the innermost shell around it if that is outward, or an open component, or kNone.
  const auto body_around = [&](std::uint32_t cavity) {
    const std::vector<std::uint32_t>& around = surroundings[cavity].around;
    if (around.empty()) return surroundings[cavity].open;
    const std::uint32_t innermost = *std::ranges::max_element(around, is_deeper);
    return facts[innermost].faces_inward() ? Nesting::kNone : innermost;
  };
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (!facts[i].faces_inward()) continue;
    if (const std::uint32_t body = body_around(i); body != Nesting::kNone) nesting.body[i] = body;
  }
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (nesting.body[i] != i) continue;
    std::uint32_t& within = nesting.within[i];
    for (const std::uint32_t other : surroundings[i].around) {
      const bool is_wall = nesting.body[other] != other;
      if (is_wall && (within == Nesting::kNone || is_deeper(within, other))) within = other;
    }
  }
  return nesting;
}

std::vector<std::uint32_t> bodies_by_area(std::span<const ComponentFacts> facts, const Nesting& nesting,
                                          const std::vector<bool>& stays) {
  std::vector<std::uint32_t> bodies;
  for (std::uint32_t i = 0; i < facts.size(); ++i) {
    if (stays[i] && nesting.is_body(i)) bodies.push_back(i);
  }
  std::ranges::stable_sort(bodies, std::greater<>(), [&](std::uint32_t i) { return facts[i].area; });
  return bodies;
}

BodyChoice choose_bodies(std::span<const ComponentFacts> facts, const Nesting& nesting, const BodySelection& options,
                         double resolution) {
  BodyChoice choice;
  choice.stays = staying(facts, nesting, options, rounding_of(resolution, options.to_metric));
  choice.figures.before = counts_of(facts, nesting, std::vector<bool>(facts.size(), true));
  choice.figures.after = counts_of(facts, nesting, choice.stays);
  if (options.least && options.measure == ComponentMeasure::volume) {
    for (std::size_t i = 0; i < facts.size(); ++i) {
      choice.figures.without_volume += choice.stays[i] && !facts[i].is_closed() ? 1 : 0;
    }
  }
  return choice;
}

}  // namespace isoextract::edit
