// One thread a cell without any vertex data: cell 512 * site + cell by its number.

flat out ivec2 cell_thread;

void main() { cell_thread = ivec2(gl_VertexID >> 9, gl_VertexID & 511); }
