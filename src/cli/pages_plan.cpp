#include "cli/pages_plan.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "cli/frame_plot.hpp"
#include "cli/gnuplot.hpp"
#include "cli/picture_plan.hpp"
#include "cli/plan_parts.hpp"
#include "convert/picture_file.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kPicturesOfPage = 12;
constexpr std::size_t kPicturesOfSheet = 60;
constexpr render::PictureSize kOnPage{320, 240};
constexpr render::PictureSize kAlone{960, 720};
constexpr render::PictureSize kOnSheet{320, 240};

std::vector<WrittenMesh> meshes_of(std::span<const batch::FrameRow> rows) {
  std::vector<WrittenMesh> meshes;
  for (const batch::FrameRow& row : rows) {
    WrittenMesh mesh{fmt::format("{}", row.frame), {}};
    for (const std::string& file : row.outputs) {
      if (extension_of(file) != ".bin") mesh.files.push_back(file);
    }
    if (mesh.files.empty()) {
      if (rows.size() == 1) continue;
      using enum batch::FrameStatus;
      const bool is_done = row.status == done || row.status == empty || row.status == kept;
      mesh.text_if_empty = is_done ? "no surface" : word_of(row.status);
    }
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

// Returns how to draw the meshes of the rows in pictures whose size is `usual` unless an option sets it.
render::PreviewOptions view_of(const PagesPlan& plan, const render::PictureSize& usual,
                               std::span<const batch::FrameRow> rows, convert::UpAxis up) {
  const auto has_mesh = std::ranges::find_if(rows, [](const batch::FrameRow& row) { return !row.outputs.empty(); });
  const double front = has_mesh != rows.end() ? has_mesh->figures.front : 0;
  convert::PictureFileOptions view = plan.view;
  if (plan.has_usual_size) {
    view.width = usual.width;
    view.height = usual.height;
  }
  return convert::preview_of(view, up, front);
}

}  // namespace

Result<PagesPlan> plan_pages(const ConvertFlags& flags, const convert::ConversionJob& job) {
  PagesPlan plan{flags.html, flags.contact_sheet, plan_view(flags.view), !flags.view.size};
  if (!plan.any()) return plan;
  const std::string_view option = flags.html ? flags.html.name() : flags.contact_sheet.name();
  if (plan.html && (plan.html->empty() || *plan.html == "-")) return refuse_usage("--html needs the name of a file");
  if (plan.contact_sheet && extension_of(*plan.contact_sheet) != fmt::format(".{}", kPictureFormat)) {
    return refuse_usage(fmt::format("--contact-sheet {}: expected a name that ends in .png", *plan.contact_sheet));
  }
  if (job.writes<convert::MeshFileOptions>() == nullptr) {
    return refuse_usage(fmt::format("{} shows the written meshes, but the output is not a mesh", option),
                        "give the output a name of a mesh format");
  }
  if (flags.batch.animate) {
    return refuse_usage(
        fmt::format("{} shows one mesh file per frame, but --animate writes all frames into one file", option),
        "leave --animate out");
  }
  if (flags.output == "-") {
    return refuse_usage(fmt::format("{} reads the mesh from its file, but -o - writes it to stdout", option),
                        "give a file with -o");
  }
  return plan;
}

Result<void> write_pages(const PagesPlan& plan, std::span<const batch::FrameRow> rows, const HtmlPage& page,
                         convert::UpAxis up, const std::vector<std::string>& arguments, const Context& context) {
  if (plan.contact_sheet) {
    const auto pictures = TRY(MeshPictures::open(evenly_spaced(meshes_of(rows), kPicturesOfSheet),
                                                 view_of(plan, kOnSheet, rows, up), context));
    if (pictures.count() == 0) {
      return fail(ErrorCode::output, fmt::format("{}: the run wrote no mesh to draw", *plan.contact_sheet));
    }
    TRY(write_contact_sheet(*plan.contact_sheet, pictures, context));
  }
  if (!plan.html) return {};
  std::string svg;
  if (rows.size() > 1) {
    svg = TRY(run_gnuplot(frame_plot_script(rows, PictureFormat::svg)));
  }
  const auto pictures = TRY(MeshPictures::open(evenly_spaced(meshes_of(rows), kPicturesOfPage),
                                               view_of(plan, rows.size() == 1 ? kAlone : kOnPage, rows, up), context));
  const auto text = TRY(page.text(rows, pictures, svg, arguments, context));
  return files::write_file(*plan.html, text);
}

}  // namespace isoextract::cli
