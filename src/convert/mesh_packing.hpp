// The packing of meshes: what the field gives to it, and what it did, in voxels too.
#pragma once

#include <string>

#include "convert/conversion_job.hpp"
#include "convert/stage_report.hpp"
#include "field/affine.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::convert {

struct Source;

// Of a mesh that was packed into its file.
struct PackedMesh {
  std::string surface = {};  // "fire.vdb iso 0.5"
  double iso = 0;
  std::string file;
  PackingOptions asked;
  double voxel = 0;  // the shortest side of one, in the mesh's units
  mesh_io::PackedFacts facts;
};
[[nodiscard]] StageReport report_of(const PackedMesh& mesh);

// The box is that of the whole volume, whatever region is extracted, so that regions of one volume meet.
[[nodiscard]] mesh_io::MeshPacking mesh_packing(const PackingOptions& options, const Source& source);

// The shortest side of a voxel that `output_from_index` places.
[[nodiscard]] double shortest_voxel_side(const field::Affine& output_from_index);

}  // namespace isoextract::convert
