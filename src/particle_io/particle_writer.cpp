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
using points::ParticleWords;

constexpr std::size_t kMostLetters = 40;
constexpr std::size_t kMostAttributes = 100;  // keeps headers short

bool is_plain_letter(char c) { return is_letter(c) || is_digit(c) || c == '_'; }

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.size() <= kMostLetters && std::ranges::all_of(name, is_plain_letter);
}

// The taken names, in lower case: at first the names that readers take for positions.
class TakenNames {
 public:
  // Returns whether the name is new.
  bool take(const std::string& name) { return names_.insert(to_lower(name)).second; }

 private:
  std::set<std::string, std::less<>> names_{"x", "y", "z", "p", "pos", "points", "position"};
};

Result<void> check_names(const std::string& file, const ParticleSet& particles) {
  if (particles.attributes.size() > kMostAttributes) {
    return fail(ErrorCode::output, fmt::format("{}: expected at most {} particle attributes, found {}", file,
                                               kMostAttributes, particles.attributes.size()));
  }
  std::vector<std::string> names;
  for (const ParticleAttribute& attribute : particles.attributes) names.push_back(attribute.name);
  for (const ParticleWords& words : particles.words) {
    names.push_back(words.name);
    if (!words.too_many) continue;
    return fail(ErrorCode::output, fmt::format("{}: expected fewer different words in '{}'", file,
                                               printable(words.name, 2 * kMostLetters)));
  }
  TakenNames taken;
  for (const std::string& name : names) {
    if (!is_plain_name(name) || !taken.take(name)) {
      return fail(
          ErrorCode::output,
          fmt::format(
              "{}: expected a unique attribute name of at most {} letters, digits and underscores (not x, y, z, p, "
              "pos, points or position), found '{}'",
              file, kMostLetters, printable(name, 2 * kMostLetters)));
    }
  }
  return {};
}

// Returns a valid name like `name` that is not taken, and takes it.
std::string take_valid_name(const std::string& name, TakenNames& taken) {
  constexpr std::size_t kLettersOfNumber = 4;  // "_100"
  std::string stem = name.empty() ? "attribute" : name.substr(0, kMostLetters - kLettersOfNumber);
  std::ranges::replace_if(
      stem, [](char c) { return !is_plain_letter(c); }, '_');
  if (is_plain_name(name) && taken.take(name)) return name;
  std::string valid = stem;
  for (int n = 2; !taken.take(valid); ++n) valid = fmt::format("{}_{}", stem, n);
  return valid;
}

// Returns why a file of the format cannot hold the words; empty if it can.
std::string why_not_stored(const ParticleWords& words, ParticleFileFormat format) {
  if (!stores_words(format)) return fmt::format("{} files hold numbers only", word_of(format));
  if (words.too_many) return "there are too many different ones";
  const auto is_split = [](const std::string& word) {
    return word.empty() || word.find_first_of(" \t\r\n") != std::string::npos;
  };
  if (format != ParticleFileFormat::xyz || std::ranges::none_of(words.words, is_split)) return {};
  return "one of them is empty or has spaces, which separate the columns of the file";
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
  std::string properties;
  for (const ParticleWords& words : particles.words) properties += fmt::format("{}:S:1:", words.name);
  properties += "pos:R:3";
  for (const ParticleAttribute& attribute : particles.attributes) {
    properties += fmt::format(":{}:R:{}", attribute.name, attribute.components);
  }
  std::string box;
  if (particles.box) {
    const glm::dvec3& origin = particles.box->origin;
    const glm::dmat3& edges = particles.box->edges;
    const auto flag = [&](std::size_t k) { return particles.box->periodic[k] ? 'T' : 'F'; };
    box = fmt::format(R"(Lattice="{} {} {} {} {} {} {} {} {}" Origin="{} {} {}" pbc="{} {} {}" )", edges[0].x,
                      edges[0].y, edges[0].z, edges[1].x, edges[1].y, edges[1].z, edges[2].x, edges[2].y, edges[2].z,
                      origin.x, origin.y, origin.z, flag(0), flag(1), flag(2));
  }
  return fmt::format("{}\n{}Properties={}\n", particles.size(), box, properties);
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

// Writes the numbers of a particle: position, then attributes.
template <class PutDoubles, class PutFloats>
char* put_row(const ParticleSet& particles, std::size_t particle, char* out, const PutDoubles& put_doubles,
              const PutFloats& put_floats) {
  const glm::dvec3& p = particles.positions[particle];
  const std::array<double, 3> position{p.x, p.y, p.z};
  out = put_doubles(out, position.data(), position.size());
  for (const ParticleAttribute& attribute : particles.attributes) {
    out = put_floats(out, attribute.values.data() + particle * attribute.components, attribute.components);
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
    for (std::size_t i = first; i < last; ++i) {
      out = put_row(particles, i, out, put_binary<double>, put_binary<float>);
    }
    return out;
  });
}

Result<void> write_text_rows(const ParticleSet& particles, files::OutputFile& file) {
  std::size_t record = 3 * (kMaxText<double> + 1) + floats_of(particles) * (kMaxText<float> + 1);
  for (const ParticleWords& words : particles.words) {
    std::size_t longest = 0;
    for (const std::string& word : words.words) longest = std::max(longest, word.size());
    record += longest + 1;
  }
  const auto put_words = [&](std::size_t particle, char* out) {
    for (const ParticleWords& words : particles.words) {
      out = std::ranges::copy(words.words[words.indices[particle]], out).out;
      *out++ = ' ';
    }
    return out;
  };
  return files::write_records(file, particles.size(), record, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t i = first; i < last; ++i) {
      out = put_row(particles, i, put_words(i, out), put_text<double>, put_text<float>);
      out[-1] = '\n';  // replaces the last space
    }
    return out;
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

Notes fit_to_file(ParticleSet& particles, ParticleFileFormat format) {
  Notes notes;
  std::erase_if(particles.words, [&](const ParticleWords& words) {
    const std::string why = why_not_stored(words, format);
    if (!why.empty()) {
      notes.push_back({NoteId::data_left_out,
                       fmt::format("the file does not have the words of '{}': {}", printable(words.name, 80), why)});
    }
    return !why.empty();
  });
  TakenNames taken;
  const auto rename = [&](std::string& name) {
    const std::string valid = take_valid_name(name, taken);
    if (valid == name) return;
    notes.push_back({NoteId::attribute_renamed,
                     fmt::format("the writer renames the attribute '{}' to '{}': names have letters, digits and "
                                 "underscores, and are not those of positions",
                                 printable(name, 80), valid)});
    name = valid;
  };
  for (ParticleAttribute& attribute : particles.attributes) rename(attribute.name);
  for (ParticleWords& words : particles.words) rename(words.name);
  return notes;
}

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
