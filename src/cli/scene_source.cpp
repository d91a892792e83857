#include "cli/scene_source.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "cli/iso_of_labels_note.hpp"
#include "cli/up_axis_note.hpp"
#include "convert/conversion.hpp"
#include "convert/picture_file.hpp"
#include "convert/placement_record.hpp"
#include "field/statistics.hpp"
#include "files/file_bytes.hpp"
#include "files/text_file.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "render/surface_normals.hpp"
#include "render/visible_range.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {
namespace {

// Transfer functions are short texts; larger files are a mistake.
constexpr std::uint64_t kMostTransferBytes = 1U << 20U;

struct PlacedMesh {
  mesh::Mesh mesh;         // in the world of its source
  bool says_y_up = false;  // the source's world is y up
};

Result<PlacedMesh> read_mesh(const std::string& path, const RenderPlan& plan, const Context& context,
                             convert::Events& events) {
  context.progress().begin("reading meshes", 0);
  auto file = TRY(mesh_io::read_mesh(path, context, {.scene = true}));
  for (const Note& note : file.notes) events.note(note);
  if (plan.mesh_colors.empty()) {
    TRY(convert::color_by_materials(file, context));
  }
  const auto record = convert::parse_placement_record(file.placement);
  if (!record && !file.placement.empty()) {
    events.note({NoteId::placement_unknown,
                 fmt::format("{}: the file has no readable placement record, so render assumes the default placement",
                             files::input_label(path))});
  }
  const bool in_voxels = record && record->placement.space == convert::Space::index;
  const bool has_volume = plan.pictures.front().input.has_value();
  if (in_voxels && has_volume && plan.job.source.placement.space == convert::Space::world) {
    events.note({NoteId::placement_differs,
                 fmt::format("{}: the mesh is in voxel coordinates, but render draws the volume in world coordinates",
                             files::input_label(path))});
  }
  const bool y_up = plan.up == render::UpAxis::y;
  const auto usual = convert::default_placement(file.y_up, y_up ? convert::UpAxis::y : convert::UpAxis::z);
  convert::move_mesh(file.mesh, record.value_or(usual).output_from_world().inverse());
  return PlacedMesh{std::move(file.mesh), record && !in_voxels && record->placement.up == convert::UpAxis::y};
}

std::vector<render::ControlPoint> named_transfer(const RenderPlan& plan, const field::ScalarField& field,
                                                 const field::FieldStatistics& statistics) {
  const render::VisibleRange range = plan.transfer_range
                                         ? render::VisibleRange{(*plan.transfer_range)[0], (*plan.transfer_range)[1]}
                                         : render::visible_range(field, statistics);
  return render::built_in_points(plan.transfer, range, field.kind);
}

Result<render::TransferFunction> read_transfer(const std::string& path, const Context& context) {
  const auto text = TRY(files::read_text_file(path, "a transfer function", kMostTransferBytes, context));
  const std::string name = files::input_label(path);
  const auto points = TRY(render::parse_transfer_function(text, name));
  auto transfer = render::TransferFunction::create(points);
  if (!transfer) return fail(ErrorCode::input, fmt::format("{}: {}", name, transfer.error().message));
  return transfer;
}

}  // namespace

Result<SceneSource> SceneSource::open(const RenderPlan& plan, const Context& context, convert::Events& events) {
  SceneSource source(plan);
  bool all_y_up = !plan.meshes.empty() && !plan.pictures.front().input;
  for (const std::string& path : plan.meshes) {
    auto read = TRY(read_mesh(path, plan, context, events));
    all_y_up = all_y_up && read.says_y_up;
    mesh::Mesh* mesh = &read.mesh;
    if (plan.shading == render::Shading::smooth) {
      TRY(render::add_normals(*mesh, path, context));
    }
    source.meshes_.push_back(std::move(*mesh));
  }
  if (all_y_up) source.up_of_meshes_ = render::UpAxis::y;
  if (plan.transfer_file) {
    source.transfer_ = TRY(read_transfer(*plan.transfer_file, context));
  }
  return source;
}

Result<void> SceneSource::choose_transfer(const field::ScalarField& field, const field::FieldStatistics& statistics) {
  if (!transfer_) {
    transfer_ = TRY(render::TransferFunction::create(named_transfer(*plan_, field, statistics)));
  }
  return {};
}

void SceneSource::remove_volume() {
  volume_.reset();
  emission_.reset();
  source_.reset();
  surfaces_.clear();
  front_ = 0;
}

