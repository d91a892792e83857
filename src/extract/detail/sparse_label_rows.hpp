// Reads the samples of a sparse label map, chunk by chunk.
#pragma once

#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/detail/label_parts.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::extract {

class SparseLabelRows {
 public:
  // Chunks in chunk_order(), with the reservation of the list.
  struct Chunks {
    std::vector<glm::ivec3> origins;
    Reservation memory;
  };

  // Reads `samples`, those of `field`, in `region`; both must outlive this object. `what` starts the message of
  // ErrorCode::out_of_memory.
  [[nodiscard]] static Result<SparseLabelRows> make(const field::ScalarField& field,
                                                    const field::SparseSamples& samples, const field::IndexBox& region,
                                                    const Context& context, const std::string& what);

  [[nodiscard]] const field::SparseLookup& lookup() const { return lookup_; }

  // Returns the chunks in which labels may have faces (sparse_chunks()). Only large tiles have labels elsewhere. Fails
  // with ErrorCode::out_of_memory.
  [[nodiscard]] Result<Chunks> chunks(const Context& context) const;

  // Returns a reader for one thread, which must not outlive this object. T is the sample type.
  template <class T>
  [[nodiscard]] SparseRows<T> rows() const {
    return {samples_, lookup_, region_};
  }

 private:
  SparseLabelRows(const field::ScalarField& field, const field::SparseSamples& samples, const field::IndexBox& region,
                  const std::vector<glm::ivec3>& nodes, Reservation memory);

  const field::ScalarField& field_;
  const field::SparseSamples& samples_;
  field::IndexBox region_;
  Reservation memory_;  // of the lookup
  field::SparseLookup lookup_;
};

}  // namespace isoextract::extract
