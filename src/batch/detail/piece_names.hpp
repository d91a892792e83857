// Names with a place for the numbers of pieces, which are known only once a surface is made: whether two of them could
// come to one name. Private to the names of outputs.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::batch {

class PieceNames {
 public:
  // Takes a name with convert::kPieceWord in it, of the output `owner`. The owner of one that was taken before and that
  // some numbers of pieces could make the same as this one, if there is any. Of digits beside a number only those
  // before it are looked at: never silent about two that could be the same.
  [[nodiscard]] std::optional<std::size_t> add(std::string_view name, std::size_t owner);

  // The owner of a name that some numbers of pieces could make this one.
  [[nodiscard]] std::optional<std::size_t> could_be(std::string_view file) const;

 private:
  struct Group {
    std::vector<bool> numbered;  // which runs of digits have a number in them; those of all of its names
    std::size_t owner = 0;       // of the first
    // By the digits that are no numbers, then those before the first number: none begins with another.
    std::map<std::string, std::size_t> owners;
  };
  std::map<std::string, Group> groups_;  // by what is no digit and no number
};

}  // namespace isoextract::batch
