#include "convert/detail/particle_file.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "convert/detail/no_surface.hpp"
#include "convert/particle_choice.hpp"
#include "convert/particle_source.hpp"
#include "convert/simulation_box.hpp"
#include "convert/source.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "particle_io/particle_reader.hpp"
#include "particle_io/particle_writer.hpp"
#include "points/region.hpp"

namespace isoextract::convert {
namespace {

// Particles with what was left out of them.
struct ChosenParticles {
  particle_io::ParticleFile file;
  std::optional<ParticleCount> chosen;     // by the condition and the stride
  std::optional<ParticleCount> in_region;  // of these
  std::uint64_t not_finite = 0;            // left out

  // Returns a source without particles, whose label and reason messages need.
  [[nodiscard]] Source empty_source(const SourceOptions& options) const {
    Source source;
    source.label = printable(file.particles.label);
    source.of_particles = true;
    source.empty = true;
    if (in_region && in_region->of > 0) source.set_empty_region(*in_region, *options.roi);
    if (chosen && chosen->chosen == 0) source.why_no_particles = why_none_chosen(*chosen, options.particles);
    return source;
  }
};

Result<ChosenParticles> read_chosen_particles(const SourceOptions& options, const Context& context, Events& events) {
  const auto are_particles = TRY(is_particles(options, context));
  if (!are_particles) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the output holds particles, but the input is a volume",
                            printable(files::input_label(options.input))),
                {Remedy::change, Setting::output_name});
  }
  const Stopwatch watch;
  particle_io::ParticleReadOptions read = particle_read_options(options);
  read.all_attributes = true;
  ChosenParticles result;
  result.file = TRY(particle_io::read_particles(options.input, read, context));
  points::ParticleSet& particles = result.file.particles;
  StageReport report = report_on(StageName::read, printable(particles.label));
  report.time = watch.elapsed();
  report.did = "read";
  events.end(report);
  for (const Note& text : std::exchange(result.file.notes, {})) events.note(text);
  TRY(context.check());
  result.chosen = TRY(keep_chosen(particles, options.particles, context));
  TRY(give_element_radii(result.file, options, context));
  for (const Note& text : std::exchange(result.file.notes, {})) events.note(text);
  TRY(apply_box_options(options.particles.simulation_box, particles));
  result.not_finite = TRY(points::keep_finite(particles, options.particles.non_finite, context));
  if (options.roi) {
    const std::uint64_t all = particles.size();
    const std::uint64_t removed = TRY(points::keep_inside(particles, *options.roi, context));
    result.in_region = {all - removed, all};
  }
  return result;
}

// Tells what the file does not state.
std::optional<Note> missing_facts_note(const std::string& path, const particle_io::ParticleFile& file,
                                       particle_io::ParticleFileFormat format) {
  std::string lacks;
  if (const auto& box = file.particles.box; box && !particle_io::stores_box(format)) {
    lacks = fmt::format("the box {}, periodic along {}", points::box_text(*box), points::periodic_text(*box));
  }
  if (!file.length_unit.empty()) {
    lacks += fmt::format("{}the unit of length, {}", lacks.empty() ? "" : ", nor ", printable(file.length_unit, 80));
  }
  if (lacks.empty()) return std::nullopt;
  return Note{NoteId::placement_not_stored,
              fmt::format("{}: the file does not state {}", files::output_label(path), lacks)};
}

void tell_choice(const ChosenParticles& chosen, const ConversionJob& job, Events& events) {
  const std::string label = printable(chosen.file.particles.label);
  if (chosen.not_finite > 0) {
    events.note(
        {NoteId::particles_left_out, fmt::format("{}: the conversion left out {}", label,
                                                 counted(chosen.not_finite, "particle whose position is not finite",
                                                         "particles whose positions are not finite"))});
  }
  StageReport report = report_on(StageName::choose_particles, label);
  const points::ParticleSet& particles = chosen.file.particles;
  report.entries.push_back(
      {{Key::path, job.source.input},
       {Key::format, chosen.file.format},
       {Key::length_unit, chosen.file.length_unit},
       {Key::frame, frame_figures(chosen.file.time)},
       {Key::particles, particles.size()},
       {Key::chosen, chosen.chosen ? Value(chosen.chosen->chosen) : Value()},
       {Key::chosen_of, chosen.chosen ? Value(chosen.chosen->of) : Value()},
       {Key::outside_region, chosen.in_region ? Value(chosen.in_region->of - chosen.in_region->chosen) : Value()},
       {Key::not_finite, chosen.not_finite},
       {Key::simulation_box, box_figures(particles.box)}});
  if (chosen.chosen) report.work.push_back(choice_fact(*chosen.chosen, job.source.particles));
  if (chosen.in_region) {
    const std::uint64_t removed = chosen.in_region->of - chosen.in_region->chosen;
    report.work.push_back(
        {WorkTopic::particles_outside_region, WorkDone::left_out, removed, chosen.in_region->of,
         fmt::format("{} of {}, outside the region", removed, counted(chosen.in_region->of, "particle"))});
  }
  events.end(report);
}

}  // namespace

Result<std::optional<mesh_io::WrittenFile>> write_particle_file(const ConversionJob& job, const OutputFileJob& output,
                                                                const Context& context, Events& events) {
  auto chosen = TRY(read_chosen_particles(job.source, context, events));
  tell_choice(chosen, job, events);
  points::ParticleSet& particles = chosen.file.particles;
  if (particles.size() == 0 && job.empty != EmptyPolicy::write) {
    TRY(leave_out_empty(chosen.empty_source(job.source), job, output, context, events));
    return std::nullopt;
  }
  context.progress().begin("writing", 0);
  const Stopwatch watch;
  const particle_io::ParticleFileFormat format = job.writes<ParticleFileOptions>()->format;
  const std::string path = files::output_label(output.path);
  for (const Note& note : particle_io::fit_to_file(particles, format)) events.note(prefixed(path + ": ", note));
  const auto bytes = TRY(particle_io::write_particles(output.path, particles, format));
  if (const auto note = missing_facts_note(output.path, chosen.file, format)) events.note(*note);
  StageReport report(StageName::write, path, printable(particles.label));
  report.time = watch.elapsed();
  report.did = "written";
  report.output.emplace();
  const std::size_t attributes = particles.attributes.size() + particles.words.size();
  report.output->samples =
      fmt::format("{} with {}", counted(particles.size(), "particle"), counted(attributes, "attribute"));
  report.output->bytes = bytes;
  events.end(report);
  return mesh_io::WrittenFile{output.path, bytes};
}

Result<std::uint64_t> particle_file_memory(const ConversionJob& job, const Context& context) {
  Events unheard;
  const auto chosen = read_chosen_particles(job.source, context, unheard);
  return chosen ? Result<std::uint64_t>(context.memory().peak()) : tl::unexpected(chosen.error());
}

}  // namespace isoextract::convert
