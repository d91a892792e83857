// Shared code of the particle readers: their exceptions, and the interface that particle_reader.cpp calls. Readers fail
// by exceptions within this module, as any value deep inside a loop can be invalid.
//
// A format describes the columns of its rows as a ParticleTable; choose_columns finds position and attributes among
// them, and a ColumnSink stores each number. The format reads the file through ContentReader, which inflates it block
// by block. It compares counts of a header with the bytes that follow (check_count) before make_particles reserves
// memory. Messages name the line or the byte.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "files/file_part.hpp"
#include "files/file_start.hpp"
#include "particle_io/particle_format.hpp"
#include "particle_io/particle_reader.hpp"

namespace isoextract::particle_io {

// The file is invalid; the message says what was expected and what was found. The caller of a format prepends the file
// name and makes an ErrorCode::input error of it.
struct InvalidParticleFile : std::runtime_error {
  explicit InvalidParticleFile(const std::string& message, Hint the_hint = {})
      : std::runtime_error(message), hint(std::move(the_hint)) {}
  Hint hint;
};

// The file ends within a frame, such as the dump of an interrupted or a running simulation.
struct TruncatedFrame : InvalidParticleFile {
  explicit TruncatedFrame(const std::string& message, std::string the_found = "the file ends in its header")
      : InvalidParticleFile(message), found(std::move(the_found)) {}
  std::string found;  // the part of the frame that the file has: "812 of 1,000 particles"
};

// Wraps any other error unchanged.
struct Refused {
  Error error;
};

// Returns the value of a result or throws its error.
template <class T>
T must(Result<T> result) {
  if (!result) throw Refused{std::move(result.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// A format lives as long as the program, keeps nothing of a file between calls but frame positions (frame_index.hpp),
// and is safe to use from several threads. Options have been checked against the description. Bytes read count in the
// file's context. Throws InvalidParticleFile, Refused and std::bad_alloc.
class ParticleFormat {
 public:
  explicit ParticleFormat(ParticleFormatDescription about) : about_(std::move(about)) {}
  virtual ~ParticleFormat() = default;
  ParticleFormat(const ParticleFormat&) = delete;
  ParticleFormat& operator=(const ParticleFormat&) = delete;

  [[nodiscard]] const ParticleFormatDescription& about() const { return about_; }

  // Returns whether the start of a file proves that it holds particles in this format.
  [[nodiscard]] virtual bool probe(const files::FileStart& /*start*/) const { return false; }

  // Returns whether a file holds particles in this format. Override it if the start of a file cannot prove that.
  [[nodiscard]] virtual bool claims(const files::InputFile& /*file*/, const files::FileStart& start,
                                    const ParticleReadOptions& /*options*/) const {
    return probe(start);
  }

  // Returns everything except ParticleInfo::format.
  [[nodiscard]] virtual ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const = 0;
  // Returns everything except ParticleFile::format. Labels the set if the file's name is not enough.
  [[nodiscard]] virtual ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const = 0;
  // Returns the bytes that the selected frame depends on. Returns nothing if the options select no frame, or if the
  // frame depends on the whole file.
  [[nodiscard]] virtual std::vector<files::ByteRange> frame_ranges(const files::InputFile& /*file*/,
                                                                   const ParticleReadOptions& /*options*/) const {
    return {};
  }
  // Returns the step and the time of the selected frame, or of the first; unset for formats without them.
  [[nodiscard]] virtual FrameTime frame_time(const files::InputFile& /*file*/,
                                             const ParticleReadOptions& /*options*/) const {
    return {};
  }
  // Returns the results of info() and read() in one, without the `format` members; see describe_particles() for
  // frame and attributes.
  [[nodiscard]] virtual DescribedParticles describe(const files::InputFile& file,
                                                    const ParticleReadOptions& options) const;

 private:
  ParticleFormatDescription about_;
};

// Implements describe(), given the result of info() and a function that reads a frame as read() does.
[[nodiscard]] DescribedParticles describe_by_reading(
    ParticleInfo info, const ParticleReadOptions& options,
    const std::function<ParticleFile(const ParticleReadOptions&)>& read);

[[nodiscard]] const ParticleFormat& ply_particles();
[[nodiscard]] const ParticleFormat& lammps_particles();
[[nodiscard]] const ParticleFormat& bgeo_particles();
[[nodiscard]] const ParticleFormat& npy_particles();
[[nodiscard]] const ParticleFormat& xyz_particles();
[[nodiscard]] const ParticleFormat& csv_particles();
[[nodiscard]] const ParticleFormat& gro_particles();
[[nodiscard]] const ParticleFormat& pdb_particles();

// Returns all formats; plug-ins last.
[[nodiscard]] const std::vector<const ParticleFormat*>& particle_formats();

// Returns the frame to read, for formats that find frames sequentially: the selected one or the first. Without a
// selection the caller must then check that there is no second frame. Throws InvalidParticleFile for a negative number.
[[nodiscard]] std::uint64_t wanted_frame(const ParticleReadOptions& options);
// Throws the error for a frame that does not exist or a missing selection.
[[noreturn]] void throw_frame_error(const ParticleReadOptions& options, std::uint64_t frames);
// Returns the name of the particles in messages: the name of the file, with the selected frame if there is one.
[[nodiscard]] std::string label_of_frame(const std::string& file, const ParticleReadOptions& options);

}  // namespace isoextract::particle_io
