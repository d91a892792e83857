// Seed S2: a patch needs no vertex data; the control stage knows it by its number.

void main() {}
