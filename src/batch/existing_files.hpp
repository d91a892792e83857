// Finds the files that a batch would replace, also label files: the job does not know their names, because only a
// conversion finds the labels.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batch/batch_job.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::batch {

// Compares a path with the name of an output. In the name, convert::kLabelPlaceholder stands for an optional minus sign
// and digits, kNamePlaceholder for one or more characters other than a slash, and kPiecePlaceholder for the number 1.
// For a label that occurs in several layers of a map, _2, _3 and so on may follow the digits. Several equal
// placeholders may stand for different texts.
//
// Returns the name with the texts that stand for label and name in the path; kPiecePlaceholder stays. Returns nullopt
// if the path differs.
[[nodiscard]] std::optional<std::string> match_output_name(std::string_view path, std::string_view name);

// Reads each folder once, for its first label file, and so does not see label files that appear later. Treats a folder
// that it cannot read as empty.
class ExistingFiles {
 public:
  // Returns the files of files_of(job) that exist. In a file name (not in the name of a folder), {label} and {name}
  // stand for all texts that match_output_name() allows.
  [[nodiscard]] std::vector<std::filesystem::path> find(const convert::ConversionJob& job);
  // Returns those of them whose names have {label} or {name}.
  [[nodiscard]] std::vector<std::filesystem::path> find_label_files(const convert::ConversionJob& job);

  // Returns an output with the name of each existing label file, for the outputs of the job with {label} or {name} in
  // the file name. Of labels split into bodies, finds those whose first body has a file; kPiecePlaceholder stays.
  [[nodiscard]] std::vector<convert::OutputFileJob> find_label_outputs(const convert::ConversionJob& job);

 private:
  struct Listing {
    std::vector<std::string> names;     // sorted
    std::vector<std::string> reversed;  // the same names, each from its last character to its first; sorted
  };
  struct Match {
    std::filesystem::path file;
    std::string output;  // the result of match_output_name()
  };

  [[nodiscard]] const Listing& list(const std::filesystem::path& folder);
  // Returns the files that match the output name, sorted by `output`.
  [[nodiscard]] std::vector<Match> find_matches(const std::filesystem::path& output);

  std::map<std::filesystem::path, Listing> folders_;
};

// Returns ExistingFiles::find_label_outputs() of each frame, without outputs whose names match those of several frames:
// 111.stl may belong to the frames 1 and 11 of {frame}{label}.stl.
[[nodiscard]] std::vector<std::vector<convert::OutputFileJob>> find_label_outputs(const BatchJob& batch);

}  // namespace isoextract::batch
