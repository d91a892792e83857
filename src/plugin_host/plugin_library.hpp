// Plug-ins as shared objects: which there are is known from tables beside them; one is opened when it is asked for, and
// stays open: in this process, or in one whose workers read files with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "sandbox/worker.hpp"

namespace isoextract::plugin_host {

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

// Opens a plug-in's file in this process. Fails with what is wrong with it, "has version 1 of the interface, expected
// 2", and where too little of a limited address space is left for its libraries.
[[nodiscard]] tl::expected<const void*, sandbox::Refusal> open_plugin(const PluginKind& kind, const std::string& id,
                                                                      const std::string& path);

// The shared object of one plug-in.
class PluginLibrary {
 public:
  PluginLibrary(PluginKind kind, std::string id, PluginFolders folders);

  // Whether a file of its name is in one of the folders.
  [[nodiscard]] bool is_there() const { return found({}).has_value(); }

  // What its function gives, whose version and id are as they should be, in this process. `input` starts the message of
  // a failure, which is ErrorCode::unavailable: it is in none of the folders, cannot be opened, or is of another
  // version.
  [[nodiscard]] Result<const void*> opened(const std::string& input) const;

  // A worker that reads `input` with it (plugin_worker.hpp); its greeting is what the plug-in calls its format. Fails
  // in the same ways, and where no process can be started.
  [[nodiscard]] Result<sandbox::Workers::Started> start_worker(const std::string& input, const sandbox::Limits& limits,
                                                               const Context& context) const;

 private:
  [[nodiscard]] Result<std::string> found(const std::string& input) const;

  PluginKind kind_;
  std::string id_;
  PluginFolders folders_;
  mutable std::mutex mutex_;
  mutable const void* plugin_ = nullptr;
  mutable std::unique_ptr<sandbox::Workers> workers_;
};

}  // namespace isoextract::plugin_host
