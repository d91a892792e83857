// An output file while its surfaces are made.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "convert/detail/label_files.hpp"
#include "convert/mesh_collector.hpp"
#include "convert/mesh_normals.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/stages/mesh_facts.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

// Returns the write options for meshes of this job and source.
[[nodiscard]] inline mesh_io::MeshWriteOptions write_options(const ConversionJob& job, const Source& source,
                                                             bool hash_files) {
  const MeshFileOptions meshes = job.meshes();
  return {
      meshes.format,        job.normals == Normals::flat,           meshes.ascii, mesh_packing(meshes.packing, source),
      copies_vertices(job), source.placement_record(meshes.format), hash_files};
}

struct OutputMeshes {
  const OutputFileJob& job;
  mesh_io::MeshWriter writer;
  LabelFileNames label_names;
  WrittenOutput written = {};
  StageTime time = {};
  std::vector<mesh::Mesh> held = {};  // for the collector or the picture, which use no writer
  std::vector<Figures> facts = {};    // of the meshes, if the caller asked for them

  [[nodiscard]] std::vector<SurfaceId> ids() const {
    std::vector<SurfaceId> all;
    for (const WrittenOutput::Part& part : written.surfaces) all.push_back(part.id);
    return all;
  }

  // Records a surface, before it goes to the writer. `label` and `grid` are those of its field.
  void note(const Surface& surface, const std::string& label, const std::string& grid) {
    if (surface.facts) facts.push_back(facts_as_written(surface, job.path, grid));
    const bool closed = surface.open_edges ? *surface.open_edges == 0
                                           : !surface.open_boundary.at_data_boundary && !surface.open_boundary.cut;
    written.surfaces.push_back({label, surface.id, surface.open_boundary, surface.mesh.name, surface.triangles(),
                                closed, surface.label_voxels, surface.label_volume});
    written.triangles += surface.triangles();
    written.vertices += surface.vertices();
    if (surface.welded) {
      written.welded.open_edges += surface.welded->open_edges;
      written.welded.nonmanifold_edges += surface.welded->nonmanifold_edges;
      written.welded.nonmanifold_vertices += surface.welded->nonmanifold_vertices;
      written.welded.misoriented_edges += surface.welded->misoriented_edges;
    }
    if (surface.open_edges) written.open_edges = written.open_edges.value_or(0) + *surface.open_edges;
  }

  // Adds the surfaces and figures of `own`, the file of one label.
  void take(OutputMeshes& own) {
    std::ranges::move(own.written.surfaces, std::back_inserter(written.surfaces));
    written.triangles += own.written.triangles;
    written.vertices += own.written.vertices;
    written.bytes += own.written.bytes;
    written.files += own.written.files;
    if (own.written.open_edges) written.open_edges = written.open_edges.value_or(0) + *own.written.open_edges;
    time += own.time;
  }

  // Moves the held meshes to the collector, with their ids, packing and placement record.
  void collect(mesh_io::MeshWriteOptions options, MeshCollector& collector) {
    std::ranges::move(held, std::back_inserter(collector.meshes));
    std::ranges::copy(ids(), std::back_inserter(collector.ids));
    collector.packing = options.packing;
    collector.placement = std::move(options.placement);
  }

  // Returns a report of the packing of each mesh that has triangles.
  [[nodiscard]] std::vector<StageReport> packed(const std::vector<mesh_io::PackedFacts>& done,
                                                const mesh_io::MeshPacking& packing) const {
    std::vector<StageReport> reports;
    for (std::size_t m = 0; m < done.size(); ++m) {
      if (done[m].bytes_before == 0) continue;
      const WrittenOutput::Part& part = written.surfaces[m];
      reports.push_back(
          report_of({part.id.is_only_surface() ? part.label : fmt::format("{} {}", part.label, part.id.name()), part.id,
                     job.path, packing, done[m]}));
    }
    return reports;
  }
};

}  // namespace isoextract::convert
