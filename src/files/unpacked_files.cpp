#include "files/unpacked_files.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/ascii.hpp"
#include "files/detail/opened_files.hpp"
#include "files/detail/standard_input.hpp"
#include "files/detail/unpacked_paths.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolderStart = "isoextract-unpacked-";

struct KnownFolders {
  std::mutex mutex;
  std::map<std::string, PackedPlace> sources;  // by temporary folders
};

KnownFolders& known_folders() {
  static KnownFolders folders;
  return folders;
}

// Removes folders of processes of this user that ended without removing them.
void remove_left_folders(const fs::path& where) {
  std::error_code error;
  for (fs::directory_iterator at(where, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename();
    if (!name.starts_with(kFolderStart)) continue;
    int process = 0;
    std::from_chars(name.data() + kFolderStart.size(), name.data() + name.size(), process);
    struct stat status {};
    if (::lstat(at->path().c_str(), &status) != 0 || status.st_uid != ::geteuid()) continue;
    const bool has_ended = process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
    std::error_code none;
    if (has_ended) fs::remove_all(at->path(), none);
  }
}

Result<fs::path> make_folder(const std::string& source) {
  static std::once_flag once;
  std::error_code error;
  const fs::path where = fs::temp_directory_path(error);
  if (!error) {
    std::call_once(once, [&] { remove_left_folders(where); });
    std::string name = where / fmt::format("{}{}-XXXXXX", kFolderStart, ::getpid());
    if (::mkdtemp(name.data()) != nullptr) return fs::path(name);
    error = std::error_code(errno, std::generic_category());
  }
  return fail(ErrorCode::unavailable,
              fmt::format("{}: unpacking it needs a temporary folder: {}", source, error.message()),
              "set the environment variable TMPDIR to a writable folder");
}

bool is_hidden(const fs::path& name) {
  return std::ranges::any_of(name, [](const fs::path& part) {
    const std::string text = part.string();
    return text.starts_with(".") || text == "__MACOSX";
  });
}

// Returns the folder that all names have in common.
fs::path common_folder(std::span<const fs::path> names) {
  fs::path common = names.front().parent_path();
  for (const fs::path& name : names) {
    fs::path shared;
    const fs::path folder = name.parent_path();
    for (auto a = common.begin(), b = folder.begin(); a != common.end() && b != folder.end() && *a == *b; ++a, ++b) {
      shared /= *a;
    }
    common = shared;
  }
  return common;
}

// Raises the number of files that this process may have open, if the system lets it.
void allow_descriptors(std::uint64_t more) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  constexpr std::uint64_t kOthers = 512;
  if (limit.rlim_cur >= more + kOthers || limit.rlim_cur == limit.rlim_max) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, limit.rlim_cur + more + kOthers);
  static_cast<void>(::setrlimit(RLIMIT_NOFILE, &limit));
}

}  // namespace

