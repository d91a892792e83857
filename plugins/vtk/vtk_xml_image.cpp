// VTK's image data as XML: .vti, and .pvti with its pieces in other files.
#include <algorithm>

#include "vtk_lattice.hpp"
#include "vtk_xml_data.hpp"

namespace isoextract_vtk {
namespace {

// Returns the numbers of an attribute; nothing if the element has none. Fails if there are not `count`.
std::vector<double> numbers_in(vtkXMLDataElement* element, const char* name, std::size_t count) {
  const std::vector<std::string> words = words_of(attribute_of(element, name));
  std::vector<double> numbers;
  for (const std::string& word : words) {
    if (const auto number = parse_number(word); number && std::isfinite(*number)) numbers.push_back(*number);
  }
  if (!words.empty() && (numbers.size() != words.size() || words.size() != count)) {
    throw ReadError(std::string("expected ") + std::to_string(count) + " numbers in " + name + ", found '" +
                    attribute_of(element, name).substr(0, 80) + "'");
  }
  return numbers;
}

Extent extent_in(vtkXMLDataElement* element, const char* name) {
  const auto numbers = numbers_in(element, name, 6);
  if (numbers.empty()) throw ReadError(std::string("expected the attribute ") + name + ", found none");
  Extent extent{};
  for (std::size_t i = 0; i < 6; ++i) {
    if (numbers[i] != std::floor(numbers[i]) || std::abs(numbers[i]) > 4e9) {
      throw ReadError(std::string("expected whole numbers in ") + name + ", found '" +
                      attribute_of(element, name).substr(0, 80) + "'");
    }
    extent[i] = static_cast<std::int64_t>(numbers[i]);
  }
  return extent;
}

std::uint64_t components_of(vtkXMLDataElement* array) {
  const std::string text = attribute_of(array, "NumberOfComponents");
  if (text.empty()) return 1;
  const auto count = parse_integer(text);
  if (!count || *count < 1 || *count > 65536) {
    throw ReadError("expected NumberOfComponents = 1 or more, found '" + text.substr(0, 40) + "'");
  }
  return static_cast<std::uint64_t>(*count);
}

std::string component_names_of(vtkXMLDataElement* array, std::uint64_t components) {
  std::string names;
  for (std::uint64_t i = 0; i < components; ++i) {
    std::string name = attribute_of(array, ("ComponentName" + std::to_string(i)).c_str());
    if (name.empty()) return {};
    std::ranges::replace(name, ' ', '_');
    names += (i == 0 ? "" : " ") + name;
  }
  return names;
}

std::vector<ArrayFacts> arrays_of(vtkXMLDataElement* parent, const char* points, const char* cells, const char* element,
                                  std::string& note) {
  std::vector<ArrayFacts> arrays;
  for (const bool of_cells : {false, true}) {
    for (vtkXMLDataElement* data : children_of(parent, of_cells ? cells : points)) {
      for (vtkXMLDataElement* array : children_of(data, element)) {
        ArrayFacts facts;
        facts.name = attribute_of(array, "Name");
        if (is_ghost_array(facts.name)) {
          if (note.empty()) note = kGhostNote;
          continue;
        }
        facts.of_cells = of_cells;
        facts.type_name = attribute_of(array, "type");
        facts.type = xml_type(facts.type_name);
        facts.components = components_of(array);
        facts.component_names = component_names_of(array, facts.components);
        arrays.push_back(std::move(facts));
      }
    }
  }
  return arrays;
}

class XmlImage final : public Lattice {
 public:
  XmlImage(const Request& request, const isoextract_plugin_host& host) : path_(request.path) {
    auto document = std::make_unique<XmlDocument>(path_);
    parallel_ = document->type() == "PImageData";
    if (!parallel_ && document->type() != "ImageData") {
      throw ReadError("expected ImageData or PImageData, found " + document->type().substr(0, 40));
    }
    format = parallel_ ? "VTK image data (parallel)" : "VTK image data";
    vtkXMLDataElement* body = document->body();
    LatticeFrame frame;
    frame.extent = extent_in(body, "WholeExtent");
    const auto copy = [&](const char* name, auto& to) {
      const auto numbers = numbers_in(body, name, to.size());
      std::ranges::copy(numbers, to.begin());
      return !numbers.empty();
    };
    copy("Origin", frame.origin);
    const bool placed = copy("Spacing", frame.spacing);
    copy("Direction", frame.direction);
    const auto elements = children_of(body, "Piece");
    if (elements.empty()) throw ReadError("expected a Piece, found none");
    for (vtkXMLDataElement* piece : elements) {
      pieces_.push_back(
          extent_in(piece, parallel_ || !attribute_of(piece, "Extent").empty() ? "Extent" : "WholeExtent"));
      if (parallel_) {
        files.push_back(path_beside(path_, attribute_of(piece, "Source")));
      } else {
        elements_.push_back(piece);
      }
    }
    auto arrays = parallel_ ? arrays_of(body, "PPointData", "PCellData", "PDataArray", note)
                            : arrays_of(elements[0], "PointData", "CellData", "DataArray", note);
    if (arrays.empty()) throw ReadError("expected point or cell data, found none");
    set_grids(frame, std::move(arrays));
    for (Grid& grid : grids) grid.has_placement = placed;
    set_time(*document, body, host);
    documents_.resize(parallel_ ? files.size() : 1);
    if (!parallel_) documents_[0] = std::move(document);
  }

