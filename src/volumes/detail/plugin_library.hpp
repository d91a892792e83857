// Plug-ins as shared objects: which there are is known from tables beside them; one is opened when it is asked for, and
// stays open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace isoextract::volumes {

using PluginFolders = std::vector<std::filesystem::path>;

// Where plug-ins are looked for, in this order: ISOEXTRACT_PLUGINS, `plugins` beside the program, and
// `../lib/isoextract/plugins` from there. They need not exist.
[[nodiscard]] PluginFolders plugin_folders();

struct PluginTable {
  std::string id;
  std::string title;
  std::vector<std::string> extensions;
};

// What the tables NAME_START-ID.txt in the folders say, by folder and then by name; the first of an id counts.
[[nodiscard]] std::vector<PluginTable> find_plugin_tables(const PluginFolders& folders, const std::string& name_start);

// What plug-ins of one kind are called, and what they export.
struct PluginKind {
  std::string name_start;  // "isoextract-volume-"
  std::string function;    // gives a struct that starts with a version (uint32_t) and an id (const char*)
  std::uint32_t version = 0;
  bool is_format = true;  // it reads one; else it is for work that messages name
};

// The shared object of one plug-in.
class PluginLibrary {
 public:
  PluginLibrary(PluginKind kind, std::string id, PluginFolders folders);

  // What its function gives, whose version and id are as they should be. `input` starts the message of a failure, which
  // is ErrorKind::unavailable: it is in none of the folders, cannot be opened, or is of another version.
  [[nodiscard]] Result<const void*> opened(const std::string& input) const;

 private:
  PluginKind kind_;
  std::string id_;
  PluginFolders folders_;
  mutable std::mutex mutex_;
  mutable const void* plugin_ = nullptr;
};

}  // namespace isoextract::volumes
