#include "vtk_xml_data.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <map>

#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkZLibDataCompressor.h>

#include "vtk_messages.hpp"

namespace isoextract_vtk {

std::string attribute_of(vtkXMLDataElement* element, const char* name) {
  const char* value = element->GetAttribute(name);
  return value == nullptr ? std::string() : std::string(value);
}

std::vector<vtkXMLDataElement*> children_of(vtkXMLDataElement* element, const char* name) {
  std::vector<vtkXMLDataElement*> found;
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* child = element->GetNestedElement(i);
    if (child->GetName() != nullptr && std::strcmp(child->GetName(), name) == 0) found.push_back(child);
  }
  return found;
}

StoredType xml_type(const std::string& name) {
  using Wide = StoredType::Wide;
  static const std::map<std::string, StoredType> types{{"UInt8", {ISOEXTRACT_U8}},
                                                       {"Int8", {ISOEXTRACT_I8}},
                                                       {"UInt16", {ISOEXTRACT_U16}},
                                                       {"Int16", {ISOEXTRACT_I16}},
                                                       {"UInt32", {ISOEXTRACT_U32}},
                                                       {"Int32", {ISOEXTRACT_I32}},
                                                       {"Float32", {ISOEXTRACT_F32}},
                                                       {"Float64", {ISOEXTRACT_F64}},
                                                       {"Int64", {ISOEXTRACT_F64, Wide::i64}},
                                                       {"UInt64", {ISOEXTRACT_F64, Wide::u64}}};
  const auto found = types.find(name);
  return found == types.end() ? StoredType{} : found->second;
}

XmlDocument::XmlDocument(const std::string& path) : file_(path), parser_(vtkSmartPointer<vtkXMLDataParser>::New()) {
  vtk_messages().clear();
  std::ifstream stream(path, std::ios::binary);
  parser_->SetStream(&stream);
  parser_->SetIgnoreCharacterData(1);  // the text between tags is read later
  const bool parsed = parser_->Parse() != 0;
  parser_->SetStream(nullptr);
  if (!parsed || parser_->GetRootElement() == nullptr) {
    throw ReadError("expected XML of VTK, found an error in it" +
                    (vtk_messages().empty() ? std::string() : ": " + first_sentence(vtk_messages())));
  }
  vtkXMLDataElement* top = root();
  if (top->GetName() == nullptr || std::string(top->GetName()) != "VTKFile") {
    throw ReadError("expected the element VTKFile at the top, found another element");
  }
  swap_ = (attribute_of(top, "byte_order") == "BigEndian") != (std::endian::native == std::endian::big);
  if (attribute_of(top, "header_type") == "UInt64") word_bytes_ = 8;
  const std::string compressor = attribute_of(top, "compressor");
  if (compressor == "vtkZLibDataCompressor") {
    compressor_ = vtkSmartPointer<vtkZLibDataCompressor>::New();
  } else if (compressor == "vtkLZ4DataCompressor") {
    compressor_ = vtkSmartPointer<vtkLZ4DataCompressor>::New();
  } else if (compressor == "vtkLZMADataCompressor") {
    compressor_ = vtkSmartPointer<vtkLZMADataCompressor>::New();
  } else if (!compressor.empty()) {
    throw ReadError("expected compression by zlib, lz4 or lzma, found " + compressor.substr(0, 60));
  }
  const auto appended = children_of(top, "AppendedData");
  appended_base64_ = appended.empty() || attribute_of(appended[0], "encoding") != "raw";
}

std::string XmlDocument::type() const { return attribute_of(root(), "type"); }
vtkXMLDataElement* XmlDocument::root() const { return parser_->GetRootElement(); }

vtkXMLDataElement* XmlDocument::body() const {
  const auto bodies = children_of(root(), type().c_str());
  if (bodies.size() != 1)
    throw ReadError("expected one element " + type() + ", found " + std::to_string(bodies.size()));
  return bodies[0];
}

bool XmlDocument::swaps(vtkXMLDataElement* array) const { return swap_ && attribute_of(array, "format") != "ascii"; }

std::uint64_t XmlDocument::header_word(const char* bytes) const {
  std::array<char, 8> word{};
  std::copy_n(bytes, word_bytes_, word.begin());
  if (swap_) std::reverse(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(word_bytes_));
  if (word_bytes_ == 4) {
    std::uint32_t value = 0;
    std::memcpy(&value, word.data(), sizeof value);
    return value;
  }
  return std::bit_cast<std::uint64_t>(word);
}

namespace {

constexpr unsigned char kNotBase64 = 255;

const std::array<unsigned char, 256>& base64_values() {
  static const auto values = [] {
    std::array<unsigned char, 256> made{};
    made.fill(kNotBase64);
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < letters.size(); ++i) {
      made[static_cast<unsigned char>(letters[i])] = static_cast<unsigned char>(i);
    }
    return made;
  }();
  return values;
}

}  // namespace

