// Names and colors of the meshes of labels.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

class LabelAppearance {
 public:
  // Takes the names of the job's table of labels if it has one, else those that the field's file states for `layer`.
  // Fails as LabelTable::read() does, and with ErrorCode::input if the table has changed since the job was made.
  [[nodiscard]] static Result<LabelAppearance> open(const ConversionJob& job, const field::ScalarField& field,
                                                    std::optional<std::int64_t> layer, const Context& context);

  // Returns the label's name, with its number if several labels share the name. For a label without a name, returns the
  // name `field` and the number.
  [[nodiscard]] std::string name(const std::string& field, std::int64_t label) const;

  // Returns the name that the table or the file gives the label, or an empty text.
  [[nodiscard]] std::string given_name(std::int64_t label) const;

  // Adds names of labels that no sample has, such as those of empty masks.
  void add_names_without_voxels(const std::vector<std::string>& names);

  // Returns all names: of labels of all layers, from the table or the file, and names added for labels without voxels.
  [[nodiscard]] std::vector<std::string> names() const;
  // Returns the named labels of all layers but this one.
  [[nodiscard]] std::vector<field::LabelName> of_other_layers() const;

  // Returns a note about named labels of this layer that are not among `found`, the labels in the samples. `in_region`:
  // the samples are only those of a region. The background does not count. `source` starts the text. Returns nothing if
  // no label is missing, or if the names come from a table.
  [[nodiscard]] std::optional<Note> note_of_missing(const std::string& source, const std::vector<std::int64_t>& found,
                                                    std::int64_t background, bool in_region) const;

  // Sets the label's color, from the table or the file or else a default color: in glTF as a material, in PLY as vertex
  // colors if the labels have names. Does nothing for other formats, or if the job colors by something else. Fails with
  // ErrorCode::out_of_memory.
  [[nodiscard]] Result<void> color(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                   const Context& context) const;

 private:
  [[nodiscard]] const field::LabelName* find(std::int64_t label) const;
  [[nodiscard]] bool is_here(const field::LabelName& entry) const { return !entry.layer || entry.layer == layer_; }

  // Fills by_label_ and shared_by_, because searching labels_ for each of 100,000 labels would be slow.
  void index();

  std::vector<field::LabelName> labels_;                    // with names, of all layers
  std::unordered_map<std::int64_t, std::size_t> by_label_;  // index in labels_ of the first entry of this layer
  std::unordered_map<std::string, std::size_t> shared_by_;  // number of entries with each name, in all layers
  std::vector<std::string> without_voxels_;                 // the added names
  std::optional<std::int64_t> layer_;
  bool has_table_ = false;  // a table may name any number of labels besides those of the map
};

}  // namespace isoextract::convert
