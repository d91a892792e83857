// An extractor with planted defects: it changes the surfaces of the CPU extractor before it returns them.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "extract/extractor.hpp"

namespace isoextract::test {

class ChangedExtractor final : public extract::Extractor {
 public:
  using Change = std::function<void(const extract::ExtractOptions& options, mesh::Mesh& mesh)>;

  explicit ChangedExtractor(Change change, std::string name = "changed")
      : change_(std::move(change)), name_(std::move(name)) {}

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] std::string device() const override { return "none"; }
  [[nodiscard]] bool has(extract::Method /*method*/) const override { return true; }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField& field, const extract::ExtractOptions& options,
                                                const Context& context) override {
    auto extraction = extract::make_cpu_extractor()->extract(field, options, context);
    if (extraction) change_(options, extraction->mesh);
    return extraction;
  }

  Change change_;
  std::string name_;
};

}  // namespace isoextract::test
