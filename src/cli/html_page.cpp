#include "cli/html_page.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "base/version.hpp"
#include "cli/values.hpp"
#include "convert/picture_file.hpp"
#include "image_io/png_writer.hpp"

namespace isoextract::cli {
namespace {

constexpr std::string_view kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;color:#1c2430;background:#fff;max-width:70rem;margin:2rem auto;padding:0 "
    "1rem}h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}code,pre{font:13px/1.4 ui-monospace,monospace}"
    "pre{background:#f2f4f7;padding:.7rem;white-space:pre-wrap;overflow-wrap:anywhere}"
    "table{border-collapse:collapse;font-size:13px}"
    "th,td{border-bottom:1px solid #d8dde5;padding:.25rem .5rem;text-align:right;vertical-align:top}"
    "th:first-child,td:first-child{text-align:left}td.words,th.words{text-align:left}"
    "td.words:not(:first-child){overflow-wrap:anywhere;min-width:6rem}"
    "figure{display:inline-block;margin:.3rem;text-align:center}"
    "img{max-width:100%;border:1px solid #d8dde5}figcaption{font-size:12px;color:#56606e}.failed{color:#a61b1b}"
    ".scroll{overflow-x:auto}svg{max-width:100%;height:auto}";

// A table wider than the window scrolls on its own.
constexpr std::string_view kTable = "<div class=\"scroll\"><table>\n";
constexpr std::string_view kTableEnd = "</table></div>\n";

std::string html_text(std::string_view text) {
  std::string html;
  for (const char c : printable(text)) {
    switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      default: html += c;
    }
  }
  return html;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t b = 0; b < 3; ++b) {
      group = (group << 8U) | (b < count ? std::to_integer<std::uint32_t>(bytes[i + b]) : 0U);
    }
    for (std::size_t d = 0; d < 4; ++d) text += d <= count ? kDigits64[(group >> (18 - 6 * d)) & 63U] : '=';
  }
  return text;
}

// Returns a table row; the first `words` cells are text, the others numbers.
std::string row_of(std::span<const std::string> cells, std::string_view tag, std::size_t words) {
  std::string html = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    html += fmt::format("<{0}{1}>{2}</{0}>", tag, i < words ? " class=\"words\"" : "", cells[i]);
  }
  return html + "</tr>\n";
}

template <class T>
std::string optional_text(const std::optional<T>& value) {
  return value ? fmt::format("{:.6g}", static_cast<double>(*value)) : "";
}

std::string count_text(const std::optional<std::uint64_t>& value) { return value ? fmt::format("{}", *value) : ""; }

// Returns the text of an iso value, with the grid if there are several.
std::string with_grid(const std::string& grid, const std::string& iso) {
  return grid.empty() ? iso : fmt::format("{} {}", html_text(grid), iso);
}

std::string frames_section(std::span<const batch::FrameRow> rows) {
  const std::array<std::string, 13> heads{"frame", "input",  "output", "status",     "iso",     "triangles", "vertices",
                                          "area",  "volume", "unit",   "components", "seconds", "bytes"};
  std::string html = "<h2>Frames</h2>\n" + std::string(kTable) + "<thead>" + row_of(heads, "th", 4) + "</thead>\n";
  for (const batch::FrameRow& row : rows) {
    const std::string status = row.error.empty() ? std::string(word_of(row.status))
                                                 : fmt::format("<span class=\"failed\">{}: {}</span>",
                                                               word_of(row.status), html_text(row.error));
    std::vector<const batch::SurfaceFigures*> surfaces = batch::rows_of(row.figures);
    const bool none = surfaces.empty();
    const batch::SurfaceFigures no_surface;
    if (none) surfaces.push_back(&no_surface);
    for (const batch::SurfaceFigures* figures : surfaces) {
      const batch::SurfaceFigures& surface = *figures;
      const std::string number = !surface.id.is_iso() ? surface.id.text() : fmt::format("{:.6g}", surface.id.iso());
      const std::string value =
          surface.asked.empty() ? number : fmt::format("{} ({})", number, html_text(surface.asked));
      const std::string iso = with_grid(surface.grid, value);
      html += row_of(
          std::array<std::string, 13>{fmt::format("{}", row.frame), html_text(row.input),
                                      html_text(batch::output_of(row, none ? nullptr : &surface)), status,
                                      none ? "" : iso, none ? "" : fmt::format("{}", surface.triangles),
                                      count_text(surface.vertices), optional_text(surface.area),
                                      optional_text(surface.volume), html_text(row.figures.unit),
                                      count_text(surface.components), fmt::format("{:.3f}", row.figures.wall_seconds),
                                      fmt::format("{}", surface.bytes.value_or(row.figures.bytes))},
          "td", 4);
    }
  }
  return html + std::string(kTableEnd);
}

}  // namespace

