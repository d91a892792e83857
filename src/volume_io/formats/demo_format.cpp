// Demo fields, computed from formulas, as inputs.
#include "field/demo_field.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"

namespace isoextract::volume_io {
namespace {

class DemoFormat final : public VolumeFormat {
 public:
  DemoFormat()
      : VolumeFormat({.id = "demo",
                      .title = "demo:NAME, a field by formula",
                      .extensions = {},
                      .prefix = std::string(field::kDemoPrefix)}) {}

  // Demo fields are densities unless the options say otherwise. Does not compute samples.
  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                   const Context& /*context*/) const override {
    const auto demo = TRY(field::parse_demo_spec(input));
    GridInfo grid = dense_grid(std::string(demo.name), glm::ivec3(demo.size), field::SampleType::f32);
    grid.kind = options.kind.value_or(field::FieldKind::density);
    return std::vector{std::move(grid)};
  }

  [[nodiscard]] Result<std::vector<std::filesystem::path>> files(const std::string& /*input*/,
                                                                 const ReadOptions& /*options*/,
                                                                 const Context& /*context*/) const override {
    return std::vector<std::filesystem::path>();
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    auto field = field::make_demo_field(input, context);
    if (!field) return field;
    TRY(set_placement(*field, {field->index_to_world, {}}, options));
    return field;
  }
};

}  // namespace

const VolumeFormat& demo_format() {
  static const DemoFormat format;
  return format;
}

}  // namespace isoextract::volume_io
