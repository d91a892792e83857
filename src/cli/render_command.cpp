// `isoextract render`: draws pictures of volumes and meshes.
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "cli/note_printer.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/render_plan.hpp"
#include "cli/scene_source.hpp"
#include "cli/sequence_values.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "convert/output_checks.hpp"
#include "convert/picture_file.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "image_io/exr_writer.hpp"
#include "render/antialias.hpp"
#include "render/gpu_renderer.hpp"
#include "render/visible_box.hpp"

namespace isoextract::cli {
namespace {

// A requested GPU never falls back to the CPU. Automatic choice takes a GPU only if it does not render in software.
Result<std::unique_ptr<render::Renderer>> open_renderer(const RenderPlan& plan, const Messages& messages) {
  if (plan.backend == convert::Backend::cpu) return render::make_cpu_renderer();
  auto gpu = render::make_gpu_renderer({plan.gpu.device, plan.gpu.memory_bytes});
  if (plan.backend == convert::Backend::gpu) {
    if (!gpu) return tl::unexpected(std::move(gpu.error()));
    return std::move(gpu->renderer);
  }
  if (gpu && !gpu->device.software) {
    messages.note({NoteId::backend, fmt::format("backend: gpu, {}", gl::describe(gpu->device))});
    return std::move(gpu->renderer);
  }
  messages.detail(fmt::format(
      "backend: cpu, because {}",
      gpu ? fmt::format("{} renders in software on the CPU", gl::describe(gpu->device)) : gpu.error().message));
  return render::make_cpu_renderer();
}

Result<void> write_picture(const render::Picture& picture, const std::string& path, const Context& context) {
  context.progress().begin("writing", 0);
  if (picture_file_of(path) != PictureFile::exr) {
    const auto written = convert::write_png(path, picture, context);
    return written ? Result<void>() : tl::unexpected(written.error());
  }
  auto file = TRY(files::OutputFile::create(path));
  TRY(image_io::write_exr(file, convert::light_of(picture), context));
  return file.commit();
}

convert::Json json_of(const EmissionSource& emission, const std::optional<std::array<double, 2>>& range) {
  return {{"grid", emission.field.grid},
          {"greatest_value", emission.greatest},
          {"range", range ? convert::Json(*range) : convert::Json()}};
}

convert::Json json_of(const PicturePlan& plan, const render::Rendered& rendered, const render::Camera& camera,
                      const StageTime& reading, const StageTime& drawing, const StageTime& writing) {
  const render::RenderStatistics& statistics = rendered.statistics;
  const auto vector = [](const glm::dvec3& v) { return convert::Json{v.x, v.y, v.z}; };
  const auto seconds = [](const StageTime& time) { return convert::Json(time.wall_seconds); };
  return {{"file", plan.output},
          {"frame", plan.frame},
          {"width", rendered.picture.width},
          {"height", rendered.picture.height},
          {"camera",
           {{"eye", vector(camera.eye)},
            {"target", vector(camera.target)},
            {"up", vector(camera.up)},
            {"vertical_field_of_view", camera.fovy},
            {"near", camera.near_depth},
            {"far", camera.far_depth}}},
          {"seconds", {{"read", seconds(reading)}, {"draw", seconds(drawing)}, {"write", seconds(writing)}}},
          {"rays", statistics.rays},
          {"samples", statistics.samples},
          {"samples_skipped", statistics.samples_skipped},
          {"samples_terminated", statistics.samples_terminated},
          {"bricks", statistics.bricks},
          {"bricks_skipped", statistics.bricks_skipped},
          {"fragments", statistics.fragments}};
}

// Returns whether every pixel shows only the background.
bool shows_nothing(const render::Picture& picture, const glm::dvec4& background) {
  constexpr float kUnseen = 1.0F / 1024;
  const glm::vec4 behind(glm::dvec3(background) * background.a, background.a);
  return std::ranges::all_of(picture.color, [&](const glm::vec4& color) {
    return glm::all(glm::lessThan(glm::abs(color - behind), glm::vec4(kUnseen)));
  });
}

// Makes a renderer keep the data of a volume for as long as the volume exists.
class VolumeKeeper {
 public:
  explicit VolumeKeeper(render::Renderer& renderer) : renderer_(renderer) {}
  VolumeKeeper(const VolumeKeeper&) = delete;
  VolumeKeeper& operator=(const VolumeKeeper&) = delete;
  ~VolumeKeeper() { forget(); }

  void be(const render::Volume* volume) { renderer_.keep(volume); }
  void forget() { renderer_.keep(nullptr); }

