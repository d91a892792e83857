#include <algorithm>
#include <cstring>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

// Attributes and tables that describe grids are short.
constexpr hssize_t kMostItems = 65536;
constexpr std::size_t kMostTextBytes = std::size_t{1} << 20;

// The innermost reason on the library's stack of errors.
std::string library_reason() {
  std::string reason;
  const auto take = [](unsigned /*n*/, const H5E_error2_t* error, void* to) -> herr_t {
    auto& text = *static_cast<std::string*>(to);
    if (text.empty() && error->desc != nullptr) {
      try {
        text = error->desc;
      } catch (const std::exception&) {
        return -1;
      }
    }
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "HDF5 gives no reason" : reason;
}

std::optional<Handle> find_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  return Handle(H5Aopen(object, name, H5P_DEFAULT), std::string("HDF5 cannot open its attribute ") + name);
}

// Rejects larger number types, which only damaged files have: the library overruns its buffers with them.
bool is_number(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return (kind == H5T_INTEGER && H5Tget_size(type) <= 8) || (kind == H5T_FLOAT && H5Tget_size(type) <= 16);
}

// Returns the number of items; 0 if there are more than kMostItems.
std::size_t count_items(hid_t space) {
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  return count > 0 && count <= kMostItems ? static_cast<std::size_t>(count) : 0;
}

}  // namespace

Handle::Handle(hid_t id, const std::string& what) : id_(id) {
  if (id < 0) throw ReadError(what + ": " + library_reason());
}

void check(herr_t status, const std::string& what) {
  if (status < 0) throw ReadError(what + ": " + library_reason());
}

H5O_type_t object_type(hid_t file, const std::string& path) {
  // Checks each group of the path first: the library fails if one is missing.
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (path != "/" && H5Lexists(file, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return H5O_TYPE_UNKNOWN;
    if (end == std::string::npos) break;
  }
  H5O_info_t info{};
  if (H5Oget_info_by_name2(file, path.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT) < 0) {
    H5Eclear2(H5E_DEFAULT);
    return H5O_TYPE_UNKNOWN;
  }
  return info.type;
}

std::optional<Handle> find_object(hid_t file, const std::string& path) {
  if (object_type(file, path) == H5O_TYPE_UNKNOWN) return std::nullopt;
  return Handle(H5Oopen(file, path.c_str(), H5P_DEFAULT), "HDF5 cannot open its object " + path);
}

std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto take = [](hid_t /*group*/, const char* name, const H5L_info_t* info, void* to) -> herr_t {
    if (info->type != H5L_TYPE_HARD) return 0;
    try {
      static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    } catch (const std::exception&) {
      return -1;
    }
    return 0;
  };
  check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names), "HDF5 cannot list one of its groups");
  return names;
}

std::vector<double> attribute_numbers(hid_t object, const char* name) {
  const auto attribute = find_attribute(object, name);
  if (!attribute) return {};
  const Handle type(H5Aget_type(*attribute), std::string("its attribute ") + name + " has no type");
  const Handle space(H5Aget_space(*attribute), std::string("its attribute ") + name + " has no size");
  std::vector<double> numbers(count_items(space));
  if (!is_number(type) || numbers.empty()) return {};
  check(H5Aread(*attribute, H5T_NATIVE_DOUBLE, numbers.data()), std::string("HDF5 cannot read its attribute ") + name);
  return numbers;
}

std::vector<std::string> attribute_texts(hid_t object, const char* name) {
  const auto attribute = find_attribute(object, name);
  if (!attribute) return {};
  const std::string what = std::string("HDF5 cannot read its attribute ") + name;
  const Handle type(H5Aget_type(*attribute), what);
  const Handle space(H5Aget_space(*attribute), what);
  const std::size_t count = count_items(space);
  if (H5Tget_class(type) != H5T_STRING || count == 0) return {};
  std::vector<std::string> texts;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> pointers(count, nullptr);
    check(H5Aread(*attribute, type, pointers.data()), what);
    for (const char* text : pointers) texts.emplace_back(text == nullptr ? "" : text);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    return texts;
  }
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > kMostTextBytes / count) return {};
  std::vector<char> letters(size * count);
  check(H5Aread(*attribute, type, letters.data()), what);
  for (std::size_t i = 0; i < count; ++i) {
    const char* const text = letters.data() + i * size;
    texts.emplace_back(text, strnlen(text, size));
  }
  return texts;
}

std::string attribute_text(hid_t object, const char* name) {
  std::string joined;
  for (const std::string& text : attribute_texts(object, name)) joined += text;
  return joined;
}

std::vector<double> dataset_numbers(hid_t file, const std::string& path) {
  if (object_type(file, path) != H5O_TYPE_DATASET) return {};
  const std::string what = "HDF5 cannot read its dataset " + path;
  const Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), what);
  const Handle type(H5Dget_type(dataset), what);
  const Handle space(H5Dget_space(dataset), what);
  std::vector<double> numbers(count_items(space));
  if (!is_number(type) || numbers.empty()) return {};
  check(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), what);
  return numbers;
}

}  // namespace isoextract_hdf5
