// VTK's XML files: their elements, and the numbers of their arrays, which are read here at offsets, straight into the
// samples' memory. VTK parses the XML and decompresses blocks; sizes are checked here, because VTK trusts them.
// Format: "VTK File Formats", https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
#pragma once

#include <string>
#include <vector>

#include <vtkDataCompressor.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include "vtk_volume.hpp"

namespace isoextract_vtk {

// Returns an attribute of an element; "" if it has none.
std::string attribute_of(vtkXMLDataElement* element, const char* name);
// Returns the children of this name, in order.
std::vector<vtkXMLDataElement*> children_of(vtkXMLDataElement* element, const char* name);

// Returns the type of an XML data array from the type's name, such as "Float32"; not scalar for "String" and others.
StoredType xml_type(const std::string& name);

// A parsed file. The element <VTKFile type="TYPE"> has one child named TYPE.
class XmlDocument {
 public:
  explicit XmlDocument(const std::string& path);
  XmlDocument(const XmlDocument&) = delete;
  XmlDocument& operator=(const XmlDocument&) = delete;
  ~XmlDocument() = default;

  [[nodiscard]] std::string type() const;
  [[nodiscard]] vtkXMLDataElement* root() const;  // <VTKFile>
  [[nodiscard]] vtkXMLDataElement* body() const;  // the child; throws unless there is exactly one
  [[nodiscard]] bool swap() const { return swap_; }

  // Reads `count` numbers of a DataArray element from number `first`, as they are stored (text is parsed).
  void read_numbers(vtkXMLDataElement* array, StoredType type, std::uint64_t first, std::uint64_t count, void* to,
                    const isoextract_plugin_host& host);
  // Returns whether to_native() must swap bytes: if the file has the other byte order, and the numbers are not text.
  [[nodiscard]] bool swaps(vtkXMLDataElement* array) const;

 private:
  // Location of an array's bytes in the file and, if the array is compressed, of its blocks.
  struct Stored {
    vtkXMLDataElement* array = nullptr;
    std::uint64_t at = 0;  // of the data, in the file
    bool base64 = false;
    std::uint64_t bytes = 0;  // of all its numbers
    std::uint64_t block_bytes = 0;
    std::vector<std::uint64_t> block_at;  // offset of each compressed block from `at`, then the end of the last block
    std::vector<char> block;              // the block that was decompressed last
    std::size_t block_number = static_cast<std::size_t>(-1);
    std::vector<char> parsed;  // of text
  };
  const Stored& find(vtkXMLDataElement* array, const isoextract_plugin_host& host);
  void find_blocks(std::uint64_t at, const isoextract_plugin_host& host);
  void parse_text(std::uint64_t at, StoredType type, const isoextract_plugin_host& host);
  void read_decoded(std::uint64_t at, bool base64, std::uint64_t first, std::uint64_t bytes, char* to) const;
  [[nodiscard]] std::uint64_t header_word(const char* bytes) const;
  void read_blocks(std::uint64_t first, std::uint64_t bytes, char* to);

  InputFile file_;
  vtkSmartPointer<vtkXMLDataParser> parser_;
  vtkSmartPointer<vtkDataCompressor> compressor_;
  std::uint64_t word_bytes_ = 4;  // of the headers before binary data
  bool swap_ = false;
  bool appended_base64_ = true;
  Stored stored_;  // of the array that was read last
};

}  // namespace isoextract_vtk
