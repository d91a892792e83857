// Lists the formats of volumes, particles and meshes that the program reads and writes, and the compressed files and
// archives that it unpacks, for `isoextract formats` and the help.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/enum_words.hpp"

namespace isoextract::cli {

enum class FormatUse { read_volume, read_particles, unpack, write_mesh, write_field, write_particles };
constexpr auto words_of(FormatUse /*type*/) {
  return std::array{Word{FormatUse::read_volume, "read volume"}, Word{FormatUse::read_particles, "read particles"},
                    Word{FormatUse::unpack, "unpack"},           Word{FormatUse::write_mesh, "write mesh"},
                    Word{FormatUse::write_field, "write field"}, Word{FormatUse::write_particles, "write particles"}};
}

struct ListedFormat {
  FormatUse use = FormatUse::read_volume;
  std::string id;     // "vdb": the value of --input-format or --format; for FormatUse::unpack only a name
  std::string title;  // one line for users
  std::vector<std::string> extensions;
  std::string library = {};  // the library that reads or writes the format; empty for the program's own code
  bool is_plugin = false;
  std::string plugin = {};   // path of the plug-in; empty if it is missing or the format needs none
  std::string package = {};  // the Debian package that building the plug-in needs; may be empty

  [[nodiscard]] bool is_there() const { return !is_plugin || !plugin.empty(); }
};

// Returns the formats in the order of FormatUse. Formats to read are in the order in which the program tries them.
[[nodiscard]] std::vector<ListedFormat> list_formats();

}  // namespace isoextract::cli
