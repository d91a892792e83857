#include "convert/stages/vertex_colours.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "convert/stages/surface_stages.hpp"

namespace isoextract::convert {
namespace {

// Of the outermost of several surfaces; the innermost is opaque, and those between are evenly so.
constexpr double kOutermostOpacity = 0.25;

using Range = std::array<double, 2>;

// The value of a vertex that its colour stands for.
class ColourValues {
 public:
  explicit ColourValues(const mesh::Attribute& attribute) : attribute_(attribute) {}

  [[nodiscard]] double operator()(std::size_t vertex) const {
    const std::byte* at = attribute_.values.data() + vertex * attribute_.stride();
    double squared = 0;
    float value = 0;
    for (std::size_t c = 0; c < attribute_.components; ++c) {
      std::memcpy(&value, at + c * sizeof value, sizeof value);
      squared += static_cast<double>(value) * static_cast<double>(value);
    }
    return attribute_.components == 1 ? static_cast<double>(value) : std::sqrt(squared);
  }

 private:
  const mesh::Attribute& attribute_;
};

// Of the finite values; 0 and 0 where there are none.
Range range_of(const ColourValues& value, std::size_t vertices) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Range range = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, vertices, 1 << 14), Range{kInfinity, -kInfinity},
      [&](const tbb::blocked_range<std::size_t>& part, Range found) {
        for (std::size_t v = part.begin(); v != part.end(); ++v) {
          const double x = value(v);
          if (std::isfinite(x)) found = {std::min(found[0], x), std::max(found[1], x)};
        }
        return found;
      },
      [](const Range& a, const Range& b) {
        return Range{std::min(a[0], b[0]), std::max(a[1], b[1])};
      });
  return range[0] <= range[1] ? range : Range{0, 0};
}

double place_in(const Range& range, double value) {
  if (std::isnan(value) || range[0] < range[1]) return (value - range[0]) / (range[1] - range[0]);
  return 0.5;
}

template <class T>
T as_fraction(double channel) {
  return static_cast<T>(std::lround(channel * std::numeric_limits<T>::max()));
}

void put_colour(const glm::dvec3& colour, bool linear, std::byte* out) {
  if (linear) {
    constexpr auto kOpaque = std::numeric_limits<std::uint16_t>::max();
    std::array<std::uint16_t, 4> rgba{0, 0, 0, kOpaque};
    for (int c = 0; c < 3; ++c) {
      rgba[static_cast<std::size_t>(c)] = as_fraction<std::uint16_t>(linear_of_srgb(colour[c]));
    }
    std::memcpy(out, rgba.data(), sizeof rgba);
    return;
  }
  for (int c = 0; c < 3; ++c) out[c] = static_cast<std::byte>(as_fraction<std::uint8_t>(colour[c]));
}

// From the outermost on, from 0 to 1; of one that is alone 1. Values that were found can be the same, of which there is
// one surface.
double depth_of(const std::vector<double>& isos, double iso, field::FieldKind kind) {
  const std::set<double> surfaces(isos.begin(), isos.end());
  if (surfaces.size() < 2) return 1;
  const auto outer = std::ranges::count_if(
      surfaces, [&](double other) { return kind == field::FieldKind::density ? other < iso : other > iso; });
  return static_cast<double>(outer) / static_cast<double>(surfaces.size() - 1);
}

double opacity_of(const ConversionJob& job, std::span<const double> isos, double iso, field::FieldKind kind) {
  if (job.opacity.size() == 1) return job.opacity.front();
  if (!job.opacity.empty()) {
    const auto at = static_cast<std::size_t>(std::ranges::find(isos, iso) - isos.begin());
    return job.opacity[std::min(at, job.opacity.size() - 1)];
  }
  const bool by_iso = job.colour && !job.colour->attribute;
  if (!by_iso) return 1;
  std::vector<double> around(isos.begin(), isos.end());  // of the surfaces that may be around this one, or within it
  if (job.source.away_from_zero) {
    const bool above = kind == field::FieldKind::density;
    std::erase_if(around, [&](double other) { return other != iso && !(above ? other > 0 : other < 0); });
  }
  return kOutermostOpacity + (1 - kOutermostOpacity) * depth_of(around, iso, kind);
}

// Removes the attributes that only give colors.
void drop_unwritten(const ConversionJob& job, mesh::Mesh& mesh) {
  for (const AttributeChoice& choice : job.source.attributes) {
    if (choice.written) continue;
    std::erase_if(mesh.attributes, [&](const mesh::Attribute& a) {
      return a.role != mesh::AttributeRole::colour && a.name == choice.name;
    });
  }
}

