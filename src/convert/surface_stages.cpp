#include "convert/surface_stages.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "convert/mesh_normals.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/mesh_relax.hpp"
#include "convert/mesh_simplify.hpp"
#include "convert/mesh_smooth.hpp"
#include "convert/vertex_colours.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::convert {
namespace {

class SurfaceStages {
 public:
  SurfaceStages(const ConversionJob& job, const Source& source, const Context& context, Events& events)
      : job_(job), source_(source), context_(context), events_(events) {}

  // While every vertex is where the field puts it.
  Result<void> carry_attributes(Surface& surface) {
    if (!source_.attributes) return {};
    for (const MissingAttribute& missing : source_.attributes->missing) {
      if (missing.choice.optional) continue;
      if (!surface.mesh.triangles.empty()) return tl::unexpected(missing.error);
      events_.note(fmt::format("{} {}: there is no surface, and no attribute '{}' either", source_.label,
                               text_of(surface), printable(missing.choice.name)));
    }
    const Stopwatch watch;
    auto records = TRY(add_attributes(*source_.attributes, surface.mesh, context_));
    for (AttributeRecord& record : records) {
      record.iso = surface.iso;
      for (const std::string& text : notes_of(record, source_.label)) events_.note(text);
    }
    // Of particles all attributes have the same reach.
    if (!records.empty() && records.front().out_of_reach > 0) {
      events_.note(
          fmt::format("{} {}: {} of {} vertices have the attributes of the nearest particle, as none is "
                      "near enough to be interpolated",
                      source_.label, text_of(surface), records.front().out_of_reach, surface.mesh.positions.size()));
    }
    events_.carried({surface.iso, surface.mesh.positions.size(), std::move(records), watch.elapsed()});
    return {};
  }

  Result<void> drop_pieces(Surface& surface) {
    if (!job_.pieces.drops()) return {};
    const bool was_empty = surface.mesh.triangles.empty();
    auto sites = TRY(voxel_sites(surface.mesh, source_, job_.surface, context_));
    auto record =
        TRY(convert::drop_pieces(surface.mesh, surface.iso, job_.pieces, source_, std::move(sites), context_));
    events_.picked(record);
    if (record.facts.without_volume > 0) {
      events_.note(fmt::format("{} {}: {} open components have no volume, and stay", source_.label, text_of(surface),
                               record.facts.without_volume));
    }
    if (was_empty || !surface.mesh.triangles.empty() || job_.empty != EmptyPolicy::error) return {};
    return tl::unexpected(Error{ErrorKind::input,
                                fmt::format("{}: none of the {} components at {} is as large as asked for",
                                            source_.label, record.facts.before.components, text_of(surface)),
                                Remedy::allow_empty, Reason::no_surface});
  }

  // While all vertices are where relaxing left them. Open meshes have no volume.
  Result<void> tell_relaxed(const Surface& surface, const edit::Sites& sites) {
    auto record = TRY(relax_record(surface.mesh, surface.iso, fmt::format("{} {}", source_.label, text_of(surface)),
                                   sites, context_));
    events_.relaxed(record);
    return {};
  }

  // While shells are where the field puts them: later stages may move them through each other.
  Result<void> look_at_bodies(Surface& surface) {
    const bool is_open = !source_.clip.empty() && !job_.surface.cap;
    const bool tells = job_.surface.relaxes() && !is_open;
    const bool marks = job_.pieces.split;
    if (!tells && !marks) return {};
    auto sites = TRY(voxel_sites(surface.mesh, source_, job_.surface, context_));
    if (tells) {
      TRY(tell_relaxed(surface, sites));
    }
    return marks ? edit::mark_bodies(surface.mesh, context_, std::move(sites)) : Result<void>();
  }

  Result<void> smooth(Surface& surface) {
    if (!job_.smooth || surface.mesh.triangles.empty()) return {};
    auto record = TRY(smooth_mesh(surface.mesh, surface.iso, *job_.smooth, source_.output_from_index, capped_box(),
                                  capped_cuts(), context_));
    events_.smoothed(record);
    return {};
  }

  Result<void> simplify(Surface& surface) {
    if (!job_.simplify) return {};
    auto simplified =
        TRY(simplify_mesh(surface.mesh, surface.iso, *job_.simplify, source_.output_from_index, context_));
    events_.simplified(simplified);
    surface.simplified_by = simplified.voxels.upper;
    for (const std::string& text : notes_of(simplified)) {
      events_.note(fmt::format("{} {}: {}", source_.label, text_of(surface), text));
    }
    return {};
  }

