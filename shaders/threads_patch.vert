// Seed S2: a corner of a quad patch, from the buffer of patches.

layout(location = 0) in uint number;

flat out uint patch_number;

void main() { patch_number = number; }
