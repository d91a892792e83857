// The surface nets of all labels of a field.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "extract/voxels.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::extract {

using Labels = std::map<std::int64_t, mesh::Mesh>;

inline ExtractOptions net_options(std::uint64_t relaxations = kDefaultRelaxations) {
  ExtractOptions options;
  options.method = Method::surface_nets;
  options.relaxations = relaxations;
  return options;
}

inline Labels nets_of(const field::ScalarField& field, const ExtractOptions& options = net_options(),
                      const LabelChoice& choice = {true, {}}) {
  const auto found = LabelVoxels::find(field, options, choice, Context());
  EXPECT_TRUE(found) << found.error().message;
  Labels meshes;
  for (const std::int64_t label : found->labels()) {
    auto extraction = found->extract(field, label, options, Context());
    EXPECT_TRUE(extraction);
    meshes.emplace(label, std::move(extraction->mesh));
  }
  return meshes;
}

}  // namespace isoextract::extract
