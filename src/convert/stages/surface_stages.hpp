// Runs the stages between a surface's extraction and its file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/attribute_source.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/label_looks.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "convert/stages.hpp"
#include "convert/stages/vertex_colors.hpp"
#include "edit/bodies.hpp"
#include "edit/vertex_colors.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_measures.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {

// The vertex attributes of a mesh that went to its file part by part.
struct AttributesOfParts {
  std::vector<AttributeResult> results;
  std::uint64_t vertices = 0;     // of the mesh, before bodies were dropped
  edit::ValueColors colors = {};  // if the job colors the vertices by an attribute
  StageTime time = {};
};

struct Surface {
  IsoChoice asked;
  SurfaceId id;
  mesh::Mesh mesh;
  std::optional<mesh::MeshShape> taken = {};  // set if the mesh went to its file part by part; `mesh` is then empty
  OpenBoundary open_boundary = {};
  bool counts_open_edges = false;                // only a count of boundary edges tells whether the mesh is closed
  std::optional<Figures> error = {};             // set if it was measured
  std::optional<Figures> facts = {};             // set if requested; measured before shading duplicates vertices
  StageTime measuring_time = {};                 // of `facts`
  std::optional<std::uint64_t> open_edges = {};  // set if counted, before shading duplicates vertices
  std::optional<mesh::Topology> welded = {};     // the topology after a reader welds the file (topology_as_read())
  bool distinct_positions = false;               // no two vertices coincide in a file of float32; false: unknown
  std::uint64_t label_voxels = 0;                // voxels of the label in the region
  double label_volume = 0;                       // volume of these voxels, in output coordinates
  std::uint64_t label_components = 0;            // components of the newly extracted mesh; 0 if unknown
  double simplified_by = 0;                      // upper bound of how far simplification moved the surface, in voxels
  double untangled_by = 0;                       // upper bound of the move by untangling and rounding, in voxels
  std::optional<edit::BodyFigures> bodies = {};  // set if bodies were selected part by part, during the extraction
  // The measures of a mesh that went part by part, if its sink measured it (partwise_output()).
  std::optional<mesh::MeshMeasures> measures = {};
  std::optional<AttributesOfParts> attributes = {};  // set if the mesh went part by part, and has attributes

  [[nodiscard]] std::uint64_t vertices() const { return taken ? taken->vertices : mesh.positions.size(); }
  [[nodiscard]] std::uint64_t triangles() const { return taken ? taken->triangles : mesh.triangles.size(); }
};

// Facts about all surfaces of the job and about the current one.
struct SurfaceFacts {
  const SurfaceList& all;                   // all surfaces of the current grid
  bool may_be_open = false;                 // the current surface may have boundary edges
  bool recorded = false;                    // Surface::facts are requested
  const LabelAppearance* labels = nullptr;  // names and colors of labels, if the surfaces are labels
};

// Input of a stage besides the surface.
struct StageContext {
  const ConversionJob& job;
  const Source& source;
  SurfaceFacts facts;
  const Context& context;

  [[nodiscard]] std::string subject(const Surface& surface) const;  // "fire.vdb iso 0.5"
  [[nodiscard]] StageReport report_on(StageName stage, const Surface& surface) const;
};

// Returns the options to extract the surface of `source` at an iso value for `job`.
[[nodiscard]] extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso);

// Returns the causes of boundary edges of a newly extracted surface.
[[nodiscard]] OpenBoundary open_boundary_of(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                                            const Source& source);

// Returns the report on a newly extracted surface.
[[nodiscard]] StageReport extraction_report(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                                            const Surface& surface, const StageContext& stage, const StageTime& time);

// The stages of kStages from `first` to `last`, both included.
struct StageRange {
  StageName first = kStages.front().name;
  StageName last = kStages.back().name;
};

// Runs the edits of kStages that are in the range, and reports them. Skips shade_surface() if the job splits the mesh
// into bodies: it then runs for each body. Fails as the stages do.
[[nodiscard]] Result<void> edit_surface(const StageContext& context, Events& events, Surface& surface,
                                        const StageRange& range = {});

// Returns the error with `subject` in place of the name of the mesh, with which messages of other rooms begin.
[[nodiscard]] Error about_surface(Error error, const std::string& mesh_name, const std::string& subject);

// Runs one edit. Fails as about_surface() says.
[[nodiscard]] Result<StageReport> run_edit(EditSurface& edit, const StageContext& context, Surface& surface);

// Runs one edit as run_edit() does, and reports it.
[[nodiscard]] Result<void> run_stage(const StageInfo& stage, const StageContext& context, Events& events,
                                     Surface& surface);

// Sends the report, unless it is empty, and then its notes. Fails with the error of the report, if it has one.
[[nodiscard]] Result<void> tell(const StageReport& report, Events& events);

}  // namespace isoextract::convert