// Reads the decoded bytes [first, first + bytes) of the raw or base64 data that begin at file offset `at`.
void XmlDocument::read_decoded(std::uint64_t at, bool base64, std::uint64_t first, std::uint64_t bytes,
                               char* to) const {
  if (!base64) {
    file_.read_at(at + first, to, bytes);
    return;
  }
  constexpr std::uint64_t kGroups = 1 << 16;
  const auto& values = base64_values();
  for (std::uint64_t done = 0; done < bytes;) {
    const std::uint64_t group = (first + done) / 3;
    const std::uint64_t skipped = (first + done) % 3;
    const std::string text = file_.text_at(at + group * 4, std::min(kGroups, (skipped + bytes - done + 2) / 3) * 4);
    std::uint64_t skip = skipped;
    for (std::size_t i = 0; i + 4 <= text.size() && done < bytes; i += 4) {
      std::array<unsigned char, 4> six{};
      std::uint64_t letters = 0;
      while (letters < 4) {
        six[letters] = values[static_cast<unsigned char>(text[i + letters])];
        if (six[letters] == kNotBase64) {
          six[letters] = 0;
          break;
        }
        ++letters;
      }
      const std::array<unsigned char, 3> three{static_cast<unsigned char>(six[0] << 2 | six[1] >> 4),
                                               static_cast<unsigned char>(six[1] << 4 | six[2] >> 2),
                                               static_cast<unsigned char>(six[2] << 6 | six[3])};
      const std::uint64_t held = letters == 0 ? 0 : letters - 1;
      for (std::uint64_t b = skip; b < 3 && done < bytes; ++b) {
        if (b >= held)
          throw ReadError("expected base64 of more bytes, found its end after " + std::to_string(first + done));
        to[done++] = static_cast<char>(three[b]);
      }
      skip = 0;
    }
    if (text.size() < 4) throw ReadError("expected base64 of more bytes, found the end of the file");
  }
}

const XmlDocument::Stored& XmlDocument::find(vtkXMLDataElement* array, const isoextract_plugin_host& host) {
  if (stored_.array == array) return stored_;
  stored_ = {};
  const std::string encoding = attribute_of(array, "format");
  std::uint64_t at = 0;
  if (encoding == "appended") {
    const auto offset = parse_integer(attribute_of(array, "offset"));
    const vtkTypeInt64 start = parser_->GetAppendedDataPosition();
    if (!offset || *offset < 0 || start <= 0) throw ReadError("expected an offset into the appended data, found none");
    at = static_cast<std::uint64_t>(start) + static_cast<std::uint64_t>(*offset);
    if (at > file_.size()) {
      throw ReadError("expected appended data at offset " + std::to_string(at) + ", found the end of the file at " +
                      std::to_string(file_.size()));
    }
    stored_.base64 = appended_base64_;
  } else {
    // The data follow the element's start tag.
    at = static_cast<std::uint64_t>(array->GetXMLByteIndex());
    const std::string text = file_.text_at(at, 1 << 16);
    char quote = 0;
    std::size_t i = 0;
    for (; i < text.size() && (quote != 0 || text[i] != '>'); ++i) {
      if (quote == 0 && (text[i] == '"' || text[i] == '\'')) {
        quote = text[i];
      } else if (text[i] == quote) {
        quote = 0;
      }
    }
    i = text.find_first_not_of(" \t\r\n", i + 1);
    if (i >= text.size()) throw ReadError("expected the numbers of an array, found none");
    at += i;
    stored_.base64 = true;
  }
  if (encoding == "ascii") {
    stored_.at = at;
  } else if (compressor_ != nullptr) {
    find_blocks(at, host);
  } else {
    std::array<char, 8> word{};
    read_decoded(at, stored_.base64, 0, word_bytes_, word.data());
    stored_.bytes = header_word(word.data());
    stored_.at = at;
  }
  stored_.array = array;
  return stored_;
}

void XmlDocument::find_blocks(std::uint64_t at, const isoextract_plugin_host& host) {
  std::vector<char> words(3 * word_bytes_);
  read_decoded(at, stored_.base64, 0, words.size(), words.data());
  const std::uint64_t count = header_word(words.data());
  const std::uint64_t bytes = header_word(words.data() + word_bytes_);
  const std::uint64_t last = header_word(words.data() + 2 * word_bytes_);
  if (count > file_.size() / word_bytes_ || bytes > (std::uint64_t{1} << 32) || last > bytes ||
      (count > 0 && bytes == 0)) {
    throw ReadError("expected compressed blocks that fit into the file, found " + std::to_string(count) + " of " +
                    std::to_string(bytes) + " bytes");
  }
  words.resize((3 + count) * word_bytes_);
  read_decoded(at, stored_.base64, 0, words.size(), words.data());
  stored_.block_at.assign(1, 0);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t size = header_word(words.data() + (3 + i) * word_bytes_);
    if (size > file_.size()) {
      throw ReadError("expected a compressed block that fits into the file, found one of " + std::to_string(size) +
                      " bytes");
    }
    stored_.block_at.push_back(stored_.block_at.back() + size);
  }
  HostMemory memory(host);
  memory.take(bytes);
  memory.keep();
  stored_.block_bytes = bytes;
  stored_.bytes = count * bytes - (last != 0 && count > 0 ? bytes - last : 0);
  stored_.at = at + (stored_.base64 ? (words.size() + 2) / 3 * 4 : words.size());
}

