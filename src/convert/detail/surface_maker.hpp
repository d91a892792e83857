// Makes the surfaces of a job: extracts, verifies, clips and edits them. Several may be made at the same time.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/active_time.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/held_events.hpp"
#include "convert/detail/label_looks.hpp"
#include "convert/detail/partwise_output.hpp"
#include "convert/detail/skipped_surfaces.hpp"
#include "convert/source.hpp"
#include "convert/stages/surface_stages.hpp"
#include "extract/extractor.hpp"
#include "extract/voxels.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {

// A surface, with the events and figures of its stages.
struct MadeSurface {
  Result<std::optional<Surface>> surface;  // nullopt if it is empty and the job skips empty surfaces
  std::exception_ptr exception;            // thrown while it was made, such as std::bad_alloc; null: none
  HeldEvents events;
  bool open = false;              // the surface may have boundary edges
  std::vector<LostSurface> lost;  // the surface, if a step removed all of it
  std::uint64_t bytes_uploaded = 0;
  std::optional<mesh::Bounds> cut_away;  // bounds before clipping, if clipping removed the whole surface
};

// Makes surfaces from the job, source and backends of a conversion, to which it refers.
struct SurfaceMaker {
  const ConversionJob& job;
  const Source& source;
  extract::Extractor* extractor;       // null for a mesh file
  extract::Extractor* other;           // compares its surface with the extractor's; null: no comparison
  const extract::LabelVoxels* labels;  // null if the surfaces are no labels
  const LabelAppearance& looks;        // of the labels
  const SurfaceList& all;              // all surfaces of the grid
  std::vector<mesh::Mesh>& meshes;     // of a mesh file; make() takes the mesh of its surface out of them
  bool mesh_facts;                     // measure Surface::facts
  const Context& context;
  PartwiseOutput* sink = nullptr;    // takes the mesh while it is made, if nothing edits it as a whole; null: none
  ActiveTime* extracting = nullptr;  // measures how long labels are extracted; null: not measured

  // Makes one surface. The source's inside must be set for it (Source::set_inside_side()). For labels, calls from
  // several threads do not disturb each other. Throws nothing but keeps exceptions in the result: an exception that
  // left a parallel loop would make TBB stop the loops of other surfaces before their end.
  [[nodiscard]] MadeSurface make(const ResolvedIso& asked) const;

  // Makes surfaces of labels and hands each to `take`, on one thread at a time, in the order of `asked`. Makes small
  // labels side by side, because one has too little work for several threads; `take` meanwhile gets earlier labels. If
  // memory runs out for one of several, makes it again and then the rest one by one. With simplification, makes all
  // labels first and simplifies them together, to keep common faces. Fails if that simplification or `take` fails, and
  // if the context is cancelled; other errors and exceptions are in MadeSurface. Throws the exceptions of `take`.
  using TakeSurface = std::function<Result<void>(MadeSurface made, const ResolvedIso& asked)>;
  [[nodiscard]] Result<void> make_labels(std::span<const ResolvedIso> asked, const TakeSurface& take) const;

  [[nodiscard]] bool simplifies_together() const { return labels != nullptr && job.edits.simplify.has_value(); }

  [[nodiscard]] SurfaceFacts facts(bool open) const {
    return {all, open, mesh_facts, labels != nullptr ? &looks : nullptr};
  }

 private:
  [[nodiscard]] Result<std::vector<MadeSurface>> make_together(std::span<const ResolvedIso> asked) const;
};

}  // namespace isoextract::convert
