// Names and colors of the meshes of labels.
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

class LabelAppearance {
 public:
  // Reads the job's table of labels, if it has one. Fails as LabelTable::read() does, and with ErrorCode::input if the
  // file has changed since the job was made.
  [[nodiscard]] static Result<LabelAppearance> open(const ConversionJob& job, const Context& context);

  // Returns the label's name in the table, with the number if several labels share it; else the field's name and the
  // number.
  [[nodiscard]] std::string name(const std::string& field, std::int64_t label) const;

  // Sets the label's color, from the table or a default: in glTF as a material, in PLY as vertex colors if there is a
  // table. Does nothing for other formats, or if the job colors by something else. Fails with
  // ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> color(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                   const Context& context) const;

 private:
  std::optional<volume_io::LabelTable> table_;
};

}  // namespace isoextract::convert
