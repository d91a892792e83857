#include "convert/mesh_packing.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {
namespace {

std::string means(const mesh_io::PackingOptions& packing) {
  if (packing.compression == mesh_io::Compression::draco) return "by Draco";
  if (packing.compression == mesh_io::Compression::none) return "by quantization";
  return packing.quantize ? "by quantization and meshoptimizer" : "by meshoptimizer";
}

std::string line_of(const PackedMesh& mesh) {
  const mesh_io::PackedFacts& facts = mesh.facts;
  std::string text =
      fmt::format("packed {}{}: {} of {} left ({:.1f} %)", means(mesh.packing), mesh.id.at_text(),
                  format_byte_size(facts.bytes_after), format_byte_size(facts.bytes_before),
                  100.0 * static_cast<double>(facts.bytes_after) / static_cast<double>(facts.bytes_before));
  if (facts.positions) {
    const auto& positions = *facts.positions;
    text +=
        mesh.id.is_file_mesh()
            ? fmt::format("; vertices moved by at most {:.4g} of the mesh's units (measured)", positions.largest_move)
            : fmt::format("; vertices moved by at most {:.4g} voxels (measured), in the mesh's units {:.4g}",
                          positions.largest_move / mesh.packing.voxel, positions.largest_move);
    if (facts.flattened_triangles > 0) {
      text += fmt::format("; {} triangles now have zero area", facts.flattened_triangles);
    }
    text += "; the report gives error, area, volume and bounds of the mesh before packing";
  } else {
    text += "; lossless";
  }
  return text + fmt::format("; {:.2f} s", facts.time.wall_seconds);
}

std::string details_of(const PackedMesh& mesh) {
  const mesh_io::PackedFacts& facts = mesh.facts;
  std::string text = fmt::format("{:.2f} s of processor time", facts.time.cpu_seconds);
  if (facts.positions) {
    text += fmt::format("; positions of {} bits in steps of {} ({:.4g} voxels), moved by at most {:.4g} along an axis",
                        facts.positions->bits, facts.positions->step, facts.positions->step / mesh.packing.voxel,
                        facts.positions->largest_axis_move);
  }
  if (facts.largest_normal_angle)
    text += fmt::format("; normals turned by at most {:.2f} degrees", *facts.largest_normal_angle);
  if (facts.used_sequential_method)
    text += "; triangles stored one by one, because Draco's default method does not reproduce the mesh";
  return text;
}

// Returns the length of a voxel's shortest edge in output coordinates.
double shortest_side(const field::Affine& output_from_index) {
  const glm::dmat3& sides = output_from_index.linear;
  return std::min({glm::length(sides[0]), glm::length(sides[1]), glm::length(sides[2])});
}

}  // namespace

mesh_io::MeshPacking mesh_packing(const mesh_io::PackingOptions& options, const Source& source) {
  mesh_io::MeshPacking packing{options, shortest_side(source.output_from_index)};
  if (!options.packs()) return packing;
  const field::IndexBox extents = source.field.extents();
  if (extents.empty()) return packing;
  // Surfaces of sparse fields pass between active voxels and the background, up to one voxel outside the extents.
  const field::Box samples{glm::dvec3(extents.min) - 1.0, glm::dvec3(extents.max) + 1.0};
  const field::Box box = field::image_of(source.output_from_index, samples);
  packing.box = mesh::Bounds{box.min, box.max};
  return packing;
}

StageReport report_of(const PackedMesh& mesh) {
  const mesh_io::PackedFacts& facts = mesh.facts;
  Value positions;
  if (facts.positions) {
    const auto length = [&](double world) {
      return Figures{{Key::voxels, world / mesh.packing.voxel}, {Key::world, world}};
    };
    positions = Value(Figures{{Key::bits, facts.positions->bits},
                              {Key::step, length(facts.positions->step)},
                              {Key::measured, Figures{{Key::axis, length(facts.positions->largest_axis_move)},
                                                      {Key::distance, length(facts.positions->largest_move)}}}});
  }
  StageReport report(StageName::pack, mesh.surface, {}, mesh.id);
  report.add_timed({{Key::file, mesh.file},
                    {Key::compression, word_of(mesh.packing.compression)},
                    {Key::bytes_before, facts.bytes_before},
                    {Key::bytes_after, facts.bytes_after},
                    {Key::positions, std::move(positions)},
                    {Key::normal_degrees, Value(facts.largest_normal_angle)},
                    {Key::flattened_triangles, facts.flattened_triangles},
                    {Key::one_by_one, facts.used_sequential_method}},
                   facts.time);
  report.did = "packed";
  report.details.push_back(details_of(mesh));
  report.lines.push_back({line_of(mesh)});
  return report;
}

}  // namespace isoextract::convert
