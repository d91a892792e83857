// A patch needs no vertex data: the control stage knows it by its number (Timokhin and Mikhaylyuk 2020;
// docs/papers.md).

void main() {}