 protected:
  Source source(std::size_t piece, const ArrayFacts& facts, const isoextract_plugin_host& host) override {
    auto& document = documents_[parallel_ ? piece : 0];
    vtkXMLDataElement* element = nullptr;
    if (parallel_) {
      document = std::make_unique<XmlDocument>(files[piece]);
      const auto elements = children_of(document->body(), "Piece");
      if (elements.size() != 1 || extent_in(elements[0], "Extent") != pieces_[piece]) {
        throw ReadError("expected one piece of the extent that the .pvti file states in " +
                        files[piece].substr(files[piece].rfind('/') + 1) + ", found other pieces");
      }
      element = elements[0];
    } else {
      element = elements_[piece];
    }
    vtkXMLDataElement* found = nullptr;
    for (vtkXMLDataElement* data : children_of(element, facts.of_cells ? "CellData" : "PointData")) {
      for (vtkXMLDataElement* array : children_of(data, "DataArray")) {
        if (attribute_of(array, "Name") == facts.name) found = array;
      }
    }
    if (found == nullptr) throw ReadError("expected the array " + facts.name + " in each piece, found one without it");
    const StoredType type = xml_type(attribute_of(found, "type"));
    XmlDocument* from = document.get();
    return {type, from->swaps(found), components_of(found),
            [from, found, type, &host](std::uint64_t first, std::uint64_t count, void* to) {
              from->read_numbers(found, type, first, count, to, host);
            }};
  }

 private:
  // Some writers store the time of the data as field data.
  void set_time(XmlDocument& document, vtkXMLDataElement* body, const isoextract_plugin_host& host) {
    for (vtkXMLDataElement* data : children_of(body, "FieldData")) {
      for (vtkXMLDataElement* array : children_of(data, "DataArray")) {
        if (attribute_of(array, "Name") != "TimeValue" || attribute_of(array, "NumberOfTuples") != "1") continue;
        const StoredType type = xml_type(attribute_of(array, "type"));
        if (type.sample_type != ISOEXTRACT_F64 && type.sample_type != ISOEXTRACT_F32) continue;
        std::array<char, 8> bytes{};
        document.read_numbers(array, type, 0, 1, bytes.data(), host);
        to_native(type, document.swaps(array), bytes.data(), 1);
        double time = 0;
        isoextract_plugin::with_sample_type(type.sample_type, [&]<class T>(T value) {
          std::memcpy(&value, bytes.data(), sizeof value);
          time = static_cast<double>(value);
        });
        for (Grid& grid : grids) grid.volume_times = {time};
      }
    }
  }

  std::string path_;
  bool parallel_ = false;
  std::vector<std::unique_ptr<XmlDocument>> documents_;  // of each file; opened when its samples are read
  std::vector<vtkXMLDataElement*> elements_;             // the pieces of a .vti file
};

}  // namespace

Opened open_xml_image(const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<XmlImage>(request, host);
}

}  // namespace isoextract_vtk
