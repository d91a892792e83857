#include "dicom_dataset.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>

#include <gdcmByteValue.h>
#include <gdcmItem.h>
#include <gdcmSequenceOfItems.h>

#include "dicom_structure.hpp"
#include "utf8.hpp"

namespace isoextract_dicom {
namespace {

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return nullptr;
  const gdcm::ByteValue* const bytes = data.GetDataElement(tag).GetByteValue();
  return bytes == nullptr || bytes->GetLength() == 0 ? nullptr : bytes;
}

template <class T>
std::vector<T> binary_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const gdcm::ByteValue* const bytes = bytes_of(data, tag);
  if (bytes == nullptr) return {};
  std::vector<T> values(bytes->GetLength() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes->GetPointer(), values.size() * sizeof(T));
  return values;
}

std::string to_utf8(const std::string& raw, const std::string& character_set) {
  const bool is_utf8 = character_set == "ISO_IR 192";
  const bool is_latin1 = character_set == "ISO_IR 100" || character_set == "ISO 2022 IR 100";
  std::string text;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const auto c = static_cast<unsigned char>(raw[i]);
    if (c < 0x20 || c == 0x7F) {
      text += ' ';
    } else if (c < 0x80) {
      text += raw[i];
    } else if (const std::size_t bytes = is_utf8 ? utf8_at(raw, i).bytes : 0; bytes > 0) {
      text.append(raw, i, bytes);
      i += bytes - 1;
    } else if (is_latin1 && c >= 0xA0) {
      text += static_cast<char>(0xC0U | (c >> 6U));
      text += static_cast<char>(0x80U | (c & 0x3FU));
    } else {
      text += '?';
    }
  }
  return text;
}

}  // namespace

std::string text_of(const gdcm::DataSet& data, const gdcm::Tag& tag, const std::string& character_set) {
  const gdcm::ByteValue* const bytes = bytes_of(data, tag);
  if (bytes == nullptr) return {};
  std::string raw(bytes->GetPointer(), bytes->GetLength());
  raw.resize(std::min(raw.size(), raw.find('\0')));
  constexpr const char* kPadding = " \t\r\n";
  const std::size_t first = raw.find_first_not_of(kPadding);
  if (first == std::string::npos) return {};
  raw = raw.substr(first, raw.find_last_not_of(kPadding) - first + 1);
  return to_utf8(raw, character_set);
}

std::vector<double> decimals_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const std::string text = text_of(data, tag);
  std::vector<double> values;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\\', at), text.size());
    std::string word = text.substr(at, end - at);
    std::erase(word, ' ');
    if (word.starts_with('+')) word.erase(0, 1);
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || stop != word.data() + word.size() || !std::isfinite(value)) return {};
    values.push_back(value);
    at = end + 1;
  }
  return values;
}

std::optional<double> decimal_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const auto values = decimals_of(data, tag);
  return values.empty() ? std::nullopt : std::optional(values.front());
}

std::vector<std::uint32_t> uint16s_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const auto values = binary_of<std::uint16_t>(data, tag);
  return {values.begin(), values.end()};
}

std::optional<std::uint32_t> uint16_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const auto values = binary_of<std::uint16_t>(data, tag);
  return values.empty() ? std::nullopt : std::optional<std::uint32_t>(values.front());
}

std::optional<std::uint32_t> uint32_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const auto values = binary_of<std::uint32_t>(data, tag);
  return values.empty() ? std::nullopt : std::optional(values.front());
}

std::optional<double> double_of(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  const auto values = binary_of<double>(data, tag);
  return values.empty() || !std::isfinite(values.front()) ? std::nullopt : std::optional(values.front());
}

std::optional<double> seconds_of(const std::string& time) {
  // HHMMSS.FFFFFF, from the ninth character on of a date and time.
  const std::string text = time.size() >= 14 && time.find('.') != 6 ? time.substr(8) : time;
  const auto two = [&](std::size_t at) -> std::optional<int> {
    int value = 0;
    if (text.size() < at + 2) return std::nullopt;
    const auto [stop, error] = std::from_chars(text.data() + at, text.data() + at + 2, value);
    return error == std::errc() && stop == text.data() + at + 2 ? std::optional(value) : std::nullopt;
  };
  const auto hours = two(0);
  const auto minutes = two(2);
  const auto seconds = two(4);
  if (!hours || !minutes || !seconds) return std::nullopt;
  double fraction = 0;
  if (text.size() > 7 && text[6] == '.') {
    const std::string digits = "0." + text.substr(7, text.find_first_not_of("0123456789", 7) - 7);
    std::from_chars(digits.data(), digits.data() + digits.size(), fraction);
  }
  return *hours * 3600.0 + *minutes * 60.0 + *seconds + fraction;
}

Items::Items(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return;
  const gdcm::DataElement& element = data.GetDataElement(tag);
  if (const gdcm::ByteValue* bytes = element.GetByteValue()) {
    if (element.GetVR() != gdcm::VR::INVALID && element.GetVR() != gdcm::VR::UN) {
      std::ostringstream name;
      name << tag << ", found one of the type " << element.GetVR();
      throw ReadError("expected a sequence as the attribute " + name.str() + ": the header is damaged");
    }
    check_items(std::string(bytes->GetPointer(), bytes->GetLength()));
  }
  items_ = element.GetValueAsSQ();
}

std::size_t Items::size() const { return items_ == nullptr ? 0 : items_->GetNumberOfItems(); }

const gdcm::DataSet& Items::operator[](std::size_t index) const {
  return items_->GetItem(index + 1).GetNestedDataSet();
}

}  // namespace isoextract_dicom
