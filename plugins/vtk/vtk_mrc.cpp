// MRC2014 and CCP4 maps (.mrc, .map, .ccp4). A. Cheng et al.: MRC2014: Extensions to the MRC format header for electron
// cryo-microscopy and tomography. J. Struct. Biol. 192, 2015. VTK's reader ignores axis order, cell angles and origin.
// Samples keep the order of the file (columns, rows, sections); the placement maps them to x, y and z.
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "vtk_volume.hpp"

namespace isoextract_vtk {
namespace {

constexpr std::uint64_t kHeaderBytes = 1024;
// Indices of 32-bit words in the header.
constexpr std::size_t kSize = 0, kMode = 3, kStart = 4, kSampling = 7, kCell = 10, kAngles = 13, kAxes = 16,
                      kSpaceGroup = 22, kExtended = 23, kImodStamp = 38, kImodFlags = 39, kOrigin = 49, kMap = 52;
constexpr std::int32_t kImod = 1146047817;

class Words {
 public:
  explicit Words(const InputFile& file) {
    file.read_at(0, words_.data(), kHeaderBytes);
    swap_ = !is_plausible();
    if (!swap_) return;
    for (std::uint32_t& word : words_) word = __builtin_bswap32(word);
    if (!is_plausible()) throw ReadError("expected the header of an MRC map, found a wrong mode or axis order in it");
  }
  [[nodiscard]] std::int32_t integer(std::size_t at) const { return std::bit_cast<std::int32_t>(words_[at]); }
  [[nodiscard]] double number(std::size_t at) const { return std::bit_cast<float>(words_[at]); }
  [[nodiscard]] bool swap() const { return swap_; }

 private:
  // The machine stamp is often wrong; mode and axes are small numbers in only one byte order.
  [[nodiscard]] bool is_plausible() const {
    bool axes = true;
    for (std::size_t i = kAxes; i < kAxes + 3; ++i) axes = axes && integer(i) >= 0 && integer(i) <= 3;
    return axes && integer(kMode) >= 0 && integer(kMode) < 256;
  }
  std::array<std::uint32_t, kHeaderBytes / 4> words_{};
  bool swap_ = false;
};

// Returns the cell's axes a, b and c in angstrom. a is along x, b in the plane of x and y.
std::array<std::array<double, 3>, 3> cell_axes(const std::array<double, 3>& length, std::array<double, 3> angle) {
  std::array<double, 3> cosine{};
  for (std::size_t i = 0; i < 3; ++i) {
    cosine[i] = angle[i] == 90 ? 0 : std::cos(angle[i] * std::numbers::pi / 180);
  }
  const double sine = std::sqrt(1 - cosine[2] * cosine[2]);
  const double cx = cosine[1];
  const double cy = (cosine[0] - cosine[1] * cosine[2]) / sine;
  const double cz_squared = 1 - cx * cx - cy * cy;
  if (!(sine > 0 && cz_squared > 0)) {
    throw ReadError("expected the angles of a unit cell, found " + printed(angle[0]) + ", " + printed(angle[1]) +
                    " and " + printed(angle[2]) + " degrees");
  }
  return {{{length[0], 0, 0},
           {length[1] * cosine[2], length[1] * sine, 0},
           {length[2] * cx, length[2] * cy, length[2] * std::sqrt(cz_squared)}}};
}

class Map final : public VolumeFile {
 public:
  explicit Map(const Request& request) : file_(request.path) {
    const Words words(file_);
    format = words.integer(kMap) == std::bit_cast<std::int32_t>(std::array{'M', 'A', 'P', ' '}) ||
                     file_.text_at(kMap * 4, 4) == "MAP "
                 ? "MRC map"
                 : "MRC map (before 2000)";
    swap_ = words.swap();
    Grid grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t size = words.integer(kSize + axis);
      if (size < 1)
        throw ReadError("expected positive numbers of columns, rows and sections, found " + std::to_string(size));
      grid.dims[axis] = static_cast<std::uint64_t>(size);
    }
    // A stack of volumes: each volume has MZ sections, the sampling along z.
    const std::int32_t sections = words.integer(kSampling + 2);
    if (words.integer(kSpaceGroup) >= 401 && sections > 0 && grid.dims[2] % static_cast<std::uint64_t>(sections) == 0) {
      grid.volumes = grid.dims[2] / static_cast<std::uint64_t>(sections);
      grid.dims[2] = static_cast<std::uint64_t>(sections);
    }
    set_type(words, grid);
    const std::int32_t extended = words.integer(kExtended);
    if (extended < 0)
      throw ReadError("expected a header of 1024 bytes or more, found an extension of " + std::to_string(extended));
    offset_ = kHeaderBytes + static_cast<std::uint64_t>(extended);
    check_fits(file_, offset_, {grid.dims[0], grid.dims[1], grid.dims[2], grid.volumes}, type_.bytes());
    place(words, grid);
    grids.push_back(std::move(grid));
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const Grid& grid = grids[0];
    const std::uint64_t volume = selection.volume * grid.dims[0] * grid.dims[1] * grid.dims[2];
    fill_from_stored(
        grid, {{}, grid.dims, type_, swap_},
        [&](std::uint64_t first, std::uint64_t count, void* to) {
          file_.read_at(offset_ + (volume + first) * type_.bytes(), to, count * type_.bytes());
        },
        selection, host);
    ReadFacts facts;
    facts.parts_read = selection.count[2];
    facts.parts = grid.dims[2];
    return facts;
  }