 private:
  render::Renderer& renderer_;
};

// Draws all pictures of a plan with the camera of the first one, so that it does not move during a sequence.
class Pictures {
 public:
  Pictures(const RenderPlan& plan, const Messages& messages, render::Renderer& renderer, const Context& context)
      : plan_(plan), messages_(messages), renderer_(renderer), context_(context) {}

  Result<void> draw_all() {
    ProgressBar bar(context_.progress(), messages_.verbosity() != Verbosity::quiet);
    NotePrinter notes(messages_, bar);
    auto source = TRY(SceneSource::open(plan_, context_, notes));
    VolumeKeeper kept(renderer_);             // destroyed before its volume
    std::optional<std::string> now;           // the current volume
    std::optional<Error> nothing;             // for the first frame that shows nothing
    std::vector<const PicturePlan*> waiting;  // empty frames before the first one that determines the camera
    for (const PicturePlan& picture : plan_.pictures) {
      StageTime reading;
      if (picture.input && now != picture.input) {
        const Stopwatch watch;
        kept.forget();
        auto read = source.read_volume(*picture.input, picture.output, context_, notes);
        if (!read) {
          if (!plan_.is_sequence || !has_no_surface(read.error().code)) return read;
          notes.note({NoteId::no_surface,
                      fmt::format("frame {}: {}: the picture shows no volume", picture.frame, read.error().message)});
          if (!nothing) nothing = read.error();
          source.remove_volume();
        }
        now = picture.input;
        kept.be(source.scene().volume);
        reading = watch.elapsed();
      }
      const render::Scene scene = source.scene();
      if (!box_ && scene.volume == nullptr && scene.surfaces.empty()) {
        waiting.push_back(&picture);
        continue;
      }
      TRY(draw(source, scene, picture, reading, bar));
      for (const PicturePlan* earlier : std::exchange(waiting, {})) {
        render::Scene bare = scene;
        bare.volume = nullptr;
        bare.surfaces.clear();
        TRY(draw(source, bare, *earlier, {}, bar));
      }
    }
    if (!waiting.empty() && nothing) return tl::unexpected(std::move(*nothing));
    return {};
  }

  [[nodiscard]] const convert::Json& records() const { return records_; }

 private:
  Result<void> draw(const SceneSource& source, const render::Scene& scene, const PicturePlan& picture,
                    const StageTime& reading, ProgressBar& bar) {
    const bool shows_something = scene.volume != nullptr || !scene.surfaces.empty();
    if (!box_ || (plan_.camera.is_fixed() && shows_something)) {  // the box of a fixed camera only sets near and far
      box_ = TRY(render::box_of(scene));
      // Later frames may show more, so a sequence frames the whole volume.
      seen_ = plan_.is_sequence ? *box_ : TRY(render::visible_box_of(scene, context_));
    }
    render::ViewAngles angles = plan_.camera;
    angles.azimuth += picture.turn;
    angles.front = source.front();
    // Pictures of a turn or a sequence have one distance.
    const auto frame = plan_.pictures.size() == 1 ? render::frame_box_closely : render::frame_turn;
    render::Camera camera = frame(seen_, angles, source.up(), plan_.options.size, plan_.fovy);
    render::enclose_box(camera, *box_);
    const Stopwatch watch;
    const int rays_across = plan_.rays_across.value_or(scene.surfaces.empty() ? 1 : 2);
    auto rendered = TRY(render::draw_antialiased(renderer_, scene, camera, plan_.options, rays_across, context_));
    TRY(source.check_mapping_intact());
    const StageTime drawing = watch.elapsed();
    const Stopwatch write_watch;
    const bool emits = scene.volume != nullptr && scene.volume->emission != nullptr;
    if (emits && picture_file_of(picture.output) == PictureFile::png) render::cover_light(rendered.picture);
    TRY(write_picture(rendered.picture, picture.output, context_));
    const StageTime writing = write_watch.elapsed();
    const bool is_empty = shows_something && shows_nothing(rendered.picture, plan_.background);
    const render::RenderStatistics& statistics = rendered.statistics;
    const std::string name = files::output_label(picture.output);
    bar.above([&] {
      messages_.summary(
          fmt::format("{} -> {}: {} x {} pixels; drawn in {:.2f} s",
                      picture.input ? files::input_label(*picture.input) : files::input_label(plan_.meshes.front()),
                      name, rendered.picture.width, rendered.picture.height, drawing.wall_seconds));
      if (is_empty)
        messages_.note(
            {NoteId::empty_picture,
             fmt::format("{}: the picture is empty: the scene is outside the camera's view, or the transfer function "
                         "makes it transparent",
                         name)});
      messages_.detail(fmt::format(
          "{}: {} rays, {} samples, {} skipped in empty bricks ({} of {} bricks), {} hidden; {} surface fragments; "
          "read in {:.2f} s, written in {:.2f} s; {}; peak memory {}",
          name, statistics.rays, statistics.samples, statistics.samples_skipped, statistics.bricks_skipped,
          statistics.bricks, statistics.samples_terminated, statistics.fragments, reading.wall_seconds,
          writing.wall_seconds, renderer_.device(), format_byte_size(peak_memory())));
    });
    records_.push_back(json_of(picture, rendered, camera, reading, drawing, writing));
    if (emits) records_.back()["emission"] = json_of(*source.emission(), plan_.emission->range);
    return {};
  }

