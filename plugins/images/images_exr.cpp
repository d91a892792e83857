// OpenEXR: scan lines and tiles (their full resolution), one or several parts; every channel is a grid. The origin is
// the data window's lower corner in pixels.
#include <algorithm>
#include <optional>
#include <string_view>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include "images.hpp"

namespace isoextract_plugin {
namespace {

constexpr std::uint64_t kBlockBytes = 1 << 22;  // target size of a block of rows
// Bound of decoded bytes per file byte: ZIP reaches 1032; a tile of one value in B44 or DWA reaches more.
constexpr std::uint64_t kMostRatio = 40'000;

// OpenEXR's texts name the file, which the host does, too.
std::string without_name(std::string text, const std::string& path) {
  const std::string quoted = " \"" + path + "\"";
  if (const std::size_t at = text.find(quoted); at != std::string::npos) text.erase(at, quoted.size());
  while (text.ends_with('.')) text.pop_back();
  return text;
}

template <class F>
decltype(auto) with_exr_errors(const std::string& path, F&& work) {
  try {
    return work();
  } catch (const ReadError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw ReadError("OpenEXR: " + without_name(error.what(), path));
  }
}

std::int32_t sample_type_of(Imf::PixelType type) {
  switch (type) {
    case Imf::UINT: return ISOEXTRACT_U32;
    case Imf::HALF: return ISOEXTRACT_F16;
    case Imf::FLOAT: return ISOEXTRACT_F32;
    default: return ISOEXTRACT_NOT_SCALAR;
  }
}

std::string type_name_of(Imf::PixelType type) {
  return type == Imf::UINT ? "uint" : type == Imf::HALF ? "half" : type == Imf::FLOAT ? "float" : "unknown";
}

// The part and channel that hold a grid's samples.
struct Source {
  int part = 0;
  std::string channel;
  bool is_gray = false;  // G and B repeat R
};

// Reads `count` rows of a channel at full width into `to`. `first`: row index from 0 at the top of the data window.
void read_rows(const Imf::Header& header, Imf::InputPart& part, const std::string& channel, Imf::PixelType type,
               std::uint64_t first, std::uint64_t count, void* to) {
  const Imath::Box2i& window = header.dataWindow();
  const int y = window.min.y + static_cast<int>(first);
  const int last = y + static_cast<int>(count) - 1;
  Imf::FrameBuffer buffer;
  buffer.insert(channel, Imf::Slice::Make(type, to, Imath::Box2i({window.min.x, y}, {window.max.x, last})));
  part.setFrameBuffer(buffer);
  part.readPixels(y, last);
}

std::uint64_t width_of(const Imath::Box2i& box) {
  return static_cast<std::uint64_t>(std::int64_t{box.max.x} - box.min.x + 1);
}
std::uint64_t height_of(const Imath::Box2i& box) {
  return static_cast<std::uint64_t>(std::int64_t{box.max.y} - box.min.y + 1);
}

// Returns how many rows of one channel are read at a time. `size`: bytes of a sample.
std::uint64_t rows_per_block(const Imf::Header& header, std::uint64_t size) {
  // A multiple of 256 rows: chunks and most tiles have at most 256, so that each is decoded once.
  return std::clamp<std::uint64_t>(kBlockBytes / (width_of(header.dataWindow()) * size) / 256 * 256, 256,
                                   std::max<std::uint64_t>(256, height_of(header.dataWindow())));
}

const Imf::Channel* channel_of(const Imf::Header& header, const std::string& name) {
  return header.channels().findChannel(name.c_str());
}

// Returns whether R, G and B of a file's one part are equal everywhere, and A, if there is one, is 1.
bool is_gray(Imf::MultiPartInputFile& file, const isoextract_plugin_host& host) {
  const Imf::Header& header = file.header(0);
  std::vector<std::string> names{"R", "G", "B"};
  if (channel_of(header, "A") != nullptr) names.emplace_back("A");
  const Imf::PixelType type = channel_of(header, "R")->type;
  const std::uint64_t size = sample_size(sample_type_of(type));
  const std::uint64_t width = width_of(header.dataWindow());
  const std::uint64_t height = height_of(header.dataWindow());
  const std::uint64_t rows = std::min(rows_per_block(header, size), height);
  HostMemory memory(host);
  memory.take(checked_product(checked_product(width, rows), size) * names.size());
  std::vector<std::vector<char>> blocks(names.size(), std::vector<char>(width * rows * size));
  Imf::InputPart part(file, 0);
  for (std::uint64_t y = 0; y < height; y += rows) {
    check_cancelled(host);
    const std::uint64_t count = std::min(rows, height - y);
    for (std::size_t i = 0; i < names.size(); ++i) read_rows(header, part, names[i], type, y, count, blocks[i].data());
    const std::size_t bytes = width * count * size;
    if (std::memcmp(blocks[0].data(), blocks[1].data(), bytes) != 0) return false;
    if (std::memcmp(blocks[0].data(), blocks[2].data(), bytes) != 0) return false;
    if (names.size() < 4) continue;
    for (std::size_t i = 0; i < width * count; ++i) {
      const bool is_one = with_sample_type(sample_type_of(type), [&]<class T>(T) {
        T value{};
        std::memcpy(&value, blocks[3].data() + i * size, size);
        constexpr auto kOne = static_cast<T>(std::is_same_v<T, std::uint16_t> ? 0x3c00 : 1);  // of a half
        return value == kOne;
      });
      if (!is_one) return false;
    }
  }
  return true;
}

// Returns whether a part has only R, G, B and perhaps A, of one type and not subsampled.
bool is_plain_rgb(const Imf::Header& header) {
  std::size_t count = 0;
  std::optional<Imf::PixelType> type;
  for (auto at = header.channels().begin(); at != header.channels().end(); ++at, ++count) {
    const std::string_view name = at.name();
    if (name != "R" && name != "G" && name != "B" && name != "A") return false;
    const Imf::Channel& channel = at.channel();
    if (channel.xSampling != 1 || channel.ySampling != 1 || channel.type != type.value_or(channel.type)) return false;
    type = channel.type;
  }
  const bool has_rgb =
      channel_of(header, "R") != nullptr && channel_of(header, "G") != nullptr && channel_of(header, "B") != nullptr;
  return has_rgb && type && sample_type_of(*type) != ISOEXTRACT_NOT_SCALAR;
}

class ExrFile final : public VolumeFile {
 public:
  ExrFile(const std::string& path, const RgbRule& rule, const isoextract_plugin_host& host) : path_(path) {
    format = "OpenEXR";
    with_exr_errors(path, [&] { list(rule, host); });
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    return with_exr_errors(path_, [&] { return read_channel(selection, host); });
  }

