// Makes one thread a cell from a buffer of dummy vertices, which Timokhin and Mikhaylyuk (2020; docs/papers.md) call
// the usual way.

layout(location = 0) in uint number;  // of the cell in this draw

uniform int first_layer;  // of this draw
uniform ivec3 grid;

flat out ivec3 cell;

void main() {
  int cells = int(number);
  cell = ivec3(cells % grid.x, cells / grid.x % grid.y, first_layer + cells / (grid.x * grid.y));
}
