// Makes one thread a cell by vertex number alone.

uniform int first_layer;  // of this draw; 32 bits cannot number all cells of 2000^3
uniform ivec3 grid;

flat out ivec3 cell;

void main() {
  int layer = gl_VertexID / (grid.x * grid.y);
  cell = ivec3(gl_VertexID % grid.x, gl_VertexID / grid.x % grid.y, first_layer + layer);
}
