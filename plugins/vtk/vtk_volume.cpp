// The plug-in `vtk` for volumes: finds the format of an input, and opens the input with that format's reader.
#include "vtk_volume.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>

#include "vtk_messages.hpp"

namespace isoextract_vtk {
namespace {

using Open = Opened (*)(const Request&, const isoextract_plugin_host&);

// Returns the value of the attribute `type` of <VTKFile ...>; "" for other files.
std::string xml_file_type(std::string_view start) {
  const std::size_t tag = start.find("<VTKFile");
  if (tag == std::string_view::npos) return {};
  const std::string_view attributes = start.substr(tag, start.find('>', tag) - tag);
  const std::size_t key = attributes.find(" type=");
  if (key == std::string_view::npos || key + 7 >= attributes.size()) return {};
  const char quote = attributes[key + 6];
  return std::string(attributes.substr(key + 7, attributes.find(quote, key + 7) - key - 7));
}

Open xml_reader(const std::string& type) {
  if (type == "ImageData" || type == "PImageData") return open_xml_image;
  if (type == "Collection") return open_time_series;
  constexpr std::array<std::string_view, 10> others{
      "RectilinearGrid",      "PRectilinearGrid",         "StructuredGrid",    "PStructuredGrid",
      "UnstructuredGrid",     "PUnstructuredGrid",        "vtkOverlappingAMR", "vtkMultiBlockDataSet",
      "vtkNonOverlappingAMR", "vtkHierarchicalBoxDataSet"};
  return std::ranges::find(others, type) == others.end() ? nullptr : open_data_set;
}

// Lines of a legacy file: "# vtk DataFile Version", a title, ASCII or BINARY, DATASET TYPE.
bool is_legacy_grid(std::string_view start) {
  return start.starts_with("# vtk DataFile") &&
         std::ranges::any_of(std::array<std::string_view, 4>{"STRUCTURED_POINTS", "STRUCTURED_GRID", "RECTILINEAR_GRID",
                                                             "UNSTRUCTURED_GRID"},
                             [&](std::string_view type) {
                               return start.find("DATASET " + std::string(type)) != std::string_view::npos;
                             });
}

bool is_meta_image(std::string_view start) {
  return start.find("DimSize") != std::string_view::npos && start.find('=') != std::string_view::npos &&
         (start.starts_with("ObjectType") || start.find("ElementType") != std::string_view::npos);
}

Open reader_by_content(std::string_view start) {
  if (const std::string type = xml_file_type(start); !type.empty()) return xml_reader(type);
  if (is_legacy_grid(start)) return open_data_set;
  if (is_meta_image(start)) return open_meta_image;
  if (start.size() > 212 && start.substr(208, 3) == "MAP") return open_mrc;
  return nullptr;
}

Open reader_by_name(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".mrc" || extension == ".map" || extension == ".ccp4" || extension == ".rec" || extension == ".st") {
    return open_mrc;
  }
  if (extension == ".cube" || extension == ".cub") return open_cube;
  if (extension == ".mhd" || extension == ".mha") return open_meta_image;
  if (extension == ".dem") return open_dem;
  if (extension == ".foam") return open_data_set;
  if (extension == ".series") return open_time_series;
  return nullptr;
}

bool probe(const unsigned char* start, std::size_t bytes, const std::string& path) {
  const std::string_view text(reinterpret_cast<const char*>(start), bytes);
  return reader_by_content(text) != nullptr || reader_by_name(path) != nullptr;
}

}  // namespace

Opened open_volume(const Request& request, const isoextract_plugin_host& host) {
  silence_vtk();
  if (std::filesystem::is_directory(request.path)) return open_data_set(request, host);
  const std::string start = InputFile(request.path).text_at(0, 1024);
  Open open = reader_by_content(start);
  if (open == nullptr && start.find("<VTKFile") == std::string::npos) open = reader_by_name(request.path);
  if (open == nullptr) {
    throw ReadError(
        "expected image data, a grid of VTK, a MetaImage, an MRC map or a Gaussian cube, found another file" +
        (xml_file_type(start).empty() ? std::string() : " (VTK's type " + xml_file_type(start).substr(0, 40) + ")"));
  }
  return open(request, host);
}

}  // namespace isoextract_vtk

const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 table =
      isoextract_plugin::volume_plugin<isoextract_vtk::open_volume, isoextract_vtk::probe>("vtk", "VTK");
  return &table;
}
