// Finds a patient's name, identities and date of birth in texts, so that no text for the user contains them.
#pragma once

#include <string>
#include <vector>

#include <gdcmDataSet.h>

namespace isoextract_dicom {

class Patient {
 public:
  // character_set: Specific Character Set of the file.
  Patient(const gdcm::DataSet& data, const std::string& character_set);

  // Returns whether a UTF-8 text contains a word of a name, an identity of at least three characters, or the date of
  // birth with year, day or month first. Ignores case, and separators in dates. Finds names of two ASCII letters only
  // as separate words, and no initials.
  [[nodiscard]] bool is_in(const std::string& text) const;

 private:
  std::vector<std::u32string> names_, identities_;  // lower case
  std::vector<std::u32string> dates_;               // eight digits
};

}  // namespace isoextract_dicom