Result<StageReport> color_by_attribute(Surface& surface, const StageContext& stage) {
  const ConversionJob& job = stage.job;
  if (!job.colour || !job.colour->attribute) return StageReport();
  const std::string& attribute = *job.colour->attribute;
  const auto is_meant = [&](const MissingAttribute& missing) { return missing.choice.name == attribute; };
  if (std::ranges::any_of(stage.source.attributes->missing, is_meant)) return StageReport();  // it was told
  const auto made = TRY(add_colours(*job.colour, job.format, surface.mesh, stage.context));
  const bool own_range = !job.colour->range;
  StageReport report = stage.report_on(StageName::color, surface);
  report.entries.push_back({{Key::attribute, attribute},
                            {Key::map, word_of(job.colour->map)},
                            {Key::range, Value(made.range)},
                            {Key::own_range, own_range},
                            {Key::not_numbers, made.not_numbers}});
  report.lines.push_back({fmt::format("colours of {}: {}, {} from {:.6g} to {:.6g}{}", stage.at(surface),
                                      printable(attribute), word_of(job.colour->map), made.range[0], made.range[1],
                                      own_range ? ", the range of its vertices" : "")});
  if (made.not_numbers > 0) {
    report.notes.push_back(fmt::format("{}: {} of {} vertices are grey, as '{}' is no number there", report.subject,
                                       made.not_numbers, surface.mesh.positions.size(), printable(attribute)));
  }
  drop_unwritten(job, surface.mesh);
  return report;
}

}  // namespace

Result<VertexColors> add_colours(const ColourChoice& choice, mesh_io::MeshFormat format, mesh::Mesh& mesh,
                                 const Context& context) {
  const auto from = std::ranges::find(mesh.attributes, choice.attribute.value_or(""), &mesh::Attribute::name);
  const bool linear = mesh_io::is_gltf(format);
  mesh::Attribute made;
  made.name = "colour";
  made.role = mesh::AttributeRole::colour;
  made.type = linear ? mesh::ComponentType::u16 : mesh::ComponentType::u8;
  made.components = linear ? 4 : 3;
  made.normalised = true;
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(context.reserve(vertices * made.stride(), "colours of vertices"));
  made.values = Buffer<std::byte>(vertices * made.stride());

  const ColourValues value(*from);
  const Range range = choice.range ? *choice.range : range_of(value, vertices);  // which looks at every vertex
  std::atomic<std::uint64_t> not_numbers{0};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, 4096), [&](const auto& part) {
    std::uint64_t grey = 0;
    for (std::size_t v = part.begin(); v != part.end(); ++v) {
      const double place = place_in(range, value(v));
      if (std::isnan(place)) ++grey;
      put_colour(edit::colour_at(choice.map, place), linear, made.values.data() + v * made.stride());
    }
    not_numbers.fetch_add(grey, std::memory_order_relaxed);
  });
  mesh.attributes.push_back(std::move(made));
  mesh.memory.take(std::move(memory));
  return VertexColors{range, not_numbers.load()};
}

std::optional<mesh::Material> material_of(const ConversionJob& job, std::span<const double> isos, double iso,
                                          field::FieldKind kind, bool open) {
  const bool by_iso = job.colour && !job.colour->attribute;
  if (!by_iso && job.opacity.empty() && !open) return std::nullopt;
  mesh::Material material;
  material.double_sided = open;
  material.opacity = opacity_of(job, isos, iso, kind);
  if (!by_iso) return material;
  const auto [least, greatest] = std::ranges::minmax(isos);
  const glm::dvec3 colour =
      edit::colour_at(job.colour->map, place_in(job.colour->range.value_or(Range{least, greatest}), iso));
  material.colour = glm::dvec3(linear_of_srgb(colour.x), linear_of_srgb(colour.y), linear_of_srgb(colour.z));
  return material;
}

Result<StageReport> color_surface(Surface& surface, const StageContext& stage) {
  const SurfaceFacts& facts = stage.facts;
  surface.mesh.material = material_of(stage.job, facts.isos, surface.iso, stage.source.field.kind, facts.may_be_open);
  if (facts.labels != nullptr) {
    TRY(facts.labels->colour(stage.job, static_cast<std::int64_t>(surface.iso), surface.mesh, stage.context));
  }
  auto report = color_by_attribute(surface, stage);
  // Colors, which go by the values of the input, are made.
  if (const auto& attributes = stage.source.attributes; report && attributes) {
    change_attributes(surface.mesh, attributes->kinds, attributes->output_from_world);
  }
  return report;
}

}  // namespace isoextract::convert
