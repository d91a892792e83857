#include "plugin_host/plugin_library.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <sys/mman.h>

#include "base/allocation_error.hpp"
#include "base/byte_size.hpp"
#include "base/printable.hpp"

namespace isoextract::plugin_host {
namespace {

namespace fs = std::filesystem;

// The first members of every plug-in struct.
struct PluginHead {
  std::uint32_t version;
  const char* id;
};

std::vector<std::string> words_of_line(const std::string& line) {
  std::istringstream words(line);
  std::vector<std::string> found;
  for (std::string word; words >> word;) found.push_back(std::move(word));
  return found;
}

// Parses "128 4449434d"; returns nothing for other texts.
std::optional<PluginMagic> read_magic(const std::string& text) {
  std::istringstream words(text);
  PluginMagic magic;
  std::string hex;
  if (!(words >> magic.offset >> hex) || hex.empty() || hex.size() % 2 != 0) return std::nullopt;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    unsigned value = 0;
    const auto [end, status] = std::from_chars(hex.data() + i, hex.data() + i + 2, value, 16);
    if (status != std::errc{} || end != hex.data() + i + 2) return std::nullopt;
    magic.bytes.push_back(static_cast<std::byte>(value));
  }
  return magic;
}

// Parses lines "key: value"; ignores unknown keys, which later versions may define.
PluginTable read_table(const std::string& id, const fs::path& path) {
  PluginTable table;
  table.id = id;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, colon);
    const std::string value = line.substr(colon + 2);
    if (key == "title") table.title = printable(value, 200);
    if (key == "library") table.library = printable(value, 200);
    if (key == "package") table.package = printable(value, 200);
    if (key == "contains") table.contains.push_back(value);
    if (key == "folders") table.folders = words_of_line(value);
    if (key == "uses") table.uses = words_of_line(value);
    if (key == "magic") {
      if (auto magic = read_magic(value)) table.magic.push_back(std::move(*magic));
    }
    if (key != "extensions") continue;
    for (std::string& word : words_of_line(value)) {
      if (word.starts_with('.')) table.extensions.push_back(std::move(word));
    }
  }
  return table;
}

// "isoextract-volume-abc.txt" -> "abc"
std::optional<std::string> id_of_table(const fs::path& path, const std::string& name_start) {
  const std::string stem = path.stem().string();
  if (path.extension() != ".txt" || !stem.starts_with(name_start)) return std::nullopt;
  std::string id = stem.substr(name_start.size());
  const bool plain = id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_") == std::string::npos;
  return plain && !id.empty() ? std::optional(std::move(id)) : std::nullopt;
}

}  // namespace

PluginFolders plugin_folders() {
  PluginFolders folders;
  if (const char* given = std::getenv("ISOEXTRACT_PLUGINS")) {
    std::istringstream list{std::string(given)};
    for (std::string folder; std::getline(list, folder, ':');) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    folders.push_back(program.parent_path() / "plugins");
    folders.push_back(program.parent_path().parent_path() / "lib" / "isoextract" / "plugins");
  }
  return folders;
}

std::vector<PluginTable> find_plugin_tables(const PluginFolders& folders, const std::string& name_start) {
  std::vector<PluginTable> found;
  for (const fs::path& folder : folders) {
    std::error_code error;
    std::map<std::string, fs::path> tables;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      if (auto id = id_of_table(at->path(), name_start)) tables.emplace(std::move(*id), at->path());
    }
    for (const auto& [id, path] : tables) {
      if (std::ranges::count(found, id, &PluginTable::id) == 0) found.push_back(read_table(id, path));
    }
  }
  return found;
}

PluginLibrary::PluginLibrary(PluginKind kind, std::string id, PluginFolders folders, std::string package)
    : kind_(std::move(kind)), id_(std::move(id)), folders_(std::move(folders)), package_(std::move(package)) {}

Result<std::string> PluginLibrary::found(const std::string& input) const {
  const std::string name = fmt::format("{}{}.so", kind_.name_start, id_);
  std::vector<std::string> looked;
  for (const fs::path& folder : folders_) {
    std::error_code none;
    if (fs::exists(folder / name, none)) return (folder / name).string();
    looked.push_back(folder.string());
  }
  return fail(
      ErrorCode::unavailable,
      fmt::format(
          "{}: {} the plug-in {}, which is in none of the folders {}", input,
          kind_.is_format ? fmt::format("the format {} needs", id_) : fmt::format("the grid tools of {} need", id_),
          name, fmt::join(looked, ", ")),
      package_.empty()
          ? "install the plug-in, or set the environment variable ISOEXTRACT_PLUGINS to its folder"
          : fmt::format("install the package {} and build isoextract again, which then builds the plug-in; or set "
                        "the environment variable ISOEXTRACT_PLUGINS to the plug-in's folder",
                        package_));
}