void XmlDocument::read_blocks(std::uint64_t first, std::uint64_t bytes, char* to) {
  while (bytes > 0) {
    const std::size_t number = first / stored_.block_bytes;
    const std::uint64_t in_block = first % stored_.block_bytes;
    const std::uint64_t size = std::min(stored_.block_bytes, stored_.bytes - number * stored_.block_bytes);
    if (stored_.block_number != number) {
      std::vector<char> compressed(stored_.block_at[number + 1] - stored_.block_at[number]);
      read_decoded(stored_.at, stored_.base64, stored_.block_at[number], compressed.size(), compressed.data());
      stored_.block.resize(size);
      stored_.block_number = static_cast<std::size_t>(-1);
      const std::size_t got =
          compressor_->Uncompress(reinterpret_cast<const unsigned char*>(compressed.data()), compressed.size(),
                                  reinterpret_cast<unsigned char*>(stored_.block.data()), size);
      if (got != size) {
        throw ReadError("expected " + std::to_string(size) + " bytes in compressed block " + std::to_string(number) +
                        ", found damaged data");
      }
      stored_.block_number = number;
    }
    const std::uint64_t part = std::min(bytes, size - in_block);
    std::memcpy(to, stored_.block.data() + in_block, part);
    first += part;
    to += part;
    bytes -= part;
  }
}

void XmlDocument::parse_text(std::uint64_t at, StoredType type, const isoextract_plugin_host& host) {
  std::string text;
  HostMemory memory(host);
  while (at < file_.size()) {
    isoextract_plugin::check_cancelled(host);
    const std::size_t before = stored_.parsed.size();
    std::string part = file_.text_at(at, 1 << 20);
    at += part.size();
    const std::size_t end = part.find('<');
    const bool ended = end != std::string::npos;
    text += part.substr(0, end);
    // A word at the end of a part goes on in the next.
    const std::size_t complete = ended || at >= file_.size() ? text.size() : text.find_last_of(" \t\r\n") + 1;
    for (const std::string& word : words_of(std::string_view(text).substr(0, complete))) {
      const auto append = [&](auto value) {
        const auto* bytes = reinterpret_cast<const char*>(&value);
        stored_.parsed.insert(stored_.parsed.end(), bytes, bytes + sizeof value);
      };
      const auto integer = parse_integer(word);
      const auto number = integer ? std::optional<double>(static_cast<double>(*integer)) : parse_number(word);
      if (!number) throw ReadError("expected numbers, found '" + word.substr(0, 40) + "'");
      // Keeps the bits of 64-bit integers; to_native() converts them to doubles.
      if (type.wide != StoredType::Wide::none) {
        if (!integer) throw ReadError("expected integers, found '" + word.substr(0, 40) + "'");
        append(*integer);
        continue;
      }
      isoextract_plugin::with_sample_type(type.sample_type, [&]<class T>(T) {
        if constexpr (std::is_integral_v<T>) {
          if (!integer || !std::in_range<T>(*integer)) {
            throw ReadError("expected integers in the range of their type, found '" + word.substr(0, 40) + "'");
          }
          append(static_cast<T>(*integer));
        } else {
          append(static_cast<T>(*number));
        }
      });
    }
    memory.take(stored_.parsed.size() - before);
    text.erase(0, complete);
    if (ended) break;
  }
  memory.keep();
  stored_.bytes = stored_.parsed.size();
}

void XmlDocument::read_numbers(vtkXMLDataElement* array, StoredType type, std::uint64_t first, std::uint64_t count,
                               void* to, const isoextract_plugin_host& host) {
  find(array, host);
  if (attribute_of(array, "format") == "ascii" && stored_.parsed.empty()) parse_text(stored_.at, type, host);
  const std::uint64_t size = type.bytes();
  if (first + count > stored_.bytes / size) {
    throw ReadError("expected " + std::to_string(first + count) + " or more numbers in the array " +
                    attribute_of(array, "Name").substr(0, 60) + ", found " + std::to_string(stored_.bytes / size));
  }
  if (!stored_.parsed.empty()) {
    std::memcpy(to, stored_.parsed.data() + first * size, count * size);
  } else if (compressor_ != nullptr) {
    read_blocks(first * size, count * size, static_cast<char*>(to));
  } else {
    read_decoded(stored_.at, stored_.base64, word_bytes_ + first * size, count * size, static_cast<char*>(to));
  }
}

}  // namespace isoextract_vtk
