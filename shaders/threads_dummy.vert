// One thread a cell by a dummy vertex from a buffer: what Timokhin and Mikhaylyuk (2020; docs/papers.md) describe as
// the usual way.

layout(location = 0) in uint number;  // of the cell in this draw

uniform int first_layer;  // of this draw
uniform ivec3 grid;

flat out ivec3 cell;

void main() {
  int cells = int(number);
  cell = ivec3(cells % grid.x, cells / grid.x % grid.y, first_layer + cells / (grid.x * grid.y));
}
