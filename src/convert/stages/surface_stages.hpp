// The stages between the extraction of a surface and its file, one after the other.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/label_looks.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "convert/stages.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct Surface {
  IsoChoice asked;
  SurfaceId id;
  mesh::Mesh mesh;
  SurfaceEnd end = {};
  bool counts_open_edges = false;                // only a look at the mesh says whether it is closed
  std::optional<Figures> error = {};             // where it was measured
  std::optional<Figures> facts = {};             // where they are asked for; of the mesh before vertices were copied
  StageTime looking = {};                        // what that took
  std::optional<std::uint64_t> open_edges = {};  // where they are counted, before vertices were copied
  double simplified_by = 0;                      // voxels: how far simplification moved it at most
};

// What is known of all surfaces, and of the one at hand.
struct SurfaceFacts {
  std::span<const SurfaceId> all;      // surfaces of the job
  bool may_be_open = false;            // it may have a border
  bool recorded = false;               // Surface::facts are asked for
  const LabelLooks* labels = nullptr;  // where surfaces are those of labels: how these look
};

// What a stage may know besides the surface.
struct StageContext {
  const ConversionJob& job;
  const Source& source;
  SurfaceFacts facts;
  const Context& context;

  [[nodiscard]] std::string subject(const Surface& surface) const;  // "fire.vdb iso 0.5"
  [[nodiscard]] StageReport report_on(StageName stage, const Surface& surface) const;
};

// How the surface of `source` at an iso value is extracted for `job`.
[[nodiscard]] extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso);

// Of the surface that was just extracted.
[[nodiscard]] StageReport extraction_report(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                                            const Surface& surface, const StageContext& stage, const StageTime& time);

// Runs every edit of kStages and tells its report. A mesh that is split into pieces is left without what
// shade_surface() does: each piece is to have its own. Fails as the stages do.
[[nodiscard]] Result<void> edit_surface(const StageContext& context, Events& events, Surface& surface);

// Runs one of them.
[[nodiscard]] Result<void> run_stage(const StageInfo& stage, const StageContext& context, Events& events,
                                     Surface& surface);

// Tells a report, unless there is nothing in it; fails where it says so.
[[nodiscard]] Result<void> tell(const StageReport& report, Events& events);

}  // namespace isoextract::convert