 private:
  void list(const RgbRule& rule, const isoextract_plugin_host& host) {
    Imf::MultiPartInputFile file(path_.c_str(), 0, false);
    const std::uint64_t size = file_size_of(path_);
    int deep = 0;
    for (int part = 0; part < file.parts(); ++part) {
      const Imf::Header& header = file.header(part);
      if (header.hasType() && Imf::isDeepData(header.type())) {
        ++deep;
        continue;
      }
      list_part(file, part, size, rule, host);
    }
    if (grids.empty() && deep > 0) {
      throw ReadError("expected one sample per pixel and channel, found a deep image, which has any number of them");
    }
    if (grids.empty()) throw ReadError("expected an image with channels, found none");
    if (deep > 0)
      add_note("the reader leaves out " + std::to_string(deep) + " of " + std::to_string(file.parts()) +
               " parts, which are deep images");
  }

  void list_part(Imf::MultiPartInputFile& file, int part, std::uint64_t size, const RgbRule& rule,
                 const isoextract_plugin_host& host) {
    const Imf::Header& header = file.header(part);
    const Imath::Box2i& window = header.dataWindow();
    const std::uint64_t pixels = checked_product(width_of(window), height_of(window));
    std::uint64_t pixel_bytes = 0;
    for (auto at = header.channels().begin(); at != header.channels().end(); ++at) {
      if (at.channel().xSampling == 1 && at.channel().ySampling == 1)
        pixel_bytes += at.channel().type == Imf::HALF ? 2 : 4;
    }
    check_file_holds(size, checked_product(pixels, pixel_bytes),
                     header.compression() == Imf::NO_COMPRESSION ? 1 : kMostRatio);
    const bool gray = file.parts() == 1 && is_plain_rgb(header) && decide_gray(file, rule, host);
    for (auto at = header.channels().begin(); at != header.channels().end(); ++at) {
      const std::string_view name = at.name();
      if (gray && name != "R") continue;
      Grid grid;
      grid.name = file.parts() > 1 && header.hasName() ? header.name() + "." + at.name() : at.name();
      grid.type_name = type_name_of(at.channel().type);
      grid.sample_type = sample_type_of(at.channel().type);
      grid.dims = {width_of(window), height_of(window), 1};
      if (at.channel().xSampling != 1 || at.channel().ySampling != 1) {
        grid.sample_type = ISOEXTRACT_NOT_SCALAR;
        grid.type_name += ", at every " + std::to_string(at.channel().xSampling) + " x " +
                          std::to_string(at.channel().ySampling) + " pixels";
      }
      grid.has_placement = window.min != Imath::V2i(0, 0);
      grid.index_to_world[3] = window.min.x;
      grid.index_to_world[7] = window.min.y;
      grids.push_back(std::move(grid));
      sources_.push_back({part, at.name(), gray});
    }
    if (gray) {
      add_note(std::string("R, G and B are equal") + (channel_of(header, "A") != nullptr ? ", and A is 1" : "") +
               ": the reader makes one grid of them");
    }
  }

