// PNG: gray, gray with alpha, RGB and RGBA of 8 and 16 bits as stored; fewer bits and palettes as 8-bit numbers.
#include <csetjmp>
#include <cstdio>

#include <png.h>

#include "images.hpp"

namespace isoextract_plugin {
namespace {

constexpr std::uint64_t kDeflateRatio = 1040;                  // the most bytes that deflate makes of one
constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 26;  // of a chunk besides the samples

// An open file with libpng's state. libpng reports errors by a jump, which must not pass objects with destructors: the
// functions below that call setjmp have none.
struct Png {
  std::FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
  char problem[200] = "";

  Png() = default;
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;
  ~Png() {
    png_destroy_read_struct(&png, &info, nullptr);
    if (file != nullptr) static_cast<void>(std::fclose(file));
  }
};

[[noreturn]] void stop(png_structp png, png_const_charp text) {
  auto* const self = static_cast<Png*>(png_get_error_ptr(png));
  static_cast<void>(std::snprintf(self->problem, sizeof self->problem, "libpng: %s", text));
  png_longjmp(png, 1);
}

void ignore(png_structp /*png*/, png_const_charp /*text*/) {}

// Reads the header, and sets the transforms to native samples of 8 or 16 bits. Returns false on errors.
bool read_header(Png& self) {
  self.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &self, stop, ignore);
  if (self.png == nullptr) return false;
  self.info = png_create_info_struct(self.png);
  if (self.info == nullptr) return false;
  if (setjmp(png_jmpbuf(self.png)) != 0) return false;
  png_set_chunk_malloc_max(self.png, kMostMemory);
  png_set_user_limits(self.png, 0x7fffffff, 0x7fffffff);
  png_init_io(self.png, self.file);
  png_read_info(self.png, self.info);
  if (png_get_bit_depth(self.png, self.info) < 8) png_set_packing(self.png);
  if (png_get_bit_depth(self.png, self.info) == 16 && std::endian::native == std::endian::little)
    png_set_swap(self.png);
  static_cast<void>(png_set_interlace_handling(self.png));
  png_read_update_info(self.png, self.info);
  return true;
}

// Reads `count` rows, each into rows[i].
bool read_rows(Png& self, png_bytep* rows, png_uint_32 count) {
  if (setjmp(png_jmpbuf(self.png)) != 0) return false;
  png_read_rows(self.png, rows, nullptr, count);
  return true;
}

// Reads all rows of an interlaced image.
bool read_image(Png& self, png_bytep* rows) {
  if (setjmp(png_jmpbuf(self.png)) != 0) return false;
  png_read_image(self.png, rows);
  return true;
}

void open(Png& self, const std::string& path) {
  self.file = std::fopen(path.c_str(), "rb");
  if (self.file == nullptr) throw ReadError("expected a readable file");
  if (!read_header(self)) throw ReadError(self.problem[0] == 0 ? "libpng cannot start" : self.problem);
}

class PngFile final : public VolumeFile {
 public:
  explicit PngFile(const std::string& path) : path_(path) {
    Png self;
    open(self, path);
    format = "PNG";
    Grid grid;
    grid.has_placement = false;
    grid.dims = {png_get_image_width(self.png, self.info), png_get_image_height(self.png, self.info), 1};
    grid.components = png_get_channels(self.png, self.info);
    const bool is_wide = png_get_bit_depth(self.png, self.info) == 16;
    grid.sample_type = is_wide ? ISOEXTRACT_U16 : ISOEXTRACT_U8;
    grid.type_name = is_wide ? "uint16" : "uint8";
    switch (png_get_color_type(self.png, self.info)) {
      case PNG_COLOR_TYPE_GRAY_ALPHA: grid.component_names = "gray alpha"; break;
      case PNG_COLOR_TYPE_RGB: grid.component_names = "R G B"; break;
      case PNG_COLOR_TYPE_RGB_ALPHA: grid.component_names = "R G B A"; break;
      case PNG_COLOR_TYPE_PALETTE: add_palette(self, grid); break;
      default: break;
    }
    check_file_holds(file_size_of(path), row_bytes(grid) * grid.dims[1], 8 * kDeflateRatio);  // 8 pixels in a byte
    grids.push_back(std::move(grid));
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    Png self;
    open(self, path_);
    const Grid& grid = grids.front();
    const std::uint64_t bytes = row_bytes(grid);
    if (png_get_rowbytes(self.png, self.info) != bytes || png_get_image_height(self.png, self.info) != grid.dims[1]) {
      throw ReadError("the file changed during the run");
    }
    const bool is_interlaced = png_get_interlace_type(self.png, self.info) != PNG_INTERLACE_NONE;
    const std::uint64_t last = selection.first[1] + selection.count[1];
    const std::uint64_t kept = is_interlaced ? grid.dims[1] : std::uint64_t{1};
    HostMemory memory(host);
    memory.take(checked_product(bytes, kept) + kept * sizeof(png_bytep));
    std::vector<png_byte> block(bytes * kept);
    std::vector<png_bytep> rows(kept);
    for (std::size_t i = 0; i < kept; ++i) rows[i] = block.data() + i * bytes;
    if (is_interlaced && !read_image(self, rows.data())) throw ReadError(self.problem);
    const std::uint64_t row_samples = selection.count[0] * sample_size(selected_type(grid, selection));
    isoextract_volume_selection row = selection;
    row.first[1] = 0;
    row.count[1] = 1;
    for (std::uint64_t y = 0; y < last; ++y) {
      if (y % 256 == 0) check_cancelled(host);
      if (!is_interlaced && !read_rows(self, rows.data(), 1)) throw ReadError(self.problem);
      if (y < selection.first[1]) continue;
      const png_byte* const from = rows[is_interlaced ? y : 0];
      row.box = static_cast<char*>(selection.box) + (y - selection.first[1]) * row_samples;
      fill_box(grid, interleaved_samples(from, grid.dims, grid.components), row);
    }
    return {};
  }

 private:
  static std::uint64_t row_bytes(const Grid& grid) {
    return grid.dims[0] * grid.components * sample_size(grid.sample_type);
  }

  // Adds the palette's colors as label colors: the samples are palette indices.
  void add_palette(Png& self, Grid& grid) {
    png_colorp colors = nullptr;
    int count = 0;
    if (png_get_PLTE(self.png, self.info, &colors, &count) == 0) return;
    for (int i = 0; i < count; ++i) {
      const png_color& color = colors[i];
      grid.labels.push_back({i, "", {color.red / 255.0, color.green / 255.0, color.blue / 255.0}, true});
    }
    note = "the samples are indices of the palette, not colors";
  }

  std::string path_;
};

}  // namespace

bool is_png(const unsigned char* start, std::size_t bytes) { return starts_with(start, bytes, "\x89PNG\r\n\x1a\n"); }

std::unique_ptr<VolumeFile> open_png(const std::string& path, const isoextract_plugin_host& /*host*/) {
  return std::make_unique<PngFile>(path);
}

}  // namespace isoextract_plugin
