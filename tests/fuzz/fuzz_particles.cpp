// The libFuzzer target of the readers of particles: the first byte chooses the format, the second what is asked for,
// and the rest is a whole file.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "support/temp_folder.hpp"
#include "volumes/particle_reader.hpp"

namespace isoextract {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

volumes::ParticleReadOptions options_of(const volumes::ParticleFormatDescription& about, std::uint8_t bits) {
  volumes::ParticleReadOptions options;
  options.format = about.id;
  options.all_attributes = (bits & 1) != 0;
  if (about.has_frames && (bits & 2) != 0) options.frame = bits >> 4;
  if (about.has_columns && (bits & 4) != 0) options.columns = {"1", "3", "2"};
  if ((bits & 8) != 0) options.attributes = {"id"};
  return options;
}

void read_one(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return;
  static const test::TempFolder folder;
  static const std::vector<volumes::ParticleFormatDescription> formats = [] {
    auto all = volumes::particle_format_descriptions();
    std::erase_if(all, [](const auto& about) { return !about.from_standard_input; });  // those of plug-ins
    return all;
  }();
  const volumes::ParticleFormatDescription& about = formats[data[0] % formats.size()];
  const volumes::ParticleReadOptions options = options_of(about, data[1]);
  const std::string input = folder / ("particles" + about.extensions.front());
  test::write_bytes(input, std::string(reinterpret_cast<const char*>(data) + 2, size - 2));
  const Context context(MemoryBudget(std::uint64_t{8} << 20));
  {
    const auto info = volumes::particle_info(input, options, context);
    const auto read = volumes::read_particles(input, options, context);
    if (!read) {
      require(read.error().kind == ErrorKind::input && read.error().message.starts_with(input));
      return;
    }
    // What is told of a file counts its frames to the end; reading one of them looks no further.
    require(!info || info->particles == read->particles.size());
    std::uint64_t bytes = read->particles.positions.size_bytes();
    for (const points::ParticleAttribute& attribute : read->particles.attributes) {
      require(attribute.values.size() == attribute.components * read->particles.size());
      bytes += attribute.values.size_bytes();
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
