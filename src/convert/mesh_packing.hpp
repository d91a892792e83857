// Compression and quantization of meshes in files: parameters that come from the field, and a report in voxels as well.
#pragma once

#include <string>

#include "convert/stage_report.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::convert {

struct Source;

// Result of packing one mesh into its file.
struct PackedMesh {
  std::string surface = {};  // "fire.vdb iso 0.5"
  SurfaceId id;
  std::string file;
  mesh_io::MeshPacking packing;
  mesh_io::PackedFacts facts;
};
[[nodiscard]] StageReport report_of(const PackedMesh& mesh);

// Returns the packing parameters. The quantization box covers the whole field whatever region is extracted, so that
// meshes of regions of one volume meet. The box is unset if `options` pack nothing or the field is empty.
[[nodiscard]] mesh_io::MeshPacking mesh_packing(const mesh_io::PackingOptions& options, const Source& source);

}  // namespace isoextract::convert
