// What the meshes of labels are called, and how they look.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "mesh/mesh.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::convert {

class LabelLooks {
 public:
  // Reads the table of the job, where it has one. Fails as LabelTable::read() does, and with ErrorCode::input where the
  // file is no longer what it was when the job was made.
  [[nodiscard]] static Result<LabelLooks> open(const ConversionJob& job, const Context& context);

  // The name in the table, with the number where several have it; else that of the field, and the number.
  [[nodiscard]] std::string name(const std::string& field, std::int64_t label) const;

  // The colour in the table, or the usual one: of the material, and where the format has none but colours of vertices,
  // and there is a table, of these. Nothing where the job colours by something else. Fails with ErrorCode::input where
  // the memory is not there.
  [[nodiscard]] Result<void> colour(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                    const Context& context) const;

 private:
  std::optional<volume_io::LabelTable> table_;
};

}  // namespace isoextract::convert
