// One libFuzzer target per format of particles, and two for the two kinds of BGEO, which mutate inputs differently. The
// first byte selects the request, and the rest is a whole file.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "fuzz/fuzz_format.hpp"
#include "fuzz/requirements.hpp"
#include "particle_io/particle_reader.hpp"
#include "support/temp_folder.hpp"

namespace isoextract {
namespace {

using fuzz::require;

particle_io::ParticleReadOptions options_of(const particle_io::ParticleFormatDescription& about, std::uint8_t bits) {
  particle_io::ParticleReadOptions options;
  options.format = about.id;
  options.all_attributes = (bits & 1) != 0;
  if (about.has_frames && (bits & 2) != 0) options.frame = bits >> 4;
  if (about.has_columns && (bits & 4) != 0) options.columns = {"1", "3", "2"};
  if ((bits & 8) != 0) options.attributes = {"id"};
  return options;
}

// The format of the target "particles_ID".
particle_io::ParticleFormatDescription format_of_target() {
  const std::string_view id = fuzz::kFormat.substr(std::string_view("particles_").size());
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    if (about.id == (id == "houdini" ? "bgeo" : id)) return about;
  }
  std::abort();
}

void read_one(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return;
  static const test::TempFolder folder;
  static const particle_io::ParticleFormatDescription about = format_of_target();
  const particle_io::ParticleReadOptions options = options_of(about, data[0]);
  const std::string input = folder / ("particles" + about.extensions.front());
  test::write_bytes(input, std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  const Context context(MemoryBudget(std::uint64_t{8} << 20));
  {
    const auto info = particle_io::list_particles(input, options, context);
    const auto read = particle_io::read_particles(input, options, context);
    if (!read) {
      fuzz::require_refusal(read.error(), input);
      return;
    }
    // Listing a file counts its frames to the end; reading a frame reads no further than that frame.
    require(!info || info->particles == read->particles.size());
    std::uint64_t bytes = read->particles.positions.size_bytes();
    for (const points::ParticleAttribute& attribute : read->particles.attributes) {
      require(attribute.values.size() == attribute.components * read->particles.size());
      bytes += attribute.values.size_bytes();
    }
    for (const points::ParticleWords& words : read->particles.words) {
      require(words.too_many || words.indices.size() == read->particles.size());
      bytes += read->particles.size() * sizeof(std::uint32_t);
    }
    require(read->particles.memory.bytes() == bytes && context.memory().reserved() == bytes);
  }
  require(context.memory().reserved() == 0);
}

}  // namespace
}  // namespace isoextract

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isoextract::read_one(data, size);
  return 0;
}
