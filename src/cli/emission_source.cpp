#include "cli/emission_source.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "cli/values.hpp"
#include "convert/field_label.hpp"
#include "convert/particle_source.hpp"
#include "field/label_map.hpp"
#include "field/statistics.hpp"
#include "files/file_bytes.hpp"
#include "render/black_body.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {
namespace {

// Below it the greatest value of a grid is no temperature in kelvin: nothing in a flame is that cold.
constexpr double kLeastKelvin = 200;

// Rewords hints about --grid as hints about --emission.
Error error_of_emission(Error error) {
  error.message = "--emission: " + error.message;
  std::erase_if(error.hint.steps,
                [](const Step& step) { return step.setting == Setting::grid && step.remedy == Remedy::leave_out; });
  for (Step& step : error.hint.steps) {
    if (step.setting == Setting::grid) step = "choose one of them with --emission GRID" + step.text;
    if (step.setting == Setting::component) step = "choose a grid with one number per sample";
  }
  return error;
}

// Returns the options that read the chosen grid.
Result<volume_io::ReadOptions> read_options(const EmissionChoice& choice, const convert::SourceOptions& options,
                                            const std::string& input, const Context& context) {
  volume_io::ReadOptions read = options.read;
  read.grid = choice.grid;
  read.component.reset();
  read.kind.reset();
  read.region.reset();
  read.no_data_for_dense_only = true;
  read.sampling = options.voxel_size;
  if (read.volume) {
    const auto volumes = TRY(volume_io::count_volumes(input, read, context));
    if (volumes == 1) read.volume.reset();
  }
  return read;
}

// Refuses a grid of vectors, from which reading would choose no component.
Result<void> check_scalar(const EmissionChoice& choice, const volume_io::ReadOptions& read, const std::string& input,
                          const Context& context) {
  const auto grids = TRY(volume_io::list_grids(input, read, context));
  const auto chosen =
      std::ranges::find_if(grids, [&](const volume_io::GridInfo& grid) { return grid.matches_name(choice.grid); });
  if (chosen == grids.end()) return {};  // reading reports it
  const bool is_vector = chosen->type.starts_with("vec") || chosen->components > 1;
  if (!is_vector) return {};
  const std::string components =
      chosen->parts.empty() ? "" : fmt::format(", such as --emission {}", shell_quoted(chosen->parts.front()));
  return fail(ErrorCode::input,
              fmt::format("{}: expected a grid with one number per voxel, but '{}' holds vectors ({})",
                          files::input_label(input), chosen->label, chosen->type),
              "choose a grid of temperatures or flames" + components);
}

bool holds_labels(const field::ScalarField& field) {
  if (!field.labels.empty()) return true;
  bool is_whole = false;
  field::visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) { is_whole = std::is_integral_v<T>; });
  return is_whole && field::guess_label_map(field) == field::LabelMapKind::label_map;
}

Result<field::ScalarField> read_grid(const EmissionChoice& choice, const convert::SourceOptions& options,
                                     const std::string& input, const Context& context, convert::Events& events) {
  const auto read = TRY(read_options(choice, options, input, context));
  TRY(check_scalar(choice, read, input, context));
  return convert::read_field(input, read, context, events);
}

bool is_empty(const field::ScalarField& field) {
  return std::holds_alternative<field::SparseSamples>(field.samples) && field.extents().empty();
}

// Checks that the values can be meant; notes that none of them emits light.
Result<void> check_values(const EmissionChoice& choice, const EmissionSource& emission, convert::Events& events) {
  const std::string label = convert::field_label(emission.field);
  const double greatest = emission.greatest;
  const std::string range = fmt::format("{}:0,{:.6g}", shell_quoted(choice.grid), greatest);
  if (!choice.range && greatest > 0 && greatest < kLeastKelvin) {
    return fail(
        ErrorCode::input,
        fmt::format("--emission: {}: expected temperatures in kelvin, found values up to {:.6g}", label, greatest),
        fmt::format("give the range of the values: with --emission {} the value 0 stands for {:g} K, where "
                    "bodies begin to glow, and {:.6g} for {:g} K",
                    range, render::BlackBody::kGlowBegins, greatest, render::BlackBody::kReference));
  }
  const double begins = choice.range ? (*choice.range)[0] : render::BlackBody::kGlowBegins;
  if (greatest > begins) return {};
  events.note({NoteId::no_effect, fmt::format("{}: no value is above {:g}{}, so the grid emits no light", label, begins,
                                              choice.range ? "" : " K, where bodies begin to glow")});
  return {};
}

}  // namespace

Result<void> check_emission_input(const EmissionChoice& choice, const convert::SourceOptions& options,
                                  const Context& context) {
  const auto of_particles = TRY(convert::is_particles(options, context));
  if (!of_particles) return {};
  return fail(ErrorCode::usage,
              fmt::format("--emission: {}: expected a volume with the grid '{}', found particles",
                          files::input_label(options.input), printable(choice.grid)),
              "leave --emission out");
}

Result<std::optional<EmissionSource>> read_emission(const EmissionChoice& choice, const convert::SourceOptions& options,
                                                    const convert::Source& source, const Context& context,
                                                    convert::Events& events) {
  if (source.field.grids == 0) {
    return fail(ErrorCode::input,
                fmt::format("--emission: {}: expected a file with named grids, to read the light from its grid '{}', "
                            "found {}",
                            source.field.source, printable(choice.grid), source.field.format),
                "write both grids into one file, such as a VDB");
  }
  std::string input = options.input;
  if (const auto colon = volume_io::find_inner_path(input)) input.resize(*colon);
  auto field = read_grid(choice, options, input, context, events);
  if (!field) return tl::unexpected(error_of_emission(std::move(field.error())));
  if (is_empty(*field)) {
    events.note({NoteId::no_effect, convert::field_label(*field) + ": the grid has no voxels, so it emits no light"});
    return std::nullopt;
  }
  if (holds_labels(*field)) {
    return fail(ErrorCode::input,
                fmt::format("--emission: {}: expected temperatures or amounts of flame, found the numbers of labels",
                            convert::field_label(*field)),
                "choose another grid with --emission GRID");
  }
  EmissionSource emission;
  const auto statistics = field::measure_statistics(*field, &context.progress(), field::WithPercentiles::no);
  emission.greatest = statistics.samples > 0 ? statistics.max : 0;
  if (const auto* sparse = std::get_if<field::SparseSamples>(&field->samples)) {
    const double background = field->scale(sparse->background);
    if (std::isfinite(background)) emission.greatest = std::max(emission.greatest, background);
  }
  emission.field = std::move(*field);
  emission.output_from_index = source.placement.output_from_world().after(emission.field.index_to_world);
  emission.light = TRY(render::emission_function(choice.range));
  TRY(check_values(choice, emission, events));
  return emission;
}

}  // namespace isoextract::cli
