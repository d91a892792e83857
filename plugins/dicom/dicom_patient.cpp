#include "dicom_patient.hpp"

#include <algorithm>
#include <array>
#include <cwctype>
#include <string_view>
#include <utility>

#include <locale.h>

#include "dicom_dataset.hpp"
#include "utf8.hpp"

namespace isoextract_dicom {
namespace {

// Converts letters of all scripts, whatever the locale of the process; only ASCII letters if the system lacks C.UTF-8.
char32_t to_lower(char32_t c) {
  static const locale_t locale = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  if (locale != nullptr) return static_cast<char32_t>(towlower_l(static_cast<std::wint_t>(c), locale));
  return c >= U'A' && c <= U'Z' ? c + 32 : c;
}

// text: valid UTF-8, as text_of() returns.
std::u32string lower_case(const std::string& text) {
  std::u32string result;
  for (std::size_t at = 0; at < text.size();) {
    const Utf8Character character = utf8_at(text, at);
    result += to_lower(character.code);
    at += std::max<std::size_t>(character.bytes, 1);
  }
  return result;
}

bool is_word_character(char32_t c) { return c >= 0x80 || (c >= U'0' && c <= U'9') || (c >= U'a' && c <= U'z'); }

// Appends the words of a text, split at `separators`.
void add_words(const std::string& text, std::u32string_view separators, std::vector<std::u32string>& words) {
  std::u32string word;
  for (const char32_t c : lower_case(text) + separators.front()) {
    if (separators.find(c) == std::u32string_view::npos) {
      word += c;
    } else if (!word.empty()) {
      words.push_back(std::exchange(word, {}));
    }
  }
}

bool is_word_of(const std::u32string& text, const std::u32string& word) {
  for (std::size_t at = text.find(word); at != std::u32string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word_character(text[at - 1])) && (end == text.size() || !is_word_character(text[end])))
      return true;
  }
  return false;
}

// Elements of group 0010. Names: the patient's, other names, birth name, the mother's birth name. Identities: the
// patient's ID, other IDs.
constexpr std::array<std::uint16_t, 4> kNames{0x0010, 0x1001, 0x1005, 0x1060};
constexpr std::array<std::uint16_t, 2> kIdentities{0x0020, 0x1000};

}  // namespace

Patient::Patient(const gdcm::DataSet& data, const std::string& character_set) {
  const auto add = [&](const gdcm::DataSet& from, std::uint16_t element, std::u32string_view separators, auto& words) {
    add_words(text_of(from, gdcm::Tag(0x0010, element), character_set), separators, words);
  };
  for (const std::uint16_t element : kNames) add(data, element, U"^ =,\\-'.", names_);
  for (const std::uint16_t element : kIdentities) add(data, element, U"\\", identities_);
  // Newer files have a sequence of other patient IDs.
  const Items others(data, gdcm::Tag(0x0010, 0x1002));
  for (std::size_t i = 0; i < others.size(); ++i) add(others[i], 0x0020, U"\\", identities_);
  std::erase_if(names_, [](const auto& word) { return word.size() < 2; });
  std::erase_if(identities_, [](const auto& word) { return word.size() < 3; });
  const std::u32string born = lower_case(text_of(data, gdcm::Tag(0x0010, 0x0030)));
  if (born.size() != 8) return;
  const auto year = born.substr(0, 4), month = born.substr(4, 2), day = born.substr(6, 2);
  dates_ = {born, day + month + year, month + day + year};
}

bool Patient::is_in(const std::string& text) const {
  const std::u32string searched = lower_case(text);
  const auto contains = [](const std::u32string& all) {
    return [&all](const std::u32string& part) { return all.find(part) != std::u32string::npos; };
  };
  const auto names = [&](const std::u32string& word) {
    const bool is_short = word.size() < 3 && word.front() < 0x80;
    return is_short ? is_word_of(searched, word) : searched.find(word) != std::u32string::npos;
  };
  std::u32string digits = searched;
  std::erase_if(digits, [](char32_t c) { return std::u32string_view(U"-./ ").find(c) != std::u32string_view::npos; });
  return std::ranges::any_of(names_, names) || std::ranges::any_of(identities_, contains(searched)) ||
         std::ranges::any_of(dates_, contains(digits));
}

}  // namespace isoextract_dicom
