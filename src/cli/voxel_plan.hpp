// Plans the options of voxels and labels.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::cli {

// LabelFlags::asked_by for a file that names its labels.
inline constexpr std::string_view kLabelsOfFile = "the labels that the file names";

// Turns --labels into iso choices, and makes surface nets the default method of --labels. Fails with ErrorCode::usage
// if --labels comes with iso values or with a method other than voxels and surface nets, or if other options of labels
// come without --labels.
[[nodiscard]] Result<void> take_labels(const LabelFlags& flags, SurfaceFlags& surface, IsoOption& isos);
// Calls take_labels() with the options of a conversion. Also fails for --labels with a table of iso values, and for
// {iso} in -o unless --labels lists only numbers.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

// Chooses all labels if the file of `input` names its labels, or else the iso value 0.5 for --method surface-nets of
// integer samples; returns a note about the choice. Chooses nothing and returns an empty text for other inputs, for
// outputs without surfaces, and if the options choose labels, iso values, several grids, or a method that is not for
// labels. Does the same for files that it cannot read: the reader reports the error.
[[nodiscard]] Result<std::string> set_default_labels(ConvertFlags& flags, const std::string& input,
                                                     const Context& context);

// Returns whether `isoextract render` draws all labels of a volume by default: the file names its labels, and the
// options choose neither surfaces nor a transfer function. Returns false for standard input, and for files that it
// cannot read.
[[nodiscard]] bool draws_all_labels(const RenderFlags& flags, const std::string& volume, const Context& context);

// A table of labels beside an input.
struct TableBeside {
  std::string path;
  volume_io::LabelTable table;
};

// Reads the table that lies beside `input` (volume_io::find_label_table()). Returns nullopt if there is no table, or if
// `input` is standard input or a demo field. Adds a note and returns nullopt if the table cannot be read.
[[nodiscard]] std::optional<TableBeside> read_table_beside(const std::string& input, const Context& context,
                                                           Notes& notes);

// Sets the label table of `job` to the one beside `input` (volume_io::find_label_table()) and adds a note about it.
// Does nothing without labels, if --label-names is given, or if the file names its labels.
[[nodiscard]] Result<void> plan_found_table(const LabelFlags& flags, const std::string& input, const Context& context,
                                            Notes& notes, convert::ConversionJob& job);

// Sets the label table, the background, the smallest number of voxels and the resampling kernel of `job`, whose
// resolution is already planned. The default kernel is the majority, because labels are never averaged. Fails with
// ErrorCode::usage for options without a meaning for labels, and as volume_io::LabelTable::read() does. Does nothing
// without --labels.
[[nodiscard]] Result<void> plan_labels(const LabelFlags& flags, const SurfaceFlags& surface, const InputFlags& input,
                                       convert::ConversionJob& job);

// Sets the options of `surface` for voxel faces and surface nets; surface.method is already planned. Voxel faces are
// not merged with --smooth, nor if labels are simplified. Fails with ErrorCode::usage for options that the method
// lacks; adds notes about options without an effect and about side effects of --smooth.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, Notes& notes, convert::SurfaceOptions& surface);

}  // namespace isoextract::cli