void HtmlPage::add(std::int64_t frame, const convert::Outcome& outcome) {
  using convert::Key;
  for (const convert::StageReport& report : outcome.reports) {
    if (report.stage != convert::StageName::mesh_facts) continue;
    for (const convert::Figures& mesh : report.entries) {
      const auto number = [&](Key statistic, Key unit) {
        return value_at<double>(mesh, {Key::error, Key::interior, statistic, unit});
      };
      const auto rms = number(Key::rms, Key::world);
      if (!rms) continue;
      errors_.push_back({frame, value_at<std::string>(mesh, {Key::grid}).value_or(""),
                         value_at<double>(mesh, {Key::iso}).value_or(0), *rms, number(Key::max, Key::world).value_or(0),
                         number(Key::max, Key::voxels).value_or(0)});
    }
  }
  const auto take = [&](const convert::WorkFact& fact) {
    SkippedWork& all = left_out_[{std::string(word_of(fact.what)), std::string(word_of(fact.done))}];
    all.count += fact.count.value_or(0);
    all.total += fact.total.value_or(0);
    if (++all.times == 1) all.first = fact.text;
  };
  for (const convert::StageReport& report : outcome.reports) std::ranges::for_each(report.work, take);
  for (const auto& part : outcome.times()) stages_[std::string(word_of(part.stage))] += part.time.wall_seconds;
  if (!outcome.device.empty()) devices_.insert(fmt::format("{} ({})", outcome.device, outcome.backend));
  for (const Note& note : outcome.notes) notes_.emplace_back(frame, note);
}

std::string HtmlPage::left_out_section() const {
  if (left_out_.empty()) return {};
  std::string html = "<h2>Work done, and work left out</h2>\n<ul>\n";
  for (const auto& [name, fact] : left_out_) {
    html += fmt::format("<li><b>{}</b> {}: {}", html_text(name.first), html_text(name.second), html_text(fact.first));
    if (fact.times > 1 && fact.total > 0) {
      html += fmt::format("; in total {} of {} over {} surfaces or frames", fact.count, fact.total, fact.times);
    }
    html += "</li>\n";
  }
  return html + "</ul>\n";
}

std::string HtmlPage::error_section() const {
  if (errors_.empty()) {
    return "<h2>Error</h2>\n<p>Not measured; <code>--error</code> measures the distance of each mesh from its "
           "isosurface.</p>\n";
  }
  std::string html = "<h2>Error</h2>\n<p>Distances of the meshes from their isosurfaces.</p>\n" + std::string(kTable) +
                     row_of(std::array<std::string, 5>{"frame", "iso", "rms", "largest", "largest, voxels"}, "th", 1);
  for (const MeasuredError& error : errors_) {
    html += row_of(std::array<std::string, 5>{fmt::format("{}", error.frame),
                                              with_grid(error.grid, fmt::format("{:.6g}", error.iso)),
                                              fmt::format("{:.3g}", error.rms), fmt::format("{:.3g}", error.largest),
                                              fmt::format("{:.3g}", error.voxels)},
                   "td", 1);
  }
  return html + std::string(kTableEnd);
}

std::string HtmlPage::stage_section() const {
  if (stages_.empty()) return {};
  std::string html = "<h2>Time by stage</h2>\n" + std::string(kTable) +
                     row_of(std::array<std::string, 2>{"stage", "seconds, of all frames"}, "th", 1);
  for (const auto& [stage, seconds] : stages_) {
    html += row_of(std::array<std::string, 2>{html_text(stage), fmt::format("{:.4f}", seconds)}, "td", 1);
  }
  return html + std::string(kTableEnd);
}

Result<std::string> HtmlPage::text(std::span<const batch::FrameRow> rows, const MeshPictures& pictures,
                                   const std::string& svg, const std::vector<std::string>& arguments,
                                   const Context& context) const {
  std::vector<std::string> words{"isoextract"};
  for (const std::string& argument : arguments) words.push_back(shell_quoted(argument));
  const std::string title = rows.size() == 1 ? rows.front().input : fmt::format("{} frames", rows.size());
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<meta name=\"generator\" "
      "content=\"{0}\">\n<title>{1}</title>\n<style>{2}</style>\n"
      "</head>\n<body>\n<h1>{1}</h1>\n<pre>{3}</pre>\n",
      html_text(generator()), html_text(title), kStyle, html_text(fmt::format("{}", fmt::join(words, " "))));
  if (pictures.count() > 0) html += "<h2>Pictures</h2>\n<div>\n";
  for (std::size_t n = 0; n < pictures.count(); ++n) {
    const auto picture = TRY(pictures.draw(n, context));
    const auto png = TRY(image_io::encode_png(convert::light_of(picture), pictures.mesh(n).label, context));
    const std::string label = html_text(pictures.mesh(n).label);
    html += fmt::format("<figure><img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">",
                        picture.width, picture.height, label, base64(png.bytes()));
    html += fmt::format("<figcaption>{}</figcaption></figure>\n", label);
    TRY(context.check());
  }
  if (pictures.count() > 0) html += "</div>\n";
  html += frames_section(rows);
  if (!svg.empty()) {
    const std::size_t start = svg.find("<svg");
    html += "<h2>Over time</h2>\n" + svg.substr(start == std::string::npos ? 0 : start) + "\n";
  }
  html += error_section() + left_out_section() + stage_section();
  if (!notes_.empty()) {
    html += "<h2>Notes</h2>\n<ul>\n";
    for (const auto& [frame, note] : notes_) html += fmt::format("<li>{}: {}</li>\n", frame, html_text(note.text));
    html += "</ul>\n";
  }
  html += fmt::format("<h2>Versions</h2>\n<p>{}", html_text(generator()));
  for (const std::string& device : devices_) html += "; " + html_text(device);
  return html + "</p>\n</body>\n</html>\n";
}

}  // namespace isoextract::cli
