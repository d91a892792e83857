#include "base/attribute_kind.hpp"

#include <algorithm>
#include <string>

#include "base/ascii.hpp"

namespace isoextract {
namespace {

struct NamedKind {
  std::string_view name;
  AttributeKind kind;
};

// Whole names.
constexpr std::array<NamedKind, 31> kNames{
    {{"v", AttributeKind::vector},           {"u", AttributeKind::vector},
     {"f", AttributeKind::vector},           {"momenta", AttributeKind::vector},
     {"n", AttributeKind::normal},           {"cd", AttributeKind::color},
     {"cs", AttributeKind::color},           {"rgb", AttributeKind::color},
     {"rgba", AttributeKind::color},         {"albedo", AttributeKind::color},
     {"diffuse", AttributeKind::color},      {"p", AttributeKind::point},
     {"pos", AttributeKind::point},          {"position", AttributeKind::point},
     {"positions", AttributeKind::point},    {"point", AttributeKind::point},
     {"points", AttributeKind::point},       {"pref", AttributeKind::point},
     {"rest", AttributeKind::point},         {"restp", AttributeKind::point},
     {"coord", AttributeKind::point},        {"coords", AttributeKind::point},
     {"coordinate", AttributeKind::point},   {"coordinates", AttributeKind::point},
     {"location", AttributeKind::point},     {"center", AttributeKind::point},
     {"centre", AttributeKind::point},       {"x y z", AttributeKind::point},
     {"disp", AttributeKind::vector},        {"impulse", AttributeKind::vector},
     {"rest_position", AttributeKind::point}}};

// Prefixes of names.
constexpr std::array<NamedKind, 6> kBeginnings{{{"vel", AttributeKind::vector},
                                                {"force", AttributeKind::vector},
                                                {"accel", AttributeKind::vector},
                                                {"normal", AttributeKind::normal},
                                                {"color", AttributeKind::color},
                                                {"colour", AttributeKind::color}}};

// Parts of names, as in "wind_velocity".
constexpr std::array<NamedKind, 4> kWords{{{"velocity", AttributeKind::vector},
                                           {"acceleration", AttributeKind::vector},
                                           {"displacement", AttributeKind::vector},
                                           {"momentum", AttributeKind::vector}}};

// Angular velocities do not scale with lengths, so they are not vectors here.
constexpr std::string_view kAngular = "angular";

template <class Names, class Matches>
std::optional<AttributeKind> kind_where(const Names& names, Matches&& matches) {
  const auto found = std::ranges::find_if(names, [&](const NamedKind& named) { return matches(named.name); });
  return found == names.end() ? std::nullopt : std::optional(found->kind);
}

}  // namespace

std::optional<AttributeKind> kind_by_name(std::string_view name) {
  const std::string lower = to_lower(name);
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  if (has(kAngular)) return std::nullopt;
  if (const auto kind = kind_where(kNames, [&](std::string_view whole) { return lower == whole; })) return kind;
  if (const auto kind = kind_where(kBeginnings, [&](std::string_view start) { return lower.starts_with(start); })) {
    return kind;
  }
  return kind_where(kWords, has);
}

}  // namespace isoextract
