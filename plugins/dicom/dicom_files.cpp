// The files of an input: a folder, a file of a series, a list of files, or a DICOMDIR.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>

#include "dicom_dataset.hpp"
#include "dicom_structure.hpp"

namespace isoextract_dicom {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 200000;
constexpr int kDeepest = 16;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool has_dicom_extension(const fs::path& path) {
  const std::string extension = lower(path.extension().string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

// Adds the DICOM files of a folder, sorted by path, and counts the others.
void add_folder(const fs::path& folder, bool with_subfolders, std::vector<std::string>& paths, std::size_t& others) {
  std::vector<fs::path> found;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied);
  for (; entry != fs::recursive_directory_iterator(); ++entry) {
    if (entry->is_directory()) {
      if (!with_subfolders || entry.depth() >= kDeepest) entry.disable_recursion_pending();
      continue;
    }
    if (!entry->is_regular_file()) continue;
    found.push_back(entry->path());
    if (found.size() > kMostFiles)
      throw ReadError("expected at most " + std::to_string(kMostFiles) + " files in the folder, found more");
  }
  std::ranges::sort(found);
  for (const fs::path& path : found) {
    if (has_dicom_signature(path.string()) || has_dicom_extension(path)) {
      paths.push_back(path.string());
    } else {
      ++others;
    }
  }
}

// Finds a file of a DICOMDIR by its ID, a path below the DICOMDIR's folder in up to eight parts. File systems may have
// changed the case; copies often keep only the last folders of the path.
std::optional<fs::path> find_referenced(const fs::path& folder, const std::string& id) {
  std::vector<std::string> parts{""};
  for (const char c : id) {
    if (c == '\\') {
      parts.emplace_back();
    } else if (c != ' ') {
      parts.back() += c;
    }
  }
  for (const std::string& part : parts) {
    if (part.empty() || part == "." || part == ".." || part.find('/') != std::string::npos) return std::nullopt;
  }
  for (std::size_t first = 0; first < parts.size(); ++first) {
    fs::path as_written = folder;
    fs::path as_lower = folder;
    for (std::size_t i = first; i < parts.size(); ++i) {
      as_written /= parts[i];
      as_lower /= lower(parts[i]);
    }
    std::error_code error;
    if (fs::is_regular_file(as_written, error)) return as_written;
    if (fs::is_regular_file(as_lower, error)) return as_lower;
  }
  return std::nullopt;
}

// Returns the file IDs in a DICOMDIR; nothing for other files.
std::optional<std::vector<std::string>> directory_of(const std::string& path, const isoextract_plugin_host& host) {
  const Structure structure = check_structure(path, host);
  if (structure.class_uid != "1.2.840.10008.1.3.10") return std::nullopt;
  gdcm::DataSet data;
  read_attributes(structure, host, data);
  std::vector<std::string> ids;
  const Items items(data, gdcm::Tag(0x0004, 0x1220));  // the records
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (std::string id = text_of(items[i], gdcm::Tag(0x0004, 0x1500)); !id.empty()) ids.push_back(std::move(id));
  }
  return ids;
}

std::string count_text(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

FoundFiles find_files(const isoextract_plugin::Request& request, const isoextract_plugin_host& host) {
  FoundFiles found;
  std::size_t others = 0;
  const fs::path path(request.path);
  if (request.files.size() > 1) {
    found.paths = request.files;
  } else if (fs::is_directory(path)) {
    add_folder(path, true, found.paths, others);
    if (others > 0)
      found.note = "the reader skips " + count_text(others, "file that is", "files that are") + " not DICOM";
    if (found.paths.empty()) throw ReadError("expected DICOM files in the folder, found none");
  } else if (const auto ids = directory_of(request.path, host)) {
    std::size_t missing = 0;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    for (const std::string& id : *ids) {
      if (const auto file = find_referenced(folder, id)) {
        found.paths.push_back(file->string());
      } else {
        ++missing;
      }
    }
    std::ranges::sort(found.paths);
    found.paths.erase(std::unique(found.paths.begin(), found.paths.end()), found.paths.end());
    if (found.paths.empty()) {
      throw ReadError("expected the files of this DICOM directory beside it, found none of " +
                      std::to_string(ids->size()));
    }
    if (missing > 0)
      found.note =
          count_text(missing, "file of the DICOM directory is", "files of the DICOM directory are") + " missing";
  } else {
    found.is_single_input = true;
    add_folder(path.has_parent_path() ? path.parent_path() : fs::path("."), false, found.paths, others);
  }
  return found;
}

}  // namespace isoextract_dicom
