#include "cli/verification_text.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "accuracy/extraction_comparison.hpp"
#include "cli/layout.hpp"

namespace isoextract::cli {
namespace {

std::string worst_text(double worst, std::string_view unit, double allowed, const std::optional<mesh::EdgeKey>& edge) {
  std::string text = fmt::format("largest difference {:.3g} {}, allowed {:.3g}", worst, unit, allowed);
  if (edge) text += fmt::format("; largest at sample {}", accuracy::edge_text(*edge));
  return text;
}

}  // namespace

std::string verification_table(const std::string& label, const convert::VerificationRecord& record) {
  const accuracy::ExtractionComparison& found = record.comparison;
  NamedLines lines;
  lines.plain(fmt::format("{} iso {}: {} and {}", label, record.iso, record.backends[0], record.backends[1]));
  if (!record.not_applicable.empty()) {
    lines.add("same", "not applicable: " + record.not_applicable);
    return lines.take();
  }
  const auto counts = [&](std::string_view name, const std::array<std::uint64_t, 2>& total,
                          const std::array<std::uint64_t, 2>& only) {
    lines.add(name, fmt::format("{} and {}; without a match {} and {}", total[0], total[1], only[0], only[1]));
  };
  counts("triangles", found.triangles.total, found.triangles.only);
  counts("vertices", found.vertices, found.vertices_only);
  lines.add("positions", worst_text(found.ulps, "ulps", accuracy::kStabilityUlps, found.farthest));
  if (found.normals_compared) {
    lines.add("normals", worst_text(found.degrees, "degrees", accuracy::kNormalDegrees, found.largest_angle_edge));
  }
  lines.add("same", record.differences.empty() ? "yes" : "no");
  return lines.take();
}

}  // namespace isoextract::cli
