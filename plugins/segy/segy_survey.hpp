// The traces of a SEG-Y file as a lattice of inlines and crosslines.
//
// Header fields are those of SEG-Y revision 1 (Norris and Faichney 2002,
// https://library.seg.org/seg-technical-standards).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <segyio/segy.h>

#include <volume_reader.hpp>

namespace isoextract_segy {

using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadError;

// An open file with the fields of its binary header.
class SegyFile {
 public:
  // Throws if the header is not that of a SEG-Y file with traces of equal length.
  explicit SegyFile(const std::string& path);
  SegyFile(const SegyFile&) = delete;
  SegyFile& operator=(const SegyFile&) = delete;
  ~SegyFile();

  [[nodiscard]] int format() const { return format_; }
  [[nodiscard]] int samples() const { return samples_; }
  [[nodiscard]] int traces() const { return traces_; }
  [[nodiscard]] double interval_us() const { return interval_us_; }  // 0 if the file states none
  [[nodiscard]] int revision() const { return revision_; }
  [[nodiscard]] int measurement_system() const { return measurement_system_; }  // 1: meters, 2: feet, else unknown

  void read_header(int trace, char* header) const;
  // segyio 1.9 reverses groups of four bytes in a little-endian file, even if samples are smaller. After this call,
  // read_samples() works for such samples, but read_header() no longer works for such files.
  void prepare_samples();
  // Reads samples first .. first + count - 1 of a trace and converts them to native numbers.
  void read_samples(int trace, int first, int count, void* to) const;

 private:
  // Returns whether samples are little-endian and of less than four bytes.
  [[nodiscard]] bool has_small_samples() const {
    return is_little_endian_ && (format_ == SEGY_SIGNED_SHORT_2_BYTE || format_ == SEGY_SIGNED_CHAR_1_BYTE);
  }

  segy_file* file_ = nullptr;
  int format_ = 0;
  bool is_little_endian_ = false;
  int samples_ = 0;
  int traces_ = 0;
  int trace_bytes_ = 0;
  long first_trace_ = 0;
  double interval_us_ = 0;
  int revision_ = 0;
  int measurement_system_ = 0;
};

// Equally spaced line numbers.
struct Lines {
  std::int64_t first = 0;
  std::int64_t step = 1;
  std::uint64_t count = 0;
};

// The lattice of the traces. Grid axis x runs along a trace, y from trace to trace in a line, z from line to line.
struct Survey {
  bool inlines_are_slow = true;     // y counts crosslines, z inlines; otherwise the reverse
  Lines fast;                       // along y
  Lines slow;                       // along z
  std::vector<std::int32_t> trace;  // index of the trace at each (y, z), y fastest; -1 if missing
  std::uint64_t missing = 0;
  double delay_ms = 0;            // time of the first sample
  std::array<double, 6> plane{};  // world x and y from (y, z, 1) in grid indices: two rows of three
  std::string note;
};

// Reads the headers of all traces. Throws if the traces are not a lattice with at most one trace at each point, or
// start at different times. The memory of the table stays reserved until the host frees the list.
Survey read_survey(const SegyFile& file, const isoextract_plugin_host& host);

}  // namespace isoextract_segy
