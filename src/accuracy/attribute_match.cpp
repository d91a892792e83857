#include "accuracy/attribute_match.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isoextract::accuracy {
namespace {

using mesh::AttributeRole;

double component_of(const mesh::Attribute& attribute, std::size_t vertex, std::size_t component) {
  const std::byte* at =
      attribute.values.data() + vertex * attribute.stride() + component * mesh::component_size(attribute.type);
  // Colors count as normalized: PLY does not store that flag as glTF does.
  return component_value(at, attribute.type, attribute.normalized || attribute.role == AttributeRole::color);
}

bool have_same_vertices(const mesh::Mesh& a, const mesh::Mesh& b, double tolerance) {
  if (a.positions.size() != b.positions.size()) return false;
  for (std::size_t v = 0; v < a.positions.size(); ++v) {
    const glm::dvec3 apart = glm::abs(a.position(v) - b.position(v));
    if (!glm::all(glm::lessThanEqual(apart, glm::dvec3(tolerance)))) return false;
  }
  return true;
}

AttributeMatch::Difference difference_of(const mesh::Attribute& a, const mesh::Attribute& b, std::size_t vertices) {
  AttributeMatch::Difference found;
  double sum = 0;
  std::uint64_t counted = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t c = 0; c < a.components; ++c) {
      const double x = component_of(a, v, c);
      const double y = component_of(b, v, c);
      const bool same = x == y || (std::isnan(x) && std::isnan(y));
      if (!same && !(std::isfinite(x) && std::isfinite(y))) {
        ++found.not_finite;
        continue;
      }
      const double apart = same ? 0 : std::abs(x - y);
      sum += apart;
      ++counted;
      if (apart > found.largest) {
        found.largest = apart;
        found.vertex = v;
      }
    }
  }
  if (counted > 0) found.mean = sum / static_cast<double>(counted);
  return found;
}

bool are_one(const mesh::Attribute& a, const mesh::Attribute& b) {
  if (a.role != b.role) return false;
  return a.role == AttributeRole::color || a.name == b.name;
}

}  // namespace

double coordinate_rounding(const mesh::Mesh& mesh) {
  bool are_floats = true;
  glm::dvec3 farthest(0);
  glm::dvec3 farthest_from_origin(0);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 place = mesh.position(v);
    are_floats = are_floats && glm::dvec3(glm::vec3(place)) == place;
    farthest = glm::max(farthest, glm::abs(place));
    farthest_from_origin = glm::max(farthest_from_origin, glm::abs(glm::dvec3(mesh.positions[v])));
  }
  const glm::dvec3 rounded = are_floats ? farthest : farthest_from_origin;
  return std::max({rounded.x, rounded.y, rounded.z}) * std::numeric_limits<float>::epsilon();
}

AttributeMatches match_attributes(const mesh::Mesh& a, const mesh::Mesh& b, bool colors, double tolerance) {
  AttributeMatches matches;
  matches.same_vertices = have_same_vertices(a, b, tolerance);
  const auto partner = [](const mesh::Attribute& wanted, const mesh::Mesh& other) {
    return std::ranges::find_if(other.attributes, [&](const mesh::Attribute& one) { return are_one(wanted, one); });
  };
  for (const mesh::Attribute& mine : a.attributes) {
    const auto other = partner(mine, b);
    if (other == b.attributes.end()) {
      matches.only[0].push_back(mine.name);
      continue;
    }
    AttributeMatch& match =
        matches.both.emplace_back(AttributeMatch{mine.name, {mine.components, other->components}, {}});
    const bool means_the_same = colors || mine.role != AttributeRole::color;
    if (matches.same_vertices && mine.components == other->components && means_the_same) {
      match.difference = difference_of(mine, *other, a.positions.size());
    }
  }
  for (const mesh::Attribute& theirs : b.attributes) {
    if (partner(theirs, a) == a.attributes.end()) matches.only[1].push_back(theirs.name);
  }
  return matches;
}

}  // namespace isoextract::accuracy
