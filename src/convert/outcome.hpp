// The outcome of one conversion, and the JSON report of it (`--report FILE.json`). docs/schemas/report.schema.json
// describes the report and must change with it. Raise kReportSchemaVersion if a reader of the old report would misread
// the new one.
//
// A stage with a StageInfo::section has a section in the report if the job asks for the stage or if
// StageInfo::is_listed is set (stages.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/note.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "convert/json_type.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

inline constexpr int kReportSchemaVersion = 1;

// One surface in one output, after all edits. With PieceChoice::split, each body is one entry.
struct WrittenSurface {
  SurfaceId id;
  std::size_t output = 0;  // index into the job's outputs
  std::uint64_t triangles = 0;
  // The range of Outcome::files that holds the surface; empty until these files are written.
  std::size_t first_file = 0;
  std::size_t files = 0;
  std::string grid = {};  // set if the job has several grids
};

// Results of a conversion, up to the failure if it failed.
struct Outcome {
  // "cpu" or "gpu"; the requested backend if it could not be opened; empty if opening was not tried
  std::string backend;
  std::string device;  // name of the processor or GPU; empty if the backend could not be opened
  int threads = 0;
  std::vector<StageReport> reports;  // in the order in which the stages ran; mostly without details and lines
  StageTime total;
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_uploaded = 0;   // to a GPU; 0 on the CPU
  std::uint64_t peak_memory = 0;      // of the process
  std::uint64_t reserved_memory = 0;  // peak of this conversion's reservations
  std::vector<WrittenSurface> written;
  std::vector<mesh_io::WrittenFile> files;
  double front = 0;            // front_azimuth() of the last source, in degrees; 0 if the conversion failed
  bool empty_picture = false;  // the picture shows none of the surfaces, although there are some
  Notes notes;
  std::optional<Error> error;  // why the conversion failed

  [[nodiscard]] bool done() const { return !error; }
  // Returns the first report of this stage with at least one entry, or null.
  [[nodiscard]] const StageReport* first(StageName stage) const;
  // Returns the times of all stages, in order.
  [[nodiscard]] std::vector<StageReport::Part> times() const;
};

// Returns the report. `job` is null if there is no plan of the conversion, because the options are invalid or
// contradict each other. `arguments` are the words of the command line without the program. `memory_limit` is in bytes.
// `hint` is the error's hint as text, with the names of the options.
[[nodiscard]] Json report_of(const ConversionJob* job, const Outcome& outcome,
                             const std::vector<std::string>& arguments, std::uint64_t memory_limit,
                             const std::string& hint);

}  // namespace isoextract::convert
