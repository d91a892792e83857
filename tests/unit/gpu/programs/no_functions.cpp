// A library that loads and has nothing in it, to stand in the place of libEGL.so.1.
