// Plans and writes the HTML page and the contact sheet of a conversion or a batch.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/frame_table.hpp"
#include "cli/html_page.hpp"
#include "cli/options.hpp"
#include "cli/plan.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Plans --html and --contact-sheet. `job` has the settings that all frames share. Fails with ErrorCode::usage for
// unusable names, and for outputs that are not mesh files of one frame each (fields, pictures, stdout, --animate).
[[nodiscard]] Result<PagesPlan> plan_pages(const ConvertFlags& flags, const convert::ConversionJob& job);

// Writes the contact sheet and the page after all conversions. `rows` has all frames with the files that they wrote;
// `page` has further facts about the frames; `up` is the meshes' up axis where the format prescribes none. Draws
// patients from the front, at the azimuth `figures.front` of the first row with a mesh.
//
// Fails as MeshPictures does. Fails with ErrorCode::unavailable if gnuplot, which plots several frames on the page, is
// missing or fails. Fails with ErrorCode::output if a file cannot be written or a contact sheet has no mesh to draw.
[[nodiscard]] Result<void> write_pages(const PagesPlan& plan, std::span<const batch::FrameRow> rows,
                                       const HtmlPage& page, convert::UpAxis up,
                                       const std::vector<std::string>& arguments, const Context& context);

}  // namespace isoextract::cli
