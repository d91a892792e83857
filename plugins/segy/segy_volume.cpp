// SEG-Y files of stacked traces as a box of samples, through segyio. Samples along a trace are x, the fastest axis, as
// in the file, so that each trace is read directly into the box.
#include <cmath>
#include <limits>
#include <mutex>

#include "segy_survey.hpp"

namespace isoextract_segy {
namespace {

constexpr int kFormatField = SEGY_BIN_FORMAT - SEGY_TEXT_HEADER_SIZE - 1;

std::string reason_text(int status) {
  switch (status) {
    case SEGY_FSEEK_ERROR:
    case SEGY_FREAD_ERROR: return "the file ends too early";
    case SEGY_TRACE_SIZE_MISMATCH: return "the file does not end after a whole number of traces";
    default: return "segyio reports error " + std::to_string(status);
  }
}

void check(int status, const std::string& what) {
  if (status != SEGY_OK) throw ReadError(what + ": " + reason_text(status));
}

bool is_known_format(int format) {
  return format == SEGY_IBM_FLOAT_4_BYTE || format == SEGY_SIGNED_INTEGER_4_BYTE ||
         format == SEGY_SIGNED_SHORT_2_BYTE || format == SEGY_IEEE_FLOAT_4_BYTE || format == SEGY_SIGNED_CHAR_1_BYTE;
}

const char* format_text(int format) {
  switch (format) {
    case SEGY_IBM_FLOAT_4_BYTE: return "IBM float";
    case SEGY_SIGNED_INTEGER_4_BYTE: return "int32";
    case SEGY_SIGNED_SHORT_2_BYTE: return "int16";
    case SEGY_IEEE_FLOAT_4_BYTE: return "float";
    default: return "int8";
  }
}

int read_field(const char* header, int which) {
  std::int32_t value = 0;
  check(segy_get_bfield(header, which, &value), "segyio cannot read its binary header");
  return value;
}

// Turns little-endian 16-bit samples into native ones.
void convert_little_endian(unsigned char* samples, int count) {
  for (int i = 0; i < count; ++i, samples += 2) {
    const auto value = static_cast<std::uint16_t>(samples[0] | samples[1] << 8);
    std::memcpy(samples, &value, sizeof value);
  }
}

}  // namespace

SegyFile::SegyFile(const std::string& path) : file_(segy_open(path.c_str(), "rb")) {
  if (file_ == nullptr) throw ReadError("segyio cannot open it");
  try {
    std::array<char, SEGY_BINARY_HEADER_SIZE> header{};
    check(segy_binheader(file_, header.data()), "segyio cannot read its binary header");
    // The format code is below 256 in the right byte order only.
    format_ =
        static_cast<unsigned char>(header[kFormatField]) << 8 | static_cast<unsigned char>(header[kFormatField + 1]);
    if (format_ > 255) {
      is_little_endian_ = true;
      format_ = (format_ & 255) << 8 | format_ >> 8;
    }
    if (!is_known_format(format_)) {
      throw ReadError("expected sample format 1, 2, 3, 5 or 8 (bytes 3225-3226), found " + std::to_string(format_));
    }
    check(segy_set_format(file_, format_ | (is_little_endian_ ? SEGY_LSB : SEGY_MSB)),
          "segyio cannot set its sample format");
    check(segy_binheader(file_, header.data()),
          "segyio cannot read its binary header");  // in the byte order that is set
    samples_ = segy_samples(header.data());
    if (samples_ <= 0)
      throw ReadError("expected samples per trace (bytes 3221-3222), found " + std::to_string(samples_));
    trace_bytes_ = segy_trsize(format_, samples_);
    if (read_field(header.data(), SEGY_BIN_EXT_HEADERS) < 0) {
      throw ReadError("expected a number of extended textual headers (bytes 3505-3506), found a variable one");
    }
    first_trace_ = segy_trace0(header.data());
    check(segy_traces(file_, &traces_, first_trace_, trace_bytes_),
          "expected traces of " + std::to_string(samples_) + " samples");
    if (traces_ < 1) throw ReadError("expected traces, found none");
    // segyio takes the interval from the binary and the trace header; it is 0 if neither states one.
    float interval = 0;
    if (segy_sample_interval(file_, 0, &interval) == SEGY_OK && interval > 0) interval_us_ = interval;
    revision_ = read_field(header.data(), SEGY_BIN_SEGY_REVISION);
    measurement_system_ = read_field(header.data(), SEGY_BIN_MEASUREMENT_SYSTEM);
  } catch (...) {
    segy_close(file_);
    throw;
  }
}

SegyFile::~SegyFile() { segy_close(file_); }

void SegyFile::read_header(int trace, char* header) const {
  check(segy_traceheader(file_, trace, header, first_trace_, trace_bytes_),
        "segyio cannot read the header of trace " + std::to_string(trace));
}

void SegyFile::prepare_samples() {
  if (has_small_samples()) check(segy_set_format(file_, format_ | SEGY_MSB), "segyio cannot set its sample format");
}

void SegyFile::read_samples(int trace, int first, int count, void* to) const {
  const int status = segy_readsubtr(file_, trace, first, first + count, 1, to, nullptr, first_trace_, trace_bytes_);
  check(status, "segyio cannot read trace " + std::to_string(trace));
  if (has_small_samples()) {
    if (format_ == SEGY_SIGNED_SHORT_2_BYTE) convert_little_endian(static_cast<unsigned char*>(to), count);
    return;
  }
  check(segy_to_native(format_, count, to), "segyio cannot convert trace " + std::to_string(trace));
}

namespace {

class SegyVolume final : public isoextract_plugin::VolumeFile {
 public:
  SegyVolume(const isoextract_plugin::Request& request, const isoextract_plugin_host& host)
      : file_(request.path), survey_(read_survey(file_, host)) {
    file_.prepare_samples();
    format = file_.revision() >= 256 ? "SEG-Y revision " + std::to_string(file_.revision() >> 8) : "SEG-Y";
    isoextract_plugin::Grid grid;
    grid.type_name = format_text(file_.format());
    grid.sample_type = sample_type();
    grid.dims = {static_cast<std::uint64_t>(file_.samples()), survey_.fast.count, survey_.slow.count};
    const auto& plane = survey_.plane;
    const double step = file_.interval_us() > 0 ? file_.interval_us() / 1000 : 1;
    grid.index_to_world = {0,     plane[0], plane[1], plane[2],  //
                           0,     plane[3], plane[4], plane[5],  //
                           -step, 0,        0,        -survey_.delay_ms + 0.0};
    grids.push_back(std::move(grid));
  }

