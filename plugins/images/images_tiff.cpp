#include "images_tiff.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <string_view>
#include <utility>

namespace isoextract_plugin {
namespace {

constexpr std::uint64_t kMostPages = 1 << 20;
constexpr std::uint64_t kLibraryMemory = std::uint64_t{1}
                                         << 26;  // of one allocation of libtiff besides a compressed strip

int keep_error(TIFF* /*tiff*/, void* problem, const char* /*module*/, const char* format, va_list values) {
  char text[300] = "";
  static_cast<void>(std::vsnprintf(text, sizeof text, format, values));
  auto& kept = *static_cast<std::string*>(problem);
  if (kept.empty()) kept = text;  // the first one is the cause
  return 1;
}

// Keeps the warning of a tag whose value lies beyond the end of the file: libtiff then leaves the tag out. Ignores
// other warnings, for example of unknown tags.
int judge_warning(TIFF* tiff, void* lost, const char* module, const char* format, va_list values) {
  return std::string_view(format).find("IO error") == std::string_view::npos
             ? 1
             : keep_error(tiff, lost, module, format, values);
}

// Returns a bound of the decoded bytes per stored byte.
std::uint64_t ratio_of(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE: return 1;
    case COMPRESSION_PACKBITS: return 64;
    case COMPRESSION_LZW:
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE: return 2000;
    default: return 40'000;  // Zstandard's blocks of one byte
  }
}

// Describes the page at which libtiff is positioned.
Page page_of(const Tiff& tiff) {
  TIFF* const file = tiff.get();
  Page page;
  page.directory = TIFFCurrentDirOffset(file);
  PageShape& shape = page.shape;
  if (TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &shape.width) == 0 ||
      TIFFGetField(file, TIFFTAG_IMAGELENGTH, &shape.height) == 0 || shape.width == 0 || shape.height == 0) {
    tiff.fail("a page has no width and height");
  }
  std::uint32_t depth = 1;
  std::uint32_t kind = 0;
  std::uint16_t old_kind = 0;
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &shape.bits);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &shape.format);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &shape.samples);
  TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &compression);
  if (shape.format == SAMPLEFORMAT_VOID) shape.format = SAMPLEFORMAT_UINT;
  if (shape.samples == 0) throw ReadError("a page has no samples per pixel");
  if (TIFFGetField(file, TIFFTAG_IMAGEDEPTH, &depth) != 0 && depth > 1) {
    throw ReadError("expected pages of one slice, found a page with a depth of " + std::to_string(depth));
  }
  if (TIFFGetField(file, TIFFTAG_SUBFILETYPE, &kind) != 0) {
    page.is_reduced = (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
  } else if (TIFFGetField(file, TIFFTAG_OSUBFILETYPE, &old_kind) != 0) {
    page.is_reduced = old_kind == OFILETYPE_REDUCEDIMAGE;
  }
  const std::uint64_t bits =
      checked_product(checked_product(shape.width, shape.height), std::uint64_t{shape.bits} * shape.samples);
  if (TIFFIsTiled(file) == 0 || compression == COMPRESSION_NONE)  // tiles may be missing
    check_file_holds(tiff.file_size(), bits / 8, ratio_of(compression));
  return page;
}

std::vector<Page> pages_of(Tiff& tiff, const isoextract_plugin_host& host) {
  std::vector<Page> pages{page_of(tiff)};
  while (TIFFLastDirectory(tiff.get()) == 0) {
    if (pages.size() % 256 == 0) check_cancelled(host);
    if (pages.size() >= kMostPages) throw ReadError("more than " + std::to_string(kMostPages) + " pages");
    if (TIFFReadDirectory(tiff.get()) == 0) {
      tiff.fail("page " + std::to_string(pages.size() + 1) + ": libtiff cannot read it");
    }
    pages.push_back(page_of(tiff));
  }
  tiff.check_tags();
  return pages;
}

