// Draws the cells of sites and captures their triangles by transform feedback: a count pass first, then a buffer of
// at least that size. After Suravikin and Korobitsyn (extract/cell_tables.hpp), and P. Yu. Timokhin, M. V. Mikhaylyuk:
// Method to extract isosurfaces on the GPU by means of programmable tessellation, 2020 (docs/papers.md).
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/buffer.hpp"
#include "base/byte_size.hpp"
#include "base/stopwatch.hpp"
#include "gl/gl_context.hpp"
#include "gl/gl_object.hpp"
#include "gl/gl_program.hpp"

namespace isoextract::gpu {

enum class GpuPipeline {
  mt_geometry,      // Suravikin and Korobitsyn: geometry shaders, tetrahedra as lines with adjacency
  mc_tessellation,  // Timokhin and Mikhaylyuk: one patch a site, of which the tessellator makes one thread a cell
  mc_points,        // one point a cell by vertex number alone, to compare with mc_tessellation
};

// Captured vertices, three a triangle, in memory order: position, key (captured_vertex.glsl), normal if requested.
struct CapturedSoup {
  std::span<const std::uint32_t> words;
  std::size_t stride = 4;  // words a vertex; 7 with normals

  [[nodiscard]] std::size_t vertices() const { return words.size() / stride; }
  [[nodiscard]] glm::vec3 position(std::size_t v) const { return floats(v, 0); }
  [[nodiscard]] std::uint32_t key(std::size_t v) const { return words[v * stride + 3]; }
  [[nodiscard]] glm::vec3 normal(std::size_t v) const { return floats(v, 4); }

 private:
  [[nodiscard]] glm::vec3 floats(std::size_t v, std::size_t first) const {
    const std::uint32_t* at = words.data() + v * stride + first;
    return {std::bit_cast<float>(at[0]), std::bit_cast<float>(at[1]), std::bit_cast<float>(at[2])};
  }
};

struct CaptureTimes {
  StageTime count;
  StageTime capture;
  StageTime read_back;
};

// GL objects that a capture needs; kept for the next capture.
struct CaptureBuffers {
  [[nodiscard]] static CaptureBuffers make();

  gl::GlBuffer feedback;
  gl::GlBuffer staging;    // copy that the CPU reads: reading the feedback buffer itself makes drivers move it to the
                           // host
  std::uint64_t size = 0;  // bytes of each of the two buffers
  gl::GlBuffer sites;
  gl::GlTexture site_texture;
  gl::GlQuery generated;  // a query object has one target for life
  gl::GlQuery written;
};

class CellCapture {
 public:
  // Captures at most `feedback_bytes` at a time, or as many as one site needs.
  CellCapture(const gl::GlContext& context, CaptureBuffers& buffers, GpuPipeline pipeline, std::size_t words_per_vertex,
              std::uint64_t feedback_bytes);

  // Draws all sites, in several draws if needed; `origins` are their lowest samples. Calls `bind` before each draw with
  // its range of sites, which the programs number from 0. Calls `take` with the triangles of each draw. They are sorted
  // by site unless the driver reorders them; the triangles of a cell are consecutive. Fails with ErrorCode::unavailable
  // if the two passes find different numbers of triangles, and as `allow` and GlContext::check() do.
  using Bind = std::function<void(std::size_t first, std::size_t count)>;
  using Take = std::function<void(std::size_t first, std::size_t count, const CapturedSoup& soup)>;
  // Called before triangles are captured, with the total number including these; an error ends the drawing.
  using Allow = std::function<Result<void>(std::uint64_t triangles)>;
  [[nodiscard]] Result<void> draw(const gl::CountAndCapture& pass, std::span<const glm::ivec3> origins,
                                  const Bind& bind, const Take& take, const Allow& allow);

  // Frees the memory of the captured triangles.
  void free_soup() { soup_ = {}; }

  [[nodiscard]] const CaptureTimes& times() const { return times_; }
  [[nodiscard]] std::uint64_t captured_bytes() const { return captured_bytes_; }

 private:
  Result<std::uint64_t> count(const gl::ShaderProgram& program, std::size_t sites);
  void draw_sites(const gl::ShaderProgram& program, std::size_t sites) const;

  const gl::GlContext& context_;
  CaptureBuffers& buffers_;
  GpuPipeline pipeline_;
  std::size_t words_;
  std::uint64_t feedback_bytes_;
  std::size_t patches_per_draw_;
  std::size_t max_sites_;   // limit of a draw
  std::size_t next_sites_;  // size of the next draw, estimated from the last one
  std::uint64_t triangles_ = 0;
  Buffer<std::uint32_t> soup_;
  CaptureTimes times_;
  std::uint64_t captured_bytes_ = 0;
};

}  // namespace isoextract::gpu