 private:
  void set_type(const Words& words, Grid& grid) {
    switch (const std::int32_t mode = words.integer(kMode)) {
      case 0:
        // IMOD's files state whether bytes are signed; MRC2014 defines them as signed.
        if (words.integer(kImodStamp) == kImod && (words.integer(kImodFlags) & 1) == 0) {
          type_ = {ISOEXTRACT_U8};
          grid.type_name = "uint8";
        } else {
          type_ = {ISOEXTRACT_I8};
          grid.type_name = "int8";
        }
        break;
      case 1: type_ = {ISOEXTRACT_I16}, grid.type_name = "int16"; break;
      case 2: type_ = {ISOEXTRACT_F32}, grid.type_name = "float"; break;
      case 6: type_ = {ISOEXTRACT_U16}, grid.type_name = "uint16"; break;
      case 12: type_ = {ISOEXTRACT_F16}, grid.type_name = "half"; break;
      case 3:
      case 4:
        throw ReadError("expected a map in real space, found Fourier coefficients (mode " + std::to_string(mode) + ")");
      default: throw ReadError("expected mode 0, 1, 2, 6 or 12, found mode " + std::to_string(mode));
    }
    grid.sample_type = type_.sample_type;
  }

  void add_note(const std::string& text) { note += (note.empty() ? "" : "; ") + text; }

  void place(const Words& words, Grid& grid) {
    std::array<double, 3> length{};
    std::array<double, 3> angle{};
    std::array<double, 3> origin{};
    std::array<std::size_t, 3> axis_of{};  // of columns, rows and sections
    bool has_origin = false;
    bool has_start = false;
    bool has_cell = true;
    unsigned seen = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      length[i] = words.number(kCell + i);
      has_cell = has_cell && std::isfinite(length[i]) && length[i] > 0 && words.integer(kSampling + i) > 0;
      angle[i] = words.number(kAngles + i);
      origin[i] = words.number(kOrigin + i);
      has_origin = has_origin || origin[i] != 0;
      has_start = has_start || words.integer(kStart + i) != 0;
      axis_of[i] = static_cast<std::size_t>(words.integer(kAxes + i)) - 1;
      if (axis_of[i] < 3) seen |= 1U << axis_of[i];
    }
    if (seen != 7) {
      const bool unset = words.integer(kAxes) == 0 && words.integer(kAxes + 1) == 0 && words.integer(kAxes + 2) == 0;
      if (!unset)
        throw ReadError("expected the axes 1, 2 and 3 in MAPC, MAPR and MAPS, each once, found other numbers");
      axis_of = {0, 1, 2};
      add_note("the header has no axis order: the reader assumes columns along x, rows along y, sections along z");
    }
    if (angle[0] == 0 && angle[1] == 0 && angle[2] == 0) {
      angle = {90, 90, 90};
      add_note("the header has no cell angles: the reader assumes 90 degrees");
    }
    grid.has_placement = has_cell;
    if (!has_cell) {
      add_note("the header has no cell size: the reader assumes voxels of size 1");
      for (std::size_t i = 0; i < 3; ++i) length[i] = std::max(1, words.integer(kSampling + i));
    } else {
      grid.length_unit = "angstrom";
    }
    const auto cell = cell_axes(length, angle);
    if (has_origin && !(std::isfinite(origin[0]) && std::isfinite(origin[1]) && std::isfinite(origin[2]))) {
      throw ReadError("expected a finite origin, found infinity or NaN");
    }
    if (has_origin && has_start) {
      add_note("the header has an origin and start indices: the reader takes the origin");
    }
    grid.index_to_world.fill(0);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t axis = axis_of[i];
      const double steps = std::max(1, words.integer(kSampling + axis));
      for (std::size_t world = 0; world < 3; ++world) {
        const double step = cell[axis][world] / steps;
        grid.index_to_world[4 * world + i] = step;
        if (!has_origin) grid.index_to_world[4 * world + 3] += step * words.integer(kStart + i);
      }
    }
    for (std::size_t world = 0; has_origin && world < 3; ++world) grid.index_to_world[4 * world + 3] = origin[world];
  }

  InputFile file_;
  StoredType type_;
  bool swap_ = false;
  std::uint64_t offset_ = 0;
};

}  // namespace

Opened open_mrc(const Request& request, const isoextract_plugin_host& /*host*/) {
  return std::make_unique<Map>(request);
}

}  // namespace isoextract_vtk
