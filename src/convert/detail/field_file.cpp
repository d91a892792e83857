#include "convert/detail/field_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/stopwatch.hpp"
#include "field/dense_field.hpp"
#include "field/statistics.hpp"
#include "files/output_file.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::convert {
namespace {

constexpr double kLargestHalf = 65504;

// Returns whether every value of the field, before its scale, fits into `type` without rounding.
bool fits(const field::ScalarField& field, field::SampleType type) {
  using field::SampleType;
  const SampleType own = field.type();
  if (own == type || type == SampleType::f64) return true;
  const bool is_small = own == SampleType::f16 || own == SampleType::u8 || own == SampleType::i8;
  if (type == SampleType::f16) return is_small;
  return is_small || own == SampleType::u16 || own == SampleType::i16;
}

// Returns the type of the samples in the file.
field::SampleType stored_type(const field::ScalarField& field, const FieldFileOptions& file) {
  using field::SampleType;
  if (file.as_half) return SampleType::f16;
  if (file.format == volume_io::VolumeFileFormat::vdb) return SampleType::f32;
  const SampleType own = field.type();
  const bool is_wide = own == SampleType::f64 || own == SampleType::u32 || own == SampleType::i32;
  if (!field.scale.is_identity()) return is_wide ? SampleType::f64 : SampleType::f32;
  return volume_io::can_store(file.format, own) ? own : SampleType::f32;
}

// Fails if the largest absolute value, the background included, exceeds `largest`: the file would store infinity.
Result<void> check_range(const field::ScalarField& field, const std::string& label, double largest, const char* numbers,
                         const Hint& hint) {
  const field::FieldStatistics values = field::measure_statistics(field);
  double most = values.samples == 0 ? 0.0 : std::max(std::abs(values.min), std::abs(values.max));
  if (const auto* sparse = std::get_if<field::SparseSamples>(&field.samples)) {
    if (const double background = std::abs(field.scale(sparse->background)); std::isfinite(background)) {
      most = std::max(most, background);
    }
  }
  if (most <= largest) return {};
  return fail(ErrorCode::output,
              fmt::format("{}: expected samples with absolute values up to {:.6g}, the limit of {}; found {:.6g}",
                          label, largest, numbers, most),
              hint);
}

std::string samples_text(const field::ScalarField& field) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    return fmt::format("{} x {} x {} samples", dense->dims.x, dense->dims.y, dense->dims.z);
  }
  const auto& sparse = std::get<field::SparseSamples>(field.samples);
  return fmt::format("samples in {} (8x8x8) and {}", counted(sparse.blocks.size(), "brick"),
                     counted(sparse.tiles.size(), "tile"));
}

struct WrittenField {
  std::uint64_t bytes = 0;
  std::string samples;
  Notes notes;
};

// Tells what the file does not state: all of the placement in NPY files, and the side of level sets in all files but
// VDB.
std::optional<Note> missing_facts_note(const std::string& path, const field::ScalarField& field,
                                       volume_io::VolumeFileFormat format) {
  const bool is_npy = format == volume_io::VolumeFileFormat::npy;
  const bool is_below = field.kind == field::FieldKind::level_set;
  if (!is_npy && !is_below) return std::nullopt;
  const field::Affine& place = field.index_to_world;
  std::string lacks;
  if (is_npy) {
    const glm::dvec3 origin = place.offset + 0.0;  // the sum turns -0 into 0
    const glm::dvec3 spacing(place.linear[0].x, place.linear[1].y, place.linear[2].z);
    const bool is_plain = place.linear == glm::dmat3(spacing.x, 0, 0, 0, spacing.y, 0, 0, 0, spacing.z) &&
                          glm::all(glm::greaterThan(spacing, glm::dvec3(0)));
    lacks = is_plain ? fmt::format("the spacing {},{},{} and the origin {},{},{}", spacing.x, spacing.y, spacing.z,
                                   origin.x, origin.y, origin.z)
                     : "the placement, which turns or mirrors the samples";
  }
  if (is_below) lacks += fmt::format("{}that inside is below the iso value", lacks.empty() ? "" : ", nor ");
  return Note{NoteId::placement_not_stored,
              fmt::format("{}: the file does not state {}", files::output_label(path), lacks)};
}

// Returns the note for NaN samples, which the file keeps whatever the NanPolicy; nullopt without such samples.
std::optional<Note> kept_nan_note(const Source& source) {
  const auto found = field::measure_statistics(source.field, nullptr, field::WithPercentiles::no);
  if (found.nan == 0) return std::nullopt;
  return Note{NoteId::nan_samples,
              fmt::format("{}: {} of {} samples {} NaN in the file", source.label, found.nan,
                          found.samples + found.nan + found.infinite, found.nan == 1 ? "stays" : "stay")};
}

Result<WrittenField> write_as(const std::string& path, const field::ScalarField& field, const FieldFileOptions& file,
                              field::SampleType type, const Context& context) {
  if (file.format == volume_io::VolumeFileFormat::vdb) {
    const auto bytes = TRY(volume_io::write_vdb(path, field, {field.name, file.as_half}, context));
    return WrittenField{bytes, samples_text(field), {}};
  }
  auto dense = TRY(field::as_dense(field, type, context));
  WrittenField written{0, samples_text(dense), dense.notes};
  written.bytes = TRY(volume_io::write_volume(path, {&dense, 1}, file.format, context));
  if (auto note = missing_facts_note(path, dense, file.format)) written.notes.push_back(std::move(*note));
  return written;
}

}  // namespace

Result<void> check_field_tools(const ConversionJob& job, const std::string& work) {
  const bool is_vdb = std::get<FieldFileOptions>(job.file).format == volume_io::VolumeFileFormat::vdb;
  return is_vdb ? volume_io::check_grid_tools(work) : Result<void>();
}

Result<mesh_io::WrittenFile> write_field(const Source& source, const ConversionJob& job, const OutputFileJob& output,
                                         const Context& context, Events& events) {
  const field::ScalarField& field = source.field;
  const auto& file = std::get<FieldFileOptions>(job.file);
  const field::SampleType type = stored_type(field, file);
  const bool is_exact = field.scale.is_identity() && fits(field, type);
  context.progress().begin("writing", 0);
  const Stopwatch watch;
  if (type == field::SampleType::f16) {
    TRY(check_range(field, source.label, kLargestHalf, "half floats", {Remedy::leave_out, Setting::half_floats}));
  } else if (type == field::SampleType::f32 && !is_exact) {
    TRY(check_range(field, source.label, std::numeric_limits<float>::max(), "floats", {}));
  }
  const WrittenField written = TRY(write_as(output.path, field, file, type, context));
  for (const Note& note : written.notes) events.note(note);
  StageReport report(StageName::write, files::output_label(output.path), source.label);
  report.time = watch.elapsed();
  report.did = "written";
  report.output.emplace();
  report.output->samples = fmt::format("{}, as {} bits each", written.samples, 8 * field::sample_size(type));
  report.output->bytes = written.bytes;
  if (!is_exact) {
    report.work.push_back(
        {WorkTopic::samples, WorkDone::rounded, std::nullopt, std::nullopt,
         fmt::format("values of {}{} to {}-bit floats", field::sample_type_name(field.type()),
                     field.scale.is_identity() ? "" : " with a scale", 8 * field::sample_size(type))});
  }
  if (!source.of_particles && job.surface.nan != extract::NanPolicy::error) {
    if (const auto note = kept_nan_note(source)) events.note(*note);
  }
  events.end(report);
  return mesh_io::WrittenFile{output.path, written.bytes};
}

}  // namespace isoextract::convert
