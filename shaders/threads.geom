// A thread that does nothing: it emits a point only if a uniform says so, which the compiler cannot know in advance.

layout(points) in;
layout(points, max_vertices = 1) out;

flat in ivec3 cell[];

uniform ivec3 grid;
uniform ivec3 emit_below;  // (0, 0, 0): in no cell; the grid: in every cell

void main() {
  if (any(greaterThanEqual(cell[0], grid))) return;
  if (any(greaterThanEqual(cell[0], emit_below))) return;
  gl_Position = vec4(0.0);
  EmitVertex();
}
