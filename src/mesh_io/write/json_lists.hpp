// The lists of a large JSON document as text, filled from small documents: a few hundred bytes a frame, where a tree of
// values would take several times that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace isoextract::mesh_io {

class JsonLists {
 public:
  // Each list of the document goes to the end of the list of its name; of texts (names of extensions) each is kept
  // once, and so is what is no list.
  void add(const nlohmann::json& document);
  // One more entry; its number.
  std::size_t add(const std::string& list, std::string_view entry);

  // Of the whole text, at most a few bytes a list too much.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  // The whole text; nothing is left here.
  [[nodiscard]] std::string take();

 private:
  struct List {
    std::string text;  // without the brackets
    std::size_t count = 0;
  };

  std::map<std::string, List> lists_;
  std::map<std::string, std::string> others_;
  std::uint64_t bytes_ = 2;  // the braces
};

}  // namespace isoextract::mesh_io
