// What the readers of particles share: how they fail, and what a format is to particle_reader.cpp. Within this room,
// failures of theirs are exceptions: rows are read deep inside loops, and every value may be wrong.
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
#include "files/file_start.hpp"
#include "particle_io/particle_format.hpp"
#include "particle_io/particle_reader.hpp"

namespace isoextract::particle_io {

// A file that does not hold what it should: what was expected and what was found. Whoever calls a format puts the
// file's name in front and makes an Error of ErrorCode::input of it.
struct DamagedParticles : std::runtime_error {
  explicit DamagedParticles(const std::string& message, Hint the_hint = {})
      : std::runtime_error(message), hint(std::move(the_hint)) {}
  Hint hint;
};

// The file ends within a frame, as a dump does whose simulation was ended.
struct CutShort : DamagedParticles {
  using DamagedParticles::DamagedParticles;
};

// Any other error, whole as it is.
struct Refused {
  Error error;
};

// The value of a result, or what is thrown instead.
template <class T>
T must(Result<T> result) {
  if (!result) throw Refused{std::move(result.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// Formats live as long as the program, keep nothing of a file between calls but places (frame_index.hpp), and may be
// used by several threads at once. Options were checked against the description. What is read counts in the context of
// the file. They throw DamagedParticles, Refused and std::bad_alloc.
class ParticleFormat {
 public:
  explicit ParticleFormat(ParticleFormatDescription about) : about_(std::move(about)) {}
  virtual ~ParticleFormat() = default;
  ParticleFormat(const ParticleFormat&) = delete;
  ParticleFormat& operator=(const ParticleFormat&) = delete;

  [[nodiscard]] const ParticleFormatDescription& about() const { return about_; }

  // Whether a file that starts so is one of particles in this format, beyond doubt.
  [[nodiscard]] virtual bool probe(const files::FileStart& /*start*/) const { return false; }

  // Likewise, for formats of which the start of a file does not tell enough.
  [[nodiscard]] virtual bool claims(const files::InputFile& /*file*/, const files::FileStart& start,
                                    const ParticleReadOptions& /*options*/) const {
    return probe(start);
  }

  // All but ParticleInfo::format.
  [[nodiscard]] virtual ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const = 0;
  // All but ParticleFile::format. Its set is labelled where the file's name is not enough.
  [[nodiscard]] virtual ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const = 0;
  // Both, without those two; the frame and the attributes as describe_particles() has them.
  [[nodiscard]] virtual DescribedParticles describe(const files::InputFile& file,
                                                    const ParticleReadOptions& options) const;

 private:
  ParticleFormatDescription about_;
};

// What describe() gives, where `read` gives a frame as read() does.
[[nodiscard]] DescribedParticles describe_with(ParticleInfo info, const ParticleReadOptions& options,
                                               const std::function<ParticleFile(const ParticleReadOptions&)>& read);

[[nodiscard]] const ParticleFormat& ply_particles();
[[nodiscard]] const ParticleFormat& lammps_particles();
[[nodiscard]] const ParticleFormat& bgeo_particles();
[[nodiscard]] const ParticleFormat& npy_particles();
[[nodiscard]] const ParticleFormat& xyz_particles();
[[nodiscard]] const ParticleFormat& csv_particles();

// All formats, those of plug-ins last.
[[nodiscard]] const std::vector<const ParticleFormat*>& particle_formats();

// For formats with frames that are found one after the other: whether a frame is the one that is asked for. Without a
// choice it is the first, and whoever reads then looks whether it is the only one.
[[nodiscard]] std::uint64_t wanted_frame(const ParticleReadOptions& options);
// Throws what is to be said of a frame that is not there, or of a missing choice.
[[noreturn]] void refuse_frame(const ParticleReadOptions& options, std::uint64_t frames);

}  // namespace isoextract::particle_io