namespace {

tl::unexpected<Error> refuse(const std::string& input, const std::string& path, const sandbox::Refusal& refusal) {
  return fail(ErrorCode::unavailable, fmt::format("{}: the plug-in {} {}", input, path, printable(refusal.what, 400)),
              refusal.advice.empty() ? "install the plug-in that belongs to this version of isoextract"
                                     : printable(refusal.advice, 200));
}

// Address space needed to load OpenVDB's libraries, the largest of any plug-in here: 60 MiB of mappings and four
// threads of log4cplus. log4cplus hangs or ends the process if it cannot start its threads.
std::size_t address_space_to_load() {
  constexpr std::size_t kLibraries = std::size_t{72} << 20;
  constexpr std::size_t kThreads = 4;
  std::size_t stack = 0;
  pthread_attr_t attributes;
  if (::pthread_getattr_default_np(&attributes) == 0) {
    ::pthread_attr_getstacksize(&attributes, &stack);
    ::pthread_attr_destroy(&attributes);
  }
  return kLibraries + kThreads * stack;
}

// Fails if the limited address space is too small, as libraries behave unpredictably then. A library that is loaded
// already needs no room.
tl::expected<void, sandbox::Refusal> check_address_space(const std::string& path) {
  const auto limit = address_space_limit();
  if (!limit || ::dlopen(path.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr) return {};
  const std::size_t needed = address_space_to_load();
  void* const room = ::mmap(nullptr, needed, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room != MAP_FAILED) {
    ::munmap(room, needed);
    return {};
  }
  return tl::unexpected(
      sandbox::Refusal{fmt::format("needs up to {} of address space to load, and the process's limit of {} leaves less",
                                   format_byte_size(needed), format_byte_size(*limit)),
                       kRaiseAddressSpaceHint});
}

}  // namespace

Result<const void*> PluginLibrary::opened(const std::string& input) const {
  const std::scoped_lock lock(mutex_);
  if (plugin_ != nullptr) return plugin_;
  const auto path = TRY(found(input));
  const auto plugin = open_plugin(kind_, id_, path);
  if (!plugin) return refuse(input, path, plugin.error());
  plugin_ = *plugin;
  return plugin_;
}

Result<sandbox::WorkerPool::Started> PluginLibrary::start_worker(const std::string& input,
                                                                 const sandbox::Limits& limits,
                                                                 const Context& context) const {
  const auto path = TRY(found(input));
  {
    const std::scoped_lock lock(mutex_);
    if (workers_ == nullptr) {
      workers_ = std::make_unique<sandbox::WorkerPool>(std::vector<std::string>{kind_.function, id_, path});
    }
  }
  auto started = workers_->start(limits, context);
  if (!started) TRY(context.check());
  if (!started) return refuse(input, path, started.error());
  return std::move(*started);
}

tl::expected<const void*, sandbox::Refusal> open_plugin(const PluginKind& kind, const std::string& id,
                                                        const std::string& path) {
  const auto wrong = [](std::string why) { return tl::unexpected(sandbox::Refusal{std::move(why), {}}); };
  TRY(check_address_space(path));
  // Never closes the library: its results may outlive the PluginLibrary, and many libraries do not support unloading.
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return wrong(fmt::format("fails to load: {}", ::dlerror()));
  void* function = ::dlsym(library, kind.function.c_str());
  const void* plugin = function == nullptr ? nullptr : kind.call(function);
  if (plugin == nullptr) {
    return wrong(fmt::format("is invalid: it has no function {}, or the function returns null", kind.function));
  }
  const auto* head = static_cast<const PluginHead*>(plugin);
  if (head->version != kind.version) {
    return wrong(fmt::format("has version {} of the interface, expected {}", head->version, kind.version));
  }
  const std::string own_id = head->id == nullptr ? "" : head->id;
  if (own_id != id) return wrong(fmt::format("has the id '{}', expected '{}'", printable(own_id, 80), id));
  return plugin;
}

}  // namespace isoextract::plugin_host
