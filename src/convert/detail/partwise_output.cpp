#include "convert/detail/partwise_output.hpp"

#include <algorithm>
#include <iterator>
#include <variant>

#include "convert/mesh_pieces.hpp"
#include "convert/stages/mesh_require.hpp"
#include "convert/stages/vertex_colors.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/mesh_assembly.hpp"
#include "field/analytic_field.hpp"

namespace isoextract::convert {
namespace {

// Returns whether the error of the surface can be measured without the whole mesh (measure_extraction_error()).
bool measures_error_by_parts(const ConversionJob& job, const Source& source) {
  // Formulas of demo fields are compared with the whole mesh.
  return !source.data && !job.surface.cap && !job.edits.pieces.drops() &&
         field::find_analytic_field(source.field.name) == nullptr;
}

bool needs_whole_mesh(const ConversionJob& job, const Source& source) {
  const SurfaceEdits& edits = job.edits;
  const bool edits_mesh = edits.pieces.split || edits.smooth || edits.hollow || edits.simplify;
  const bool examines_mesh =
      job.verify || (job.error && !measures_error_by_parts(job, source)) || !tests_by_parts(edits.require);
  const auto* file = job.writes<MeshFileOptions>();
  // The normals of caps are known only when the mesh is whole. glTF with flat normals has three vertices per triangle.
  const bool normals_need_all = job.normals == Normals::area || (job.normals == Normals::smooth && job.surface.cap) ||
                                (job.normals == Normals::flat && file != nullptr && mesh_io::is_gltf(file->format));
  return file == nullptr || !source.clip.empty() || edits_mesh || examines_mesh || normals_need_all ||
         attributes_need_whole_mesh(job, source);
}

bool writes_one_surface(const ConversionJob& job) {
  return job.outputs.size() == 1 && job.outputs.front().isos.size() == 1;
}

// Returns whether vertices at equal positions need the whole mesh: to move apart, or because readers weld them.
bool needs_distinct_positions(const ConversionJob& job) {
  return job.edits.touching == Touching::apart || mesh_io::mesh_format_info(job.meshes().format).readers_weld;
}

// Returns whether the writer needs the positions of each triangle's corners.
bool needs_triangle_corners(const ConversionJob& job) {
  return job.normals == Normals::flat || job.meshes().format == mesh_io::MeshFormat::stl;
}

}  // namespace

bool writes_shared_parts(const ConversionJob& job) {
  const auto* meshes = job.writes<MeshFileOptions>();
  const bool takes_parts = meshes != nullptr && !meshes->packing.packs() && job.normals != Normals::flat &&
                           mesh_io::has_fixed_places(meshes->format, meshes->ascii);
  return takes_parts && writes_one_surface(job);
}

bool goes_by_parts(const ConversionJob& job, const Source& source, double iso, bool may_have_nan) {
  using extract::Method;
  const auto* file = job.writes<MeshFileOptions>();
  const bool takes_parts = file != nullptr && mesh_io::mesh_format_info(file->format).takes_parts &&
                           !file->packing.packs() && !file->packing.optimize_order && writes_one_surface(job);
  const bool makes_parts = (job.surface.method == Method::mc || job.surface.method == Method::mt) &&
                           !job.surface.heights && (!may_have_nan || job.surface.nan != extract::NanPolicy::hole) &&
                           job.backend.backend == Backend::cpu;
  if (!takes_parts || !makes_parts || needs_whole_mesh(job, source)) return false;
  const extract::ExtractOptions options = extract_options_of(job, source, iso);
  const field::IndexBox stored = source.field.extents();
  const auto region = extract::clip_region(source.field, stored, options);
  if (!region) return false;
  const extract::OutputPlacement placement = extract::output_placement(source.field, options, stored, *region);
  const extract::OutputPlacement of_all = extract::output_placement(source.field, options, stored, stored);
  if (job.error && (placement.margin() != of_all.margin() || placement.origin() != of_all.origin())) {
    return false;  // the surface of the region differs from that of all samples, which the measurement extracts
  }
  return placement.origin() == glm::dvec3(0) && (!needs_distinct_positions(job) || placement.keeps_vertices_apart());
}

bool holds_whole_selection(const mesh::MeshShape& shape, std::uint64_t sampling_bytes, bool measures,
                           std::uint64_t left) {
  // Many components take as much again as the mesh and its selection, and the figures more.
  const std::uint64_t factor = measures ? 4 : 2;
  const std::uint64_t selecting = edit::whole_selection_bytes(shape.vertices, shape.triangles, shape.has_normals);
  return sampling_bytes <= left && selecting <= (left - sampling_bytes) / factor;
}

void add_partwise_hint(Error& error) {
  if (error.code != ErrorCode::out_of_memory) return;
  error.hint.steps.emplace_back(
      "PLY, glTF, OBJ and STL files take a mesh in parts, unless edits or tests need it whole");
}

Result<bool> PartwiseOutput::begin_early(const mesh::MeshShape& estimate) {
  const bool has_work = bodies_ != nullptr || attributes_ != nullptr || measuring_ != nullptr;
  if (has_work || ranks() != nullptr || (needs_.distinct_positions && !estimate.distinct_positions)) return false;
  is_early_ = TRY(writer_.begin_early(hooks_.head(estimate), estimate));
  return is_early_;
}

Result<bool> PartwiseOutput::begin(const mesh::MeshShape& shape) {
  is_early_ = false;
  if (needs_.distinct_positions && !shape.distinct_positions) return false;
  if (needs_.near_vertices && !shape.uses_near_vertices) return false;
  if (bodies_ != nullptr) {
    const std::uint64_t sampling = attributes_ != nullptr ? attributes_->whole_bytes(shape.vertices) : 0;
    if (holds_whole_selection(shape, sampling, measuring_ != nullptr, context_.memory().left())) return false;
  }
  if (attributes_ != nullptr) {
    const bool has_memory = TRY(attributes_->begin(shape));
    if (!has_memory) return false;
  }
  if (bodies_ == nullptr) return begin_rest(shape);
  TRY(bodies_->begin(shape));
  passes_ = bodies_->passes();
  selecting_end_ = looking_end_ = passes_.size();
  return true;
}

Result<bool> PartwiseOutput::begin_rest(const mesh::MeshShape& shape) {
  shape_ = shape;
  selecting_end_ = looking_end_ = passes_.size();
  if (attributes_ == nullptr || !attributes_->measures_first()) return begin_writing();
  passes_.push_back({.normals = false, .triangles = false});
  looking_end_ = passes_.size();
  return true;
}

Result<bool> PartwiseOutput::begin_writing() {
  measuring_end_ = passes_.size();
  mesh::Mesh head = hooks_.head(shape_);
  if (attributes_ != nullptr) {
    head.attributes = TRY(attributes_->attributes());
    shape_.not_finite_attributes = attributes_->not_finite();
  }
  const bool takes = TRY(writer_.begin_parts(std::move(head), shape_, ranks()));
  if (!takes) return false;
  if (measuring_ != nullptr) {
    std::ranges::copy(measuring_->passes(), std::back_inserter(passes_));
    measuring_end_ = passes_.size();
    TRY(measuring_->begin(shape_));
  }
  for (mesh::PartPass pass : writer_.part_passes()) {
    pass.positions |= pass.attributes;
    passes_.push_back(pass);
  }
  return true;
}

Result<void> PartwiseOutput::begin_pass(std::size_t pass) {
  pass_ = pass;
  if (pass < selecting_end_) return bodies_->begin_pass(pass);
  if (pass < looking_end_) return {};
  if (pass < measuring_end_) {
    if (pass == looking_end_) watch_.restart();
    return measuring_->begin_pass(pass - looking_end_);
  }
  if (is_collecting_) return {};
  if (measuring_ != nullptr) {
    measures_ = TRY(measuring_->finish());
    measuring_.reset();
    measuring_time_ = watch_.elapsed();
    TRY(hooks_.accept(*measures_));
  }
  if (passes_[pass].attributes) attributes_->begin_pass(writer_.part_passes()[pass - measuring_end_]);
  return writer_.begin_pass(pass - measuring_end_);
}

Result<void> PartwiseOutput::take(const mesh::MeshPart& part) {
  if (is_early_) return writer_.take_part(part);
  if (pass_ < selecting_end_) return bodies_->take(part);
  if (pass_ < looking_end_) TRY(attributes_->measure(part));
  if (bodies_ == nullptr) return take_rest(part);
  return bodies_->keep(part, [this](const mesh::MeshPart& kept) { return take_rest(kept); });
}

Result<void> PartwiseOutput::take_rest(const mesh::MeshPart& part) {
  if (is_collecting_) return collect(part);
  if (pass_ < looking_end_) return bodies_ != nullptr ? attributes_->measure_written(part) : Result<void>();
  if (measuring_ != nullptr) return measuring_->take(part);
  if (!passes_[pass_].attributes) return writer_.take_part(part);
  return attributes_->add(part, [this](const mesh::MeshPart& chunk) { return writer_.take_part(chunk); });
}

Result<void> PartwiseOutput::end_pass() {
  if (pass_ >= looking_end_) return {};
  bool takes = true;
  if (pass_ >= selecting_end_) {
    attributes_->finish_measuring();
    takes = TRY(begin_writing());
  } else {
    TRY(bodies_->end_pass());
    passes_ = bodies_->passes();
    const bool goes_on = passes_.size() > selecting_end_;
    selecting_end_ = looking_end_ = passes_.size();
    if (goes_on || pass_ + 1 < selecting_end_) return {};
    const mesh::MeshShape& shape = bodies_->kept_shape();
    takes = shape.triangles > 0 && TRY(begin_rest(shape));
  }
  if (takes) return {};
  if (attributes_ == nullptr) return begin_collecting(bodies_->kept_shape());
  has_declined_ = true;  // the whole mesh needs their memory
  bodies_.reset();
  attributes_.reset();
  return {};
}

Result<void> PartwiseOutput::begin_collecting(const mesh::MeshShape& shape) {
  is_collecting_ = true;
  measuring_.reset();  // later stages measure the mesh
  mesh::Mesh& mesh = collected_.emplace();
  mesh.name = hooks_.head(shape).name;
  mesh.origin = shape.origin;
  if (shape.triangles == 0) return {};
  const std::uint64_t vectors = shape.vertices * (shape.has_normals ? 2 : 1);
  mesh.memory = TRY(context_.reserve(vectors * sizeof(glm::vec3) + shape.triangles * sizeof(glm::uvec3),
                                     mesh.name + ": the selected components"));
  mesh.positions = Buffer<glm::vec3>(shape.vertices);
  mesh.normals = Buffer<glm::vec3>(shape.has_normals ? shape.vertices : 0);
  mesh.triangles = Buffer<glm::uvec3>(shape.triangles);
  passes_.push_back({.normals = shape.has_normals});
  return {};
}

Result<void> PartwiseOutput::collect(const mesh::MeshPart& part) {
  std::ranges::copy(part.positions, collected_->positions.begin() + part.first_vertex);
  std::ranges::copy(part.normals, collected_->normals.begin() + part.first_vertex);
  std::ranges::copy(part.triangles, collected_->triangles.begin() + part.first_triangle);
  return {};
}

std::unique_ptr<PartwiseOutput> partwise_output(const StageContext& stage, const SurfaceId& id,
                                                mesh_io::MeshWriter& writer, Ranks* ranks) {
  const ConversionJob& job = stage.job;
  if (needs_whole_mesh(job, stage.source)) return nullptr;
  const auto make_head = [&stage, id](const mesh::MeshShape& shape) {
    mesh::Mesh head;
    head.name = stage.source.field.name;
    head.material = material_of(stage.job, stage.facts.all, id, stage.source.field.kind, shape.may_be_open);
    return head;
  };
  const auto accept = [&stage, id](const mesh::MeshMeasures& measures) {
    return require_of_parts(measures, id, stage);
  };
  PartwiseOutput::Work work;
  const bool is_measured = stage.facts.recorded || !job.edits.require.empty();
  // Ranks cannot measure the triangles of a cap, which are far apart.
  if (job.edits.pieces.drops() || stage.source.attributes || job.error || (is_measured && job.surface.cap)) {
    ranks = nullptr;
  }
  if (is_measured) {
    work.measures = std::make_unique<mesh::PartwiseMeasures>(stage.source.field.name, stage.context, ranks);
  }
  if (job.edits.pieces.drops()) {
    work.bodies = std::make_unique<edit::PartwiseBodies>(stage.source.field.name,
                                                         body_selection(job.edits.pieces, stage.source), stage.context);
  }
  if (stage.source.attributes) work.attributes = std::make_unique<PartwiseAttributes>(stage);
  const PartwiseOutput::Needs needs{needs_distinct_positions(job),
                                    work.measures != nullptr || work.bodies != nullptr || needs_triangle_corners(job)};
  return std::make_unique<PartwiseOutput>(writer, PartwiseOutput::Hooks{make_head, accept}, ranks, needs,
                                          std::move(work), stage.context);
}

bool takes_layers(const ConversionJob& job, const extract::Extractor* extractor) {
  using extract::Method;
  const SourceOptions& source = job.source;
  const bool by_slabs = (job.surface.method == Method::mc || job.surface.method == Method::mt) &&
                        !job.surface.heights && !job.surface.cap && job.surface.nan != extract::NanPolicy::hole;
  const bool changes_samples = !source.filters.empty() || !source.blurs.empty() || source.resamples();
  const bool reads_samples =
      job.verify || job.error || !source.attributes.empty() || !std::ranges::all_of(job.isos(), &IsoChoice::is_number);
  return extractor != nullptr && extractor->name() == "cpu" && by_slabs && !changes_samples && !reads_samples &&
         job.writes<MeshFileOptions>() != nullptr && !source.mesh && source.masks.empty();
}

std::string reason_against_sharing(const ConversionJob& job, const Source& source, bool has_sink,
                                   std::string_view backend) {
  using extract::Method;
  const Method method = job.surface.method;
  if (job.source.mesh) return "the input is a mesh";
  if (job.surface.heights || (method != Method::mc && method != Method::mt)) return "only mc and mt work slab by slab";
  if (!has_sink) return "an option or the output needs the whole mesh in one process";
  if (!std::holds_alternative<field::DenseSamples>(source.field.samples)) return "the samples are sparse";
  if (backend != "cpu") return "the GPU extracts the surface";
  if (job.surface.nan == extract::NanPolicy::hole) return "holes around NaN samples need the whole mesh";
  return {};
}

}  // namespace isoextract::convert