class TiffFile final : public VolumeFile {
 public:
  TiffFile(const std::string& path, const isoextract_plugin_host& host) : path_(path) {
    Tiff tiff(path);
    pages_ = pages_of(tiff, host);
    tiff.select(pages_.front().directory);
    creator = text_tag(tiff, TIFFTAG_SOFTWARE);
    no_data_ = no_data_of(tiff);
    const std::string text = text_tag(tiff, TIFFTAG_IMAGEDESCRIPTION);
    auto layout = imagej_layout(tiff, text, pages_);
    if (!layout) layout = ome_layout(text, pages_, path);
    if (!layout) layout = plain_layout(tiff, pages_);
    format = (TIFFIsBigTIFF(tiff.get()) != 0 && layout->format == "TIFF") ? "BigTIFF" : layout->format;
    series_ = std::move(layout->series);
    for (std::size_t i = 0; i < series_.size(); ++i) add_grids(i, *layout);
    add_notes(tiff, *layout);
    note = layout->note;
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const Grid& grid = grids[selection.grid];
    const auto [number, channel] = sources_[selection.grid];
    const Series& series = series_[number];
    const bool is_length = selection.component == ISOEXTRACT_COMPONENT_LENGTH;
    const std::uint64_t slice = selection.count[0] * selection.count[1];
    const std::uint64_t bytes = slice * sample_size(selected_type(grid, selection));
    PageBox box{selection.first[0], selection.first[1], selection.count[0], selection.count[1], {}, no_data_};
    if (!is_length) box.component = static_cast<std::uint64_t>(selection.component);
    HostMemory memory(host);
    std::vector<char> all;  // components of a slice
    if (is_length) {
      const std::uint64_t size = checked_product(slice, grid.components * sample_size(grid.sample_type));
      memory.take(size);
      all.resize(size);
    }
    Tiff tiff(path_);
    for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
      check_cancelled(host);
      const std::uint64_t plane =
          (selection.volume * series.sizes[1] + channel) * series.sizes[0] + selection.first[2] + z;
      char* const to = static_cast<char*>(selection.box) + z * bytes;
      const Page& page = pages_[series.pages[plane]];
      read_page(tiff, page, box, is_length ? all.data() : to, host);
      if (!is_length) continue;
      isoextract_volume_selection part = selection;
      std::fill_n(part.first, 3, 0);
      part.count[2] = 1;
      part.box = to;
      fill_box(grid, interleaved_samples(all.data(), {box.width, box.height, 1}, grid.components), part);
    }
    return {{}, selection.count[2], series.pages.size()};
  }

 private:
  // Adds a grid for each channel of a series.
  void add_grids(std::size_t number, Layout& layout) {
    const Series& series = series_[number];
    const PageShape& shape = pages_[series.pages.front()].shape;
    for (const std::size_t page : series.pages) {
      if (pages_[page].shape == shape) continue;
      throw ReadError("expected pages of one size and type in an image, found " + std::to_string(shape.width) + " x " +
                      std::to_string(shape.height) + " " + type_of(shape).name + " and " +
                      std::to_string(pages_[page].shape.width) + " x " + std::to_string(pages_[page].shape.height) +
                      " " + type_of(pages_[page].shape).name);
    }
    const PageType type = type_of(shape);
    if (type.is_wide_integer) layout.add_note("the reader makes doubles of 64-bit integers, exact up to 2^53");
    for (std::uint64_t c = 0; c < series.sizes[1]; ++c) {
      Grid grid;
      grid.name = grid_name(series, c);
      grid.type_name = type.name;
      grid.sample_type = given_type(type, no_data_.has_value());
      grid.dims = {shape.width, shape.height, series.sizes[0]};
      grid.volumes = series.sizes[2];
      grid.has_placement = series.has_placement;
      grid.index_to_world = series.index_to_world;
      grid.length_unit = series.length_unit;
      grid.slope = series.slope;
      grid.intercept = series.intercept;
      if (series.time_step > 0) {
        for (std::uint64_t t = 0; t < grid.volumes; ++t)
          grid.volume_times.push_back(static_cast<double>(t) * series.time_step);
        grid.time_unit = series.time_unit;
      }
      grid.components = shape.samples;
      if (shape.samples == 3) grid.component_names = "R G B";
      if (shape.samples == 4) grid.component_names = "R G B A";
      grids.push_back(std::move(grid));
      sources_.push_back({number, c});
    }
  }

  std::string grid_name(const Series& series, std::uint64_t channel) const {
    std::string name = series_.size() > 1 ? series.name : "";
    if (series.sizes[1] == 1) return name;
    if (!name.empty()) name += ".";
    const bool is_named = channel < series.channels.size() && !series.channels[channel].empty();
    return name + (is_named ? series.channels[channel] : "channel" + std::to_string(channel));
  }

  void add_notes(Tiff& tiff, Layout& layout) const {
    const auto reduced = std::ranges::count(pages_, true, &Page::is_reduced);
    if (reduced > 0) layout.add_note(std::to_string(reduced) + " reduced copies or masks do not count as pages");
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    if (TIFFGetField(tiff.get(), TIFFTAG_PHOTOMETRIC, &photometric) == 0) return;
    if (photometric == PHOTOMETRIC_PALETTE) layout.add_note("the samples are indices of the palette, not colors");
    if (photometric == PHOTOMETRIC_MINISWHITE) layout.add_note("the reader does not invert the samples: 0 means white");
  }

  std::string path_;
  std::vector<Page> pages_;
  std::vector<Series> series_;
  struct Channel {
    std::size_t series;
    std::uint64_t channel;
  };
  std::vector<Channel> sources_;  // of each grid
  std::optional<double> no_data_;
};

}  // namespace

Tiff::Tiff(const std::string& path) : size_(file_size_of(path)) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  if (!options) throw std::bad_alloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_error, problem_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), judge_warning, lost_.get());
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(size_ + kLibraryMemory));
  // D: reads strip tables on demand. m: no memory mapping, because a mapped file that shrinks would end the process.
  tiff_.reset(TIFFOpenExt(path.c_str(), "rDm", options.get()));
  if (!tiff_) fail("not a TIFF file");
}

void Tiff::check_tags() const {
  if (!lost_->empty()) throw ReadError("the file ends before the values of its tags: libtiff: " + *lost_);
}

void Tiff::fail(const std::string& otherwise) const {
  std::string text = problem_->empty() ? otherwise : "libtiff: " + *problem_;
  while (text.ends_with('.')) text.pop_back();
  throw ReadError(text);
}

void Tiff::select(std::uint64_t directory) {
  if (TIFFCurrentDirOffset(get()) == directory) return;
  if (TIFFSetSubDirectory(get(), directory) == 0) fail("libtiff cannot find a page");
}

std::string text_tag(const Tiff& tiff, std::uint32_t tag) {
  const char* text = nullptr;
  return TIFFGetField(tiff.get(), tag, &text) != 0 && text != nullptr ? text : "";
}

bool is_tiff(const unsigned char* start, std::size_t bytes) {
  using std::string_view_literals::operator""sv;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (starts_with(start, bytes, magic)) return true;
  }
  return false;
}

std::unique_ptr<VolumeFile> open_tiff(const std::string& path, const isoextract_plugin_host& host) {
  return std::make_unique<TiffFile>(path, host);
}

}  // namespace isoextract_plugin
