// The readers of the plug-in `vtk` for volumes, and their shared functions. "Fails" means: throws ReadError.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <volume_reader.hpp>

namespace isoextract_vtk {

using isoextract_plugin::Grid;
using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadError;
using isoextract_plugin::ReadFacts;
using isoextract_plugin::Request;
using isoextract_plugin::VolumeFile;
using Opened = std::unique_ptr<VolumeFile>;
using Dims = std::array<std::uint64_t, 3>;

// A file that is read at offsets; bounds are checked.
class InputFile {
 public:
  explicit InputFile(const std::string& path);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  [[nodiscard]] std::uint64_t size() const { return size_; }
  // Fails if the file ends before offset + bytes.
  void read_at(std::uint64_t offset, void* to, std::uint64_t bytes) const;
  // Returns the bytes from an offset up to `most`, fewer at the end of the file.
  [[nodiscard]] std::string text_at(std::uint64_t offset, std::uint64_t most) const;

 private:
  int handle_ = -1;
  std::uint64_t size_ = 0;
};

// How samples are stored. The plug-in interface has no 64-bit integers: they are converted to f64.
struct StoredType {
  enum class Wide { none, i64, u64 };
  std::int32_t sample_type = ISOEXTRACT_NOT_SCALAR;  // after conversion
  Wide wide = Wide::none;
  [[nodiscard]] std::uint64_t bytes() const { return isoextract_plugin::sample_size(sample_type); }
};
constexpr std::string_view kWideNote = "the reader makes doubles of 64-bit integers, exact up to 2^53";

// Converts samples in place: swaps bytes if `swap`, and turns 64-bit integers into doubles.
void to_native(StoredType type, bool swap, void* samples, std::uint64_t count);

// A box of samples in a file, x fastest and the components of a sample beside each other.
struct StoredBox {
  Dims first{};  // grid index of the box's first sample
  Dims dims{};
  StoredType type;
  bool swap = false;
};

// Reads the numbers first .. first + count - 1 of a stored box, without conversion.
using ReadNumbers = std::function<void(std::uint64_t first, std::uint64_t count, void* to)>;

// Fills the part of the selection that a stored box has. Reads slice by slice, and only the rows (in full) that are
// needed.
void fill_from_stored(const Grid& grid, const StoredBox& stored, const ReadNumbers& read,
                      const isoextract_volume_selection& selection, const isoextract_plugin_host& host);

// Returns the product, or nothing if it is larger than `limit`.
std::optional<std::uint64_t> product(const std::vector<std::uint64_t>& factors, std::uint64_t limit);

// Fails unless the product of `counts` is 1 or more, and so many numbers of `bytes` bytes fit into the file from the
// offset on.
void check_fits(const InputFile& file, std::uint64_t offset, const std::vector<std::uint64_t>& counts,
                std::uint64_t bytes);

// Returns the words of a text. Numbers may have a sign and Fortran's exponents (1.5D+02, 1.5-102).
std::vector<std::string> words_of(std::string_view text);
std::optional<double> parse_number(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);
std::string printed(double value);  // six significant digits

// Returns the path of the file `name` that the file `path` refers to. Fails for absolute names and names with "..".
std::string path_beside(const std::string& path, const std::string& name);

// Returns an open file of each format.
Opened open_meta_image(const Request& request, const isoextract_plugin_host& host);
Opened open_mrc(const Request& request, const isoextract_plugin_host& host);
Opened open_cube(const Request& request, const isoextract_plugin_host& host);
Opened open_dem(const Request& request, const isoextract_plugin_host& host);
Opened open_xml_image(const Request& request, const isoextract_plugin_host& host);    // .vti, .pvti
Opened open_data_set(const Request& request, const isoextract_plugin_host& host);     // by VTK's readers
Opened open_time_series(const Request& request, const isoextract_plugin_host& host);  // .pvd, .series
Opened open_volume(const Request& request, const isoextract_plugin_host& host);       // any of them

}  // namespace isoextract_vtk
