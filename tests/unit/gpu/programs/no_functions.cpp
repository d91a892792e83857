// A library that loads but is empty, as a substitute for libEGL.so.1.
