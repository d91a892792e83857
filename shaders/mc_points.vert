// Makes one thread a cell without vertex data: vertex 512 * site + cell.

flat out ivec2 cell_thread;

void main() { cell_thread = ivec2(gl_VertexID >> 9, gl_VertexID & 511); }
