#include "cli/sequence_values.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/progress.hpp"
#include "cli/progress_bar.hpp"
#include "convert/particle_source.hpp"
#include "convert/sequence_values.hpp"

namespace isoextract::cli {
namespace {

constexpr std::uint64_t kEnoughParticles = 50;

void add_note(BatchPlan& plan, const Note& note) {
  plan.common.notes.push_back(note);
  plan.frame_notes.push_back(note);
}

std::vector<FrameSource> first_frames(const BatchPlan& plan) {
  std::vector<FrameSource> frames;
  for (const batch::FrameJob& frame : plan.batch.frames) {
    if (frames.size() == kFramesForRadius) break;
    frames.push_back({frame.number, frame.job.source});
  }
  return frames;
}

Result<void> set_spacing(BatchPlan& plan) {
  if (plan.common.job.writes<convert::ParticleFileOptions>() != nullptr) return {};
  const auto found = TRY(find_sequence_spacing(first_frames(plan), plan.common.context));
  if (!found) return {};
  plan.common.job.source.particles.sequence_spacing = found;
  for (batch::FrameJob& frame : plan.batch.frames) frame.job.source.particles.sequence_spacing = found;
  add_note(plan, {NoteId::cell_size, spacing_note(*found)});
  return {};
}

Result<void> set_radius(BatchPlan& plan) {
  if (plan.common.job.writes<convert::ParticleFileOptions>() != nullptr) return {};
  const auto found = TRY(find_sequence_radius(first_frames(plan), plan.common.context));
  if (!found) return {};
  plan.common.job.source.particles.sequence_radius = found->radius;
  for (batch::FrameJob& frame : plan.batch.frames) frame.job.source.particles.sequence_radius = found->radius;
  add_note(plan, {NoteId::particle_radius, found->note()});
  return {};
}

Result<void> set_color_range(BatchPlan& plan, const Messages& messages) {
  Progress progress;
  progress.begin("reading attributes for the range of colors", plan.batch.frames.size());
  const bool is_shown = plan.progress != ProgressStyle::json && messages.verbosity() != Verbosity::quiet;
  const ProgressBar bar(progress, is_shown, {}, true);
  std::optional<edit::ValueRange> range;
  for (const batch::FrameJob& frame : plan.batch.frames) {
    const auto found = convert::find_color_range(frame.job, plan.common.context.beside());
    TRY(plan.common.context.check());
    progress.advance(1);
    if (!found || !*found) continue;
    const edit::ValueRange& own = **found;
    range = range ? edit::ValueRange{std::min((*range)[0], own[0]), std::max((*range)[1], own[1])} : own;
  }
  if (!range) return {};
  plan.common.job.color->range = range;
  for (batch::FrameJob& frame : plan.batch.frames) frame.job.color->range = range;
  add_note(plan, {NoteId::color_range,
                  fmt::format("--color-by {}: the colors range from {:.6g} to {:.6g}, the values of all {} frames; add "
                              ":MIN,MAX to save the first pass over the frames",
                              printable(*plan.common.job.color->attribute), (*range)[0], (*range)[1],
                              plan.batch.frames.size())});
  return {};
}

}  // namespace

std::string SequenceRadius::note() const {
  return fmt::format(
      "all frames have the radius {:.6g}, which fits the particles of frame {}; choose another with "
      "--radius R, or one for each frame with --radius auto:each",
      radius, frame);
}

Result<std::optional<SequenceRadius>> find_sequence_radius(std::span<const FrameSource> frames,
                                                           const Context& context) {
  std::optional<SequenceRadius> first;
  for (const FrameSource& frame : frames) {
    if (frame.source.particles.radius || frame.source.particles.element_radii) return std::nullopt;
    const auto particles = convert::is_particles(frame.source, context.beside());
    TRY(context.check());
    if (!particles) continue;
    if (!*particles) return std::nullopt;
    const auto found = convert::find_radius(frame.source, context.beside());
    TRY(context.check());
    if (!found) continue;
    if (found->has_attribute) return std::nullopt;
    if (!found->radius) continue;
    if (!first || found->particles >= kEnoughParticles) first = SequenceRadius{*found->radius, frame.frame};
    if (found->particles >= kEnoughParticles) break;
  }
  return first;
}

Result<std::optional<double>> find_sequence_spacing(std::span<const FrameSource> frames, const Context& context) {
  std::optional<double> finest;
  for (const FrameSource& frame : frames) {
    const convert::ParticleOptions& options = frame.source.particles;
    const bool is_of_spheres = points::method_info(options.method).kind == field::FieldKind::level_set;
    if (!is_of_spheres || options.radius || options.cell_size || frame.source.resamples()) return std::nullopt;
    const auto particles = convert::is_particles(frame.source, context.beside());
    TRY(context.check());
    if (!particles.value_or(false)) continue;
    const auto found = convert::find_sphere_spacing(frame.source, context.beside());
    TRY(context.check());
    if (found && *found) finest = std::min(finest.value_or(**found), **found);
  }
  return finest;
}

std::string spacing_note(double spacing) {
  return fmt::format(
      "all frames have samples {:.6g} apart, which keeps particles of the radius {:.6g}; choose another distance with "
      "--cell-size C, in median radii of each frame",
      spacing, points::kMinSphereRadius * spacing);
}

Result<void> find_sequence_values(const ConvertFlags& flags, BatchPlan& plan, const Messages& messages) {
  if (plan.batch.frames.size() < 2) return {};
  if (!(flags.particles.radius && flags.particles.radius->is_of_each_frame)) TRY(set_radius(plan));
  TRY(set_spacing(plan));
  const std::optional<convert::ColorChoice>& color = plan.common.job.color;
  if (color && color->attribute && !color->range) TRY(set_color_range(plan, messages));
  return {};
}

}  // namespace isoextract::cli
