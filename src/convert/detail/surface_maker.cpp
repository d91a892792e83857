#include "convert/detail/surface_maker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "convert/detail/label_choice.hpp"
#include "convert/detail/no_surface.hpp"
#include "convert/mesh_normals.hpp"
#include "convert/stages/mesh_simplify.hpp"
#include "convert/verification.hpp"
#include "extract/height_field.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

Result<extract::Extraction> extract_field(const SurfaceMaker& maker, const ResolvedIso& asked,
                                          const extract::ExtractOptions& options) {
  const field::ScalarField& field = maker.source.field;
  if (const auto& heights = maker.job.surface.heights) {
    return extract_heights(field, *heights, options, maker.context);
  }
  if (maker.labels == nullptr) return maker.extractor->extract(field, options, maker.context);
  const ActiveTime::Task task(maker.extracting);
  auto extraction = maker.labels->extract(field, asked.id.label(), options, maker.context);
  if (extraction) extraction->mesh.name = field.name;
  return extraction;
}

bool is_cut_open(const SurfaceMaker& maker) { return !maker.source.clip.empty() && !maker.job.surface.cap; }

// Takes a mesh of the file.
Result<Surface> take_mesh(const SurfaceMaker& maker, const ResolvedIso& asked, MadeSurface& made) {
  const std::uint64_t number = asked.id.file_mesh();
  Surface surface{.asked = asked.asked,
                  .id = asked.id,
                  .mesh = std::move(maker.meshes.at(number == 0 ? 0 : number - 1)),
                  .counts_open_edges = true};
  const StageContext stage{maker.job, maker.source, maker.facts(false), maker.context};
  TRY(tell(TRY(run_edit(repair_surface, stage, surface)), made.events));
  const mesh::Topology topology = TRY(mesh::measure_topology(surface.mesh, maker.context));
  made.open = topology.open_edges > 0 || is_cut_open(maker);
  return surface;
}

// Extracts the surface, and compares it with the other backend if the job verifies.
Result<Surface> extract_surface(const SurfaceMaker& maker, const ResolvedIso& asked, MadeSurface& made) {
  const Source& source = maker.source;
  const Stopwatch watch;
  extract::ExtractOptions options = extract_options_of(maker.job, source, asked.id.iso_or_zero());
  options.sink = maker.sink;
  auto extraction = TRY(extract_field(maker, asked, options));
  TRY(volume_io::check_mapping_intact(source.field));
  extract::ExtractStats& stats = extraction.stats;
  made.open = may_be_open(stats, options) || is_cut_open(maker);
  Surface surface{.asked = asked.asked,
                  .id = asked.id,
                  .mesh = std::move(extraction.mesh),
                  .taken = extraction.taken,
                  .open_boundary = open_boundary_of(stats, options, source),
                  .counts_open_edges = stats.hole_cells > 0 || is_cut_open(maker)};
  if (surface.taken) {
    surface.measures = maker.sink->take_measures();
    surface.measuring_time = maker.sink->measuring_time();
    surface.bodies = maker.sink->bodies();
    surface.attributes = maker.sink->take_attributes();
    const StageTime selecting = surface.bodies ? surface.bodies->time : StageTime();
    const StageTime sampling = surface.attributes ? surface.attributes->time : StageTime();
    for (const StageTime& other : {surface.measuring_time, selecting, sampling}) {
      stats.emit += {-other.wall_seconds, -other.cpu_seconds};
    }
  }
  if (const auto* found = maker.labels != nullptr ? maker.labels->find(asked.id.label()) : nullptr) {
    const double voxel = std::abs(glm::determinant(source.output_from_index.linear));
    surface.label_voxels = found->voxels;
    surface.label_volume = voxel * static_cast<double>(found->voxels);
    surface.label_components = found->shells;
  }
  const StageContext stage{maker.job, source, maker.facts(made.open), maker.context};
  if (stats.device) made.bytes_uploaded = stats.device->bytes_uploaded;
  StageReport report = extraction_report(stats, options, surface, stage, watch.elapsed());
  if (surface.bodies) {
    surface.taken = maker.sink->written_shape();
    if (!surface.taken) report.did = "extracted";
  }
  made.events.end(report);
  if (maker.other != nullptr) {
    const auto record = TRY(compare_backends(source.field, options, extract::method_info(maker.job.surface.method),
                                             surface.mesh, *maker.extractor, *maker.other, maker.context));
    TRY(volume_io::check_mapping_intact(source.field));
    surface.mesh.edges = {};  // only the comparison needs them
    TRY(tell(convert::report_of(record, source.label), made.events));
  }
  return surface;
}