Result<void> UnpackedFiles::add(const fs::path& name, std::span<const std::byte> content) {
  const auto failed = [&](std::string_view what) {
    return fail(ErrorCode::unavailable,
                fmt::format("{}: {} failed: {}", source_, what, std::generic_category().message(errno)));
  };
  const int descriptor = ::memfd_create("isoextract-unpacked", MFD_CLOEXEC);
  if (descriptor < 0) return failed("memory for an unpacked file");
  descriptors_.push_back(descriptor);
  while (!content.empty()) {
    const ssize_t put = ::write(descriptor, content.data(), content.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return failed("storing an unpacked file in memory");
    content = content.subspan(static_cast<std::size_t>(put));
  }
  const fs::path link = folder_ / name;
  std::error_code error;
  fs::create_directories(link.parent_path(), error);
  fs::create_symlink(fmt::format("/proc/{}/fd/{}", ::getpid(), descriptor), link, error);
  if (!error) return {};
  errno = error.value();
  return failed("naming an unpacked file in the temporary folder");
}

Result<std::shared_ptr<const UnpackedFiles>> UnpackedFiles::make(const fs::path& source,
                                                                 std::span<const UnpackedMember> members,
                                                                 std::span<const std::byte> content, bool as_file,
                                                                 const Context& context) {
  struct Part {
    fs::path name;
    std::span<const std::byte> content;
  };
  const std::string label = input_label(source);
  std::vector<Part> parts;
  std::set<fs::path> seen;
  for (const UnpackedMember& member : members) {
    const auto bytes = content.first(static_cast<std::size_t>(member.bytes));
    content = content.subspan(bytes.size());
    const fs::path name = fs::path(member.name).lexically_normal();
    if (name.empty() || name.is_absolute() || *name.begin() == "..") {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected relative file names inside the archive's folder, found '{}'", label,
                              printable(member.name, 200)));
    }
    if (bytes.empty() || (!as_file && is_hidden(name))) continue;
    if (!seen.insert(name).second) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected each file once, found '{}' twice", label, printable(member.name, 200)));
    }
    parts.push_back({name, bytes});
  }
  if (parts.empty()) return fail(ErrorCode::input, label + ": the archive contains only empty or hidden files");
  allow_descriptors(parts.size());

  const std::shared_ptr<UnpackedFiles> files(new UnpackedFiles());
  files->source_ = source.string();
  std::uint64_t total = 0;
  for (const Part& part : parts) total += part.content.size();
  files->memory_ = TRY(context.reserve(total, label + ": its unpacked content"));
  files->folder_ = TRY(make_folder(label));
  {
    KnownFolders& known = known_folders();
    const std::scoped_lock lock(known.mutex);
    known.sources.emplace(files->folder_.string(), PackedPlace{files->source_, files->folder_.string(), {}, as_file});
  }
  std::vector<fs::path> names;
  for (const Part& part : parts) names.push_back(part.name);
  const fs::path common = common_folder(names);
  for (const Part& part : parts) {
    TRY(context.check());
    TRY(files->add(common.empty() ? part.name : part.name.lexically_relative(common), part.content));
  }
  files->path_ = as_file ? files->folder_ / parts.front().name.filename() : files->folder_;
  return std::shared_ptr<const UnpackedFiles>(files);
}

UnpackedFiles::~UnpackedFiles() {
  for (const int descriptor : descriptors_) ::close(descriptor);
  if (folder_.empty()) return;
  std::error_code none;
  fs::remove_all(folder_, none);
  KnownFolders& known = known_folders();
  const std::scoped_lock lock(known.mutex);
  known.sources.erase(folder_.string());
}

std::shared_ptr<const UnpackedFiles> find_unpacked(const InputFile& file) {
  return opened_files_of(file.context())->find_unpacked(file.version());
}

void keep_unpacked(const InputFile& file, std::shared_ptr<const UnpackedFiles> unpacked) {
  opened_files_of(file.context())->keep_unpacked(file.version(), std::move(unpacked));
}

std::optional<PackedPlace> packed_place(const fs::path& path) {
  KnownFolders& known = known_folders();
  const std::string text = path.string();
  const std::scoped_lock lock(known.mutex);
  const auto after = known.sources.upper_bound(text);
  if (after == known.sources.begin()) return std::nullopt;
  const auto& [folder, place] = *std::prev(after);
  if (!text.starts_with(folder) || (text.size() > folder.size() && text[folder.size()] != '/')) return std::nullopt;
  PackedPlace found = place;
  if (text.size() > folder.size()) found.member = text.substr(folder.size() + 1);
  return found;
}

fs::path packed_source(const fs::path& path) {
  const auto place = packed_place(path);
  return place ? fs::path(place->source) : path;
}

std::string name_without_packing(std::string name) {
  const std::string lower = to_lower(name);
  for (const std::string_view suffix : {".gz", ".xz", ".zst", ".bz2"}) {
    if (lower.size() > suffix.size() && lower.ends_with(suffix)) name.resize(name.size() - suffix.size());
  }
  return name;
}

std::string openable_path(const InputFile& file) {
  const auto kept = is_standard_input(file.path()) ? detail::kept_standard_input(file.context()) : -1;
  return kept && *kept >= 0 ? fmt::format("/proc/{}/fd/{}", ::getpid(), *kept) : file.path().string();
}

}  // namespace isoextract::files