  static bool decide_gray(Imf::MultiPartInputFile& file, const RgbRule& rule, const isoextract_plugin_host& host) {
    if (rule.equal) return *rule.equal;
    if (!is_gray(file, host)) return false;
    return std::ranges::all_of(rule.compared, [&](const std::string& path) {
      return with_exr_errors(path, [&] {
        Imf::MultiPartInputFile other(path.c_str(), 0, false);
        return other.parts() == 1 && is_plain_rgb(other.header(0)) && is_gray(other, host);
      });
    });
  }

  ReadFacts read_channel(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) const {
    const Source& source = sources_[selection.grid];
    const Grid& grid = grids[selection.grid];
    Imf::MultiPartInputFile file(path_.c_str(), 0, false);
    if (source.part >= file.parts()) throw ReadError("the file changed during the run");
    const Imf::Header& header = file.header(source.part);
    const Imf::Channel* channel = channel_of(header, source.channel);
    if (channel == nullptr || sample_type_of(channel->type) != grid.sample_type ||
        width_of(header.dataWindow()) != grid.dims[0] || height_of(header.dataWindow()) != grid.dims[1]) {
      throw ReadError("the file changed during the run");
    }
    Imf::InputPart part(file, source.part);
    const std::uint64_t size = sample_size(grid.sample_type);
    const std::uint64_t rows = std::min(rows_per_block(header, size), selection.count[1]);
    const std::uint64_t row_bytes = grid.dims[0] * size;
    HostMemory memory(host);
    memory.take(2 * rows * row_bytes);
    std::vector<char> block(rows * row_bytes);
    std::vector<char> other(source.is_gray ? block.size() : 0);
    char* to = static_cast<char*>(selection.box);
    bool differs = false;
    for (std::uint64_t y = 0; y < selection.count[1]; y += rows) {
      check_cancelled(host);
      const std::uint64_t count = std::min(rows, selection.count[1] - y);
      const auto read = [&](const std::string& name, std::vector<char>& into) {
        read_rows(header, part, name, channel->type, selection.first[1] + y, count, into.data());
      };
      read(source.channel, block);
      for (std::uint64_t row = 0; row < count; ++row, to += selection.count[0] * size) {
        std::memcpy(to, block.data() + row * row_bytes + selection.first[0] * size, selection.count[0] * size);
      }
      for (const char* name : {"G", "B"}) {
        if (!source.is_gray || differs) break;
        read(name, other);
        differs = std::memcmp(block.data(), other.data(), count * row_bytes) != 0;
      }
    }
    ReadFacts facts;
    if (differs)
      facts.note = "R, G and B differ, unlike those of the first, the middle and the last slice: the samples are R";
    return facts;
  }

  void add_note(const std::string& text) { note += (note.empty() ? "" : "; ") + text; }

  std::string path_;
  std::vector<Source> sources_;  // of each grid
};

}  // namespace

bool is_exr(const unsigned char* start, std::size_t bytes) { return starts_with(start, bytes, "\x76\x2f\x31\x01"); }

std::unique_ptr<VolumeFile> open_exr(const std::string& path, const RgbRule& rule, const isoextract_plugin_host& host) {
  return std::make_unique<ExrFile>(path, rule, host);
}

}  // namespace isoextract_plugin
