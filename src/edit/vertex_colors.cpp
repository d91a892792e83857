#include "edit/vertex_colors.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "base/srgb.hpp"

namespace isoextract::edit {
namespace {

// Returns the value that a vertex's color shows.
class ColorValues {
 public:
  explicit ColorValues(const mesh::Attribute& attribute) : attribute_(attribute) {}

  [[nodiscard]] double operator()(std::size_t vertex) const {
    const std::byte* at = attribute_.values.data() + vertex * attribute_.stride();
    double squared = 0;
    double value = 0;
    for (std::size_t c = 0; c < attribute_.components; ++c) {
      value = mesh::component_value(at + c * component_size(attribute_.type), attribute_.type, attribute_.normalized);
      squared += value * value;
    }
    return attribute_.components == 1 ? value : std::sqrt(squared);
  }

 private:
  const mesh::Attribute& attribute_;
};

const mesh::Attribute& attribute_of(const mesh::Mesh& mesh, const std::string& name) {
  return *std::ranges::find(mesh.attributes, name, &mesh::Attribute::name);
}

// Returns the range of the finite values, if there are any.
std::optional<ValueRange> range_of(const ColorValues& value, std::size_t vertices) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const ValueRange range = reduce_ranges(
      vertices, 1 << 14, ValueRange{kInfinity, -kInfinity},
      [&](std::size_t begin, std::size_t end, ValueRange found) {
        for (std::size_t v = begin; v != end; ++v) {
          const double x = value(v);
          if (std::isfinite(x)) found = {std::min(found[0], x), std::max(found[1], x)};
        }
        return found;
      },
      [](const ValueRange& a, const ValueRange& b) {
        return ValueRange{std::min(a[0], b[0]), std::max(a[1], b[1])};
      });
  return range[0] <= range[1] ? std::optional(range) : std::nullopt;
}

template <class T>
T as_fraction(double channel) {
  return static_cast<T>(std::lround(channel * std::numeric_limits<T>::max()));
}

void put_color(const glm::dvec3& color, bool linear, std::byte* out) {
  if (linear) {
    constexpr auto kOpaque = std::numeric_limits<std::uint16_t>::max();
    std::array<std::uint16_t, 4> rgba{0, 0, 0, kOpaque};
    for (int c = 0; c < 3; ++c) {
      rgba[static_cast<std::size_t>(c)] = as_fraction<std::uint16_t>(srgb_to_linear(color[c]));
    }
    std::memcpy(out, rgba.data(), sizeof rgba);
    return;
  }
  for (int c = 0; c < 3; ++c) out[c] = static_cast<std::byte>(as_fraction<std::uint8_t>(color[c]));
}

// Returns a color attribute without values.
mesh::Attribute color_attribute(ColorStorage storage) {
  const bool linear = storage == ColorStorage::linear_u16;
  mesh::Attribute made;
  made.name = "color";
  made.role = mesh::AttributeRole::color;
  made.type = linear ? mesh::ComponentType::u16 : mesh::ComponentType::u8;
  made.components = linear ? 4 : 3;
  made.normalized = true;
  return made;
}

Result<Reservation> reserve_colors(std::size_t vertices, const mesh::Attribute& made, const Context& context) {
  return context.reserve(vertices * made.stride(), "the vertex colors");
}

}  // namespace

double place_in(const ValueRange& range, double value) {
  if (std::isnan(value) || range[0] < range[1]) return (value - range[0]) / (range[1] - range[0]);
  return 0.5;
}

std::optional<ValueRange> range_of_attribute(const mesh::Mesh& mesh, const std::string& attribute) {
  return range_of(ColorValues(attribute_of(mesh, attribute)), mesh.positions.size());
}

Result<ValueColors> color_by_values(mesh::Mesh& mesh, const std::string& attribute, Colormap map,
                                    const std::optional<ValueRange>& range, ColorStorage storage,
                                    const Context& context) {
  mesh::Attribute made = color_attribute(storage);
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(reserve_colors(vertices, made, context));
  made.values = Buffer<std::byte>(vertices * made.stride());

  const ColorValues value(attribute_of(mesh, attribute));
  const ValueRange ends = range ? *range : range_of(value, vertices).value_or(ValueRange{});
  const bool linear = storage == ColorStorage::linear_u16;
  std::atomic<std::uint64_t> not_numbers{0};
  for_each_range(vertices, 4096, [&](std::size_t begin, std::size_t end) {
    std::uint64_t gray = 0;
    for (std::size_t v = begin; v != end; ++v) {
      const double place = place_in(ends, value(v));
      if (std::isnan(place)) ++gray;
      put_color(color_at(map, place), linear, made.values.data() + v * made.stride());
    }
    not_numbers.fetch_add(gray, std::memory_order_relaxed);
  });
  std::erase_if(mesh.attributes, [](const mesh::Attribute& other) { return other.role == mesh::AttributeRole::color; });
  mesh.attributes.push_back(std::move(made));
  mesh.memory.take(std::move(memory));
  return ValueColors{ends, not_numbers.load()};
}

Result<void> color_uniformly(mesh::Mesh& mesh, const glm::dvec3& color, const Context& context) {
  return color_ranges(mesh, std::array{RangeColor{0, mesh.positions.size(), color}}, context);
}

Result<void> color_ranges(mesh::Mesh& mesh, std::span<const RangeColor> ranges, const Context& context) {
  mesh::Attribute made = color_attribute(ColorStorage::srgb_u8);
  auto memory = TRY(reserve_colors(mesh.positions.size(), made, context));
  made.values = Buffer<std::byte>(mesh.positions.size() * made.stride());
  std::ranges::fill(made.values, std::byte{0xFF});
  for (const RangeColor& range : ranges) {
    std::byte* const first = made.values.data() + range.first_vertex * made.stride();
    for (std::size_t v = 0; v < range.vertices; ++v) put_color(range.color, false, first + v * made.stride());
  }
  mesh.attributes.push_back(std::move(made));
  mesh.memory.take(std::move(memory));
  return {};
}

Result<void> store_colors(mesh::Mesh& mesh, bool are_linear, ColorStorage storage, const Context& context) {
  const auto found = std::ranges::find(mesh.attributes, mesh::AttributeRole::color, &mesh::Attribute::role);
  if (found == mesh.attributes.end()) return {};
  const mesh::Attribute& given = *found;
  const bool linear = storage == ColorStorage::linear_u16;
  mesh::Attribute made = color_attribute(storage);
  made.name = given.name;
  made.components = linear ? 4 : given.components;
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(reserve_colors(vertices, made, context));
  made.values = Buffer<std::byte>(vertices * made.stride());
  const std::size_t size = mesh::component_size(given.type);
  for_each_range(vertices, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      const std::byte* const from = given.values.data() + v * given.stride();
      std::byte* const to = made.values.data() + v * made.stride();
      for (std::size_t c = 0; c < made.components; ++c) {
        const double value = c < given.components ? mesh::component_value(from + c * size, given.type, true) : 1;
        double channel = std::isnan(value) ? 0 : std::clamp(value, 0.0, 1.0);
        if (c < 3 && are_linear != linear) channel = linear ? srgb_to_linear(channel) : linear_to_srgb(channel);
        if (linear) {
          const auto word = as_fraction<std::uint16_t>(channel);
          std::memcpy(to + c * sizeof word, &word, sizeof word);
        } else {
          to[c] = static_cast<std::byte>(as_fraction<std::uint8_t>(channel));
        }
      }
    }
  });
  *found = std::move(made);
  mesh.memory.take(std::move(memory));
  return {};
}

}  // namespace isoextract::edit
