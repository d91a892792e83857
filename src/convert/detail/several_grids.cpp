#include "convert/detail/several_grids.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

bool has_surfaces_of(const OutputFileJob& output, const std::optional<std::string>& grid) {
  return !output.grid || output.grid == grid;
}

}  // namespace

std::vector<std::optional<std::string>> grids_of(const SourceOptions& source) {
  std::vector<std::optional<std::string>> grids{source.read.grid};
  grids.insert(grids.end(), source.more_grids.begin(), source.more_grids.end());
  return grids;
}

std::vector<std::optional<std::string>> grids_of(const SourceOptions& source, const OutputFileJob& output) {
  if (output.grid) return {output.grid};
  return grids_of(source);
}

SourceOptions with_grid(const SourceOptions& source, const std::optional<std::string>& grid) {
  SourceOptions options = source;
  options.read.grid = grid;
  return options;
}

std::vector<IsoChoice> isos_of(const ConversionJob& job, const std::optional<std::string>& grid) {
  std::vector<IsoChoice> isos;
  for (const OutputFileJob& output : job.outputs) {
    if (has_surfaces_of(output, grid)) isos.insert(isos.end(), output.isos.begin(), output.isos.end());
  }
  return isos;
}

std::size_t first_iso_of(const ConversionJob& job, std::size_t output, const std::optional<std::string>& grid) {
  std::size_t first = 0;
  for (std::size_t o = 0; o < output; ++o) {
    if (has_surfaces_of(job.outputs[o], grid)) first += job.outputs[o].isos.size();
  }
  return first;
}

Result<void> check_grids(const SourceOptions& source, const Context& context) {
  if (source.more_grids.empty()) return {};
  std::vector<std::string> labels;
  for (const std::optional<std::string>& grid : grids_of(source)) {
    const SourceOptions options = with_grid(source, grid);
    const auto particles = TRY(is_particles(options, context));
    if (particles) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected only volumes in a run with several grids, found particles in '{}'",
                              files::input_label(source.input), printable(grid.value_or(""))),
                  "convert the particles in a separate run");
    }
    auto label = TRY(volume_io::grid_label(source.input, options.read, context));
    if (std::ranges::find(labels, label) != labels.end()) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected each grid once, found '{}' twice", files::input_label(source.input), label),
                  "choose each grid once");
    }
    labels.push_back(std::move(label));
  }
  return {};
}

}  // namespace isoextract::convert
