// One corner of a quad patch, from the buffer of patches (Timokhin and Mikhaylyuk 2020; docs/papers.md).

layout(location = 0) in uint number;

flat out uint patch_number;

void main() { patch_number = number; }
