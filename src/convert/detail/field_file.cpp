#include "convert/detail/field_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "field/statistics.hpp"
#include "files/output_file.hpp"
#include "volume_io/grid_tools.hpp"

namespace isoextract::convert {
namespace {

constexpr double kLargestHalf = 65504;

// Returns whether float represents every value of the field exactly.
bool fits_float(const field::ScalarField& field) {
  using field::SampleType;
  const SampleType type = field.type();
  return field.scale.is_identity() && type != SampleType::f64 && type != SampleType::u32 && type != SampleType::i32;
}

bool fits_half(const field::ScalarField& field) {
  using field::SampleType;
  const SampleType type = field.type();
  return field.scale.is_identity() && (type == SampleType::f16 || type == SampleType::u8 || type == SampleType::i8);
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
  return fmt::format("samples in {} bricks (8x8x8) and {} tiles", sparse.blocks.size(), sparse.tiles.size());
}

}  // namespace

Result<mesh_io::WrittenFile> write_field(const Source& source, const ConversionJob& job, const OutputFileJob& output,
                                         const Context& context, Events& events) {
  const field::ScalarField& field = source.field;
  const bool as_half = std::get<FieldFileOptions>(job.file).as_half;
  context.progress().begin("writing", 0);
  const Stopwatch watch;
  if (as_half) {
    TRY(check_range(field, source.label, kLargestHalf, "half floats", {Remedy::leave_out, Setting::half_floats}));
  } else if (!fits_float(field)) {
    TRY(check_range(field, source.label, std::numeric_limits<float>::max(), "floats", {}));
  }
  const auto bytes = TRY(volume_io::write_vdb(output.path, field, {field.name, as_half}, context));
  StageReport report(StageName::write, files::output_label(output.path), source.label);
  report.time = watch.elapsed();
  report.did = "written";
  report.output.emplace();
  report.output->samples = fmt::format("{}, as {} bits each", samples_text(field), as_half ? 16 : 32);
  report.output->bytes = bytes;
  if (as_half ? !fits_half(field) : !fits_float(field)) {
    report.work.push_back(
        {WorkTopic::samples, WorkDone::rounded, std::nullopt, std::nullopt,
         fmt::format("values of {}{} to {}", field::sample_type_name(field.type()),
                     field.scale.is_identity() ? "" : " with a scale", as_half ? "16-bit floats" : "32-bit floats")});
  }
  if (!source.of_particles && job.surface.nan != extract::NanPolicy::error) {
    events.note(
        {NoteId::nan_samples, fmt::format("{}: the file stores samples that are not numbers unchanged", source.label)});
  }
  events.end(report);
  return mesh_io::WrittenFile{output.path, bytes};
}

}  // namespace isoextract::convert
