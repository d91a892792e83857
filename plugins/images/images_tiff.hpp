// TIFF through libtiff: pages (images_tiff.cpp), how they form volumes (images_tiff_layout.cpp, images_ome.cpp), and
// their samples (images_tiff_pixels.cpp).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tiffio.h>

#include "images.hpp"

namespace isoextract_plugin {

// An open file. Keeps libtiff's first error for fail() and its first warning of lost tag values for check_tags(); drops
// all other warnings.
class Tiff {
 public:
  // Opens the file at its first page.
  explicit Tiff(const std::string& path);

  [[nodiscard]] TIFF* get() const { return tiff_.get(); }
  [[nodiscard]] std::uint64_t file_size() const { return size_; }
  // Throws with libtiff's text, or with `otherwise` if it gave none.
  [[noreturn]] void fail(const std::string& otherwise) const;
  // Throws if the value of a tag read so far lies beyond the end of the file.
  void check_tags() const;
  // Selects a page by the offset of its directory.
  void select(std::uint64_t directory);

 private:
  struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  };
  std::unique_ptr<std::string> problem_ = std::make_unique<std::string>();  // libtiff keeps the string's address
  std::unique_ptr<std::string> lost_ = std::make_unique<std::string>();     // for check_tags(); at a fixed address, too
  std::uint64_t size_ = 0;
  std::unique_ptr<TIFF, Close> tiff_;
};

// The shape of a page's samples.
struct PageShape {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 1;     // of a sample
  std::uint16_t format = 1;   // SAMPLEFORMAT_...
  std::uint16_t samples = 1;  // of a pixel

  friend bool operator==(const PageShape&, const PageShape&) = default;
};

struct Page {
  PageShape shape;
  std::uint64_t directory = 0;  // offset
  // Offset of an uncompressed plane that has no directory of its own, and follows the samples of the file's only page
  // (ImageJ's files of more than 4 GiB).
  std::optional<std::uint64_t> plane;
  bool is_reduced = false;  // a smaller copy of another page, or a mask
};

// Type of a page's samples.
struct PageType {
  std::int32_t stored = ISOEXTRACT_NOT_SCALAR;  // a sample in memory after unpacking; 64-bit integers are f64
  std::string name;
  bool is_wide_integer = false;  // of 64 bits
};
[[nodiscard]] PageType type_of(const PageShape& shape);

// One image of the file: its planes by slice, channel and time.
struct Series {
  std::string name;
  std::array<std::uint64_t, 3> sizes{1, 1, 1};  // slices, channels, times
  std::vector<std::size_t> pages;               // page indices; slice z, channel c, time t is at (t * C + c) * Z + z
  std::vector<std::string> channels;            // their names, or empty
  bool has_placement = false;
  std::array<double, 12> index_to_world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::string length_unit;
  double time_step = 0;  // 0: not stated
  std::string time_unit;
  double slope = 1;
  double intercept = 0;
};

// The volumes of a file, from its texts and tags.
struct Layout {
  std::string format = "TIFF";
  std::string note;
  std::vector<Series> series;  // one or more

  void add_note(const std::string& text) { note += (note.empty() ? "" : "; ") + text; }
};

// Returns the layout by ImageJ's description `text`; nullopt if another program wrote it. Removes reduced pages from
// `pages`, and adds the planes without a directory. Needs the file at its first page.
[[nodiscard]] std::optional<Layout> imagej_layout(Tiff& tiff, const std::string& text, std::vector<Page>& pages);
// Returns the layout by OME-XML; nullopt if `text` is none or describes no image. `path` is the file's.
[[nodiscard]] std::optional<Layout> ome_layout(const std::string& text, const std::vector<Page>& pages,
                                               const std::string& path);
// Returns a series for each shape of the pages. GeoTIFF's tags place the first series. Needs the file at its first
// page.
[[nodiscard]] Layout plain_layout(Tiff& tiff, const std::vector<Page>& pages);

// Returns the value that marks missing samples, from GDAL's tag of the selected page; nullopt without one or for NaN.
[[nodiscard]] std::optional<double> no_data_of(const Tiff& tiff);

// Returns the unit's name as isoextract knows it (um, mm), "" for pixels, or the text itself.
[[nodiscard]] std::string known_unit(std::string text);

// Returns the text of a tag, or "".
[[nodiscard]] std::string text_tag(const Tiff& tiff, std::uint32_t tag);

// A part of a page to read.
struct PageBox {
  std::uint64_t x = 0, y = 0, width = 0, height = 0;
  std::optional<std::uint64_t> component;  // if unset, all components
  std::optional<double> no_data;           // becomes NaN, and samples f32 or f64
};
// Fills `to` with the samples of the box, of type given_type(), components beside each other.
void read_page(Tiff& tiff, const Page& page, const PageBox& box, void* to, const isoextract_plugin_host& host);
[[nodiscard]] std::int32_t given_type(const PageType& type, bool has_no_data);

}  // namespace isoextract_plugin
