// What is written about a conversion, or all frames of it, besides its meshes: a page, a contact sheet.
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

// `job` is what all frames share. Refuses names that make no sense, and outputs that are no meshes in files of their
// own.
[[nodiscard]] Result<PagesPlan> plan_pages(const ConvertFlags& flags, const convert::ConversionJob& job);

// Once all is converted: `rows` are all frames, with the files that they wrote. `page` knows what they did. Fails as
// MeshPictures does, with ErrorCode::unavailable where there is no gnuplot to plot several frames, and with
// ErrorCode::output.
[[nodiscard]] Result<void> write_pages(const PagesPlan& plan, std::span<const batch::FrameRow> rows,
                                       const HtmlPage& page, convert::UpAxis up,
                                       const std::vector<std::string>& arguments, const Context& context);

}  // namespace isoextract::cli
