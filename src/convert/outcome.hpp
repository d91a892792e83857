// What one conversion did, and the document that `--report FILE.json` writes of it. docs/report.schema.json describes
// it; the two change together, and kSchemaVersion rises where a reader of the old document would misread the new one.
//
// The sections are those of the stages (stages.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "convert/json_type.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

inline constexpr int kReportSchemaVersion = 1;

// What of a surface went to one of the outputs, after all that changes it; pieces in files of their own are one each.
struct WrittenSurface {
  SurfaceId id;
  std::size_t output = 0;  // of the job's
  std::uint64_t triangles = 0;
  // The range of Outcome::files that holds it; empty until they are written.
  std::size_t first_file = 0;
  std::size_t files = 0;
  std::string grid = {};  // where the job has several
};

// What a conversion did, or how far it came before it failed.
struct Outcome {
  std::string backend;  // "cpu" or "gpu"; if it could not be opened, what was asked for; empty if that was not tried
  std::string device;   // the processor's or the GPU's name; empty if it could not be opened
  int threads = 0;
  std::vector<StageReport> reports;  // in the order in which the stages ran
  StageTime total;
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_uploaded = 0;   // to a device; 0 on the CPU
  std::uint64_t peak_memory = 0;      // of the process
  std::uint64_t reserved_memory = 0;  // the most that this conversion reserved at a time
  std::vector<WrittenSurface> written;
  std::vector<mesh_io::WrittenFile> files;
  bool empty_picture = false;  // there are surfaces, and a picture shows none of them
  std::vector<std::string> notes;
  std::optional<Error> error;  // why the conversion failed

  [[nodiscard]] bool done() const { return !error; }
  // The first report of the stage with figures; null where there is none.
  [[nodiscard]] const StageReport* first(StageName stage) const;
  // Of all stages, in their order.
  [[nodiscard]] std::vector<StageReport::Part> times() const;
};

// The report's document. `job` is null where the options gave none, which is why the outcome failed. `arguments` are
// the words of the command line without the program, `memory_limit` the budget's; `hint` is the outcome's hint in
// words, which only the command line has.
[[nodiscard]] Json report_of(const ConversionJob* job, const Outcome& outcome,
                             const std::vector<std::string>& arguments, std::uint64_t memory_limit,
                             const std::string& hint);

}  // namespace isoextract::convert