// Extracts the surface or takes it from a mesh file, and clips it.
Result<Surface> open_surface(const SurfaceMaker& maker, const ResolvedIso& asked, MadeSurface& made) {
  const Source& source = maker.source;
  Surface surface = TRY(maker.job.source.mesh ? take_mesh(maker, asked, made) : extract_surface(maker, asked, made));
  const StageContext stage{maker.job, source, maker.facts(made.open), maker.context};
  std::optional<mesh::Bounds> whole;  // bounds before clipping
  if (!source.clip.empty() && !surface.mesh.triangles.empty()) whole = mesh::measure_bounds(surface.mesh);
  const StageReport clipped = TRY(run_edit(clip_surface, stage, surface));
  TRY(tell(clipped, made.events));
  made.cut_away = surface.mesh.triangles.empty() ? whole : std::nullopt;
  return surface;
}

Error error_of_none(const SurfaceMaker& maker, const ResolvedIso& asked, MadeSurface& made) {
  const Stopwatch watch;
  Error error = no_surface(maker.job, maker.source, asked, maker.labels != nullptr, made.cut_away);
  StageReport report = report_on(StageName::statistics, maker.source.label);
  report.time = watch.elapsed();
  made.events.end(report);
  return error;
}

Result<std::optional<Surface>> make_surface(const SurfaceMaker& maker, const ResolvedIso& asked, MadeSurface& made) {
  const EmptyPolicy empty = maker.job.empty;
  Surface surface = TRY(open_surface(maker, asked, made));
  if (surface.triangles() == 0 && !surface.bodies && empty != EmptyPolicy::write) {
    if (empty == EmptyPolicy::error) return tl::unexpected(error_of_none(maker, asked, made));
    if (made.cut_away) made.lost.push_back({asked.id, "clipping removed every triangle"});
    return std::optional<Surface>();
  }
  const StageName last = maker.simplifies_together() ? StageName::smooth : kStages.back().name;
  TRY(edit_surface({maker.job, maker.source, maker.facts(made.open), maker.context}, made.events, surface,
                   {.last = last}));
  if (surface.triangles() != 0 || empty == EmptyPolicy::write) return surface;
  made.lost.push_back({asked.id, "no component has the requested size"});
  return std::optional<Surface>();
}

// Runs the stages after the simplification of labels. Vertices of triangles that intersect move only now: before, they
// would leave the faces that labels have in common.
void finish(const SurfaceMaker& maker, MadeSurface& made) {
  try {
    if (!*made.surface) return;
    const StageContext stage{maker.job, maker.source, maker.facts(made.open), maker.context};
    auto done = run_stage(stage_info(StageName::untangle), stage, made.events, **made.surface);
    if (done) done = edit_surface(stage, made.events, **made.surface, {.first = StageName::touching});
    if (!done) made.surface = tl::unexpected(done.error());
  } catch (...) {
    made.exception = std::current_exception();
  }
}

bool ran_out_of_memory(const MadeSurface& made) {
  return !made.surface && made.surface.error().code == ErrorCode::out_of_memory;
}

