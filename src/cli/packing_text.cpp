#include "cli/packing_text.hpp"

#include <fmt/format.h>

#include "base/byte_size.hpp"

namespace isoextract::cli {
namespace {

std::string means(const convert::PackingOptions& asked) {
  if (asked.compression == meshes::Compression::draco) return "by Draco";
  if (asked.compression == meshes::Compression::none) return "by quantising";
  return asked.quantize ? "by quantising and meshoptimizer" : "by meshoptimizer";
}

}  // namespace

std::string packing_summary(const convert::MeshPackingRecord& record) {
  const meshes::PackedFacts& facts = record.facts;
  std::string text =
      fmt::format("packed {} at iso {}: {} of {} left ({:.1f} %)", means(record.asked), record.iso,
                  format_byte_size(facts.bytes_after), format_byte_size(facts.bytes_before),
                  100.0 * static_cast<double>(facts.bytes_after) / static_cast<double>(facts.bytes_before));
  if (facts.positions) {
    const auto& positions = *facts.positions;
    text += fmt::format("; vertices measured at most {:.4g} voxels from where they were, in the mesh's units {:.4g}",
                        positions.largest / record.voxel, positions.largest);
    if (facts.flattened_triangles > 0) {
      text += fmt::format("; {} triangles have lost their area", facts.flattened_triangles);
    }
    text += "; the error, area, volume and bounds given are those of the mesh before packing";
  } else {
    text += "; nothing is lost";
  }
  return text + fmt::format("; {:.2f} s", facts.time.wall_seconds);
}

std::string packing_details(const convert::MeshPackingRecord& record) {
  const meshes::PackedFacts& facts = record.facts;
  std::string text = fmt::format("{:.2f} s of processor time", facts.time.cpu_seconds);
  if (facts.positions) {
    text += fmt::format("; positions of {} bits in steps of {} ({:.4g} voxels), moved by at most {:.4g} along an axis",
                        facts.positions->bits, facts.positions->step, facts.positions->step / record.voxel,
                        facts.positions->largest_axis);
  }
  if (facts.largest_normal_turn)
    text += fmt::format("; normals turned by at most {:.2f} degrees", *facts.largest_normal_turn);
  if (facts.one_by_one) text += "; triangle by triangle, as they do not join as on a manifold";
  return text;
}

}  // namespace isoextract::cli
