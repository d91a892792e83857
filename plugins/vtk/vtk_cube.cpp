// Gaussian cube files: densities, potentials and orbitals of quantum chemistry. Format: https://gaussian.com/cubegen.
// Values are text with z fastest; several orbitals are volumes. VTK's reader (vtkGaussianCubeReader) knows one only.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "vtk_volume.hpp"

namespace isoextract_vtk {
namespace {

constexpr std::uint64_t kPartBytes = 1 << 20;

// The words of a text file, one after another.
class TextWords {
 public:
  TextWords(const InputFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}

  // Returns the next word; "" at the end of the file.
  std::string_view next() {
    while (true) {
      while (at_ < part_.size() && is_space(part_[at_])) ++at_;
      std::size_t end = at_;
      while (end < part_.size() && !is_space(part_[end])) ++end;
      if (end < part_.size() || offset_ >= file_.size()) {
        const std::string_view word = std::string_view(part_).substr(at_, end - at_);
        at_ = end;
        return word;
      }
      part_.erase(0, at_);
      at_ = 0;
      if (part_.size() > 4096) throw ReadError("expected numbers, found a word of more than 4096 letters");
      const std::string more = file_.text_at(offset_, kPartBytes);
      offset_ += more.size();
      part_ += more;
    }
  }

  // Returns whether the file ends directly after the last word.
  [[nodiscard]] bool ended_in_word() const { return at_ == part_.size() && offset_ >= file_.size(); }
  // Returns the file offset of the text after the last word.
  [[nodiscard]] std::uint64_t offset() const { return offset_ - (part_.size() - at_); }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  const InputFile& file_;
  std::uint64_t offset_ = 0;
  std::string part_;
  std::size_t at_ = 0;
};

double number_in(const std::vector<std::string>& words, std::size_t index, const char* line) {
  const auto number = index < words.size() ? parse_number(words[index]) : std::nullopt;
  if (!number || !std::isfinite(*number)) {
    throw ReadError(std::string("expected a number in the line of ") + line + ", found '" +
                    (index < words.size() ? words[index].substr(0, 40) : "nothing") + "'");
  }
  return *number;
}

std::int64_t integer_in(const std::vector<std::string>& words, std::size_t index, const char* line) {
  const double number = number_in(words, index, line);
  if (number != std::floor(number) || std::abs(number) > 1e9) {
    throw ReadError(std::string("expected a whole number in the line of ") + line + ", found " +
                    words[index].substr(0, 40));
  }
  return static_cast<std::int64_t>(number);
}

class Cube final : public VolumeFile {
 public:
  explicit Cube(const Request& request) : file_(request.path) {
    format = "Gaussian cube";
    const std::string text = file_.text_at(0, 1 << 20);
    std::size_t at = 0;
    const auto next_line = [&] {
      const std::size_t end = text.find('\n', at);
      if (end == std::string::npos) throw ReadError("expected a header of atoms and axes, found the end of the text");
      std::string line = text.substr(at, end - at);
      at = end + 1;
      return line;
    };
    const std::string title = next_line();
    next_line();
    const auto first = words_of(next_line());
    const std::int64_t atoms = integer_in(first, 0, "the atoms");
    Grid grid;
    for (std::size_t world = 0; world < 3; ++world) {
      grid.index_to_world[4 * world + 3] = number_in(first, world + 1, "the origin");
    }
    const std::int64_t values = first.size() > 4 ? integer_in(first, 4, "the atoms") : 1;
    if (values < 1) throw ReadError("expected one or more values per point, found " + std::to_string(values));
    std::size_t negative = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto words = words_of(next_line());
      const std::int64_t count = integer_in(words, 0, "an axis");
      if (count == 0) throw ReadError("expected a number of points along each axis, found 0");
      negative += count < 0 ? 1 : 0;
      grid.dims[axis] = static_cast<std::uint64_t>(std::abs(count));
      for (std::size_t world = 0; world < 3; ++world) {
        grid.index_to_world[4 * world + axis] = number_in(words, world + 1, "an axis");
      }
    }
    if (negative != 0 && negative != 3) {
      throw ReadError("expected numbers of points of one sign (positive: bohr, negative: angstrom), found both signs");
    }
    grid.length_unit = negative == 0 ? "bohr" : "angstrom";
    for (std::int64_t atom = 0; atom < std::abs(atoms); ++atom) next_line();
    values_at_ = at;
    grid.components = static_cast<std::uint64_t>(values);
    if (atoms < 0) read_orbitals(grid);
    check_fits(file_, values_at_, {grid.dims[0], grid.dims[1], grid.dims[2], grid.volumes, grid.components}, 2);
    grid.sample_type = ISOEXTRACT_F32;
    grid.type_name = "float";
    const auto name_words = words_of(title);
    for (const std::string& word : name_words) creator += (creator.empty() ? "" : " ") + word;
    creator.resize(std::min<std::size_t>(creator.size(), 200));
    grids.push_back(std::move(grid));
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const Grid& grid = grids[0];
    const std::uint64_t per_point = grid.volumes * grid.components;
    const std::uint64_t count = grid.dims[0] * grid.dims[1] * grid.dims[2] * per_point;
    if (values_.empty()) {
      HostMemory memory(host);
      memory.take(count * sizeof(float));
      std::vector<float> values;
      values.reserve(count);
      TextWords words(file_, values_at_);
      while (values.size() < count) {
        if (values.size() % (std::size_t{1} << 16) == 0) isoextract_plugin::check_cancelled(host);
        const std::string_view word = words.next();
        const auto number = word.empty() ? std::nullopt : parse_number(word);
        if (!number) {
          throw ReadError("expected " + std::to_string(count) + " numbers, found '" + std::string(word.substr(0, 40)) +
                          "' after " + std::to_string(values.size()));
        }
        values.push_back(static_cast<float>(*number));
      }
      if (words.ended_in_word()) read_note_ = "the file ends without a line end: its last number may lack digits";
      values_ = std::move(values);
      memory.keep();
    }
    const auto step = static_cast<std::int64_t>(per_point);
    const auto z = static_cast<std::int64_t>(grid.dims[2]);
    const auto y = static_cast<std::int64_t>(grid.dims[1]);
    isoextract_plugin::fill_box(
        grid, {values_.data() + selection.volume * grid.components, {step * z * y, step * z, step}, 1}, selection);
    ReadFacts facts;
    facts.note = read_note_;
    return facts;
  }

