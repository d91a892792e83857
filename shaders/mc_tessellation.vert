// A patch needs no vertex data: the control stage gets its number (Timokhin and Mikhaylyuk 2020; docs/papers.md).

void main() {}
