#include "base/error.hpp"

namespace isoextract {

Hint::Hint(std::string words) {
  if (!words.empty()) steps.emplace_back(std::move(words));
}

Hint::Hint(Remedy remedy, Setting setting, std::string text) { steps.emplace_back(remedy, setting, std::move(text)); }

}  // namespace isoextract
