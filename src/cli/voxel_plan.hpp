// Plans the options of voxels and labels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::cli {

// Turns --labels into iso choices, and makes surface nets their default method. Fails with ErrorCode::usage for
// --labels with other methods than voxels and surface nets, with iso values or a table of them, and for --labels all
// with {iso} in -o. Fails likewise for --label-names without --labels.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

// Chooses all labels if the file of `input` names its labels, and returns a note about it; chooses the iso value 0.5
// for surface nets of integers, with a note, too. Otherwise returns an empty text; also if the options choose labels,
// iso values, or a method that is not for labels. Files that it cannot read choose nothing: the reader reports them.
[[nodiscard]] Result<std::string> set_default_labels(ConvertFlags& flags, const std::string& input,
                                                     const Context& context);

// A table of labels beside an input.
struct TableBeside {
  std::string path;
  volume_io::LabelTable table;
};

// Reads the table that lies beside `input` (volume_io::find_label_table()). Returns nothing if there is none, or if
// `input` is no file. A file beside the input that is no label table only adds a note.
[[nodiscard]] std::optional<TableBeside> read_table_beside(const std::string& input, const Context& context,
                                                           Notes& notes);

// Sets the label table of `job` to the one beside `input` (volume_io::find_label_table()) and adds a note about it.
// Does nothing without labels, if --label-names is given, or if the file names its labels.
[[nodiscard]] Result<void> plan_found_table(const ConvertFlags& flags, const std::string& input, const Context& context,
                                            Notes& notes, convert::ConversionJob& job);

// Sets the label table of `job`, whose resolution is already planned, and resampling by majority, because labels are
// never averaged. Fails with ErrorCode::usage for options without a meaning for labels, and as
// volume_io::LabelTable::read() does, which checks the table. Does nothing without --labels.
[[nodiscard]] Result<void> plan_labels(const ConvertFlags& flags, convert::ConversionJob& job);

// Returns whether --labels gives a set: all, or ranges and names. Which labels these are is known only from the
// samples.
[[nodiscard]] bool has_all_labels(const ConvertFlags& flags);

// Sets the options of voxel faces and surface nets of `surface`, whose method is already planned; --smooth, and
// simplified labels, turn off the merging of faces. Fails with ErrorCode::usage for options that the method lacks; adds
// notes about options without an effect.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, Notes& notes, convert::SurfaceOptions& surface);

}  // namespace isoextract::cli