// Hands the surfaces over, up to the first one that fails or, if `may_repeat`, that ran out of memory.
class Handover {
 public:
  Handover(std::span<MadeSurface> made, std::span<const ResolvedIso> asked, bool may_repeat)
      : made_(made), asked_(asked), may_repeat_(may_repeat) {}

  // Keeps an exception until finish(): it must not leave a parallel loop.
  void run(const SurfaceMaker::TakeSurface& take) {
    try {
      for (; taken_ < made_.size() && !(may_repeat_ && ran_out_of_memory(made_[taken_])); ++taken_) {
        done_ = take(std::exchange(made_[taken_], {}), asked_[taken_]);
        if (!done_) return;
      }
    } catch (...) {
      exception_ = std::current_exception();
    }
  }

  // Returns how many surfaces were taken. Throws the exception of run().
  Result<std::size_t> finish() {
    if (exception_) std::rethrow_exception(exception_);
    if (!done_) return tl::unexpected(std::move(done_.error()));
    return taken_;
  }

 private:
  std::span<MadeSurface> made_;
  std::span<const ResolvedIso> asked_;
  bool may_repeat_;
  std::size_t taken_ = 0;
  Result<void> done_;
  std::exception_ptr exception_;
};

}  // namespace

Result<void> SurfaceMaker::make_labels(std::span<const ResolvedIso> asked, const TakeSurface& take) const {
  if (simplifies_together()) {
    auto made = TRY(make_together(asked));
    Handover handover(made, asked, false);
    handover.run(take);
    TRY(handover.finish());
    return {};
  }
  std::vector<MadeSurface> made;  // the first of `asked`
  bool is_alone = true;           // no other surface took memory while `made` was made
  bool one_by_one = false;        // memory ran out for one of several
  while (!asked.empty()) {
    TRY(context.check());
    const std::span<const ResolvedIso> rest = asked.subspan(made.size());
    const LabelGroup group =
        one_by_one ? LabelGroup{std::min<std::size_t>(rest.size(), 1), false} : next_group(rest, *labels);
    std::vector<MadeSurface> next(made.empty() || group.is_small ? group.size : 0);
    Handover handover(made, asked, !is_alone);
    for_each_fixed_range(1 + next.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (i == 0) {
          handover.run(take);
        } else if (!context.cancelled()) {
          next[i - 1] = make(rest[i - 1]);
        }
      }
    });
    const std::size_t taken = TRY(handover.finish());
    TRY(context.check());
    asked = asked.subspan(taken);
    one_by_one = one_by_one || taken < made.size();
    is_alone = made.empty() && next.size() == 1;
    if (taken < made.size()) next.clear();
    made = std::move(next);
  }
  return {};
}

Result<std::vector<MadeSurface>> SurfaceMaker::make_together(std::span<const ResolvedIso> asked) const {
  std::vector<MadeSurface> made(asked.size());
  const auto for_groups = [&](const auto& body) {
    for (std::size_t begin = 0; begin < made.size();) {
      const std::size_t count = next_group(asked.subspan(begin), *labels).size;
      for_each_index(count, [&](std::size_t i) { body(begin + i); });
      begin += count;
    }
  };
  for_groups([&](std::size_t i) {
    if (!context.cancelled()) made[i] = make(asked[i]);
  });
  TRY(context.check());
  std::vector<HeldLabel> held;
  for (MadeSurface& one : made) {
    if (one.exception || !one.surface) return made;  // the conversion ends when it comes to this surface
    if (*one.surface) held.push_back({&**one.surface, &one.events});
  }
  TRY(simplify_labels(held, {job, source, facts(false), context}));
  for_groups([&](std::size_t i) { finish(*this, made[i]); });
  return made;
}

MadeSurface SurfaceMaker::make(const ResolvedIso& asked) const {
  MadeSurface made;
  try {
    made.surface = make_surface(*this, asked, made);
  } catch (...) {
    made.exception = std::current_exception();
  }
  return made;
}

}  // namespace isoextract::convert