  isoextract_plugin::ReadFacts read(const isoextract_volume_selection& selection,
                                    const isoextract_plugin_host& host) override {
    const std::scoped_lock lock(mutex_);
    isoextract_plugin::with_sample_type(grids[0].sample_type, [&]<class T>(T) { read_box<T>(selection, host); });
    isoextract_plugin::ReadFacts facts;
    facts.note = placement_note();
    for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
      for (std::uint64_t y = 0; y < selection.count[1]; ++y) facts.parts_read += trace_at(selection, y, z) >= 0 ? 1 : 0;
    }
    facts.parts = static_cast<std::uint64_t>(file_.traces());
    return facts;
  }

 private:
  // Missing traces become NaN, which integers do not have.
  [[nodiscard]] std::int32_t sample_type() const {
    const bool needs_floats = survey_.missing > 0;
    switch (file_.format()) {
      case SEGY_SIGNED_INTEGER_4_BYTE: return needs_floats ? ISOEXTRACT_F64 : ISOEXTRACT_I32;
      case SEGY_SIGNED_SHORT_2_BYTE: return needs_floats ? ISOEXTRACT_F32 : ISOEXTRACT_I16;
      case SEGY_SIGNED_CHAR_1_BYTE: return needs_floats ? ISOEXTRACT_F32 : ISOEXTRACT_I8;
      default: return ISOEXTRACT_F32;
    }
  }

