// Options and descriptions of particle formats, and the list of formats. A new format needs a class in `formats`,
// derived from ParticleFormat, the function that returns it (detail/particle_source.hpp), and a line in the list in
// particle_format.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/note.hpp"

namespace isoextract::particle_io {

// An attribute that a condition on the particles needs (points/selection_expression.hpp).
struct AttributeOfCondition {
  std::vector<std::string> names;  // alternative names; the reader takes the first that the file has
  bool required = true;            // false: ignored if missing
  // Lines for the hint if it is missing: the condition's text, with a caret below the name (SelectionName::mark).
  std::string mark;

  friend bool operator==(const AttributeOfCondition&, const AttributeOfCondition&) = default;
};

// Selects the contents to read.
struct ParticleReadOptions {
  std::optional<std::string> format;                  // id of a format; default: by content, then by extension
  std::optional<std::int64_t> frame;                  // for files with several frames, such as time steps; from 0
  bool all_attributes = false;                        // read every attribute; otherwise only those named below
  std::vector<std::string> attributes;                // names of quantities (ParticleQuantity::name) or columns
  std::vector<std::string> optional_attributes = {};  // more names, ignored if missing
  std::vector<std::string> first_scalar_of;           // names; reads the first that is a numeric scalar attribute
  std::vector<AttributeOfCondition> condition = {};   // read as numbers or, if they are text, as words
  // The columns of x, y and z, by name or by number from 1. For formats with has_columns.
  std::optional<std::array<std::string, 3>> columns;
  std::optional<std::string> grid;  // name of a particle set, for formats with has_grids

  friend bool operator==(const ParticleReadOptions&, const ParticleReadOptions&) = default;
};

// Properties of a format.
struct ParticleFormatDescription {
  std::string id = {};                       // name by which it is selected: "lammps"; lower case, never changes
  std::string title = {};                    // one line for users
  std::vector<std::string> extensions = {};  // file name endings in lower case: ".csv"; ".gz" and the like may follow
  bool has_frames = false;                   // files may have several frames, selected by ParticleReadOptions::frame
  bool has_columns = false;                  // ParticleReadOptions::columns may select the columns of x, y and z
  bool has_grids = false;                    // files may have several named sets, selected by ParticleReadOptions::grid
  bool needs_extension = false;              // only the extension of the file name identifies the format
  bool is_plugin = false;                    // a plug-in reads it
  // These members are as in volume_io::FormatDescription:
  std::string library = {};  // the reader's library: "HDF5"; empty for the program's own code
  std::string package = {};  // the Debian package that building the plug-in needs
  std::string plugin = {};   // path of the plug-in; empty if it is missing
};

// Named data that a file has for each particle.
struct ParticleQuantity {
  std::string name;  // as in the file; "NAME[1]", "NAME[2]", ... for later quantities of the same name
  std::string type;  // "f32", "i32", ...; "number" or "text" in text files
  std::string unit;  // as in the file; may be empty
  std::size_t components = 1;
  bool numeric = true;  // can be read as an attribute
};

// The moment of a frame, as the file states it.
struct FrameTime {
  std::optional<std::int64_t> step;  // number of the simulation's time step
  std::optional<double> time;        // finite, in the file's own unit

  friend bool operator==(const FrameTime&, const FrameTime&) = default;
};

// Contents of a file or of one frame.
struct ParticleInfo {
  std::string format;                        // the format's id
  std::uint64_t frames = 1;                  // number of whole frames; ParticleReadOptions::frame selects one
  std::vector<FrameTime> times;              // of each frame; empty for formats without steps and times
  std::uint64_t particles = 0;               // in the selected frame; default: the first one
  std::string frame_name;                    // the file's name of that frame: "time step 1000"; may be empty
  std::vector<ParticleQuantity> quantities;  // without the position
  std::string length_unit;                   // of the positions; may be empty
  Notes notes;                               // assumptions and changes made while reading
};

// Returns all formats in the order of detection and display, plug-ins last. Leaves out a plug-in if another format has
// its id.
[[nodiscard]] std::vector<ParticleFormatDescription> particle_format_descriptions();
// Returns whether the file name has the extension of a particle format, ignoring case.
[[nodiscard]] bool has_particle_extension(const std::filesystem::path& path);

}  // namespace isoextract::particle_io
