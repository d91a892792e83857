// What all formats of particles have in common, and the list of them. A new format is a class of its own in `particles`
// and a line in the list (particle_format.cpp).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::particle_io {

// What is to be read, as plain values.
struct ParticleReadOptions {
  std::optional<std::string> format;    // the id of one; default: by content, then by extension
  std::optional<std::int64_t> frame;    // of a file with several, such as time steps; counted from 0
  bool all_attributes = false;          // every one that is made of numbers; otherwise those that are named here,
  std::vector<std::string> attributes;  // by ParticleQuantity::name, or the name of a column of a table,
  std::vector<std::string> attributes_if_there = {};  // likewise, but one that is not there is left out,
  std::vector<std::string> first_of;                  // and the first of these that is there, as one number a particle
  // Which columns are x, y and z: names of columns, or their numbers, counted from 1. For formats with has_columns.
  std::optional<std::array<std::string, 3>> columns;
  std::optional<std::string> grid;  // a set of particles by its name, for formats with has_grids

  friend bool operator==(const ParticleReadOptions&, const ParticleReadOptions&) = default;
};

// What a format says of itself without looking at a file.
struct ParticleFormatDescription {
  std::string id = {};                       // what it is chosen by: "lammps"; lower case, and it never changes
  std::string title = {};                    // one line for people
  std::vector<std::string> extensions = {};  // the ends of files' names, in lower case: ".csv"; ".gz" may follow
  bool has_frames = false;                   // a file may hold several, and ParticleReadOptions::frame chooses one
  bool has_columns = false;                  // ParticleReadOptions::columns may say which columns are x, y and z
  bool has_grids = false;      // a file may hold several sets by name, and ParticleReadOptions::grid chooses one
  bool known_by_name = false;  // nothing in its files tells for sure that they are of this format
  bool from_standard_input = true;
};

// What a file tells of each particle under one name.
struct ParticleQuantity {
  std::string name;  // as the file has it; "NAME[k]" for the k-th further one of the same name
  std::string type;  // "f32", "i32", ...; "number" or "text" in text files
  std::string unit;  // where the file says so, as it is written there
  std::size_t components = 1;
  bool numeric = true;  // it can be read as an attribute
};

// What is in a file, or in one frame of it.
struct ParticleInfo {
  std::string format;                        // the id of one
  std::uint64_t frames = 1;                  // in the file; ParticleReadOptions::frame chooses one
  std::uint64_t particles = 0;               // in the chosen frame, in the first one where none is chosen
  std::string frame_name;                    // what the file calls that frame: "time step 1000"; may be empty
  std::vector<ParticleQuantity> quantities;  // without the position
  std::string length_unit;                   // of the positions, where the file says so
  std::vector<std::string> notes;            // what was taken otherwise than the file has it, or assumed
};

// All of them, in the order in which they are asked and shown, those of plug-ins last.
[[nodiscard]] std::vector<ParticleFormatDescription> particle_format_descriptions();
// Whether a file is named like those of one of them, whatever the case.
[[nodiscard]] bool has_particle_extension(const std::filesystem::path& path);

}  // namespace isoextract::particle_io
