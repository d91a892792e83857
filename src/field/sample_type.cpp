#include "field/sample_type.hpp"

namespace isoextract::field {

std::size_t sample_size(SampleType type) {
  return visit_sample_type(type, []<class T>(std::type_identity<T>) { return sizeof(T); });
}

}  // namespace isoextract::field