Result<void> SceneSource::read_volume(const std::string& input, const std::string& output, const Context& context,
                                      convert::Events& events) {
  remove_volume();
  convert::ConversionJob job = plan_->job;
  job.source.input = input;
  if (plan_->emission) TRY(check_emission_input(*plan_->emission, job.source, context));
  const auto field_notes = [&](const field::ScalarField& field) {
    Notes notes;
    if (!std::exchange(printed_label_note_, true)) {
      auto note = iso_of_labels_note(field, job);
      if (!note && plan_->draws_volume && job.isos().empty()) note = volume_of_labels_note(field);
      if (note) notes.push_back(std::move(*note));
    }
    if (plan_->up || printed_up_axis_note_) return notes;
    if (const auto note = up_axis_note(field, convert::UpAxis::z, "the picture shows it on its side")) {
      printed_up_axis_note_ = true;
      notes.push_back(*note);
    }
    return notes;
  };
  if (!plan_->isos.empty()) {
    convert::MeshCollector collected{.wants_source = plan_->draws_volume};
    job.outputs = {{output, plan_->isos}};
    convert::Outcome outcome = convert::run(job, context, events, {.field_notes = field_notes}, nullptr, &collected);
    if (outcome.error) {  // in a sequence, frames without a surface still show the volume
      const bool shows_volume = plan_->is_sequence && plan_->draws_volume;
      const bool goes_on = shows_volume && outcome.error->code == ErrorCode::no_surface;
      if (!goes_on) return tl::unexpected(std::move(*outcome.error));
      events.note({NoteId::no_surface, outcome.error->message});
    }
    surfaces_ = std::move(collected.meshes);
    front_ = outcome.front;
    source_ = std::move(collected.source);
  }
  if (plan_->draws_volume && !source_) {
    source_ = TRY(convert::open_source(job.source, {}, context, events));
    front_ = convert::front_azimuth(source_->field, source_->placement);
    for (const Note& note : field_notes(source_->field)) events.note(note);
  }
  if (plan_->shading == render::Shading::smooth) {
    for (mesh::Mesh& mesh : surfaces_) {
      TRY(render::add_normals(mesh, input, context));
    }
  }
  if (!plan_->draws_volume) return {};
  TRY(place_volume(context, events));
  if (!plan_->emission) return {};
  emission_ = TRY(read_emission(*plan_->emission, job.source, *source_, context, events));
  if (emission_) {
    emission_volume_ = render::Volume{&emission_->field, emission_->output_from_index, emission_->light};
    volume_->emission = &emission_volume_;
  }
  return {};
}

Result<void> SceneSource::place_volume(const Context& context, convert::Events& events) {
  const auto box = TRY(render::volume_box(source_->field));
  const auto statistics = field::measure_statistics(source_->field, &context.progress(), field::WithPercentiles::no);
  if (statistics.nan > 0) {
    events.note(
        {NoteId::nan_samples,
         fmt::format("{}: {} of {} samples are NaN: render draws nothing in cells with such samples", source_->label,
                     statistics.nan, statistics.samples + statistics.nan + statistics.infinite)});
  }
  TRY(choose_transfer(source_->field, statistics));
  if (!unit_length_) {
    const field::Box world = field::image_of(source_->output_from_index, box);
    const glm::dvec3 sides = world.max - world.min;
    unit_length_ = plan_->unit_length.value_or(std::max({sides.x, sides.y, sides.z}) / 100);
  }
  volume_ = render::Volume{&source_->field, source_->output_from_index, *transfer_, *unit_length_};
  return {};
}

void SceneSource::add_surface(render::Scene& scene, const mesh::Mesh& mesh) const {
  render::Surface surface = convert::surface_of(mesh);
  surface.shading = plan_->shading;
  const std::vector<double>& opacity = plan_->opacity;
  if (opacity.size() == 1) surface.opacity = opacity.front();
  if (opacity.size() > 1) surface.opacity = opacity[std::min(scene.surfaces.size(), opacity.size() - 1)];
  scene.surfaces.push_back(surface);
}

render::Scene SceneSource::scene() const {
  render::Scene scene;
  if (volume_) scene.volume = &*volume_;
  for (const mesh::Mesh& mesh : surfaces_) add_surface(scene, mesh);
  const std::vector<glm::dvec3>& colors = plan_->mesh_colors;
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    add_surface(scene, meshes_[m]);
    if (!colors.empty()) scene.surfaces.back().color = colors[std::min(m, colors.size() - 1)];
  }
  scene.background = plan_->background;
  return scene;
}

Result<void> SceneSource::check_mapping_intact() const {
  if (emission_) TRY(volume_io::check_mapping_intact(emission_->field));
  return source_ ? volume_io::check_mapping_intact(source_->field) : Result<void>();
}

}  // namespace isoextract::cli
