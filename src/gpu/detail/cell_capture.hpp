// Drawing the cells of sites, and capturing the triangles by transform feedback: a count pass first, then a buffer of
// exactly that size. After Suravikin and Korobitsyn (extract/cell_tables.hpp), and P. Yu. Timokhin, M. V. Mikhaylyuk:
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
  mc_tessellation,  // Timokhin and Mikhaylyuk: a patch a site, the tessellator makes a thread a cell
  mc_points,        // one point a cell by its number alone: what that is compared with
};

// Captured vertices, three a triangle, as they lie in memory: position, key (captured_vertex.glsl), perhaps a normal.
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

// Objects of the context that a capture needs, kept for the next one.
struct CaptureBuffers {
  [[nodiscard]] static CaptureBuffers make();

  gl::GlBuffer feedback;
  gl::GlBuffer staging;    // what is read from: reading the feedback buffer itself makes drivers move it to the host
  std::uint64_t size = 0;  // of both
  gl::GlBuffer sites;
  gl::GlTexture site_texture;
  gl::GlQuery generated;  // a query object has one target for life
  gl::GlQuery written;
};

class CellCapture {
 public:
  // Captures no more than `feedback_bytes` at a time, or what one site needs.
  CellCapture(const gl::GlContext& context, CaptureBuffers& buffers, GpuPipeline pipeline, std::size_t words_per_vertex,
              std::uint64_t feedback_bytes);

  // Draws the sites, whose lowest samples are given; `bind` is called before each draw with the range of sites that it
  // draws, which the programs know by number from 0 on. `take` gets the triangles of each draw: by rising site, except
  // where the driver chose otherwise, and those of one cell one after the other.
  using Bind = std::function<void(std::size_t first, std::size_t count)>;
  using Take = std::function<void(std::size_t first, std::size_t count, const CapturedSoup& soup)>;
  // Asked before triangles are captured, with the number of all so far and these; an error ends the drawing.
  using Allow = std::function<Result<void>(std::uint64_t triangles)>;
  [[nodiscard]] Result<void> draw(const gl::CellPass& pass, std::span<const glm::ivec3> origins, const Bind& bind,
                                  const Take& take, const Allow& allow);

  // What was read back, once nobody looks at it any more.
  void free_soup() { soup_ = {}; }

  [[nodiscard]] const CaptureTimes& times() const { return times_; }
  [[nodiscard]] std::uint64_t captured_bytes() const { return captured_bytes_; }

 private:
  Result<std::uint64_t> count(const gl::CellProgram& program, std::size_t sites);
  void draw_sites(const gl::CellProgram& program, std::size_t sites) const;

  const gl::GlContext& context_;
  CaptureBuffers& buffers_;
  GpuPipeline pipeline_;
  std::size_t words_;
  std::uint64_t feedback_bytes_;
  std::size_t patches_per_draw_;
  std::size_t max_sites_;   // of a draw
  std::size_t next_sites_;  // of the next draw, by what the last one needed
  std::uint64_t triangles_ = 0;
  Buffer<std::uint32_t> soup_;
  CaptureTimes times_;
  std::uint64_t captured_bytes_ = 0;
};

}  // namespace isoextract::gpu
