#include "particle_io/particle_writer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "base/version.hpp"
#include "files/output_file.hpp"
#include "files/record_stream.hpp"
#include "particle_io/write/structured_writers.hpp"
#include "volume_io/npy_text.hpp"

namespace isoextract::particle_io {
namespace {

using points::ParticleAttribute;
using points::ParticleSet;

constexpr std::size_t kMostLetters = 40;
constexpr std::size_t kMostAttributes = 100;  // keeps headers short

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.size() <= kMostLetters &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

Result<void> check_names(const std::string& file, const ParticleSet& particles) {
  if (particles.attributes.size() > kMostAttributes) {
    return fail(ErrorCode::output, fmt::format("{}: expected at most {} particle attributes, found {}", file,
                                               kMostAttributes, particles.attributes.size()));
  }
  std::set<std::string, std::less<>> taken{"x", "y", "z", "p", "pos", "points", "position"};
  for (const ParticleAttribute& attribute : particles.attributes) {
    if (!is_plain_name(attribute.name) || !taken.insert(to_lower(attribute.name)).second) {
      return fail(
          ErrorCode::output,
          fmt::format(
              "{}: expected a unique attribute name of at most {} letters, digits and underscores (not x, y, z, p, "
              "pos, points or position), found '{}'",
              file, kMostLetters, printable(attribute.name, 2 * kMostLetters)));
    }
  }
  return {};
}

std::string ply_header(const ParticleSet& particles) {
  const std::string_view order = std::endian::native == std::endian::little ? "little" : "big";
  std::string text = fmt::format(
      "ply\nformat binary_{}_endian 1.0\ncomment {}\nelement vertex {}\nproperty double x\nproperty double y\nproperty "
      "double z\n",
      order, generator(), particles.size());
  for (const ParticleAttribute& attribute : particles.attributes) {
    for (std::size_t c = 0; c < attribute.components; ++c) {
      const std::string part = attribute.components == 1   ? ""
                               : attribute.components == 3 ? fmt::format("_{}", "xyz"[c])
                                                           : fmt::format("_{}", c);
      text += fmt::format("property float {}{}\n", attribute.name, part);
    }
  }
  return text + "end_header\n";
}

std::string npy_particle_header(const ParticleSet& particles) {
  const char order = std::endian::native == std::endian::little ? '<' : '>';
  std::string fields = fmt::format("('position', '{}f8', (3,))", order);
  for (const ParticleAttribute& attribute : particles.attributes) {
    fields += attribute.components == 1
                  ? fmt::format(", ('{}', '{}f4')", attribute.name, order)
                  : fmt::format(", ('{}', '{}f4', ({},))", attribute.name, order, attribute.components);
  }
  return volume_io::npy_header(fmt::format("[{}]", fields), fmt::format("({},)", particles.size()));
}

std::string xyz_header(const ParticleSet& particles) {
  std::string properties = "pos:R:3";
  for (const ParticleAttribute& attribute : particles.attributes) {
    properties += fmt::format(":{}:R:{}", attribute.name, attribute.components);
  }
  return fmt::format("{}\nProperties={}\n", particles.size(), properties);
}

template <class T>
char* put_binary(char* out, const T* values, std::size_t count) {
  std::memcpy(out, values, count * sizeof(T));
  return out + count * sizeof(T);
}

// Length of the longest numbers, "-2.2250738585072014e-308" and "-1.17549435e-38".
template <class T>
constexpr std::size_t kMaxText = sizeof(T) == sizeof(double) ? 24 : 15;

// Adds a space after each number.
template <class T>
char* put_text(char* out, const T* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    out = std::to_chars(out, out + kMaxText<T>, values[i]).ptr;
    *out++ = ' ';
  }
  return out;
}

// Writes particles [first, last) one after another: position, then attributes.
template <class PutDoubles, class PutFloats, class End>
char* put_rows(const ParticleSet& particles, std::size_t first, std::size_t last, char* out,
               const PutDoubles& put_doubles, const PutFloats& put_floats, const End& end) {
  for (std::size_t i = first; i < last; ++i) {
    const std::array<double, 3> position{particles.positions[i].x, particles.positions[i].y, particles.positions[i].z};
    out = put_doubles(out, position.data(), position.size());
    for (const ParticleAttribute& attribute : particles.attributes) {
      out = put_floats(out, attribute.values.data() + i * attribute.components, attribute.components);
    }
    out = end(out);
  }
  return out;
}

std::size_t floats_of(const ParticleSet& particles) {
  std::size_t floats = 0;
  for (const ParticleAttribute& attribute : particles.attributes) floats += attribute.components;
  return floats;
}

Result<void> write_binary_rows(const ParticleSet& particles, files::OutputFile& file) {
  const std::size_t record = 3 * sizeof(double) + floats_of(particles) * sizeof(float);
  return files::write_records(file, particles.size(), record, [&](std::size_t first, std::size_t last, char* out) {
    return put_rows(particles, first, last, out, put_binary<double>, put_binary<float>, [](char* at) { return at; });
  });
}

Result<void> write_text_rows(const ParticleSet& particles, files::OutputFile& file) {
  const std::size_t record = 3 * (kMaxText<double> + 1) + floats_of(particles) * (kMaxText<float> + 1);
  // Replaces the last space of a line by its end.
  const auto end_line = [](char* at) {
    at[-1] = '\n';
    return at;
  };
  return files::write_records(file, particles.size(), record, [&](std::size_t first, std::size_t last, char* out) {
    return put_rows(particles, first, last, out, put_text<double>, put_text<float>, end_line);
  });
}

Result<void> write_content(files::OutputFile& file, const ParticleSet& particles, ParticleFileFormat format) {
  switch (format) {
    case ParticleFileFormat::ply: TRY(file.write(std::string_view(ply_header(particles)))); break;
    case ParticleFileFormat::npy: TRY(file.write(std::string_view(npy_particle_header(particles)))); break;
    case ParticleFileFormat::xyz:
      TRY(file.write(std::string_view(xyz_header(particles))));
      return write_text_rows(particles, file);
    case ParticleFileFormat::bgeo: return write_bgeo(file, particles);
    case ParticleFileFormat::vtu: return write_vtu(file, particles);
  }
  return write_binary_rows(particles, file);
}

}  // namespace

std::optional<ParticleFileFormat> particle_file_format_by_path(const std::filesystem::path& path) {
  const std::string extension = to_lower(path.extension().string());
  for (const auto& entry : words_of(ParticleFileFormat{})) {
    if (extension.size() > 1 && extension.substr(1) == entry.word) return entry.value;
  }
  return std::nullopt;
}

Result<std::uint64_t> write_particles(const std::filesystem::path& path, const ParticleSet& particles,
                                      ParticleFileFormat format) {
  TRY(check_names(printable(path.string()), particles));
  auto file = TRY(files::OutputFile::create(path));
  TRY(write_content(file, particles, format));
  TRY(file.commit());
  return file.bytes_written();
}

}  // namespace isoextract::particle_io