 private:
  // Reads the number of orbitals and the orbitals' own numbers, which follow the atoms.
  void read_orbitals(Grid& grid) {
    TextWords words(file_, values_at_);
    const auto count = parse_integer(words.next());
    if (!count || *count < 1 || *count > 1000000)
      throw ReadError("expected a number of orbitals after the atoms, found none");
    std::string numbers;
    for (std::int64_t i = 0; i < *count; ++i) {
      const std::string_view word = words.next();
      const auto orbital = parse_integer(word);
      if (!orbital)
        throw ReadError("expected the numbers of " + std::to_string(*count) + " orbitals, found '" +
                        std::string(word.substr(0, 40)) + "'");
      if (i < 32) numbers += (i == 0 ? "" : ", ") + std::to_string(*orbital);
    }
    grid.volumes = static_cast<std::uint64_t>(*count);
    note = (*count > 1 ? "the volumes are the orbitals " : "the file has orbital ") + numbers +
           (*count > 32 ? ", ..." : "");
    values_at_ = words.offset();
  }

  InputFile file_;
  std::uint64_t values_at_ = 0;
  std::vector<float> values_;
  std::string read_note_;
};

}  // namespace

Opened open_cube(const Request& request, const isoextract_plugin_host& /*host*/) {
  return std::make_unique<Cube>(request);
}

}  // namespace isoextract_vtk