  [[nodiscard]] std::string placement_note() const {
    std::string text = "grid axes are samples, ";
    text += survey_.inlines_are_slow ? "crosslines, inlines; " : "inlines, crosslines; ";
    text += survey_.note;
    text += file_.interval_us() > 0 ? "; z is minus the time in ms, or minus the depth in m"
                                    : "; z is minus the number of the sample, as the file states no interval";
    if (file_.measurement_system() == 1) text += "; x and y are in meters";
    if (file_.measurement_system() == 2) text += "; x and y are in feet";
    return text;
  }

  [[nodiscard]] std::int32_t trace_at(const isoextract_volume_selection& selection, std::uint64_t y,
                                      std::uint64_t z) const {
    return survey_.trace[(selection.first[2] + z) * survey_.fast.count + selection.first[1] + y];
  }

  template <class T>
  void read_box(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) {
    T* to = static_cast<T*>(selection.box);
    const std::uint64_t count = selection.count[0];
    // The stored samples of one trace, if they become floats: up to 4 bytes each.
    std::vector<std::int32_t> stored;
    HostMemory memory(host);
    const bool converts =
        survey_.missing > 0 && file_.format() != SEGY_IBM_FLOAT_4_BYTE && file_.format() != SEGY_IEEE_FLOAT_4_BYTE;
    if (converts) {
      memory.take(count * sizeof(std::int32_t));
      stored.resize(count);
    }
    for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
      isoextract_plugin::check_cancelled(host);
      for (std::uint64_t y = 0; y < selection.count[1]; ++y, to += count) {
        const std::int32_t trace = trace_at(selection, y, z);
        if (trace < 0) {
          if constexpr (std::is_floating_point_v<T>) std::fill_n(to, count, std::numeric_limits<T>::quiet_NaN());
          continue;
        }
        const auto first = static_cast<int>(selection.first[0]);
        if (!converts) {
          file_.read_samples(trace, first, static_cast<int>(count), to);
          continue;
        }
        file_.read_samples(trace, first, static_cast<int>(count), stored.data());
        switch (file_.format()) {
          case SEGY_SIGNED_INTEGER_4_BYTE: copy_as<std::int32_t>(stored.data(), count, to); break;
          case SEGY_SIGNED_SHORT_2_BYTE: copy_as<std::int16_t>(stored.data(), count, to); break;
          default: copy_as<std::int8_t>(stored.data(), count, to); break;
        }
      }
    }
  }

  template <class Stored, class T>
  static void copy_as(const void* stored, std::uint64_t count, T* to) {
    const auto* const bytes = static_cast<const char*>(stored);
    for (std::uint64_t i = 0; i < count; ++i) {
      Stored value{};
      std::memcpy(&value, bytes + i * sizeof(Stored), sizeof(Stored));
      to[i] = static_cast<T>(value);
    }
  }

  std::mutex mutex_;  // of file_, which has one position
  SegyFile file_;
  Survey survey_;
};

std::unique_ptr<isoextract_plugin::VolumeFile> open_file(const isoextract_plugin::Request& request,
                                                         const isoextract_plugin_host& host) {
  return std::make_unique<SegyVolume>(request, host);
}

// The textual header begins with "C 1" or "C01", in EBCDIC.
bool probe_file(const unsigned char* start, std::size_t bytes, const std::string& /*path*/) {
  return bytes >= 3 && start[0] == 0xC3 && (start[1] == 0x40 || start[1] == 0xF0) && start[2] == 0xF1;
}

}  // namespace
}  // namespace isoextract_segy

const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 table =
      isoextract_plugin::volume_plugin<isoextract_segy::open_file, isoextract_segy::probe_file>("segy", "SEG-Y");
  return &table;
}
