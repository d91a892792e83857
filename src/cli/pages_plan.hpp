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

// `job` is the job that all frames share. Refuses unusable names, and outputs that are not meshes in separate files.
[[nodiscard]] Result<PagesPlan> plan_pages(const ConvertFlags& flags, const convert::ConversionJob& job);

// Call after all conversions. `rows` has all frames with the files that they wrote; `page` has the facts about them.
// Fails as MeshPictures does, with ErrorCode::unavailable if a plot of several frames needs gnuplot and it is missing,
// and with ErrorCode::output.
[[nodiscard]] Result<void> write_pages(const PagesPlan& plan, std::span<const batch::FrameRow> rows,
                                       const HtmlPage& page, convert::UpAxis up,
                                       const std::vector<std::string>& arguments, const Context& context);

}  // namespace isoextract::cli