  const RenderPlan& plan_;
  const Messages& messages_;
  render::Renderer& renderer_;
  const Context& context_;
  std::optional<field::Box> box_;  // box of the whole scene
  field::Box seen_;                // box that the camera frames
  convert::Json records_ = convert::Json::array();
};

// Checks before drawing that every output is writable.
Result<void> check_outputs(const RenderPlan& plan, const Context& context) {
  files::InputFileSet read;
  for (const std::string& mesh : plan.meshes) convert::add_read_mesh(read, mesh, context);
  if (plan.transfer_file) read.add(*plan.transfer_file, "holds the transfer function");
  convert::ConversionJob job = plan.job;
  for (const PicturePlan& picture : plan.pictures) {  // pictures of a turn share their input
    if (!picture.input || *picture.input == job.source.input) continue;
    job.source.input = *picture.input;
    convert::add_read_files(read, job, Context());
  }
  if (plan.json) {
    TRY(convert::check_output_file(*plan.json, read));
  }
  for (const PicturePlan& picture : plan.pictures) {
    if (picture.output == "-") continue;
    TRY(convert::check_output_file(picture.output, read));
    if (plan.json && files::is_same_output(*plan.json, picture.output)) {
      return fail(ErrorCode::usage, fmt::format("{}: both a picture and --json name this file", *plan.json));
    }
  }
  return {};
}

std::vector<FrameSource> first_frames(const RenderPlan& plan) {
  std::vector<FrameSource> frames;
  for (const PicturePlan& picture : plan.pictures) {
    if (frames.size() == kFramesForRadius) break;
    frames.push_back({picture.frame, plan.job.source});
    frames.back().source.input = picture.input.value_or("");
  }
  return frames;
}

// Gives all frames of a sequence the particle radius and the sphere spacing that convert would choose, so that pictures
// show the surfaces of convert. Fails with ErrorCode::cancelled only.
Result<void> share_particle_values(RenderPlan& plan, const Context& context, const Messages& messages) {
  if (!plan.is_sequence) return {};
  convert::ParticleOptions& particles = plan.job.source.particles;
  if (!plan.has_radius_of_each_frame) {
    if (const auto found = TRY(find_sequence_radius(first_frames(plan), context))) {
      particles.sequence_radius = found->radius;
      messages.note({NoteId::particle_radius, found->note()});
    }
  }
  particles.sequence_spacing = TRY(find_sequence_spacing(first_frames(plan), context));
  if (particles.sequence_spacing) messages.note({NoteId::cell_size, spacing_note(*particles.sequence_spacing)});
  return {};
}

// Draws picture by picture; stops at the first error. A frame of a sequence may lack a surface.
Result<void> run_render(const RenderPlan& given, const Messages& messages) {
  RenderPlan plan = given;
  for (const Note& note : plan.notes) messages.note(note);
  const Context context{plan.memory};
  TRY(check_outputs(plan, context));
  TRY(share_particle_values(plan, context, messages));
  const auto renderer = TRY(open_renderer(plan, messages));
  Pictures pictures(plan, messages, *renderer, context);
  TRY(pictures.draw_all());
  if (plan.json) {
    const convert::Json json{{"schema", word_of(convert::JsonDocument::render)},
                             {"device", renderer->device()},
                             {"pictures", pictures.records()}};
    TRY(files::write_file(*plan.json, convert::json_text(json)));
  }
  if (plan.missing.empty()) return {};
  return fail(ErrorCode::frames,
              fmt::format("the inputs lack the frames {}", batch::text_of(plan.missing, batch::kShownFrameRuns)),
              "leave these frames out of --frames");
}

}  // namespace

std::unique_ptr<Command> make_render_command() {
  return std::make_unique<PlannedCommand<RenderFlags, plan_render, run_render>>(
      CommandWords{"render", "INPUT... [-o FILE] [options]", "Draw volumes, surfaces and meshes as PNG or OpenEXR."});
}

}  // namespace isoextract::cli
