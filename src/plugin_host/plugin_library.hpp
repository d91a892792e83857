// Plug-ins are shared objects (.so). A text file beside each, its table, gives its title and file name extensions. A
// plug-in is opened on demand and stays open, in this process or in a server process whose workers read files with it.
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

// Returns the folders to search, in this order: those of the environment variable ISOEXTRACT_PLUGINS (separated by
// ":"), then `plugins` and `../lib/isoextract/plugins`, relative to the program's folder. They need not exist.
[[nodiscard]] PluginFolders plugin_folders();

// Bytes that the files of a format have at an offset.
struct PluginMagic {
  std::uint64_t offset = 0;
  std::vector<std::byte> bytes;
};

// Contents of a table (plugins/volume_plugin.h). Unknown lines are ignored, as later versions may define them.
struct PluginTable {
  std::string id;
  std::string title;
  std::vector<std::string> extensions;  // ".vti"
  std::vector<PluginMagic> magic;
  std::vector<std::string> contains;
  std::vector<std::string> folders;
  std::vector<std::string> uses;
  std::string library;
  std::string package;
};

// Returns the tables, which are the files name_start + ID + ".txt" in the folders, by folder and then by ID. Returns
// only the first of several tables with one ID. An ID consists of a-z, 0-9, - and _; other files are ignored.
[[nodiscard]] std::vector<PluginTable> find_plugin_tables(const PluginFolders& folders, const std::string& name_start);

// Calls the exported function of a plug-in, which returns a Plugin.
template <class Plugin>
const void* call_plugin_function(void* function) {
  return reinterpret_cast<const Plugin* (*)()>(function)();
}

// File name prefix and exported function of one kind of plug-in.
struct PluginKind {
  std::string name_start;  // "isoextract-volume-"
  std::string function;    // exported; returns a struct that starts with a version (uint32_t) and an id (const char*)
  const void* (*call)(void* function) = nullptr;  // call_plugin_function<Plugin>
  std::uint32_t version = 0;
  bool is_format = true;  // whether messages say "the format ID needs the plug-in", else "the grid tools of ID need"
};

// Opens a plug-in's file in this process, never closes it, and returns the result of its exported function. The text of
// an error completes "the plug-in FILE ...", such as "has version 1 of the interface, expected 2". Also fails if the
// limit of the address space (ulimit -v) leaves too little for the plug-in's libraries.
[[nodiscard]] tl::expected<const void*, sandbox::Refusal> open_plugin(const PluginKind& kind, const std::string& id,
                                                                      const std::string& path);

// The shared object of one plug-in.
class PluginLibrary {
 public:
  // `package` is the Debian package that building the plug-in needs, for messages; may be empty.
  PluginLibrary(PluginKind kind, std::string id, PluginFolders folders, std::string package = {});

  // Returns whether one of the folders has the plug-in's file.
  [[nodiscard]] bool is_there() const { return found({}).has_value(); }
  // Returns the path of the plug-in's file; empty if no folder has it.
  [[nodiscard]] std::string path() const { return found({}).value_or(std::string()); }

  // Returns the result of the exported function after checking its version and id, in this process. Fails with
  // ErrorCode::unavailable if no folder has the plug-in, if it cannot be opened, or if its version or id differs.
  // `input` starts the message. Safe to call from several threads.
  [[nodiscard]] Result<const void*> opened(const std::string& input) const;

  // Starts a worker that reads `input` with the plug-in (detail/plugin_worker.hpp). Started::greeting is the name of
  // the format for a volume plug-in, and "" for a particle plug-in. Fails as opened() and Context::check() do, and if
  // no process starts and loads the plug-in within limits.seconds. Safe to call from several threads.
  [[nodiscard]] Result<sandbox::WorkerPool::Started> start_worker(const std::string& input,
                                                                  const sandbox::Limits& limits,
                                                                  const Context& context) const;

 private:
  [[nodiscard]] Result<std::string> found(const std::string& input) const;

  PluginKind kind_;
  std::string id_;
  PluginFolders folders_;
  std::string package_;
  mutable std::mutex mutex_;
  mutable const void* plugin_ = nullptr;
  mutable std::unique_ptr<sandbox::WorkerPool> workers_;
};

}  // namespace isoextract::plugin_host