  // When the vertices are those that are written. Attributes that are only for that go.
  Result<void> colour(const SurfaceFacts& facts, Surface& surface) {
    surface.mesh.material = material_of(job_, facts.isos, surface.iso, source_.field.kind, facts.may_be_open);
    if (facts.labels != nullptr) {
      const auto label = static_cast<std::int64_t>(surface.iso);
      TRY(facts.labels->colour(job_, label, surface.mesh, context_));
    }
    if (!job_.colour || !job_.colour->attribute) return {};
    const auto is_meant = [&](const MissingAttribute& missing) {
      return missing.choice.name == *job_.colour->attribute;
    };
    if (std::ranges::any_of(source_.attributes->missing, is_meant)) return {};  // it was told
    auto record = TRY(add_colours(*job_.colour, job_.format, surface.mesh, context_));
    record.iso = surface.iso;
    if (record.not_numbers > 0) {
      events_.note(fmt::format("{} {}: {} of {} vertices are grey, as '{}' is no number there", source_.label,
                               text_of(surface), record.not_numbers, surface.mesh.positions.size(),
                               printable(record.attribute)));
    }
    events_.coloured(record);
    for (const AttributeChoice& choice : job_.source.attributes) {
      if (choice.written) continue;
      std::erase_if(surface.mesh.attributes, [&](const mesh::Attribute& a) {
        return a.role != mesh::AttributeRole::colour && a.name == choice.name;
      });
    }
    return {};
  }

  // When colours, which go by the values of the input, are made.
  void change_attributes(Surface& surface) {
    if (!source_.attributes) return;
    convert::change_attributes(surface.mesh, source_.attributes->kinds, source_.attributes->output_from_world);
  }

  Result<void> measure_error(Surface& surface) {
    if (!job_.error) return {};
    if (is_label()) {
      events_.note("the error of the mesh is not measured: labels have no isosurface between the samples");
      return {};
    }
    const Stopwatch watch;
    const field::ScalarField& data = source_.data ? *source_.data : source_.field;
    auto measured = TRY(measure_mesh_error(surface.mesh, data, extract_options_of(job_, source_, surface.iso),
                                           *job_.error, source_.data ? &source_.field : nullptr, source_.clip,
                                           {job_.smooth.has_value(), surface.simplified_by}, context_));
    surface.error = measured;
    TRY(volumes::check_not_lost(data));
    events_.measured(*surface.error, watch.elapsed());
    return {};
  }

 private:
  [[nodiscard]] bool is_label() const { return !source_.isos.empty() && source_.isos.front().asked.is_label(); }

  [[nodiscard]] std::string text_of(const Surface& surface) const {
    return fmt::format("{} {}", is_label() ? "label" : "iso", surface.iso);
  }

  // The samples whose outermost the caps go through, where there are caps.
  [[nodiscard]] std::optional<field::IndexBox> capped_box() const {
    if (!job_.surface.cap) return std::nullopt;
    if (source_.region) return source_.region;
    if (std::holds_alternative<field::SparseSamples>(source_.field.samples)) return std::nullopt;
    return source_.field.extents();
  }

  [[nodiscard]] std::span<const mesh::HalfSpace> capped_cuts() const {
    if (!job_.surface.cap) return {};
    return source_.clip;
  }

  const ConversionJob& job_;
  const Source& source_;
  const Context& context_;
  Events& events_;
};

}  // namespace

extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso) {
  extract::ExtractOptions options = source.extract_options(job.surface, iso);
  options.smooth_normals = job.normals == Normals::smooth;
  options.shared_frame = mesh_packing(job.packing, source).quantizes();
  options.edge_keys = job.verify && extract::method_info(job.surface.method).traits.vertices_on_edges;
  return options;
}

Result<void> shade_surface(const ConversionJob& job, const Source& source, bool recorded, const Context& context,
                           Events& events, Surface& surface) {
  if (recorded) {
    // Only for reports: finding components and open edges takes longer than to extract the mesh.
    const Stopwatch watch;
    context.progress().begin("measuring", 0);
    surface.record = TRY(mesh_record(surface.iso, "", surface.mesh, context));
    surface.recording += watch.elapsed();
  }
  if (surface.counts_open_edges) {
    const auto topology = TRY(surface.record ? Result<mesh::Topology>(surface.record->topology)
                                             : mesh::measure_topology(surface.mesh, context));
    surface.open_edges = topology.open_edges;
  }
  return fit_normals(surface.mesh, job, source, surface.iso, context, events);
}

Result<void> finish_surface(const ConversionJob& job, const Source& source, const SurfaceFacts& facts,
                            const Context& context, Events& events, Surface& surface) {
  SurfaceStages stages(job, source, context, events);
  TRY(stages.carry_attributes(surface));
  TRY(stages.drop_pieces(surface));
  TRY(stages.look_at_bodies(surface));
  TRY(stages.smooth(surface));
  TRY(stages.simplify(surface));
  TRY(stages.colour(facts, surface));
  stages.change_attributes(surface);
  if (!job.pieces.split) {
    TRY(shade_surface(job, source, facts.recorded, context, events, surface));
  }
  return stages.measure_error(surface);
}

}  // namespace isoextract::convert
